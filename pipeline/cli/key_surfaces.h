#pragma once
#include <filesystem>
#include <vector>

#include "pipeline/keyframes/key_heart.h"

namespace beatlas::cli {

/// Key surfaces as a JSON file tells of them (schemas/surfaces.schema.json), read.
struct KeySurfaces {
  keyframes::KeyHeart heart;
  std::vector<std::filesystem::path> files;  ///< the JSON file and those it names
};

/// PLY, OBJ and STL by the ends of their names, beside the JSON file unless they say where.
/// @throws Error{InvalidInput} naming the file, and in JSON the path, and what is wrong
[[nodiscard]] KeySurfaces read_key_surfaces(const std::filesystem::path& json_file);

}  // namespace beatlas::cli
