#include "pipeline/phantom/cover.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace beatlas::phantom {
namespace {

constexpr float kUnsettled = -1.0F;
constexpr int kPoints = 4;          // a side, supersampled
constexpr double kFarSigmas = 1.5;  // beyond the box by so much of the blur, it is of one part
constexpr double kCreaseCosine = 0.8;
constexpr int kScattered = 400;  // points for a box with a crease
constexpr int kRunBlock = 32;    // voxels of a block that is gone through row by row

/// Points spread over a box and its blur, along i, j, k: the additive recurrence with the powers of
/// the root of x^8 = x + 1 (Roberts' sequence, even in any seven dimensions), the normal numbers by
/// Box and Muller.
std::vector<Vec3> scattered_points(const Vec3& box_mm, const Vec3& sigma_mm) {
  constexpr double kRoot = 1.0969815577985598;
  constexpr double kTurn = 2.0 * std::numbers::pi;
  std::vector<Vec3> out;
  for (int n = 0; n < kScattered; ++n) {
    std::array<double, 7> u{};
    for (int d = 0; d < 7; ++d) {
      const double at = 0.5 + (n + 1) * std::pow(kRoot, -(d + 1));
      u[static_cast<std::size_t>(d)] = at - std::floor(at);
    }
    const double first = std::sqrt(-2.0 * std::log(1.0 - u[3]));
    const double second = std::sqrt(-2.0 * std::log(1.0 - u[5]));
    const Vec3 normal(first * std::cos(kTurn * u[4]), first * std::sin(kTurn * u[4]),
                      second * std::cos(kTurn * u[6]));
    out.push_back(box_mm.cwiseProduct(Vec3(u[0], u[1], u[2]) - Vec3::Constant(0.5)) +
                  sigma_mm.cwiseProduct(normal));
  }
  return out;
}

class Cover {
 public:
  Cover(const Grid& grid, const std::vector<Body>& bodies, const CoverOptions& options,
        const std::function<void(const Block&, const Shares&)>& emit)
      : grid_(grid), bodies_(bodies), options_(options), emit_(emit) {
    spacing_mm_ = grid.spacing_mm();
    box_mm_ = spacing_mm_;
    if (options.thickness_mm > 0.0) box_mm_.z() = options.thickness_mm;
    if (options.partial_volume == PartialVolume::None) box_mm_.setZero();
    axes_ = grid.mm_from_index.linear().colwise().normalized();
    for (int a = 0; a < 3; ++a) {
      parts_[a] = std::max(1, static_cast<int>(std::ceil(box_mm_[a] / options.flat_mm - 1e-9)));
    }
    scattered_ = scattered_points(box_mm_, options.sigma_mm);
    blur_mm_ = kBlurSigmas * options.sigma_mm.maxCoeff();
    reach_mm_ = 0.5 * box_mm_.norm() + blur_mm_;
  }

  void settle(const Block& block, Shares shares) const {
    const Vec3 count(block.size[0], block.size[1], block.size[2]);
    const Vec3 middle =
        Vec3(block.first[0], block.first[1], block.first[2]) + 0.5 * (count - Vec3::Ones());
    const Vec3 centre = grid_.mm_from_index * middle;
    const Vec3 edges = spacing_mm_.cwiseProduct(count - Vec3::Ones()) + box_mm_;
    const double radius = 0.5 * edges.norm() + blur_mm_;
    bool settled = true;
    for (std::size_t n = 0; n < bodies_.size(); ++n) {
      if (shares[n] != kUnsettled) continue;
      shares[n] = share_of_ball(bodies_[n], shares, centre, radius);
      settled = settled && shares[n] != kUnsettled;
    }
    if (settled) {
      emit_(block, shares);
      return;
    }
    if (block.size[0] * block.size[1] * block.size[2] <= kRunBlock) {
      for (int k = block.first[2]; k < block.first[2] + block.size[2]; ++k) {
        for (int j = block.first[1]; j < block.first[1] + block.size[1]; ++j) {
          row(block.first[0], block.size[0], j, k, shares);
        }
      }
      return;
    }
    int axis = 0;
    double longest = -1.0;
    for (int a = 0; a < 3; ++a) {
      if (block.size[a] > 1 && edges[a] > longest) {
        longest = edges[a];
        axis = a;
      }
    }
    Block low = block;
    Block high = block;
    low.size[axis] = block.size[axis] / 2;
    high.first[axis] += low.size[axis];
    high.size[axis] -= low.size[axis];
    settle(low, shares);
    settle(high, shares);
  }

