#pragma once
#include <filesystem>

#include "runtime/atlas/bytes.h"

namespace beatlas::pack {

/// Writes `bytes` to a new hidden file beside `file`, has it reach the disk and renames it over
/// `file`: at any moment the name stands for the old content or the whole new one.
/// @throws Error{Machine} if that fails; `file` is then as it was and nothing new is left.
void replace_file(const std::filesystem::path& file, atlas::ByteView bytes);

}  // namespace beatlas::pack
