#pragma once
/// The scripted press on an atlas's own left ventricle: paper B's muscle at the depth of a finger
/// below the surface as the images show it beating. Where the package has a map of the LV's wall
/// the finger goes to the segment it is told, onto the muscle that lies there.

#include <filesystem>
#include <optional>
#include <vector>

#include "runtime/app/press.h"
#include "runtime/app/ventricle.h"
#include "runtime/atlas/atlas.h"

namespace beatlas::app {

struct AtlasPressRow {
  double time_s;
  double displacement_mm;  ///< D of the finger; 0 at the surface of end-diastole
  double depth_mm;         ///< below the moving surface; negative above it
  double force_n;          ///< before any cap, along the surface's normal
};

/// The muscle under the finger.
struct PressedWall {
  palpation::WallPlace place;  ///< nearest on the endocardium, at end-diastole
  palpation::Tissue tissue;
};

struct AtlasPress {
  Vec3 place_mm = Vec3::Zero();     ///< workspace: where the finger touches first
  Vec3 outward = Vec3::UnitX();     ///< the surface's normal there at end-diastole
  std::vector<AtlasPressRow> rows;  ///< one a millisecond
  double deepest_mm = 0;
  double largest_force_n = 0;
  std::optional<PressedWall> wall;  ///< none without a map
  /// Where there is a wall: the same finger at the same place on healthy muscle, on an infarct
  /// weeks old, and on the tissue that is there.
  std::vector<TissueForce> tissues;
};

/// Of the free wall from its anterior end, mid ventricle first, then base and apex, the first
/// segment (1..17) that a finger reaches from outside. @param package opened with needs_of_press
/// @throws Error{InvalidInput} if there is none
[[nodiscard]] int reachable_segment(const atlas::Atlas& package, const palpation::LvWall& wall);

/// @param package opened with needs_of_press  @param script as run_press ran it
/// @param ventricle of the package; none: the place's tissue is that of script.segment
/// @throws Error{InvalidInput} if the segment cannot be reached from outside, as the septum.
/// @throws Error{InvalidInput} if the package lacks the heart's field (the message names the scene
/// that would hold it) or a parameter is out of range.
[[nodiscard]] AtlasPress press_on_atlas(const atlas::Atlas& package,
                                        const palpation::PalpationParameters& parameters,
                                        const PressScript& script,
                                        const std::optional<AtlasVentricle>& ventricle);

/// atlas_press.csv and atlas_press.svg. @throws Error{Machine} if one cannot be written.
void write_atlas_press(const AtlasPress& press, const std::filesystem::path& folder);
/// See schemas/press.schema.json, "atlas".
[[nodiscard]] nlohmann::json atlas_press_json(const AtlasPress& press);
[[nodiscard]] std::string atlas_press_text(const AtlasPress& press);

}  // namespace beatlas::app
