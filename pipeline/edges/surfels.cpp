#include "pipeline/edges/surfels.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/edges/slice_image.h"

namespace beatlas::edges {
namespace {

constexpr double kSurfaceSmoothMm = 2;  ///< Gaussian
constexpr double kQuadricMm = 6;        ///< crossings so near are of one piece
constexpr double kQuadricSigma = 3;     ///< [mm] Gaussian of their weights
constexpr double kAlike = 0.5;          ///< cosine of the angle between normals of one piece
constexpr int kQuadricFits = 2;         ///< the second in the first one's frame
constexpr double kStiffness = 20;       ///< [mm^4] of bends, beside some 60 crossings
constexpr double kMostMoveMm = 1;
constexpr double kMostBend = 1.0 / 16;  ///< [1/mm]: that of a ball of 8 mm
constexpr double kLeastFall = 1e-4;     ///< [1/mm]: less has no direction

std::vector<float> smoothed(const Grid& grid, const std::vector<float>& coverage) {
  const Vec3 spacing = grid.spacing_mm();
  const int nz = grid.size[2];
  std::vector<cv::Mat> plane(static_cast<std::size_t>(nz));
  for (int k = 0; k < nz; ++k) {
    cv::GaussianBlur(slice_of(grid, coverage, k), plane[static_cast<std::size_t>(k)], {0, 0},
                     kSurfaceSmoothMm / spacing[0], kSurfaceSmoothMm / spacing[1],
                     cv::BORDER_REPLICATE);
  }
  const int reach = static_cast<int>(std::ceil(3 * kSurfaceSmoothMm / spacing[2]));
  std::vector<double> weight;
  for (int n = -reach; n <= reach; ++n) {
    weight.push_back(std::exp(-0.5 * std::pow(n * spacing[2] / kSurfaceSmoothMm, 2)));
  }
  const double sum = std::accumulate(weight.begin(), weight.end(), 0.0);
  std::vector<float> out(coverage.size());
  for (int k = 0; k < nz; ++k) {
    cv::Mat slice = slice_of(grid, out, k);
    slice.setTo(0);
    std::size_t at = 0;
    for (int n = -reach; n <= reach; ++n) {
      const cv::Mat& near = plane[static_cast<std::size_t>(std::clamp(k + n, 0, nz - 1))];
      cv::scaleAdd(near, weight[at++] / sum, slice, slice);
    }
  }
  return out;
}

/// Where the level crosses a line of the grid.
struct Crossing {
  Vec3 at;
  Vec3 normal;
};

class Level {
 public:
  Level(const Grid& grid, const std::vector<float>& coverage)
      : grid_(grid), spacing_(grid.spacing_mm()), value_(smoothed(grid, coverage)) {}

  [[nodiscard]] std::vector<Crossing> crossings() const {
    std::vector<Crossing> out;
    for_each_voxel(grid_, [&](int i, int j, int k, std::size_t) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Index3 next{i, j, k};
        if (++next[axis] < grid_.size[axis]) add_crossing({i, j, k}, next, out);
      }
    });
    return out;
  }

 private:
  /// Of the line between two voxels beside each other, if there is one.
  void add_crossing(const Index3& here, const Index3& next, std::vector<Crossing>& out) const {
    const float first = at(here[0], here[1], here[2]) - 0.5F;
    const float second = at(next[0], next[1], next[2]) - 0.5F;
    if ((first < 0) == (second < 0)) return;
    const double share = static_cast<double>(first / (first - second));
    const Vec3 slope = (1 - share) * slope_at(here) + share * slope_at(next);
    if (slope.norm() < kLeastFall) return;
    const Vec3 from(here[0], here[1], here[2]);
    const Vec3 to(next[0], next[1], next[2]);
    out.push_back({((1 - share) * from + share * to).cwiseProduct(spacing_), -slope.normalized()});
  }

  [[nodiscard]] float at(int i, int j, int k) const { return value_[grid_.offset(i, j, k)]; }
  [[nodiscard]] Vec3 slope_at(const Index3& at) const {
    Vec3 out;
    for (int axis = 0; axis < 3; ++axis) {
      Index3 low = at;
      Index3 high = at;
      low[axis] = std::max(0, at[axis] - 1);
      high[axis] = std::min(grid_.size[axis] - 1, at[axis] + 1);
      out[axis] = static_cast<double>(value_[grid_.offset(high[0], high[1], high[2])] -
                                      value_[grid_.offset(low[0], low[1], low[2])]) /
                  (std::max(1, high[axis] - low[axis]) * spacing_[axis]);
    }
    return out;
  }

  const Grid& grid_;
  Vec3 spacing_;
  std::vector<float> value_;
};

