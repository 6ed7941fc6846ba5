#pragma once
/// An atlas's own left ventricle for paper B's muscle and circulation: what --preset or
/// --parameters say of it, and what the package knows.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/atlas/atlas.h"
#include "runtime/palpation/lv_wall.h"
#include "runtime/palpation/parameters.h"
#include "runtime/palpation/regions.h"

namespace beatlas::app {

/// What is known of an atlas's left ventricle.
struct AtlasVentricle {
  std::shared_ptr<const palpation::LvWall> wall;
  palpation::TissueMap tissue;
};

/// What of a package paper B's muscle needs: the heart's field and the endocardium with its map;
/// without them, where there is one, the field of the LV's blood, which tells where the free wall
/// is (else the body's left side is taken for it).
[[nodiscard]] atlas::Needs needs_of_press(const atlas::Manifest& manifest);

/// What was asked for.
struct ToldMuscle {
  palpation::PalpationParameters parameters;
  std::vector<palpation::Region> regions;
  std::filesystem::path file;  ///< that it was read from; empty: none
};
/// @param file JSON (schemas/palpation.schema.json), may be empty  @param preset may be empty; both
/// empty: healthy
/// @throws Error{Usage} if both are named, Error{InvalidInput} by file and JSON path
[[nodiscard]] ToldMuscle told_muscle(const std::string& file, const std::string& preset);

/// Which muscle of a package (opened with needs_of_press) is ill; none without a map.
/// @throws Error{InvalidInput} naming `package` if regions need a map and there is none, or by file
/// and line of a painted map
[[nodiscard]] std::optional<AtlasVentricle> ventricle_of(const atlas::Atlas& atlas,
                                                         const ToldMuscle& told,
                                                         const std::string& package);

/// The parameters on the package's own ventricle (palpation::on_heart), at the package's heart
/// rate.
/// @throws Error{InvalidInput} naming `package` if it holds no volumes of lv_blood, or as on_heart
void scale_to_atlas(palpation::PalpationParameters& parameters, const atlas::Manifest& manifest,
                    const std::string& package);

}  // namespace beatlas::app
