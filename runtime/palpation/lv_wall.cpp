#include "runtime/palpation/lv_wall.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/base/triangle.h"
#include "runtime/palpation/segments.h"

namespace beatlas::palpation {
namespace {

constexpr std::size_t kLookedAt = 32;  // vertices a call beside the way downhill
constexpr int kMostSteps = 256;        // of the way downhill; half around a ventricle is some 60

/// Twice the area of each triangle, as a vector along its normal.
Vec3 doubled_area(const std::vector<Vec3f>& at, const std::array<std::uint32_t, 3>& triangle) {
  const Vec3 a = at[triangle[0]].cast<double>();
  return (at[triangle[1]].cast<double>() - a).cross(at[triangle[2]].cast<double>() - a);
}

}  // namespace

LvWall::LvWall(std::shared_ptr<const atlas::SurfacePayload> endocardium,
               std::shared_ptr<const atlas::SurfaceMapPayload> map, int end_diastole)
    : endocardium_(std::move(endocardium)),
      map_(std::move(map)),
      end_diastole_(static_cast<std::size_t>(std::max(0, end_diastole))) {
  if (!endocardium_ || !map_) {
    throw_invalid("the atlas has no map of the LV's wall; build it again from images");
  }
  const std::size_t vertices = map_->segment.size();
  const std::size_t phases = map_->thickness_mm.size();
  if (endocardium_->positions.size() != phases || end_diastole_ >= phases ||
      endocardium_->positions.front().size() != vertices) {
    throw_invalid("the map of the LV's wall is none of its surface; build the package again");
  }
  const std::vector<Vec3f>& at = endocardium_->positions[end_diastole_];
  std::vector<double> area(vertices);
  outward_.assign(vertices, Vec3::Zero());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& triangle : endocardium_->triangles) {
    const Vec3 doubled = doubled_area(at, triangle);
    const double third = doubled.norm() / 6;
    for (std::size_t n = 0; n < 3; ++n) {
      area[triangle[n]] += third;
      outward_[triangle[n]] += doubled;
      edges.emplace_back(triangle[n], triangle[(n + 1) % 3]);
      edges.emplace_back(triangle[(n + 1) % 3], triangle[n]);
    }
  }
  for (Vec3& normal : outward_) {
    normal = normal.norm() > 0 ? Vec3(normal.normalized()) : Vec3(Vec3::UnitX());
  }
  double whole = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    share_.push_back(area[v] * static_cast<double>(wall_mm()[v]));
    whole += share_.back();
  }
  if (!(whole > 0)) throw_invalid("the map of the LV's wall has no wall; build the package again");
  for (double& share : share_) share /= whole;
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  first_neighbour_.assign(vertices + 1, 0);
  for (const auto& [from, to] : edges) {
    ++first_neighbour_[from + 1];
    neighbours_.push_back(to);
  }
  for (std::size_t v = 0; v < vertices; ++v) first_neighbour_[v + 1] += first_neighbour_[v];
}

std::size_t LvWall::phase_of(double beats) const noexcept {
  const std::size_t phases = endocardium_->positions.size();
  const double share = std::isfinite(beats) ? beats - std::floor(beats) : 0;
  return static_cast<std::size_t>(std::lround(share * static_cast<double>(phases))) % phases;
}

const std::vector<Vec3f>& LvWall::positions(double beats) const noexcept {
  return endocardium_->positions[phase_of(beats)];
}

double LvWall::wall_mm_at(std::uint32_t vertex, double beats) const noexcept {
  return static_cast<double>(map_->thickness_mm[phase_of(beats)][vertex]);
}

WallPlace LvWall::place(std::uint32_t vertex, double away2_mm2) const noexcept {
  return {.vertex = vertex,
          .away_mm = std::sqrt(away2_mm2),
          .long_axis = static_cast<double>(map_->long_axis[vertex]),
          .segment = map_->segment[vertex],
          .wall_mm = static_cast<double>(wall_mm()[vertex])};
}

WallPlace LvWall::nearest(const Vec3& mm, double beats) const noexcept {
  const std::vector<Vec3f>& at = positions(beats);
  const std::vector<float>& wall = wall_mm();
  const Vec3f x = mm.cast<float>();
  float best = std::numeric_limits<float>::infinity();
  std::uint32_t found = 0;
  for (std::uint32_t v = 0; v < at.size(); ++v) {
    const float away = (at[v] - x).squaredNorm();
    if (!(away < best) || !(wall[v] > 0)) continue;
    best = away;
    found = v;
  }
  return place(found, static_cast<double>(best));
}

WallPlace LvWall::near(const Vec3& mm, double beats, std::uint32_t from) const noexcept {
  const std::vector<Vec3f>& at = positions(beats);
  const Vec3f x = mm.cast<float>();
  std::uint32_t here = from < at.size() ? from : 0;
  float best = (at[here] - x).squaredNorm();
  for (int step = 0; step < kMostSteps; ++step) {
    std::uint32_t next = here;
    for (std::uint32_t n = first_neighbour_[here]; n < first_neighbour_[here + 1]; ++n) {
      const float away = (at[neighbours_[n]] - x).squaredNorm();
      if (!(away < best)) continue;
      best = away;
      next = neighbours_[n];
    }
    if (next == here) break;
    here = next;
  }
  return place(here, static_cast<double>(best));
}

