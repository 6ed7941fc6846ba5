#include "runtime/palpation/regions.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>

#include "runtime/base/error.h"
#include "runtime/base/json_numbers.h"
#include "runtime/base/json_object.h"

namespace beatlas::palpation {
namespace {

using nlohmann::json;

constexpr std::size_t kMostRegions = 100;
constexpr double kThinnestRatio = 0.3;
constexpr double kThickestRatio = 2;

Region region_from_json(const json& entry, const std::string& path) {
  JsonObject object(entry, path);
  Region region;
  object.read("painted", region.painted);
  object.read("label", region.label, 0, 255);
  object.read("thinner_than_mm", region.thinner_than_mm, 0, 40);
  object.read("scar", region.tissue.scar, 0, 1);
  object.read("thickness_ratio", region.tissue.thickness_ratio, kThinnestRatio, kThickestRatio);
  object.read("alpha", region.tissue.alpha, 0, 1);
  object.read("stiffness_ratio", region.tissue.stiffness_ratio, kSoftestRatio, kStiffestRatio);
  object.read("measured", region.measured);
  object.read("healthy_kpa", region.healthy_kpa, 0.1, 1000);
  object.read("reach_mm", region.reach_mm, 1, 50);
  region.ratio_of_atlas = !object.has("thickness_ratio");
  object.finish();
  const int kinds = static_cast<int>(object.has("painted")) +
                    static_cast<int>(object.has("thinner_than_mm")) +
                    static_cast<int>(object.has("measured"));
  if (kinds != 1 || (object.has("painted") && region.painted.empty()) ||
      (object.has("measured") && region.measured.empty())) {
    throw_invalid(path +
                  " must have one of painted or measured, the name of a file, or thinner_than_mm");
  }
  for (const char* key : {"healthy_kpa", "reach_mm"}) {
    if (object.has(key) && region.measured.empty()) {
      throw_invalid(path + "/" + key + " is of a measured map; name that by measured");
    }
  }
  for (const char* key : {"scar", "thickness_ratio", "alpha", "stiffness_ratio"}) {
    if (object.has(key) && !region.measured.empty()) {
      throw_invalid(path + "/" + key + " is not measured; tell it in a region before this one");
    }
  }
  if (object.has("label") && !object.has("painted")) {
    throw_invalid(path + "/label is of a painted map; name that by painted");
  }
  return region;
}

/// Median of the wall where `ill` is false, each vertex for its share of muscle; of all if none is.
double healthy_wall_mm(const LvWall& wall, const std::vector<bool>& ill) {
  std::vector<std::pair<float, double>> walls;  // thickness, share
  double whole = 0;
  for (const bool also_ill : {false, true}) {
    for (std::size_t v = 0; v < ill.size(); ++v) {
      if (!(wall.wall_mm()[v] > 0) || (ill[v] && !also_ill)) continue;
      walls.emplace_back(wall.wall_mm()[v], wall.muscle_share()[v]);
      whole += walls.back().second;
    }
    if (!walls.empty()) break;
  }
  std::sort(walls.begin(), walls.end());
  double sum = 0;
  for (const auto& [thickness_mm, share] : walls) {
    sum += share;
    if (sum >= 0.5 * whole) return static_cast<double>(thickness_mm);
  }
  return static_cast<double>(walls.back().first);
}

std::string in_words(double value) {
  std::array<char, 32> out{};
  std::snprintf(out.data(), out.size(), "%.3g", value);
  return out.data();
}

/// What a measured map says of the muscle's stiffness, into `of_vertex`.
void take_measured(const Region& region, const RegionMaps& maps, std::vector<Tissue>& of_vertex) {
  const auto found = maps.measured.find(region.measured);
  if (found == maps.measured.end() || found->second.size() != of_vertex.size()) {
    throw_invalid("the measured map " + region.measured + " is none of this atlas's LV");
  }
  const std::vector<float>& kpa = found->second;
  std::vector<float> measured;
  std::copy_if(kpa.begin(), kpa.end(), std::back_inserter(measured),
               [](float value) { return value > 0; });
  if (measured.empty()) {
    throw_invalid("the measured map " + region.measured + " says nothing of this atlas's LV wall");
  }
  double healthy = region.healthy_kpa;
  if (!(healthy > 0)) {
    const auto middle = measured.begin() + static_cast<std::ptrdiff_t>(measured.size() / 2);
    std::nth_element(measured.begin(), middle, measured.end());
    healthy = static_cast<double>(*middle);
  }
  for (std::size_t v = 0; v < kpa.size(); ++v) {
    if (!(kpa[v] > 0)) continue;
    Tissue& tissue = of_vertex[v];
    const double ratio = static_cast<double>(kpa[v]) / healthy;
    if (!(ratio >= kSoftestRatio && ratio <= kStiffestRatio)) {
      throw_invalid("the measured map " + region.measured + " has " + in_words(kpa[v]) +
                    " kPa where " + in_words(healthy) +
                    " kPa is healthy; a place may be 0.1 to 10 times as stiff: check its units and "
                    "healthy_kpa");
    }
    tissue.stiffness_ratio = ratio / (1 + kScarStiffening * tissue.scar);
  }
}

/// The vertices that a region is painted on, or those of its thin wall.
std::vector<bool> vertices_of(const Region& region, const LvWall& wall, const RegionMaps& maps) {
  std::vector<bool> ill(wall.vertex_count());
  if (region.painted.empty()) {
    for (std::size_t v = 0; v < ill.size(); ++v) {
      const auto mm = static_cast<double>(wall.wall_mm()[v]);
      ill[v] = mm > 0 && mm < region.thinner_than_mm;
    }
    return ill;
  }
  const auto labels = maps.painted.find(region.painted);
  if (labels == maps.painted.end() || labels->second.size() != ill.size()) {
    throw_invalid("the painted map " + region.painted + " is none of this atlas's LV");
  }
  for (std::size_t v = 0; v < ill.size(); ++v) ill[v] = labels->second[v] == region.label;
  return ill;
}

/// What a region that is told in numbers makes of its vertices, into `of_vertex`.
void take_told(const Region& region, const LvWall& wall, const RegionMaps& maps,
               std::vector<Tissue>& of_vertex) {
  const std::vector<bool> ill = vertices_of(region, wall, maps);
  const double healthy_mm = region.ratio_of_atlas ? healthy_wall_mm(wall, ill) : 1;
  for (std::size_t v = 0; v < ill.size(); ++v) {
    if (!ill[v]) continue;
    of_vertex[v] = region.tissue;
    if (!region.ratio_of_atlas) continue;
    const auto mm = static_cast<double>(wall.wall_mm()[v]);
    of_vertex[v].thickness_ratio = mm > 0 ? std::clamp(mm / healthy_mm, kThinnestRatio, 1.0) : 1;
  }
}

}  // namespace

std::vector<Region> regions_from_json(const json& list) {
  if (!list.is_array() || list.size() > kMostRegions) {
    throw_invalid("/regions must be a list of at most " + std::to_string(kMostRegions));
  }
  std::vector<Region> regions;
  for (std::size_t n = 0; n < list.size(); ++n) {
    regions.push_back(region_from_json(list[n], "/regions/" + std::to_string(n)));
  }
  return regions;
}

json regions_to_json(const std::vector<Region>& regions) {
  json list = json::array();
  for (const Region& region : regions) {
    if (!region.measured.empty()) {
      json entry = {{"measured", region.measured}, {"reach_mm", region.reach_mm}};
      if (region.healthy_kpa > 0) entry["healthy_kpa"] = region.healthy_kpa;
      list.push_back(std::move(entry));
      continue;
    }
    json entry = {{"scar", region.tissue.scar},
                  {"alpha", region.tissue.alpha},
                  {"stiffness_ratio", region.tissue.stiffness_ratio}};
    if (!region.ratio_of_atlas) entry["thickness_ratio"] = region.tissue.thickness_ratio;
    if (region.painted.empty()) {
      entry["thinner_than_mm"] = region.thinner_than_mm;
    } else {
      entry["painted"] = region.painted;
      entry["label"] = region.label;
    }
    list.push_back(std::move(entry));
  }
  return list;
}

Infarct infarct_of_wall(const LvWall& wall, const std::vector<Tissue>& of_vertex) {
  Infarct out;
  for (std::size_t v = 0; v < of_vertex.size(); ++v) {
    const double alpha = of_vertex[v].alpha;
    if (!(alpha < 1)) continue;
    out.fraction += wall.muscle_share()[v];
    out.alpha += wall.muscle_share()[v] * alpha;
  }
  if (out.fraction > 0) out.alpha /= out.fraction;
  out.fraction = std::min(out.fraction, 1.0);  // shares add up to 1 but for rounding
  return out;
}

TissueMap tissue_of_wall(const LvWall& wall, const SegmentTissue& segments,
                         const std::vector<Region>& regions, const RegionMaps& maps) {
  TissueMap out;
  for (const std::uint8_t segment : wall.map().segment) {
    out.of_vertex.push_back(segments[static_cast<std::size_t>(segment - 1)]);
  }
  for (const Region& region : regions) {
    if (region.measured.empty()) {
      take_told(region, wall, maps, out.of_vertex);
    } else {
      take_measured(region, maps, out.of_vertex);
    }
  }
  out.infarct = infarct_of_wall(wall, out.of_vertex);
  return out;
}

}  // namespace beatlas::palpation
