#pragma once
#include <string>
#include <vector>

#include "runtime/atlas/bytes.h"

namespace beatlas::pack {

struct ZipEntry {
  std::string name;
  atlas::Bytes bytes;
};

/// A zip of stored entries in the given order, each of 1980-01-01 00:00: the same entries give the
/// same bytes. @throws Error{Machine}
[[nodiscard]] atlas::Bytes build_zip(const std::vector<ZipEntry>& entries);

}  // namespace beatlas::pack
