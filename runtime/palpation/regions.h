#pragma once
/// Disease by place: which vertices of an atlas's left ventricle are ill, and how.

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/palpation/lv_wall.h"
#include "runtime/palpation/muscle.h"
#include "runtime/palpation/segments.h"

namespace beatlas::palpation {

/// A region beside those by AHA segment: painted, where the atlas's wall is thin, or where its
/// stiffness was measured.
struct Region {
  std::string painted;         ///< name of a painted map, see RegionMaps; empty: none
  int label = 1;               ///< 0..255: of the painted map
  double thinner_than_mm = 0;  ///< 0..40, of the wall at end-diastole
  Tissue tissue;
  /// The thickness over the median of the wall outside the region, vertex by vertex, stands for
  /// tissue.thickness_ratio (held within 0.3..1: a wall that is thicker by disease is told so).
  bool ratio_of_atlas = false;
  /// Name of a measured map, see RegionMaps; empty: none. It sets how stiff the muscle is where it
  /// reaches, and leaves all else as segments and regions before it have it.
  std::string measured;
  double healthy_kpa = 0;  ///< 0.1..1000: what counts as a ratio of 1; 0: the median of the map
  double reach_mm = 10;    ///< 1..50: how far a measured point tells of the muscle about it

  [[nodiscard]] bool operator==(const Region&) const = default;
};

/// Maps of one wall that regions name.
struct RegionMaps {
  std::map<std::string, std::vector<std::uint8_t>> painted;  ///< [name][vertex] 0: not painted
  std::map<std::string, std::vector<float>> measured;  ///< [name][vertex] kPa; 0: not measured
};

/// An atlas's own tissue, and what infarct it makes of the ventricle.
struct TissueMap {
  std::vector<Tissue> of_vertex;
  Infarct infarct;  ///< by shares of muscle

  [[nodiscard]] const Tissue& at(const WallPlace& place) const noexcept {
    return of_vertex[place.vertex];
  }
};

/// Segments first, then each region in its order: where several hold a vertex the last counts.
/// A measured modulus of elasticity stands for stiffness: what bends is a plate of the wall's own
/// thickness, so k_v goes with the modulus. What scar the tissue has is in the measurement already,
/// and does not count twice.
/// @throws Error{InvalidInput} if a map is missing or of another number of vertices, or a measured
/// stiffness is not within 0.1 to 10 times the healthy one
[[nodiscard]] TissueMap tissue_of_wall(const LvWall& wall, const SegmentTissue& segments,
                                       const std::vector<Region>& regions, const RegionMaps& maps);

/// What infarct this tissue of the wall's vertices makes of the whole ventricle.
[[nodiscard]] Infarct infarct_of_wall(const LvWall& wall, const std::vector<Tissue>& of_vertex);

/// schemas/palpation.schema.json, "regions". @throws Error{InvalidInput} by JSON path
[[nodiscard]] std::vector<Region> regions_from_json(const nlohmann::json& list);
[[nodiscard]] nlohmann::json regions_to_json(const std::vector<Region>& regions);

}  // namespace beatlas::palpation
