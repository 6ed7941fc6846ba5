#include "pipeline/segment/surface_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "pipeline/core/slices.h"
#include "pipeline/segment/tissue.h"

namespace beatlas::segment {
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

}  // namespace

std::vector<SurfacePoint> surface_points(const Grid& grid,
                                         const std::vector<std::uint8_t>& inside) {
  const bool across = thin_slices(grid);
  const Vec3 spacing = grid.spacing_mm();
  std::vector<float> smooth(inside.size());
  std::transform(inside.begin(), inside.end(), smooth.begin(),
                 [](std::uint8_t in) { return in != 0 ? 1.0F : 0.0F; });
  smooth = smooth_in_plane(grid, smooth, std::max(kSmoothMm, 0.8 * spacing.head<2>().maxCoeff()));
  if (across) smooth = smooth_across(grid, smooth);

  const Vec3 face_mm2(spacing[1] * spacing[2], spacing[0] * spacing[2], spacing[0] * spacing[1]);
  const int axes = across ? 3 : 2;
  std::vector<SurfacePoint> points;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (inside[grid.offset(i, j, k)] == 0) continue;
        Vec3 open = Vec3::Zero();
        Vec3 gradient = Vec3::Zero();
        for (int axis = 0; axis < axes; ++axis) {
          std::array<float, 2> beside{};
          double apart = 0;
          for (int side = -1; side <= 1; side += 2) {
            Index3 at{i, j, k};
            at[static_cast<std::size_t>(axis)] += side;
            const bool there = grid.contains(at[0], at[1], at[2]);
            if (!there) at = {i, j, k};
            const std::size_t v = grid.offset(at[0], at[1], at[2]);
            if (there && inside[v] == 0) open[axis] += face_mm2[axis];
            if (there) apart += spacing[axis];
            beside[side < 0 ? 0 : 1] = smooth[v];
          }
          if (apart > 0) gradient[axis] = (beside[1] - beside[0]) / apart;
        }
        if (open.isZero()) continue;
        SurfacePoint point;
        point.voxel = {i, j, k};
        const double steep = gradient.norm();
        point.outward_mm = steep > 0 ? Vec3(-gradient / steep) : Vec3(open.normalized());
        point.area_mm2 = open.dot(point.outward_mm.cwiseAbs());
        const double longest = 1.5 * spacing.head(axes).minCoeff();
        const double out_mm =
            steep > 0 ? std::clamp((smooth[grid.offset(i, j, k)] - 0.5) / steep, -longest, longest)
                      : 0.0;
        point.index = Vec3(i, j, k) + (out_mm * point.outward_mm).cwiseQuotient(spacing);
        points.push_back(point);
      }
    }
  }
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
    image = smooth_in_plane(part, image, kAverageMm);
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
  std::vector<std::int32_t> at(grid.count(), -1);
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (chosen[p] == 0) continue;
    const Index3& v = points[p].voxel;
    at[grid.offset(v[0], v[1], v[2])] = static_cast<std::int32_t>(p);
  }
  std::vector<std::size_t> root(points.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t p) {
    while (root[p] != p) p = root[p] = root[root[p]];
    return p;
  };
  const Vec3 spacing = grid.spacing_mm();
  // An outline moves in the plane by about as much as the next slice is away.
  const int reach = std::clamp(
      static_cast<int>(std::ceil(std::min(spacing[2], 10.0) / spacing.head<2>().minCoeff())),
      kTouchPx, 10);
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (chosen[p] == 0) continue;
    const Index3& v = points[p].voxel;
    for (int dk = 0; dk <= 1; ++dk) {
      const int r = dk == 0 ? kTouchPx : reach;
      for (int dj = -r; dj <= r; ++dj) {
        for (int di = -r; di <= r; ++di) {
          if (!grid.contains(v[0] + di, v[1] + dj, v[2] + dk)) continue;
          const std::int32_t other = at[grid.offset(v[0] + di, v[1] + dj, v[2] + dk)];
          if (other >= 0) root[find(p)] = find(static_cast<std::size_t>(other));
        }
      }
    }
  }
  std::vector<double> area(points.size(), 0);
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (chosen[p] != 0) area[find(p)] += points[p].area_mm2;
  }
  const auto largest = std::max_element(area.begin(), area.end());
  if (largest == area.end() || !(*largest > 0)) return {};
  const auto patch = static_cast<std::size_t>(largest - area.begin());
  Vec3 centre = Vec3::Zero();
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (chosen[p] != 0 && find(p) == patch) centre += points[p].area_mm2 * points[p].index;
  }
  centre /= *largest;
  Patch out{*largest, patch, {}};
  double nearest = -1;
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (chosen[p] == 0 || find(p) != patch) continue;
    out.points.push_back(p);
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

}  // namespace beatlas::segment
