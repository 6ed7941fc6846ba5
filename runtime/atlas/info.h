#pragma once
/// What `beatlas info` says of a package.

#include <optional>
#include <string>

#include "runtime/atlas/manifest.h"

namespace beatlas::atlas {

/// (V_ed - V_es) / V_ed of lv_blood, 0..1 for a heart that pumps; empty without an LV or with an
/// empty one.
[[nodiscard]] std::optional<double> ejection_fraction(const Manifest& manifest);

/// All of atlas.json (see schemas/manifest.schema.json) and `phases`, `ejection_fraction` (null if
/// unknown), `source`/`spacing_mm`, `surface_levels` (what the build measured of each surface),
/// `volume` (null without one; its figures null if untold); see schemas/info.schema.json. Keys are
/// only ever added.
[[nodiscard]] nlohmann::json info_json(const Manifest& manifest);

/// The same for people: a few lines, ends with a newline.
[[nodiscard]] std::string info_text(const Manifest& manifest);

}  // namespace beatlas::atlas
