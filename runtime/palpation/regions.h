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

/// A region beside those by AHA segment: painted, or where the atlas's wall is thin.
struct Region {
  std::string painted;         ///< name of a painted map, see PaintedMaps; empty: by thickness
  int label = 1;               ///< 0..255: of the painted map
  double thinner_than_mm = 0;  ///< 0..40, of the wall at end-diastole
  Tissue tissue;
  /// The thickness over the median of the wall outside the region, vertex by vertex, stands for
  /// tissue.thickness_ratio (held within 0.3..1: a wall that is thicker by disease is told so).
  bool ratio_of_atlas = false;

  [[nodiscard]] bool operator==(const Region&) const = default;
};

/// [name][vertex] label, 0 where nothing is painted.
using PaintedMaps = std::map<std::string, std::vector<std::uint8_t>>;

/// An atlas's own tissue, and what infarct it makes of the ventricle.
struct TissueMap {
  std::vector<Tissue> of_vertex;
  Infarct infarct;  ///< by shares of muscle

  [[nodiscard]] const Tissue& at(const WallPlace& place) const noexcept {
    return of_vertex[place.vertex];
  }
};

/// Segments first, then each region in its order: where several hold a vertex the last counts.
/// @throws Error{InvalidInput} if a painted map is missing or of another number of vertices
[[nodiscard]] TissueMap tissue_of_wall(const LvWall& wall, const SegmentTissue& segments,
                                       const std::vector<Region>& regions,
                                       const PaintedMaps& painted);

/// What infarct this tissue of the wall's vertices makes of the whole ventricle.
[[nodiscard]] Infarct infarct_of_wall(const LvWall& wall, const std::vector<Tissue>& of_vertex);

/// schemas/palpation.schema.json, "regions". @throws Error{InvalidInput} by JSON path
[[nodiscard]] std::vector<Region> regions_from_json(const nlohmann::json& list);
[[nodiscard]] nlohmann::json regions_to_json(const std::vector<Region>& regions);

}  // namespace beatlas::palpation
