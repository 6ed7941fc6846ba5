#include "pipeline/mesh/surface_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/core/parallel.h"
#include "pipeline/field/closest_triangle.h"
#include "pipeline/field/interpolant.h"
#include "pipeline/mesh/rv_wall.h"
#include "pipeline/mesh/triangle_mesh.h"
#include "pipeline/mesh/zero_along.h"
#include "runtime/palpation/segments.h"

namespace beatlas::mesh {
namespace {

constexpr double kThickestMm = 40.0;
constexpr double kGapMm = 3.0;   // between a vertex of the endocardium and the muscle's field
constexpr double kStepMm = 0.5;  // below a sample, so that no wall is stepped over

template <class Of>
const Of* of(const std::vector<Of>& all, Structure structure) {
  const auto found = std::find_if(all.begin(), all.end(),
                                  [&](const Of& each) { return each.structure == structure; });
  return found == all.end() ? nullptr : &*found;
}

std::vector<Vec3> as_double(const std::vector<Vec3f>& points) {
  std::vector<Vec3> out;
  out.reserve(points.size());
  for (const Vec3f& p : points) out.emplace_back(p.cast<double>());
  return out;
}

/// The way from an endocardial place through the muscle; 0 if there is none.
double through_muscle_mm(const field::Interpolant& muscle, const Vec3& from, const Vec3& along) {
  double enter = 0;
  while (!(muscle.value(from + enter * along) < 0)) {
    enter += kStepMm;
    if (enter > kGapMm) return 0;
  }
  for (double way = enter; way < kThickestMm; way += kStepMm) {
    if (muscle.value(from + (way + kStepMm) * along) < 0) continue;
    return zero_between(muscle, from, along, way, way + kStepMm);
  }
  return 0;
}

/// To the nearest whole multiple of 1 / parts.
float rounded(double value, double parts) {
  return static_cast<float>(std::round(value * parts) / parts);
}

constexpr double kNameParts = 1e4;
constexpr double kThicknessParts = 100;

/// Names of places in the first phase.
SurfaceMap named(const SurfaceCycle& surface, const MapFrame& frame) {
  SurfaceMap out;
  out.structure = surface.structure;
  for (const Vec3f& x : surface.positions.front()) {
    const Vec3 from = x.cast<double>() - frame.origin_mm;
    const double share =
        (frame.height_mm(x.cast<double>()) - frame.apex_mm) / (frame.base_mm - frame.apex_mm);
    double angle = std::atan2(from.dot(frame.septal), from.dot(frame.anterior));
    if (angle < 0) angle += 2 * std::numbers::pi;
    out.long_axis.push_back(rounded(std::clamp(share, 0.0, 1.0), kNameParts));
    out.angle_rad.push_back(rounded(angle, kNameParts));
    if (out.angle_rad.back() > 2 * std::numbers::pi) out.angle_rad.back() = 0;
    const int segment = surface.structure == Structure::RvBlood
                            ? 0
                            : palpation::segment_at(out.long_axis.back(), out.angle_rad.back());
    out.segment.push_back(static_cast<std::uint8_t>(segment));
  }
  return out;
}

std::vector<double> from_endocardium_mm(const field::Interpolant& muscle, const SurfaceCycle& blood,
                                        std::size_t phase) {
  const std::vector<Vec3> at = as_double(blood.positions[phase]);
  const std::vector<Vec3> normal = vertex_normals(at, blood.triangles);
  std::vector<double> out;
  for (std::size_t v = 0; v < at.size(); ++v) {
    out.push_back(through_muscle_mm(muscle, at[v], normal[v]));
  }
  return out;
}

/// Of a surface that is both the endocardium and the epicardium.
std::vector<double> from_muscle_mm(const field::Interpolant& inside, const SurfaceCycle& blood,
                                   const SurfaceCycle& muscle, std::size_t phase) {
  constexpr double kOnEndocardiumMm = 1.5;
  constexpr double kAlong = 0.5;  // cosine between a normal and the way to the endocardium
  constexpr double kProbeMm = 0.25;
  const field::ClosestTriangle endocardium({as_double(blood.positions[phase]), blood.triangles});
  const auto away_mm = [&](const Vec3& mm) {
    return std::sqrt(endocardium.nearest(mm, {}).distance2_mm2);
  };
  const std::vector<Vec3> at = as_double(muscle.positions[phase]);
  const std::vector<Vec3> normal = vertex_normals(at, muscle.triangles);
  std::vector<double> out;
  for (std::size_t v = 0; v < at.size(); ++v) {
    const double away = away_mm(at[v]);
    double thick = 0;
    if (away < kOnEndocardiumMm) {
      thick = through_muscle_mm(inside, at[v], -normal[v]);
    } else if (away < kThickestMm &&
               away_mm(at[v] + kProbeMm * normal[v]) - away > kAlong * kProbeMm) {
      thick = away;
    }
    out.push_back(thick);
  }
  return out;
}

}  // namespace

std::optional<MapFrame> map_frame(const std::optional<LongAxis>& axis,
                                  const Affine& workspace_from_lps, const Vec3& voxel_mm) {
  if (!axis || !axis->rv_centre_mm) return std::nullopt;
  const Vec3 to_front_and_above = workspace_from_lps.linear() * Vec3(0, -1, 1);
  MapFrame out;
  out.origin_mm = workspace_from_lps * axis->origin_mm;
  out.towards_base = (workspace_from_lps.linear() * axis->towards_base).normalized();
  const Vec3 to_rv = workspace_from_lps * *axis->rv_centre_mm - out.origin_mm;
  out.septal = (to_rv - to_rv.dot(out.towards_base) * out.towards_base).normalized();
  out.anterior = out.towards_base.cross(out.septal);
  if (out.anterior.dot(to_front_and_above) < 0) out.anterior = -out.anterior;
  out.apex_mm = axis->apex_mm.front();
  out.base_mm = axis->lv_base_mm.front();
  out.rv_base_mm = axis->rv_base_mm;
  out.voxel_mm = voxel_mm;
  return out;
}

std::optional<SurfaceMap> surface_map(Structure structure, const std::vector<FieldCycle>& fields,
                                      const std::vector<SurfaceCycle>& surfaces,
                                      const MapFrame& frame) {
  const FieldCycle* muscle_field = of(fields, Structure::LvMyocardium);
  const SurfaceCycle* blood = of(surfaces, Structure::LvBlood);
  const SurfaceCycle* mapped = of(surfaces, structure);
  const bool both_sides = structure == Structure::LvMyocardium;
  if (muscle_field == nullptr || mapped == nullptr || (both_sides && blood == nullptr)) {
    return std::nullopt;
  }
  SurfaceMap out = named(*mapped, frame);
  out.thickness_mm.resize(mapped->positions.size());
  parallel_for(mapped->positions.size(), [&](std::size_t p) {
    const field::Interpolant inside(muscle_field->distance_mm.grid,
                                    muscle_field->distance_mm.phases[p]);
    const std::vector<double> thick = structure == Structure::RvBlood
                                          ? rv_wall_mm(fields, *mapped, p, frame)
                                      : both_sides ? from_muscle_mm(inside, *blood, *mapped, p)
                                                   : from_endocardium_mm(inside, *mapped, p);
    for (const double mm : thick) out.thickness_mm[p].push_back(rounded(mm, kThicknessParts));
  });
  return out;
}

}  // namespace beatlas::mesh
