#include "pipeline/shape/sub_slices.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/box_share.h"

namespace beatlas::shape {
namespace {

constexpr double kLeastPartMm = 1;  ///< of a slice
constexpr double kMostPartMm = 1.5;
constexpr double kPatchMm = 2;   ///< Gaussian in plane, of the coverage whose gradient is taken
constexpr float kMixed = 1e-3F;  ///< less is none, and as near to 1 is all
constexpr double kLeastSlope = 1e-3;  ///< [1 / mm] of a gradient that is a direction
constexpr int kHalvings = 24;

/// Smoothed over a patch of the slice and its two neighbours.
std::vector<float> soft_coverage(const Grid& grid, const std::vector<float>& coverage) {
  const Vec3 spacing = grid.spacing_mm();
  std::vector<float> plane(coverage.size());
  const auto slice = [&](std::vector<float>& of, int k) {
    return cv::Mat(grid.size[1], grid.size[0], CV_32F, of.data() + grid.offset(0, 0, k));
  };
  for (int k = 0; k < grid.size[2]; ++k) {
    const cv::Mat from(grid.size[1], grid.size[0], CV_32F,
                       const_cast<float*>(coverage.data()) + grid.offset(0, 0, k));
    cv::GaussianBlur(from, slice(plane, k), {0, 0}, kPatchMm / spacing[0], kPatchMm / spacing[1],
                     cv::BORDER_REPLICATE);
  }
  std::vector<float> out(coverage.size());
  for (int k = 0; k < grid.size[2]; ++k) {
    slice(out, k) = 0.25 * slice(plane, std::max(0, k - 1)) + 0.5 * slice(plane, k) +
                    0.25 * slice(plane, std::min(grid.size[2] - 1, k + 1));
  }
  return out;
}

/// [1 / mm] How fast coverage falls around a voxel.
/// @param v offset of the voxel in the grid
Vec3 fall_around(const Grid& grid, const std::vector<float>& soft, const Index3& index,
                 std::size_t v) {
  const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(grid.size[0]),
                                          grid.slice_count()};
  const Vec3 spacing = grid.spacing_mm();
  Vec3 fall = Vec3::Zero();
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    const std::size_t before = index[a] > 0 ? v - stride[a] : v;
    const std::size_t after = index[a] + 1 < grid.size[a] ? v + stride[a] : v;
    fall[axis] = static_cast<double>(soft[before] - soft[after]) / (2 * spacing[axis]);
  }
  return fall;
}

/// Offset of the plane that leaves this share of a box below it, see share_below.
double offset_of_share(const Vec3& outward, const Vec3& half, double share) {
  double low = -outward.cwiseAbs().dot(half);
  double high = -low;
  for (int n = 0; n < kHalvings; ++n) {
    const double middle = 0.5 * (low + high);
    (share_below(outward, half, middle) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

int parts_of_slices(const Grid& grid) {
  const Vec3 spacing = grid.spacing_mm();
  const double pixel = std::clamp(std::min(spacing[0], spacing[1]), kLeastPartMm, kMostPartMm);
  return std::max(1, static_cast<int>(std::lround(spacing[2] / pixel)));
}

SubSlices split_slices(const Grid& grid, const std::vector<float>& coverage, int parts) {
  SubSlices out{grid, {}};
  out.grid.size[2] *= parts;
  out.grid.mm_from_index = grid.mm_from_index * Eigen::Translation3d(0, 0, 0.5 / parts - 0.5) *
                           Eigen::Scaling(Vec3(1, 1, 1.0 / parts));
  out.coverage.resize(out.grid.count());
  const std::vector<float> soft = soft_coverage(grid, coverage);
  const Vec3 spacing = grid.spacing_mm();
  const Vec3 half = 0.5 * spacing;
  const Vec3 half_part(half[0], half[1], half[2] / parts);
  for_each_voxel(grid, [&](int i, int j, int k, std::size_t v) {
    const float share = coverage[v];
    const auto covered = [&](int part) -> float& {
      return out.coverage[out.grid.offset(i, j, k * parts + part)];
    };
    const bool mixed = share > kMixed && share < 1 - kMixed;
    Vec3 outward = Vec3::Zero();
    if (mixed) outward = fall_around(grid, soft, {i, j, k}, v);
    const double slope = outward.norm();
    if (!mixed || slope < kLeastSlope) {
      for (int part = 0; part < parts; ++part) covered(part) = share;
      return;
    }
    outward /= slope;
    const double offset = offset_of_share(outward, half, static_cast<double>(share));
    for (int part = 0; part < parts; ++part) {
      const double z = spacing[2] * ((part + 0.5) / parts - 0.5);
      covered(part) = static_cast<float>(share_below(outward, half_part, offset - outward[2] * z));
    }
  });
  return out;
}

}  // namespace beatlas::shape
