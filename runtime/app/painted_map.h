#pragma once
/// Painted maps of an atlas's left ventricle, from CSV.

#include <filesystem>

#include "runtime/palpation/regions.h"

namespace beatlas::app {

/// Every map that `regions` name, by that name. A file has the columns `vertex` and `label` (whole
/// numbers; vertices of lv_blood as `beatlas export --to obj` numbers them, from 0) or `segment`
/// (1..17) and `label`; labels 0..255; what it does not list has label 0.
/// @param folder that relative names start from
/// @throws Error{InvalidInput} naming file and line
[[nodiscard]] palpation::PaintedMaps read_painted_maps(
    const std::vector<palpation::Region>& regions, const std::filesystem::path& folder,
    const palpation::LvWall& wall);

}  // namespace beatlas::app