 private:
  /// Of all voxels in a ball, if it is 0 or 1.
  float share_of_ball(const Body& body, const Shares& shares, const Vec3& centre,
                      double radius) const {
    if (body.within >= 0 && shares[static_cast<std::size_t>(body.within)] == 0.0F) return 0.0F;
    if ((centre - body.ball_mm).norm() >= body.ball_radius_mm + radius) return 0.0F;
    const double distance = body.surface(centre).distance_mm;
    if (std::abs(distance) < radius) return kUnsettled;
    return distance < 0.0 ? 1.0F : 0.0F;
  }

  /// `length` voxels along i from (first, j, k). @param known shares that hold for all of them
  void row(int first, int length, int j, int k, const Shares& known) const {
    std::array<int, kMostBodies> settled_until{};  // from there on a body is to be looked at again
    std::array<float, kMostBodies> settled{};
    for (int i = first; i < first + length; ++i) {
      Shares shares = known;
      const Vec3 centre = grid_.mm(i, j, k);
      for (std::size_t n = 0; n < bodies_.size(); ++n) {
        if (shares[n] != kUnsettled) continue;
        const Body& body = bodies_[n];
        if (body.within >= 0 && shares[static_cast<std::size_t>(body.within)] == 0.0F) {
          shares[n] = 0.0F;
          continue;
        }
        if (i - first < settled_until[n]) {
          shares[n] = settled[n];
          continue;
        }
        const SignedPlane plane = body.surface(centre);
        const double beyond = std::abs(plane.distance_mm) - reach_mm_;
        if (beyond < 0.0) {
          shares[n] = static_cast<float>(voxel_share(body, centre, plane));
          continue;
        }
        shares[n] = plane.distance_mm < 0.0 ? 1.0F : 0.0F;
        settled[n] = shares[n];
        settled_until[n] =
            i - first + 1 + static_cast<int>(std::min(beyond / spacing_mm_.x(), 1e6));
      }
      emit_({{i, j, k}, {1, 1, 1}}, shares);
    }
  }

  double voxel_share(const Body& body, const Vec3& centre, const SignedPlane& at_centre) const {
    const Vec3 outward = axes_.transpose() * at_centre.outward;
    const Vec3 half = 0.5 * box_mm_;
    if (options_.partial_volume == PartialVolume::None) {
      if (options_.sigma_mm.isZero(0.0)) return at_centre.distance_mm < 0.0 ? 1.0 : 0.0;
      return blurred_box_share(half, options_.sigma_mm, at_centre.distance_mm, outward);
    }
    if (options_.partial_volume == PartialVolume::Supersampled) {
      return points_share(body, centre, at_centre, outward);
    }
    const double near =
        half.dot(outward.cwiseAbs()) + kFarSigmas * outward.cwiseProduct(options_.sigma_mm).norm();
    const bool far = blur_mm_ > 0.0 && std::abs(at_centre.distance_mm) > near;
    if (parts_ == Index3{1, 1, 1} || far) {
      return blurred_box_share(half, options_.sigma_mm, at_centre.distance_mm, outward);
    }
    const Vec3 part = half.cwiseQuotient(Vec3(parts_[0], parts_[1], parts_[2]));
    double sum = 0.0;
    double least_cosine = 1.0;
    for (int k = 0; k < parts_[2]; ++k) {
      for (int j = 0; j < parts_[1]; ++j) {
        for (int i = 0; i < parts_[0]; ++i) {
          const Vec3 offset = part.cwiseProduct(
              Vec3(2 * i + 1 - parts_[0], 2 * j + 1 - parts_[1], 2 * k + 1 - parts_[2]));
          const SignedPlane plane = body.surface(centre + axes_ * offset);
          least_cosine = std::min(least_cosine, plane.outward.dot(at_centre.outward));
          sum += blurred_box_share(part, options_.sigma_mm, plane.distance_mm,
                                   axes_.transpose() * plane.outward);
        }
      }
    }
    if (least_cosine < kCreaseCosine) return scattered_share(body, centre);
    return sum / (parts_[0] * parts_[1] * parts_[2]);
  }

