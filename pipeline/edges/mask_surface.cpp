#include "pipeline/edges/mask_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/box.h"
#include "pipeline/core/box_share.h"
#include "pipeline/core/distance_map.h"
#include "pipeline/edges/boundary.h"
#include "pipeline/edges/slice_image.h"

namespace beatlas::edges {
namespace {

using Mask = std::vector<std::uint8_t>;

/// Gaussian of what is a smooth body: the longest edge of a voxel by this, within the two [mm].
constexpr double kWidthByEdge = 4.0 / 3.0;
constexpr double kLeastWidthMm = 1;
constexpr double kMostWidthMm = 4;
constexpr double kShiftByWidth = 0.75;   ///< Gaussian: places so near are shifted alike
constexpr double kWindowByWidth = 0.75;  ///< to each side in plane, and a slice: signs must agree
constexpr double kReach = 4;             ///< of a Gaussian, in its widths
constexpr double kRoom = 5;              ///< around a mask, likewise
constexpr int kFairRounds = 12;
/// Share of the way to the middle of what signs leave open; above 1, for smoothing takes some back.
constexpr float kToMiddle = 1.4F;
constexpr float kLeastOpenMm = 0.3F;  ///< less counts no more than this
constexpr double kAstrayMm = 0.06;    ///< still asked for by signs: no smooth body is there
constexpr float kFarMm = 100;         ///< more than any distance of use
constexpr double kLeastSlope = 1e-3;

/// 1 in voxels of the mask with one of the others among the 26 around.
Mask rim_of(const Grid& grid, const Mask& mask) {
  Mask rim(mask.size());
  Mask reached(mask.size());  // all around, in plane
  Mask others(mask.size());
  std::transform(mask.begin(), mask.end(), others.begin(),
                 [](std::uint8_t value) { return static_cast<std::uint8_t>(value == 0); });
  const cv::Mat square = cv::Mat::ones(3, 3, CV_8U);
  for (int k = 0; k < grid.size[2]; ++k) {
    cv::dilate(slice_of(grid, others, k), slice_of(grid, reached, k), square, {-1, -1}, 1,
               cv::BORDER_CONSTANT, 0);
  }
  for (int k = 0; k < grid.size[2]; ++k) {
    cv::Mat out = slice_of(grid, rim, k);
    slice_of(grid, reached, k).copyTo(out);
    if (k > 0) out |= slice_of(grid, reached, k - 1);
    if (k + 1 < grid.size[2]) out |= slice_of(grid, reached, k + 1);
  }
  for (std::size_t v = 0; v < rim.size(); ++v) {
    rim[v] = static_cast<std::uint8_t>(rim[v] != 0 && mask[v] != 0);
  }
  return rim;
}

/// Distance to the surface [mm], negative inside: a voxel lies nearer to it than the nearest one of
/// the other side, and farther than the outermost of its own; between these in the middle.
std::vector<float> rough_distance(const Grid& grid, const Mask& inside) {
  Mask outside(inside.size());
  std::transform(inside.begin(), inside.end(), outside.begin(),
                 [](std::uint8_t value) { return static_cast<std::uint8_t>(value == 0); });
  const auto distance = [&](const Mask& mask) { return distance_map(grid, mask, true); };
  const std::vector<float> to_outside = distance(outside);
  const std::vector<float> to_inside = distance(inside);
  const std::vector<float> to_inner_rim = distance(rim_of(grid, inside));
  const std::vector<float> to_outer_rim = distance(rim_of(grid, outside));
  std::vector<float> out(inside.size());
  for (std::size_t v = 0; v < inside.size(); ++v) {
    const bool in = inside[v] != 0;
    const float most = std::min(kFarMm, in ? to_outside[v] : to_inside[v]);
    const float least = std::min(kFarMm, in ? to_inner_rim[v] : to_outer_rim[v]);
    out[v] = (in ? -0.5F : 0.5F) * (least + most);
  }
  return out;
}

double width_mm(const Grid& grid) {
  return std::clamp(kWidthByEdge * grid.spacing_mm().maxCoeff(), kLeastWidthMm, kMostWidthMm);
}

/// Gaussian in space, in place.
void blur(const Grid& grid, double sigma_mm, std::vector<float>& values) {
  const Vec3 width = sigma_mm * grid.spacing_mm().cwiseInverse();
  const auto taps = [&](int axis) {
    return 2 * static_cast<int>(std::ceil(kReach * width[axis])) + 1;
  };
  for (int k = 0; k < grid.size[2]; ++k) {
    cv::Mat plane = slice_of(grid, values, k);
    cv::GaussianBlur(plane, plane, {taps(0), taps(1)}, width[0], width[1], cv::BORDER_REPLICATE);
  }
  cv::Mat across(grid.size[2], static_cast<int>(grid.slice_count()), CV_32F, values.data());
  const cv::Mat kernel = cv::getGaussianKernel(taps(2), width[2], CV_32F);
  cv::sepFilter2D(across, across, CV_32F, cv::Mat::ones(1, 1, CV_32F), kernel, {-1, -1}, 0,
                  cv::BORDER_REPLICATE);
}

/// Smoothed so that what is quadratic over the width stays: G + (G - G G).
void smooth(const Grid& grid, std::vector<float>& values) {
  blur(grid, width_mm(grid), values);
  std::vector<float> twice = values;
  blur(grid, width_mm(grid), twice);
  for (std::size_t v = 0; v < values.size(); ++v) values[v] = 2 * values[v] - twice[v];
}

/// The greatest of the window around each voxel, in place.
void greatest_around(const Grid& grid, std::vector<float>& values) {
  const auto reach = [&](int axis) {
    return static_cast<int>(std::lround(kWindowByWidth * width_mm(grid) / grid.spacing_mm()[axis]));
  };
  const cv::Mat square = cv::Mat::ones(2 * reach(1) + 1, 2 * reach(0) + 1, CV_8U);
  for (int k = 0; k < grid.size[2]; ++k) {
    cv::Mat plane = slice_of(grid, values, k);
    cv::dilate(plane, plane, square);
  }
  std::vector<float> in_plane = values;
  for (int k = 0; k < grid.size[2]; ++k) {
    cv::Mat out = slice_of(grid, values, k);
    if (k > 0) cv::max(out, slice_of(grid, in_plane, k - 1), out);
    if (k + 1 < grid.size[2]) cv::max(out, slice_of(grid, in_plane, k + 1), out);
  }
}

/// The mean of values around each voxel by their weights; 0 where there are none. @param values
/// already times their weights
void mean_around(const Grid& grid, std::vector<float>& values, std::vector<float>& weights) {
  blur(grid, kShiftByWidth * width_mm(grid), values);
  blur(grid, kShiftByWidth * width_mm(grid), weights);
  for (std::size_t v = 0; v < values.size(); ++v) {
    values[v] = weights[v] > 1e-6F ? values[v] / weights[v] : 0.0F;
  }
}

/// By how much [mm] a distance may be raised or lowered so that its sign in the window around a
/// voxel is the mask's; least > most where no such shift is.
struct Shifts {
  std::vector<float> least;
  std::vector<float> most;
};

Shifts shifts_of(const Grid& grid, const Mask& inside, const std::vector<float>& distance) {
  Shifts out{std::vector<float>(inside.size(), -kFarMm),
             std::vector<float>(inside.size(), -kFarMm)};
  for (std::size_t v = 0; v < inside.size(); ++v) {
    if (inside[v] != 0) {
      out.most[v] = distance[v];
    } else {
      out.least[v] = -distance[v];
    }
  }
  greatest_around(grid, out.least);
  greatest_around(grid, out.most);
  for (float& most : out.most) most = -most;
  return out;
}

/// The smooth distance [mm], negative inside, and how well it may be believed.
struct SmoothDistance {
  std::vector<float> mm;
  std::vector<float> trust;  ///< 1; towards 0 where no smooth body is
};

SmoothDistance smooth_distance(const Grid& grid, const Mask& inside) {
  const std::size_t n = inside.size();
  SmoothDistance out{rough_distance(grid, inside), std::vector<float>(n)};
  std::vector<float>& distance = out.mm;
  smooth(grid, distance);
  std::vector<float> shift(n);
  std::vector<float> weight(n);
  for (int round = 0; round <= kFairRounds; ++round) {
    const Shifts shifts = shifts_of(grid, inside, distance);
    const bool last = round == kFairRounds;
    for (std::size_t v = 0; v < n; ++v) {
      const float least = shifts.least[v];
      const float most = shifts.most[v];
      shift[v] = weight[v] = 0;
      if (least <= -kFarMm || most >= kFarMm) continue;  // far from the surface
      const float middle = 0.5F * (least + most);
      const float needed = least <= most ? std::clamp(0.0F, least, most) : middle;
      weight[v] = 1 / std::max(most - least, kLeastOpenMm);
      shift[v] = weight[v] *
                 (last ? std::max({least, -most, 0.0F}) : needed + kToMiddle * (middle - needed));
    }
    mean_around(grid, shift, weight);
    if (last) break;
    for (std::size_t v = 0; v < n; ++v) distance[v] += shift[v];
    smooth(grid, distance);
  }
  for (std::size_t v = 0; v < n; ++v) {
    const double astray = static_cast<double>(shift[v]) / kAstrayMm;
    out.trust[v] = static_cast<float>(std::exp(-astray * astray));
  }
  return out;
}

/// [mm / mm] How a distance grows along the grid's axes around a voxel.
/// @param v offset of the voxel in the grid
Vec3 growth_around(const Grid& grid, const Vec3& spacing, const std::vector<float>& distance,
                   const Index3& index, std::size_t v) {
  const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(grid.size[0]),
                                          grid.slice_count()};
  Vec3 growth = Vec3::Zero();
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    const std::size_t before = index[a] > 0 ? v - stride[a] : v;
    const std::size_t after = index[a] + 1 < grid.size[a] ? v + stride[a] : v;
    if (before == after) continue;
    const std::size_t steps = (after - before) / stride[a];
    growth[axis] = static_cast<double>(distance[after] - distance[before]) /
                   (static_cast<double>(steps) * spacing[axis]);
  }
  return growth;
}

