#include "pipeline/alarm/surface_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "pipeline/core/slices.h"
#include "pipeline/tissue/tissue.h"

namespace beatlas::alarm {
namespace {

constexpr double kSmoothMm = 2.0;  ///< of the mask, whose steps are no normals
constexpr double kAverageMm = 2.5;
constexpr int kTouchPx = 2;  ///< points of one outline this near are neighbours

bool thin_slices(const Grid& grid) {
  return grid.size[2] > 1 && !are_thick_slices(grid.spacing_mm()[2]);
}

/// Along the slices' axis by weights 1/4, 1/2, 1/4.
std::vector<float> smooth_across(const Grid& grid, const std::vector<float>& image) {
  std::vector<float> out(image.size());
  const std::size_t slice = grid.slice_count();
  const int n = grid.size[2];
  for (int k = 0; k < n; ++k) {
    const float* here = image.data() + static_cast<std::size_t>(k) * slice;
    const float* below = image.data() + static_cast<std::size_t>(std::max(0, k - 1)) * slice;
    const float* above = image.data() + static_cast<std::size_t>(std::min(n - 1, k + 1)) * slice;
    float* target = out.data() + static_cast<std::size_t>(k) * slice;
    for (std::size_t v = 0; v < slice; ++v) {
      target[v] = 0.25F * below[v] + 0.5F * here[v] + 0.25F * above[v];
    }
  }
  return out;
}

/// A body's voxels and their smoothed mask, which tells how its surface lies in them.
class BodySurface {
 public:
  /// Both must outlive this.
  BodySurface(const Grid& grid, const std::vector<std::uint8_t>& inside)
      : grid_(grid), inside_(inside), axes_(thin_slices(grid) ? 3 : 2), smooth_(inside.size()) {
    std::transform(inside.begin(), inside.end(), smooth_.begin(),
                   [](std::uint8_t in) { return in != 0 ? 1.0F : 0.0F; });
    smooth_ = tissue::smooth_in_plane(grid, smooth_,
                                      std::max(kSmoothMm, 0.8 * spacing_.head<2>().maxCoeff()));
    if (axes_ == 3) smooth_ = smooth_across(grid, smooth_);
  }

  /// None where the voxel has no face on the surface.
  [[nodiscard]] std::optional<SurfacePoint> point_in(int i, int j, int k) const {
    Vec3 open_mm2 = Vec3::Zero();  // of its faces
    Vec3 gradient = Vec3::Zero();  // [1 / mm] of the smoothed mask
    for (int axis = 0; axis < axes_; ++axis) {
      std::array<float, 2> beside{};
      double apart = 0;
      for (int side = -1; side <= 1; side += 2) {
        Index3 at{i, j, k};
        at[static_cast<std::size_t>(axis)] += side;
        const bool there = grid_.contains(at[0], at[1], at[2]);
        if (!there) at = {i, j, k};
        const std::size_t v = grid_.offset(at[0], at[1], at[2]);
        if (there && inside_[v] == 0) open_mm2[axis] += face_mm2_[axis];
        if (there) apart += spacing_[axis];
        beside[side < 0 ? 0 : 1] = smooth_[v];
      }
      if (apart > 0) gradient[axis] = (beside[1] - beside[0]) / apart;
    }
    if (open_mm2.isZero()) return {};
    SurfacePoint point;
    point.voxel = {i, j, k};
    const double steep = gradient.norm();
    point.outward_mm = steep > 0 ? Vec3(-gradient / steep) : Vec3(open_mm2.normalized());
    point.area_mm2 = open_mm2.dot(point.outward_mm.cwiseAbs());
    const double longest = 1.5 * spacing_.head(axes_).minCoeff();
    const double out_mm =
        steep > 0 ? std::clamp((smooth_[grid_.offset(i, j, k)] - 0.5) / steep, -longest, longest)
                  : 0.0;
    point.index = Vec3(i, j, k) + (out_mm * point.outward_mm).cwiseQuotient(spacing_);
    return point;
  }

 private:
  const Grid& grid_;
  const std::vector<std::uint8_t>& inside_;
  int axes_;  ///< across which it has a surface
  Vec3 spacing_ = grid_.spacing_mm();
  Vec3 face_mm2_{spacing_[1] * spacing_[2], spacing_[0] * spacing_[2], spacing_[0] * spacing_[1]};
  std::vector<float> smooth_;
};

/// Points joined to patches.
class JoinedPoints {
 public:
  explicit JoinedPoints(std::size_t count) : root_(count) {
    std::iota(root_.begin(), root_.end(), std::size_t{0});
  }

  void join(std::size_t one, std::size_t other) { root_[patch_of(one)] = patch_of(other); }

  /// A number that all points of a patch have in common.
  [[nodiscard]] std::size_t patch_of(std::size_t p) {
    while (root_[p] != p) p = root_[p] = root_[root_[p]];
    return p;
  }

