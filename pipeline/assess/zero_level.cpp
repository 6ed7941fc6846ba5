#include "pipeline/assess/zero_level.h"

#include <array>
#include <cmath>

#include "pipeline/core/parallel.h"

namespace beatlas::assess {
namespace {

constexpr int kEdge = atlas::FieldPayload::kBlockEdge;

/// Where the field crosses zero between two points of different sign.
Vec3 crossing(const field::FieldQuery& query, double t_s, Vec3 a, double at_a, Vec3 b,
              double at_b) {
  Vec3 x = a;
  for (int iteration = 0; iteration < 40; ++iteration) {
    double u = at_a / (at_a - at_b);
    if (iteration % 3 == 2 || !(u > 0.0 && u < 1.0)) u = 0.5;
    x = a + (b - a) * u;
    const double value = query.sample(x, t_s).distance_mm;
    if (std::abs(value) < 1e-9 || (b - a).squaredNorm() < 1e-18) break;
    if ((value < 0.0) == (at_a < 0.0)) {
      a = x;
      at_a = value;
    } else {
      b = x;
      at_b = value;
    }
  }
  return x;
}

/// Whether a block or one beside it has a leaf. A block without leaf may hold a surface that the
/// spline carries in from a neighbour.
bool is_near_leaf(const atlas::FieldPayload& payload, const Index3& b) {
  const Index3& blocks = payload.block_count;
  for (int z = std::max(0, b[2] - 1); z <= std::min(blocks[2] - 1, b[2] + 1); ++z) {
    for (int y = std::max(0, b[1] - 1); y <= std::min(blocks[1] - 1, b[1] + 1); ++y) {
      for (int x = std::max(0, b[0] - 1); x <= std::min(blocks[0] - 1, b[0] + 1); ++x) {
        const auto n = [](int value) { return static_cast<std::size_t>(value); };
        if (payload.blocks[n(x) + n(blocks[0]) * (n(y) + n(blocks[1]) * n(z))] >= 0) return true;
      }
    }
  }
  return false;
}

/// Distances at a block's lattice points. Edges are those that start in a block, so each block
/// looks one sample into the next.
class BlockSamples {
 public:
  BlockSamples(const field::FieldQuery& query, double t_s, const Index3& block)
      : origin_mm_(query.payload().origin_mm), voxel_mm_(query.payload().voxel_mm), block_(block) {
    for (int z = 0; z < kSide; ++z) {
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          mm_[place(x, y, z)] = query.sample(point(x, y, z), t_s).distance_mm;
        }
      }
    }
  }

  [[nodiscard]] double mm(int x, int y, int z) const { return mm_[place(x, y, z)]; }
  [[nodiscard]] Vec3 point(int x, int y, int z) const {
    return origin_mm_ +
           voxel_mm_ * Vec3(block_[0] * kEdge + x, block_[1] * kEdge + y, block_[2] * kEdge + z);
  }

 private:
  static constexpr int kSide = kEdge + 1;

  static std::size_t place(int x, int y, int z) {
    const auto n = [](int value) { return static_cast<std::size_t>(value); };
    return n(x) + n(kSide) * (n(y) + n(kSide) * n(z));
  }

  Vec3 origin_mm_;
  double voxel_mm_;
  Index3 block_;
  std::array<double, std::size_t{kSide} * kSide * kSide> mm_{};
};

/// The points on a block's edges.
std::vector<SurfacePoint> points_in(const field::FieldQuery& query, double t_s,
                                    const Index3& block) {
  const double h = query.payload().voxel_mm;
  const BlockSamples samples(query, t_s, block);
  std::vector<SurfacePoint> found;
  const auto look_along = [&](int axis, int x, int y, int z) {
    const Index3 end{x + (axis == 0), y + (axis == 1), z + (axis == 2)};
    const double from = samples.mm(x, y, z);
    const double to = samples.mm(end[0], end[1], end[2]);
    if ((from < 0.0) == (to < 0.0)) return;
    SurfacePoint out;
    out.x = crossing(query, t_s, samples.point(x, y, z), from,
                     samples.point(end[0], end[1], end[2]), to);
    const Vec3 gradient = query.sample(out.x, t_s).gradient;
    const double length = gradient.norm();
    out.area_mm2 = length > 0.0 ? h * h * length / gradient.lpNorm<1>() : h * h;
    found.push_back(out);
  };
  for (int z = 0; z < kEdge; ++z) {
    for (int y = 0; y < kEdge; ++y) {
      for (int x = 0; x < kEdge; ++x) {
        for (int axis = 0; axis < 3; ++axis) look_along(axis, x, y, z);
      }
    }
  }
  return found;
}

}  // namespace

std::vector<SurfacePoint> zero_level(const field::FieldQuery& query, double t_s) {
  const atlas::FieldPayload& payload = query.payload();
  const Index3& blocks = payload.block_count;
  std::vector<std::vector<SurfacePoint>> found(payload.blocks.size());
  parallel_for(payload.blocks.size(), [&](std::size_t block) {
    const int n = static_cast<int>(block);
    const Index3 b{n % blocks[0], n / blocks[0] % blocks[1], n / (blocks[0] * blocks[1])};
    if (is_near_leaf(payload, b)) found[block] = points_in(query, t_s, b);
  });
  std::vector<SurfacePoint> points;
  for (const auto& each : found) points.insert(points.end(), each.begin(), each.end());
  return points;
}

}  // namespace beatlas::assess
