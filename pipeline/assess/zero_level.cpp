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

}  // namespace

std::vector<SurfacePoint> zero_level(const field::FieldQuery& query, double t_s) {
  const atlas::FieldPayload& payload = query.payload();
  const Index3& blocks = payload.block_count;
  const double h = payload.voxel_mm;
  std::vector<std::vector<SurfacePoint>> found(payload.blocks.size());
  // Edges are those that start in a block, so each block looks one sample into the next. A block
  // without leaf may hold a surface that the spline carries in from a neighbour.
  const auto is_near_leaf = [&](int bx, int by, int bz) {
    for (int z = std::max(0, bz - 1); z <= std::min(blocks[2] - 1, bz + 1); ++z) {
      for (int y = std::max(0, by - 1); y <= std::min(blocks[1] - 1, by + 1); ++y) {
        for (int x = std::max(0, bx - 1); x <= std::min(blocks[0] - 1, bx + 1); ++x) {
          if (payload.blocks[static_cast<std::size_t>(x + blocks[0] * (y + blocks[1] * z))] >= 0) {
            return true;
          }
        }
      }
    }
    return false;
  };
  parallel_for(payload.blocks.size(), [&](std::size_t block) {
    const int n = static_cast<int>(block);
    const Index3 b{n % blocks[0], n / blocks[0] % blocks[1], n / (blocks[0] * blocks[1])};
    if (!is_near_leaf(b[0], b[1], b[2])) return;
    constexpr int kSide = kEdge + 1;
    std::array<double, static_cast<std::size_t>(kSide * kSide * kSide)> value{};
    const auto point = [&](int x, int y, int z) -> Vec3 {
      return payload.origin_mm + h * Vec3(b[0] * kEdge + x, b[1] * kEdge + y, b[2] * kEdge + z);
    };
    const auto at = [&](int x, int y, int z) -> double& {
      return value[static_cast<std::size_t>(x + kSide * (y + kSide * z))];
    };
    for (int z = 0; z < kSide; ++z) {
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          at(x, y, z) = query.sample(point(x, y, z), t_s).distance_mm;
        }
      }
    }
    for (int z = 0; z < kEdge; ++z) {
      for (int y = 0; y < kEdge; ++y) {
        for (int x = 0; x < kEdge; ++x) {
          for (int axis = 0; axis < 3; ++axis) {
            const Index3 end{x + (axis == 0), y + (axis == 1), z + (axis == 2)};
            const double from = at(x, y, z);
            const double to = at(end[0], end[1], end[2]);
            if ((from < 0.0) == (to < 0.0)) continue;
            SurfacePoint out;
            out.x = crossing(query, t_s, point(x, y, z), from, point(end[0], end[1], end[2]), to);
            const Vec3 gradient = query.sample(out.x, t_s).gradient;
            const double length = gradient.norm();
            out.area_mm2 = length > 0.0 ? h * h * length / gradient.lpNorm<1>() : h * h;
            found[block].push_back(out);
          }
        }
      }
    }
  });
  std::vector<SurfacePoint> points;
  for (const auto& each : found) points.insert(points.end(), each.begin(), each.end());
  return points;
}

}  // namespace beatlas::assess