WallPlace LvWall::follow(const Vec3& mm, double beats, Trail& trail) const noexcept {
  const std::vector<Vec3f>& at = positions(beats);
  const std::vector<float>& wall = wall_mm();
  const Vec3f x = mm.cast<float>();
  const auto away2 = [&](std::uint32_t v) { return (at[v] - x).squaredNorm(); };
  const std::uint32_t from = trail.vertex < at.size() ? trail.vertex : 0;
  // It may go by places without a wall; it stays at none if it has seen one with.
  std::uint32_t here = from;
  float best = away2(here);
  std::uint32_t found = from;
  float least = wall[from] > 0 ? best : std::numeric_limits<float>::infinity();
  const auto see = [&](std::uint32_t v, float away) {
    if (!(away < least) || !(wall[v] > 0)) return;
    least = away;
    found = v;
  };
  for (int step = 0; step < kMostSteps; ++step) {
    std::uint32_t next = here;
    for (std::uint32_t n = first_neighbour_[here]; n < first_neighbour_[here + 1]; ++n) {
      const std::uint32_t v = neighbours_[n];
      const float away = away2(v);
      see(v, away);
      if (!(away < best)) continue;
      best = away;
      next = v;
    }
    if (next == here) break;
    here = next;
  }
  std::uint32_t look = trail.looked < at.size() ? trail.looked : 0;
  for (std::size_t n = 0; n < std::min(kLookedAt, at.size()); ++n) {
    see(look, away2(look));
    if (++look == at.size()) look = 0;
  }
  trail = {.vertex = found, .looked = look};
  return place(found, static_cast<double>(away2(found)));
}

std::uint32_t LvWall::middle_of(int segment) const {
  const std::vector<Vec3f>& at = endocardium_->positions[end_diastole_];
  Vec3 sum = Vec3::Zero();
  double weight = 0;
  for (std::size_t v = 0; v < at.size(); ++v) {
    if (map_->segment[v] != segment) continue;
    sum += share_[v] * at[v].cast<double>();
    weight += share_[v];
  }
  if (!(weight > 0)) {
    throw_invalid("the LV's wall has no segment " + std::to_string(segment) +
                  "; look at mesh/map_lv_blood.csv of the study");
  }
  const Vec3 mean = sum / weight;
  std::uint32_t out = 0;
  double best = std::numeric_limits<double>::infinity();
  for (std::uint32_t v = 0; v < at.size(); ++v) {
    const double away = (at[v].cast<double>() - mean).squaredNorm();
    if (map_->segment[v] != segment || !(share_[v] > 0) || !(away < best)) continue;
    best = away;
    out = v;
  }
  return out;
}

LvWall::Material LvWall::material_at(const Vec3& mm, double beats) const {
  const std::size_t phases = endocardium_->positions.size();
  const double along =
      (std::isfinite(beats) ? beats - std::floor(beats) : 0) * static_cast<double>(phases);
  const std::size_t before = static_cast<std::size_t>(along) % phases;
  const double share = along - std::floor(along);
  const std::vector<Vec3f>& from = endocardium_->positions[before];
  const std::vector<Vec3f>& to = endocardium_->positions[(before + 1) % phases];
  const auto at = [&](std::uint32_t v) -> Vec3 {
    return (1 - share) * from[v].cast<double>() + share * to[v].cast<double>();
  };
  Material out;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& triangle : endocardium_->triangles) {
    if (std::any_of(triangle.begin(), triangle.end(),
                    [&](std::uint32_t v) { return !(wall_mm()[v] > 0); })) {
      continue;
    }
    const Vec3 weights = nearest_of_triangle(mm, at(triangle[0]), at(triangle[1]), at(triangle[2]));
    const auto mixed = [&](const auto& place) -> Vec3 {
      return weights[0] * place(triangle[0]) + weights[1] * place(triangle[1]) +
             weights[2] * place(triangle[2]);
    };
    const double away = (mixed(at) - mm).squaredNorm();
    if (!(away < least)) continue;
    least = away;
    Eigen::Index nearest = 0;
    weights.maxCoeff(&nearest);
    out = {.mm = mixed([&](std::uint32_t v) { return this->mm(v); }),
           .vertex = triangle[static_cast<std::size_t>(nearest)]};
  }
  return out;
}

std::shared_ptr<const LvWall> lv_wall_of(const atlas::Atlas& package) {
  const auto map = package.surface_map(Structure::LvBlood);
  if (!map) return nullptr;
  return std::make_shared<const LvWall>(package.surface(Structure::LvBlood), map,
                                        package.manifest().end_diastole);
}

}  // namespace beatlas::palpation
