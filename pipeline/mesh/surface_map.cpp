#include "pipeline/mesh/surface_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/core/parallel.h"
#include "pipeline/field/closest_triangle.h"
#include "pipeline/field/interpolant.h"
#include "pipeline/mesh/triangle_mesh.h"
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

/// The zero between two places of a ray, to 1e-4 mm.
double zero_between(const field::Interpolant& muscle, const Vec3& from, const Vec3& along,
                    double low, double high) {
  const bool low_inside = muscle.value(from + low * along) < 0;
  while (high - low > 1e-4) {
    const double middle = 0.5 * (low + high);
    ((muscle.value(from + middle * along) < 0) == low_inside ? low : high) = middle;
  }
  return 0.5 * (low + high);
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
SurfaceMap named(const SurfaceCycle& surface, const LvFrame& frame) {
  SurfaceMap out;
  out.structure = surface.structure;
  for (const Vec3f& x : surface.positions.front()) {
    const Vec3 from = x.cast<double>() - frame.origin_mm;
    const double share =
        (from.dot(frame.towards_base) - frame.apex_mm) / (frame.base_mm - frame.apex_mm);
    double angle = std::atan2(from.dot(frame.septal), from.dot(frame.anterior));
    if (angle < 0) angle += 2 * std::numbers::pi;
    out.long_axis.push_back(rounded(std::clamp(share, 0.0, 1.0), kNameParts));
    out.angle_rad.push_back(rounded(angle, kNameParts));
    if (out.angle_rad.back() > 2 * std::numbers::pi) out.angle_rad.back() = 0;
    out.segment.push_back(static_cast<std::uint8_t>(
        palpation::segment_at(out.long_axis.back(), out.angle_rad.back())));
  }
  return out;
}

}  // namespace

LvFrame lv_frame(const LongAxis& axis, const Affine& workspace_from_lps, const Vec3& rv_centre_mm) {
  const Vec3 to_front_and_above = workspace_from_lps.linear() * Vec3(0, -1, 1);
  LvFrame out;
  out.origin_mm = workspace_from_lps * axis.origin_mm;
  out.towards_base = (workspace_from_lps.linear() * axis.towards_base).normalized();
  const Vec3 to_rv = rv_centre_mm - out.origin_mm;
  out.septal = (to_rv - to_rv.dot(out.towards_base) * out.towards_base).normalized();
  out.anterior = out.towards_base.cross(out.septal);
  if (out.anterior.dot(to_front_and_above) < 0) out.anterior = -out.anterior;
  out.apex_mm = axis.apex_mm.front();
  out.base_mm = axis.lv_base_mm.front();
  return out;
}

std::vector<SurfaceMap> surface_maps(const std::vector<FieldCycle>& fields,
                                     const std::vector<SurfaceCycle>& surfaces,
                                     const LvFrame& frame) {
  const FieldCycle* muscle_field = of(fields, Structure::LvMyocardium);
  const SurfaceCycle* blood = of(surfaces, Structure::LvBlood);
  const SurfaceCycle* muscle = of(surfaces, Structure::LvMyocardium);
  if (muscle_field == nullptr || blood == nullptr || muscle == nullptr) return {};
  std::vector<SurfaceMap> out{named(*blood, frame), named(*muscle, frame)};
  const std::size_t phases = blood->positions.size();
  for (SurfaceMap& map : out) map.thickness_mm.resize(phases);
  parallel_for(phases, [&](std::size_t p) {
    constexpr double kOnEndocardiumMm = 1.5;
    constexpr double kAlong = 0.5;  // cosine between a normal and the way to the endocardium
    const field::Interpolant inside(muscle_field->distance_mm.grid,
                                    muscle_field->distance_mm.phases[p]);
    const std::vector<Vec3> inner = as_double(blood->positions[p]);
    const std::vector<Vec3> inner_normal = vertex_normals(inner, blood->triangles);
    std::vector<float>& of_blood = out[0].thickness_mm[p];
    for (std::size_t v = 0; v < inner.size(); ++v) {
      of_blood.push_back(
          rounded(through_muscle_mm(inside, inner[v], inner_normal[v]), kThicknessParts));
    }
    const field::ClosestTriangle endocardium({inner, blood->triangles});
    const std::vector<Vec3> wall = as_double(muscle->positions[p]);
    const std::vector<Vec3> wall_normal = vertex_normals(wall, muscle->triangles);
    std::vector<float>& of_muscle = out[1].thickness_mm[p];
    const auto away_mm = [&](const Vec3& mm) {
      return std::sqrt(endocardium.nearest(mm, {}).distance2_mm2);
    };
    for (std::size_t v = 0; v < wall.size(); ++v) {
      constexpr double kProbeMm = 0.25;
      const double away = away_mm(wall[v]);
      double thick = 0;
      if (away < kOnEndocardiumMm) {
        thick = through_muscle_mm(inside, wall[v], -wall_normal[v]);
      } else if (away < kThickestMm &&
                 away_mm(wall[v] + kProbeMm * wall_normal[v]) - away > kAlong * kProbeMm) {
        thick = away;
      }
      of_muscle.push_back(rounded(thick, kThicknessParts));
    }
  });
  return out;
}

}  // namespace beatlas::mesh
