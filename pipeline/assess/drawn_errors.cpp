#include "pipeline/assess/drawn_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "pipeline/assess/statistics.h"
#include "pipeline/assess/surface_checks.h"
#include "pipeline/core/parallel.h"
#include "runtime/base/triangle.h"

namespace beatlas::assess {
namespace {

struct Triangle {
  std::array<Vec3, 3> corners;
  Vec3 middle = Vec3::Zero();
  double reach = 0;  ///< [mm] from the middle to the farthest corner

  [[nodiscard]] Vec3 area_normal() const {
    return 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  }
};

template <class Item, class Height>
void sort_by_height(std::vector<Item>& items, const Height& height) {
  std::stable_sort(items.begin(), items.end(),
                   [&](const Item& a, const Item& b) { return height(a) < height(b); });
}

/// Calls visit(item, |height - z|) of items in the order of their heights, from z upward and then
/// downward, each way until it returns false.
template <class Item, class Height, class Visit>
void each_by_height(const std::vector<Item>& items, const Height& height, double z,
                    const Visit& visit) {
  const auto middle =
      std::lower_bound(items.begin(), items.end(), z,
                       [&](const Item& item, double value) { return height(item) < value; });
  for (auto it = middle; it != items.end() && visit(*it, height(*it) - z); ++it) continue;
  for (auto it = middle; it != items.begin();) {
    --it;
    if (!visit(*it, z - height(*it))) break;
  }
}

struct TriangleSet {
  std::vector<Triangle> triangles;  ///< by the height of their middles
  double reach = 0;                 ///< [mm] the largest
};

/// In workspace [mm].
TriangleSet triangles_of(const atlas::SurfacePayload& surface, std::size_t phase) {
  const std::vector<Vec3f>& positions = surface.positions[phase];
  TriangleSet out;
  out.triangles.reserve(surface.triangles.size());
  for (const auto& corners : surface.triangles) {
    Triangle triangle;
    for (std::size_t c = 0; c < 3; ++c) triangle.corners[c] = positions[corners[c]].cast<double>();
    triangle.middle = (triangle.corners[0] + triangle.corners[1] + triangle.corners[2]) / 3;
    for (const Vec3& corner : triangle.corners) {
      triangle.reach = std::max(triangle.reach, (corner - triangle.middle).norm());
    }
    out.triangles.push_back(triangle);
    out.reach = std::max(out.reach, triangle.reach);
  }
  sort_by_height(out.triangles, [](const Triangle& triangle) { return triangle.middle.z(); });
  return out;
}

/// [mm] + outside; none where there is no triangle.
std::optional<double> signed_distance(const TriangleSet& set, const Vec3& x) {
  double least = std::numeric_limits<double>::infinity();
  double side = 1;
  const auto height = [](const Triangle& triangle) { return triangle.middle.z(); };
  each_by_height(set.triangles, height, x.z(), [&](const Triangle& triangle, double dz) {
    if (dz - set.reach >= least) return false;
    if ((triangle.middle - x).norm() - triangle.reach >= least) return true;
    const auto& [a, b, c] = triangle.corners;
    const Vec3 weights = nearest_of_triangle(x, a, b, c);
    const Vec3 off = x - weights[0] * a - weights[1] * b - weights[2] * c;
    if (off.norm() >= least) return true;
    least = off.norm();
    side = off.dot(triangle.area_normal());
    return true;
  });
  if (set.triangles.empty()) return {};
  return std::copysign(least, side);
}

/// Whether a place lies within the images or half a voxel beyond them.
bool is_seen(const Grid& seen, const Vec3& lps) {
  const Vec3 index = seen.mm_from_index.inverse() * lps;
  for (int axis = 0; axis < 3; ++axis) {
    if (index[axis] < -0.5 || index[axis] > seen.size[static_cast<std::size_t>(axis)] - 0.5) {
      return false;
    }
  }
  return true;
}

using DrawnPoint = phantom::DrawnTruth::Frame::Point;

double height_of(const DrawnPoint& point) { return point.lps.z(); }

/// [mm] Without a sign; none where there are no points. @param points by height_of
std::optional<double> distance_from(const std::vector<DrawnPoint>& points, double spacing_mm,
                                    const Vec3& lps) {
  const DrawnPoint* nearest = nullptr;
  double least = std::numeric_limits<double>::infinity();
  each_by_height(points, height_of, lps.z(), [&](const DrawnPoint& point, double dz) {
    if (dz * dz >= least) return false;
    const double squared = (lps - point.lps).squaredNorm();
    if (squared >= least) return true;
    least = squared;
    nearest = &point;
    return true;
  });
  if (nearest == nullptr) return {};
  // Beside the point, as far as to the next ones, the surface is its plane.
  const double across = (lps - nearest->lps).dot(nearest->normal);
  const double beside = std::sqrt(std::max(0.0, least - across * across));
  return std::hypot(across, std::max(0.0, beside - spacing_mm));
}

}  // namespace

TrueSurface true_surface(const phantom::Phantom& truth, Structure structure, int p, int phases,
                         const CompareOptions& options) {
  const double share = p / static_cast<double>(phases);
  const auto frame = truth.frame(share * truth.spec().rr_interval_s);
  const auto on_crease = [frame, structure, band_mm = options.crease_band_mm](const Vec3& lps) {
    return frame->crease_distance_mm(structure, lps) < band_mm;
  };
  TrueSurface out;
  for (const Vec3& lps : frame->sample_surface(structure, options.sample_spacing_mm)) {
    if (!on_crease(lps)) out.points.push_back({lps});
  }
  out.distance_mm = [frame, structure, on_crease](const Vec3& lps) -> std::optional<double> {
    const phantom::Nearest nearest = frame->nearest(structure, lps);
    if (on_crease(nearest.point)) return {};
    return nearest.distance_mm;
  };
  return out;
}

TrueSurface true_surface(const phantom::DrawnTruth::Frame& frame, Structure structure,
                         double spacing_mm, const Grid& seen) {
  const auto is_asked = [&frame, structure, seen](const Vec3& lps) {
    return is_seen(seen, lps) && (structure != Structure::Heart || frame.below_base(lps));
  };
  std::vector<DrawnPoint> points = frame.surface(structure);
  sort_by_height(points, height_of);
  TrueSurface out;
  for (const DrawnPoint& point : points) {
    if (is_asked(point.lps)) out.points.push_back({point.lps, point.area_mm2});
  }
  out.distance_mm = [&frame, structure, spacing_mm, is_asked,
                     points = std::move(points)](const Vec3& lps) -> std::optional<double> {
    if (!is_asked(lps)) return {};
    const std::optional<double> least = distance_from(points, spacing_mm, lps);
    if (!least) return {};
    return frame.contains(structure, lps) ? -*least : *least;
  };
  return out;
}

std::vector<VertexError> vertex_errors(const atlas::SurfacePayload& surface,
                                       const Affine& workspace_from_lps, int p,
                                       const TrueSurface& truth) {
  const std::vector<Vec3f>& positions = surface.positions[static_cast<std::size_t>(p)];
  std::vector<VertexError> out(positions.size());
  for (const auto& corners : surface.triangles) {
    const Vec3 a = positions[corners[0]].cast<double>();
    const Vec3 area_normal =
        0.5 *
        (positions[corners[1]].cast<double>() - a).cross(positions[corners[2]].cast<double>() - a);
    for (const std::uint32_t vertex : corners) {
      out[vertex].normal += area_normal;
      out[vertex].area_mm2 += area_normal.norm() / 3;
    }
  }
  const Affine lps_from_workspace = workspace_from_lps.inverse();
  parallel_for(out.size(), [&](std::size_t v) {
    VertexError& vertex = out[v];
    vertex.place = positions[v].cast<double>();
    vertex.normal.normalize();
    const std::optional<double> off = truth.distance_mm(lps_from_workspace * vertex.place);
    vertex.off_mm = off.value_or(0);
    if (!off) vertex.area_mm2 = 0;
  });
  std::erase_if(out, [](const VertexError& vertex) { return vertex.area_mm2 == 0; });
  return out;
}

DrawnErrors drawn_errors(const atlas::SurfacePayload& surface, const Affine& workspace_from_lps,
                         int p, const TrueSurface& truth, const std::vector<VertexError>& vertices,
                         double true_ml) {
  const auto phase = static_cast<std::size_t>(p);
  const TriangleSet triangles = triangles_of(surface, phase);
  std::vector<Weighted> to_truth;
  to_truth.reserve(vertices.size());
  for (const VertexError& vertex : vertices) to_truth.push_back({vertex.off_mm, vertex.area_mm2});
  std::vector<Weighted> to_package(truth.points.size(), {0, 0});
  parallel_for(to_package.size(), [&](std::size_t n) {
    const TrueSurface::Point& point = truth.points[n];
    const std::optional<double> distance =
        signed_distance(triangles, workspace_from_lps * point.lps);
    if (distance) to_package[n] = {-*distance, point.area};
  });
  std::erase_if(to_package, [](const Weighted& each) { return each.weight == 0; });
  DrawnErrors out;
  set_distances(pooled_statistics(to_truth, to_package), out);
  out.volume_error_ml = enclosed_volume_ml(surface.triangles, surface.positions[phase]) - true_ml;
  out.volume_error_percent = 100 * out.volume_error_ml / true_ml;
  out.points = static_cast<int>(to_truth.size() + to_package.size());
  return out;
}

}  // namespace beatlas::assess
