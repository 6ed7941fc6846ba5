#include "pipeline/mesh/rv_wall.h"

#include <algorithm>
#include <optional>

#include "pipeline/field/interpolant.h"
#include "pipeline/mesh/triangle_mesh.h"
#include "pipeline/mesh/zero_along.h"

namespace beatlas::mesh {
namespace {

constexpr double kNormalWallMm = 5;  // the most that is normal (Rudski et al. 2010)
constexpr double kThickestFreeWallMm = 3 * kNormalWallMm;
constexpr double kVoxelsOfWall = 2;  // that a wall must be thick to be resolved
constexpr double kAlongWayMm = 0.5;  // below a sample of the fields
constexpr double kAcrossWall =
    0.5;  // cosine between the way and the heart's normal where it leaves

std::optional<field::Interpolant> distances(const std::vector<FieldCycle>& fields,
                                            Structure structure, std::size_t phase) {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const FieldCycle& each) {
    return each.structure == structure;
  });
  if (found == fields.end()) return std::nullopt;
  return field::Interpolant(found->distance_mm.grid, found->distance_mm.phases[phase]);
}

}  // namespace

std::vector<double> rv_wall_mm(const std::vector<FieldCycle>& fields, const SurfaceCycle& rv,
                               std::size_t phase, const MapFrame& frame) {
  std::vector<double> out(rv.positions[phase].size(), 0.0);
  const auto heart = distances(fields, Structure::Heart, phase);
  if (!heart || phase >= frame.rv_base_mm.size()) return out;
  const auto muscle = distances(fields, Structure::LvMyocardium, phase);
  const auto blood = distances(fields, Structure::LvBlood, phase);
  const auto in_lv = [&](const Vec3& mm) {
    return (muscle && muscle->value(mm) < 0) || (blood && blood->value(mm) < 0);
  };
  // The way to the outside; none where it ends in the LV or is too long.
  const auto way_out_mm = [&](const Vec3& from, const Vec3& along) -> std::optional<double> {
    double low = 0;
    double high = 0;
    while (heart->value(from + high * along) < 0) {
      if (high >= kThickestFreeWallMm || in_lv(from + high * along)) return std::nullopt;
      low = high;
      high += kAlongWayMm;
    }
    return high > 0 ? zero_between(*heart, from, along, low, high) : 0;
  };
  std::vector<Vec3> at;
  at.reserve(out.size());
  for (const Vec3f& x : rv.positions[phase]) at.emplace_back(x.cast<double>());
  const std::vector<Vec3> normal = vertex_normals(at, rv.triangles);
  for (std::size_t v = 0; v < at.size(); ++v) {
    const double resolved_mm = kVoxelsOfWall * normal[v].cwiseProduct(frame.voxel_mm).norm();
    if (resolved_mm > kNormalWallMm) continue;
    const std::optional<double> way_mm = way_out_mm(at[v], normal[v]);
    if (!way_mm || *way_mm < resolved_mm) continue;
    const Vec3 end = at[v] + *way_mm * normal[v];
    const bool below_base = frame.height_mm(end) < frame.rv_base_mm[phase];
    const Vec3 outward = heart->sample(end).gradient.normalized();
    if (below_base && outward.dot(normal[v]) > kAcrossWall) out[v] = *way_mm;
  }
  return out;
}

}  // namespace beatlas::mesh
