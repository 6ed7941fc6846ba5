#include "pipeline/mesh/levels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "pipeline/core/parallel.h"
#include "pipeline/field/interpolant.h"
#include "pipeline/mesh/cycle_fit.h"
#include "pipeline/mesh/triangle_mesh.h"
#include "runtime/base/error.h"

namespace beatlas::mesh {
namespace {

void check(const SurfaceCycle& surface, const FieldCycle& field) {
  const std::size_t phases = field.distance_mm.phases.size();
  if (phases == 0 || surface.positions.size() != phases || surface.triangles.empty()) {
    throw_invalid("field and surface of " + std::string(structure_name(field.structure)) +
                  " are of different phases; run the stage mesh again");
  }
}

std::vector<Vec3> as_double(const std::vector<Vec3f>& points) {
  std::vector<Vec3> out;
  out.reserve(points.size());
  for (const Vec3f& x : points) out.emplace_back(x.cast<double>());
  return out;
}

}  // namespace

SurfaceCycle level_of_detail(const SurfaceCycle& surface, const FieldCycle& field,
                             const MeshOptions& options, StageContext& context) {
  check(surface, field);
  check_options(field, options);
  const double edge_mm = triangle_edge_mm(field.voxel_mm, options);
  const std::size_t phases = surface.positions.size();
  std::vector<field::Interpolant> zero;
  zero.reserve(phases);
  for (const std::vector<float>& samples : field.distance_mm.phases) {
    zero.emplace_back(field.distance_mm.grid, samples);
  }

  const auto reference = static_cast<std::size_t>(std::max(0, options.reference_phase));
  const TriangleMesh from{as_double(surface.positions[reference]), surface.triangles};
  const TriangleMesh mesh = remeshed(from, edge_mm);
  constexpr std::size_t kFewestTriangles = 32;
  const Topology after = inspect(mesh.points.size(), mesh.triangles);
  if (!after.closed_manifold || mesh.triangles.size() < kFewestTriangles ||
      after.euler_number != inspect(from.points.size(), from.triangles).euler_number) {
    char text[64];
    std::snprintf(text, sizeof text, "%g", edge_mm);
    throw Error(ErrorCode::Quality, "the surface of " +
                                        std::string(structure_name(field.structure)) +
                                        " is too small for triangles of " + text + " mm");
  }
  context.progress(0.1, "places of vertices");
  const std::vector<OnTriangle> places = located(from, mesh.points);
  Cycle cycle(phases);
  parallel_for(phases, [&](std::size_t p) {
    const std::vector<Vec3f>& old = surface.positions[p];
    cycle[p].reserve(places.size());
    for (const OnTriangle& place : places) {
      const Triangle& t = surface.triangles[place.triangle];
      Vec3 at = Vec3::Zero();
      for (std::size_t n = 0; n < 3; ++n) at += place.weight[n] * old[t[n]].cast<double>();
      cycle[p].push_back(at);
    }
  });
  context.progress(0.2, "fit to all phases");
  CycleFit fit(mesh.triangles, zero, edge_mm);
  fit.settle(cycle);
  context.progress(0.8, "thin triangles and crossings");
  if (const int left = fit.mend(cycle); left > 0) {
    context.warn("a level of detail of " + std::string(structure_name(field.structure)) +
                 " passes through itself at " + std::to_string(left) +
                 " pairs of triangles, all phases together");
  }
  SurfaceCycle out;
  out.structure = surface.structure;
  out.triangles = fit.triangles();
  for (const std::vector<Vec3>& phase : cycle) {
    std::vector<Vec3f>& points = out.positions.emplace_back();
    points.reserve(phase.size());
    for (const Vec3& x : phase) points.emplace_back(x.cast<float>());
  }
  context.progress(1.0);
  return out;
}

SurfaceError error_against(const FieldCycle& field, const SurfaceCycle& surface) {
  check(surface, field);
  const std::size_t phases = surface.positions.size();
  std::vector<OffSurface> sums(phases);
  parallel_for(phases, [&](std::size_t p) {
    const field::Interpolant zero(field.distance_mm.grid, field.distance_mm.phases[p]);
    sums[p] = off_surface(as_double(surface.positions[p]), surface.triangles, zero);
  });
  SurfaceError out;
  OffSurface all;
  for (const OffSurface& phase : sums) {
    all.area += phase.area;
    all.off += phase.off;
    all.signed_off += phase.signed_off;
    out.worst_phase_mm = std::max(out.worst_phase_mm, phase.mean_mm());
  }
  out.mean_mm = all.mean_mm();
  out.bias_mm = all.signed_off / all.area;
  return out;
}

}  // namespace beatlas::mesh
