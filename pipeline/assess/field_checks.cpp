#include "pipeline/assess/field_checks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "pipeline/assess/lattice_of_field.h"
#include "pipeline/assess/statistics.h"
#include "pipeline/core/parallel.h"

namespace beatlas::assess {
namespace {

double phase_time_s(const field::FieldQuery& query, std::size_t phase, std::size_t phases) {
  return query.rr_interval_s() * static_cast<double>(phase) / static_cast<double>(phases);
}

/// Samples of the pieces of inside (or outside) that are not the largest one. Neighbours share a
/// face; the outside reaches round the lattice.
std::size_t beside_the_largest(const std::vector<char>& inside, const Index3& size, bool value) {
  const auto nx = static_cast<std::size_t>(size[0]);
  const auto ny = static_cast<std::size_t>(size[1]);
  const auto nz = static_cast<std::size_t>(size[2]);
  std::vector<char> seen(inside.size(), 0);
  std::vector<std::size_t> stack;
  std::size_t all = 0;
  std::size_t largest = 0;
  for (std::size_t start = 0; start < inside.size(); ++start) {
    if (seen[start] != 0 || (inside[start] != 0) != value) continue;
    std::size_t count = 0;
    stack.push_back(start);
    seen[start] = 1;
    while (!stack.empty()) {
      const std::size_t at = stack.back();
      stack.pop_back();
      ++count;
      const auto visit = [&](bool there, std::size_t next) {
        if (!there || seen[next] != 0 || (inside[next] != 0) != value) return;
        seen[next] = 1;
        stack.push_back(next);
      };
      const std::size_t x = at % nx;
      const std::size_t y = at / nx % ny;
      const std::size_t z = at / (nx * ny);
      visit(x > 0, at - 1);
      visit(x + 1 < nx, at + 1);
      visit(y > 0, at - nx);
      visit(y + 1 < ny, at + nx);
      visit(z > 0, at - nx * ny);
      visit(z + 1 < nz, at + nx * ny);
    }
    all += count;
    largest = std::max(largest, count);
  }
  return all - largest;
}

std::vector<Vec3> vertex_normals(const atlas::SurfacePayload& surface,
                                 const std::vector<Vec3f>& positions) {
  std::vector<Vec3> out(positions.size(), Vec3::Zero());
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3 first = positions[a].cast<double>();
    const Vec3 normal =
        (positions[b].cast<double>() - first).cross(positions[c].cast<double>() - first);
    for (const std::uint32_t vertex : {a, b, c}) out[vertex] += normal;
  }
  for (Vec3& normal : out) normal.normalize();
  return out;
}

}  // namespace

std::vector<PhaseOfField> look_at_phases(const atlas::FieldPayload& field) {
  const auto phases = static_cast<std::size_t>(field.phases);
  const double voxel_ml = std::pow(field.voxel_mm, 3) * 1e-3;
  std::vector<PhaseOfField> out(phases);
  parallel_for(phases, [&](std::size_t phase) {
    const LatticeOfField lattice = lattice_of_field(field, phase);
    std::vector<char> inside(lattice.distance_mm.size());
    double voxels_inside = 0;
    std::size_t count = 0;
    for (std::size_t n = 0; n < inside.size(); ++n) {
      const double distance = lattice.distance_mm[n];
      voxels_inside += std::clamp(0.5 - distance / field.voxel_mm, 0.0, 1.0);
      inside[n] = distance < 0.0 ? 1 : 0;
      if (distance < 0.0) ++count;
    }
    std::vector<Weighted> slopes;
    for (const float slope : lattice.slopes) slopes.push_back({slope - 1.0});
    out[phase].volume_ml = voxels_inside * voxel_ml;
    out[phase].slope_error = pooled_statistics(slopes, {}).p95;
    if (count > 0) {
      const std::size_t stray = beside_the_largest(inside, lattice.size, true) +
                                beside_the_largest(inside, lattice.size, false);
      out[phase].stray_percent = 100.0 * static_cast<double>(stray) / static_cast<double>(count);
    }
  });
  return out;
}

double vertex_distance_mm(const field::FieldQuery& query, const atlas::SurfacePayload& surface) {
  double worst = 0;
  const std::size_t phases = surface.positions.size();
  for (std::size_t phase = 0; phase < phases; ++phase) {
    const double t_s = phase_time_s(query, phase, phases);
    double squares = 0;
    for (const Vec3f& vertex : surface.positions[phase]) {
      squares += std::pow(query.sample(vertex.cast<double>(), t_s).distance_mm, 2);
    }
    worst = std::max(worst, std::sqrt(squares / static_cast<double>(std::max<std::size_t>(
                                                    1, surface.positions[phase].size()))));
  }
  return worst;
}

double surface_error_mm(const field::FieldQuery& query, const atlas::SurfacePayload& surface) {
  const std::size_t phases = surface.positions.size();
  double worst = 0;
  for (std::size_t phase = 0; phase < phases; ++phase) {
    const std::vector<Vec3f>& positions = surface.positions[phase];
    const double t_s = phase_time_s(query, phase, phases);
    double area = 0;
    double off = 0;
    for (const auto& triangle : surface.triangles) {
      std::array<Vec3, 3> corner;
      for (std::size_t n = 0; n < 3; ++n) corner[n] = positions[triangle[n]].cast<double>();
      const Vec3 middle = (corner[0] + corner[1] + corner[2]) / 3;
      const double share = (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm();
      area += 4 * share;
      off += share * std::abs(query.sample(middle, t_s).distance_mm);
      for (const Vec3& x : corner) {
        off += share * std::abs(query.sample((middle + x) / 2, t_s).distance_mm);
      }
    }
    worst = std::max(worst, area > 0 ? off / area : 0);
  }
  return worst;
}

double wrong_side_percent(const field::FieldQuery& query, const atlas::SurfacePayload& surface) {
  const double step_mm = query.payload().voxel_mm;
  const std::size_t phases = surface.positions.size();
  double worst = 0;
  for (std::size_t phase = 0; phase < phases; ++phase) {
    const std::vector<Vec3f>& positions = surface.positions[phase];
    const std::vector<Vec3> normals = vertex_normals(surface, positions);
    const double t_s = phase_time_s(query, phase, phases);
    std::size_t wrong = 0;
    for (std::size_t n = 0; n < positions.size(); ++n) {
      const Vec3 x = positions[n].cast<double>();
      const double out = query.sample(x + step_mm * normals[n], t_s).distance_mm;
      const double in = query.sample(x - step_mm * normals[n], t_s).distance_mm;
      if (!(out > 0.0 && in < 0.0)) ++wrong;
    }
    if (!positions.empty()) {
      worst = std::max(worst,
                       100.0 * static_cast<double>(wrong) / static_cast<double>(positions.size()));
    }
  }
  return worst;
}

}  // namespace beatlas::assess