  /// Where normals differ within a box, a crease runs through it and no plane stands for it.
  double scattered_share(const Body& body, const Vec3& centre) const {
    int inside = 0;
    for (const Vec3& offset : scattered_) inside += body.inside(centre + axes_ * offset);
    return static_cast<double>(inside) / static_cast<double>(scattered_.size());
  }

  /// The mean over points of the box; with a blur, each point's, with the surface taken as flat.
  double points_share(const Body& body, const Vec3& centre, const SignedPlane& at_centre,
                      const Vec3& outward) const {
    const bool sharp = options_.sigma_mm.isZero(0.0);
    double sum = 0.0;
    for (int k = 0; k < kPoints; ++k) {
      for (int j = 0; j < kPoints; ++j) {
        for (int i = 0; i < kPoints; ++i) {
          const Vec3 offset =
              box_mm_.cwiseProduct(Vec3(i, j, k) / kPoints + Vec3::Constant(0.5 / kPoints - 0.5));
          if (!sharp) {
            sum += blurred_box_share(Vec3::Zero(), options_.sigma_mm,
                                     at_centre.distance_mm + outward.dot(offset), outward);
          } else if (at_centre.distance_mm * at_centre.distance_mm > offset.squaredNorm()) {
            sum += at_centre.distance_mm < 0.0 ? 1.0 : 0.0;
          } else {
            sum += body.inside(centre + axes_ * offset) ? 1.0 : 0.0;
          }
        }
      }
    }
    return sum / (kPoints * kPoints * kPoints);
  }

  const Grid& grid_;
  const std::vector<Body>& bodies_;
  const CoverOptions& options_;
  const std::function<void(const Block&, const Shares&)>& emit_;
  Vec3 spacing_mm_;
  Vec3 box_mm_;            // edges of a voxel's box
  Eigen::Matrix3d axes_;   // unit vectors of i, j, k
  Index3 parts_{1, 1, 1};  // of a voxel's box
  std::vector<Vec3> scattered_;
  double blur_mm_ = 0;   // how far the blur reaches
  double reach_mm_ = 0;  // how far a voxel sees
};

}  // namespace

void cover(const Grid& grid, const Block& block, const std::vector<Body>& bodies,
           const CoverOptions& options,
           const std::function<void(const Block&, const Shares&)>& emit) {
  assert(bodies.size() <= kMostBodies);
  Shares shares{};
  std::fill_n(shares.begin(), bodies.size(), kUnsettled);
  Cover(grid, bodies, options, emit).settle(block, shares);
}

std::vector<Block> blocks_of(const Grid& grid, const Index3& edge) {
  std::vector<Block> out;
  for (int k = 0; k < grid.size[2]; k += edge[2]) {
    for (int j = 0; j < grid.size[1]; j += edge[1]) {
      for (int i = 0; i < grid.size[0]; i += edge[0]) {
        out.push_back({{i, j, k},
                       {std::min(edge[0], grid.size[0] - i), std::min(edge[1], grid.size[1] - j),
                        std::min(edge[2], grid.size[2] - k)}});
      }
    }
  }
  return out;
}

}  // namespace beatlas::phantom