/// Of a grid that the mask fills but for a margin.
std::vector<float> coverage_here(const Grid& grid, const Mask& inside) {
  const SmoothDistance distance = smooth_distance(grid, inside);
  std::vector<float> coverage = outline_coverage(grid, inside);
  const Vec3 spacing = grid.spacing_mm();
  const Vec3 half = 0.5 * spacing;
  for_each_voxel(grid, [&](int i, int j, int k, std::size_t v) {
    const Vec3 outward = growth_around(grid, spacing, distance.mm, {i, j, k}, v);
    const double slope = outward.norm();
    const auto here = static_cast<double>(distance.mm[v]);
    if (slope < kLeastSlope || std::abs(here) > half.norm() * slope) return;
    const auto share = static_cast<float>(share_below(outward / slope, half, -here / slope));
    coverage[v] += distance.trust[v] * (share - coverage[v]);
  });
  return coverage;
}

}  // namespace

std::vector<float> smooth_coverage(const Grid& grid, const std::vector<std::uint8_t>& inside) {
  std::vector<float> out(inside.size());
  const Box box = box_around(grid, inside);
  if (box.empty()) return out;
  // With room for the distance to go on as it does; what a grid cuts goes on beyond it.
  Index3 room{};
  Index3 size{};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    room[a] = static_cast<int>(std::ceil(kRoom * width_mm(grid) / grid.spacing_mm()[axis]));
    size[a] = box.size[a] + 2 * room[a];
  }
  const auto of_grid = [&](std::size_t a, int at) { return box.first[a] + at - room[a]; };
  const Grid wide = grid.part({of_grid(0, 0), of_grid(1, 0), of_grid(2, 0)}, size);
  Mask mask(wide.count());
  std::size_t v = 0;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i, ++v) {
        mask[v] = inside[grid.offset(std::clamp(of_grid(0, i), 0, grid.size[0] - 1),
                                     std::clamp(of_grid(1, j), 0, grid.size[1] - 1),
                                     std::clamp(of_grid(2, k), 0, grid.size[2] - 1))];
      }
    }
  }
  const std::vector<float> found = coverage_here(wide, mask);
  v = 0;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i, ++v) {
        const Index3 at{of_grid(0, i), of_grid(1, j), of_grid(2, k)};
        if (grid.contains(at[0], at[1], at[2])) out[grid.offset(at[0], at[1], at[2])] = found[v];
      }
    }
  }
  return out;
}

}  // namespace beatlas::edges