/// Turns and moves a piece so that a quadric through its surroundings has its frame.
void settle(const std::vector<Crossing>& crossings, const PlacesNearby& nearby, Surfel& surfel) {
  using Row = Eigen::Matrix<double, 6, 1>;
  Eigen::Matrix<double, 6, 6> left = Eigen::Matrix<double, 6, 6>::Zero();
  left.diagonal() << 1e-6, 1e-6, 1e-6, kStiffness, kStiffness, kStiffness;
  Row right = Row::Zero();
  nearby.visit(surfel.at, [&](std::size_t n, const Vec3& off) {
    if (crossings[n].normal.dot(surfel.normal) < kAlike) return;
    const double u = off.dot(surfel.along);
    const double v = off.dot(surfel.across);
    Row row;
    row << 1, u, v, u * u, u * v, v * v;
    const double weight = std::exp(-0.5 * off.squaredNorm() / (kQuadricSigma * kQuadricSigma));
    left.noalias() += weight * row * row.transpose();
    right += weight * off.dot(surfel.normal) * row;
  });
  const Row fit = left.ldlt().solve(right);
  const Vec3 along = surfel.along;
  const Vec3 across = surfel.across;
  surfel.at += std::clamp(fit[0], -kMostMoveMm, kMostMoveMm) * surfel.normal;
  surfel.normal = (surfel.normal - fit[1] * along - fit[2] * across).normalized();
  surfel.along = surfel.normal.unitOrthogonal();
  surfel.across = surfel.normal.cross(surfel.along);
  Eigen::Matrix2d bend;
  bend << fit[3], 0.5 * fit[4], 0.5 * fit[4], fit[5];
  Eigen::Matrix2d turn;
  turn << surfel.along.dot(along), surfel.across.dot(along), surfel.along.dot(across),
      surfel.across.dot(across);
  bend = (turn.transpose() * bend * turn).eval();
  const double most = std::max(1.0, bend.norm() / kMostBend);
  surfel.bend = {bend(0, 0) / most, 2 * bend(0, 1) / most, bend(1, 1) / most};
}

}  // namespace

std::vector<Surfel> surfels_of(const Grid& grid, const std::vector<float>& coverage,
                               double pitch_mm) {
  const std::vector<Crossing> crossings = Level(grid, coverage).crossings();
  std::vector<Vec3> places(crossings.size());
  std::transform(crossings.begin(), crossings.end(), places.begin(),
                 [](const Crossing& crossing) { return crossing.at; });
  const PlacesNearby nearby(places, kQuadricMm);
  // The first crossing of a cell stands for those that look the same way.
  const Vec3 extent =
      grid.spacing_mm().cwiseProduct(Vec3(grid.size[0], grid.size[1], grid.size[2]));
  const Grid cells{
      Index3{static_cast<int>(extent[0] / pitch_mm) + 1, static_cast<int>(extent[1] / pitch_mm) + 1,
             static_cast<int>(extent[2] / pitch_mm) + 1},
      Affine::Identity()};
  std::vector<std::vector<std::uint32_t>> taken(cells.count());
  std::vector<Surfel> out;
  for (std::size_t n = 0; n < crossings.size(); ++n) {
    const Crossing& crossing = crossings[n];
    std::vector<std::uint32_t>& here = taken[cells.offset(
        static_cast<int>(crossing.at[0] / pitch_mm), static_cast<int>(crossing.at[1] / pitch_mm),
        static_cast<int>(crossing.at[2] / pitch_mm))];
    if (std::any_of(here.begin(), here.end(), [&](std::uint32_t other) {
          return crossings[other].normal.dot(crossing.normal) > kAlike;
        })) {
      continue;
    }
    here.push_back(static_cast<std::uint32_t>(n));
    Surfel surfel;
    surfel.at = crossing.at;
    surfel.normal = crossing.normal;
    surfel.along = surfel.normal.unitOrthogonal();
    surfel.across = surfel.normal.cross(surfel.along);
    out.push_back(surfel);
  }
  parallel_for(out.size(), [&](std::size_t at) {
    for (int fit = 0; fit < kQuadricFits; ++fit) settle(crossings, nearby, out[at]);
  });
  return out;
}

PlacesNearby::PlacesNearby(std::vector<Vec3> places, double reach_mm)
    : places_(std::move(places)), reach_mm_(reach_mm) {
  Vec3 high = Vec3::Zero();
  if (!places_.empty()) low_ = high = places_[0];
  for (const Vec3& place : places_) {
    low_ = low_.cwiseMin(place);
    high = high.cwiseMax(place);
  }
  for (int axis = 0; axis < 3; ++axis) {
    size_[axis] = static_cast<int>((high[axis] - low_[axis]) / reach_mm_) + 1;
  }
  std::vector<std::size_t> cell(places_.size());
  first_.assign(index(size_[0] - 1, size_[1] - 1, size_[2] - 1) + 2, 0);
  for (std::size_t n = 0; n < places_.size(); ++n) {
    const Index3 at = cell_of(places_[n]);
    cell[n] = index(at[0], at[1], at[2]);
    ++first_[cell[n] + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  order_.resize(places_.size());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t n = 0; n < places_.size(); ++n) order_[next[cell[n]]++] = n;
}

Index3 PlacesNearby::cell_of(const Vec3& place) const {
  Index3 out{};
  for (int axis = 0; axis < 3; ++axis) {
    out[axis] = static_cast<int>(std::floor((place[axis] - low_[axis]) / reach_mm_));
  }
  return out;
}

}  // namespace beatlas::edges