 private:
  std::vector<std::size_t> root_;
};

/// Calls visit(offset) for the voxels of a slice within a square about a place in it.
template <class Visit>
void for_square(const Grid& grid, int i, int j, int k, int reach, const Visit& visit) {
  for (int b = j - reach; b <= j + reach; ++b) {
    for (int a = i - reach; a <= i + reach; ++a) {
      if (grid.contains(a, b, k)) visit(grid.offset(a, b, k));
    }
  }
}

/// Chosen points, joined where they are neighbours in a slice or from slice to slice.
JoinedPoints joined_neighbours(const Grid& grid, const std::vector<SurfacePoint>& points,
                               const std::vector<std::uint8_t>& chosen) {
  std::vector<std::int32_t> at(grid.count(), -1);
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (chosen[p] == 0) continue;
    const Index3& v = points[p].voxel;
    at[grid.offset(v[0], v[1], v[2])] = static_cast<std::int32_t>(p);
  }
  const Vec3 spacing = grid.spacing_mm();
  // An outline moves in the plane by about as much as the next slice is away.
  const int reach = std::clamp(
      static_cast<int>(std::ceil(std::min(spacing[2], 10.0) / spacing.head<2>().minCoeff())),
      kTouchPx, 10);
  JoinedPoints out(points.size());
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (chosen[p] == 0) continue;
    const auto join = [&](std::size_t offset) {
      if (at[offset] >= 0) out.join(p, static_cast<std::size_t>(at[offset]));
    };
    const Index3& v = points[p].voxel;
    for_square(grid, v[0], v[1], v[2], kTouchPx, join);
    for_square(grid, v[0], v[1], v[2] + 1, reach, join);
  }
  return out;
}

}  // namespace

std::vector<SurfacePoint> surface_points(const Grid& grid,
                                         const std::vector<std::uint8_t>& inside) {
  const BodySurface surface(grid, inside);
  std::vector<SurfacePoint> points;
  for_each_voxel(grid, [&](int i, int j, int k, std::size_t v) {
    if (inside[v] == 0) return;
    const std::optional<SurfacePoint> point = surface.point_in(i, j, k);
    if (point) points.push_back(*point);
  });
  return points;
}

std::vector<std::vector<float>> averaged_over_surface(const Grid& grid,
                                                      const std::vector<SurfacePoint>& points,
                                                      std::vector<std::vector<float>> values) {
  if (points.empty()) return values;
  // Only the part of the grid that holds the points: one box around a small pool is cheap.
  Index3 low = points.front().voxel;
  Index3 high = low;
  for (const SurfacePoint& point : points) {
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], point.voxel[a]);
      high[a] = std::max(high[a], point.voxel[a]);
    }
  }
  const Grid part =
      grid.part(low, {high[0] - low[0] + 1, high[1] - low[1] + 1, high[2] - low[2] + 1});
  std::vector<std::size_t> at;
  at.reserve(points.size());
  for (const SurfacePoint& point : points) {
    at.push_back(
        part.offset(point.voxel[0] - low[0], point.voxel[1] - low[1], point.voxel[2] - low[2]));
  }
  const bool across = thin_slices(grid);
  const auto spread = [&](const auto& value_of) {
    std::vector<float> image(part.count(), 0);
    for (std::size_t p = 0; p < points.size(); ++p) {
      image[at[p]] = static_cast<float>(points[p].area_mm2) * value_of(p);
    }
    image = tissue::smooth_in_plane(part, image, kAverageMm);
    return across ? smooth_across(part, image) : image;
  };
  const std::vector<float> weight = spread([](std::size_t) { return 1.0F; });
  for (std::vector<float>& list : values) {
    const std::vector<float> sum = spread([&](std::size_t p) { return list[p]; });
    for (std::size_t p = 0; p < points.size(); ++p) {
      if (weight[at[p]] > 0) list[p] = sum[at[p]] / weight[at[p]];
    }
  }
  return values;
}

Patch largest_patch(const Grid& grid, const std::vector<SurfacePoint>& points,
                    const std::vector<std::uint8_t>& chosen) {
  JoinedPoints joined = joined_neighbours(grid, points, chosen);
  std::vector<double> area(points.size(), 0);
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (chosen[p] != 0) area[joined.patch_of(p)] += points[p].area_mm2;
  }
  const auto largest = std::max_element(area.begin(), area.end());
  if (largest == area.end() || !(*largest > 0)) return {};
  const auto patch = static_cast<std::size_t>(largest - area.begin());
  Patch out{*largest, patch, {}};
  Vec3 centre = Vec3::Zero();
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (chosen[p] == 0 || joined.patch_of(p) != patch) continue;
    out.points.push_back(p);
    centre += points[p].area_mm2 * points[p].index;
  }
  centre /= *largest;
  const Vec3 spacing = grid.spacing_mm();
  double nearest = -1;
  for (const std::size_t p : out.points) {
    const double away = (points[p].index - centre).cwiseProduct(spacing).squaredNorm();
    if (nearest >= 0 && away >= nearest) continue;
    nearest = away;
    out.middle = p;
  }
  return out;
}

std::vector<std::size_t> spread_over(const Patch& patch, const Grid& grid,
                                     const std::vector<SurfacePoint>& points, std::size_t most,
                                     double apart_mm) {
  std::vector<std::size_t> out;
  if (patch.points.empty()) return out;
  const Vec3 spacing = grid.spacing_mm();
  std::vector<double> away2(patch.points.size(), std::numeric_limits<double>::max());
  std::size_t next = patch.middle;
  while (out.size() < most) {
    out.push_back(next);
    double farthest = 0;
    for (std::size_t p = 0; p < patch.points.size(); ++p) {
      const Vec3 apart = points[patch.points[p]].index - points[out.back()].index;
      away2[p] = std::min(away2[p], apart.cwiseProduct(spacing).squaredNorm());
      if (away2[p] <= farthest) continue;
      farthest = away2[p];
      next = patch.points[p];
    }
    if (farthest < apart_mm * apart_mm) break;
  }
  return out;
}

}  // namespace beatlas::alarm
