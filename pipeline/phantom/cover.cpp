#include "pipeline/phantom/cover.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace beatlas::phantom {
namespace {

constexpr float kUnsettled = -1.0F;

struct Cover {
  const Grid& grid;
  const std::vector<Body>& bodies;
  const CoverOptions& options;
  const std::function<void(const Block&, const Shares&, bool)>& emit;
  Vec3 spacing_mm;
  Vec3 box_mm;            // edges of a voxel's box
  Eigen::Matrix3d axes;   // unit vectors of i, j, k
  Index3 parts{1, 1, 1};  // of a voxel's box

  double voxel_share(const Body& body, const Vec3& centre, const SignedPlane& at_centre) const {
    if (!options.partial_volume) return at_centre.distance_mm < 0.0 ? 1.0 : 0.0;
    const Vec3 half = 0.5 * box_mm.cwiseQuotient(Vec3(parts[0], parts[1], parts[2]));
    if (parts == Index3{1, 1, 1}) {
      return box_share(half, at_centre.distance_mm, axes.transpose() * at_centre.outward);
    }
    double sum = 0.0;
    for (int k = 0; k < parts[2]; ++k) {
      for (int j = 0; j < parts[1]; ++j) {
        for (int i = 0; i < parts[0]; ++i) {
          const Vec3 offset = half.cwiseProduct(
              Vec3(2 * i + 1 - parts[0], 2 * j + 1 - parts[1], 2 * k + 1 - parts[2]));
          const SignedPlane plane = body(centre + axes * offset);
          sum += box_share(half, plane.distance_mm, axes.transpose() * plane.outward);
        }
      }
    }
    return sum / (parts[0] * parts[1] * parts[2]);
  }

  void settle(const Block& block, Shares shares) const {
    const Vec3 count(block.size[0], block.size[1], block.size[2]);
    const Vec3 middle =
        Vec3(block.first[0], block.first[1], block.first[2]) + 0.5 * (count - Vec3::Ones());
    const Vec3 centre = grid.mm_from_index * middle;
    const Vec3 edges = spacing_mm.cwiseProduct(count - Vec3::Ones()) + box_mm;
    const double radius = 0.5 * edges.norm();
    const bool single = block.size == Index3{1, 1, 1};
    bool settled = true;
    for (std::size_t n = 0; n < bodies.size(); ++n) {
      if (shares[n] != kUnsettled) continue;
      const SignedPlane plane = bodies[n](centre);
      if (std::abs(plane.distance_mm) >= radius) {
        shares[n] = plane.distance_mm < 0.0 ? 1.0F : 0.0F;
      } else {
        settled = false;
        if (single) shares[n] = static_cast<float>(voxel_share(bodies[n], centre, plane));
      }
    }
    if (settled || single) {
      emit(block, shares, settled);
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
};

}  // namespace

double box_share(const Vec3& half_mm, double distance_mm, const Vec3& outward) {
  std::array<double, 3> m{};
  double total = 0.0;
  for (int a = 0; a < 3; ++a) {
    m[a] = std::abs(outward[a]) * half_mm[a];
    total += m[a];
  }
  if (distance_mm >= total) return 0.0;
  if (distance_mm <= -total) return 1.0;
  // Unit cube, m1 x + m2 y + m3 z < alpha with m1 + m2 + m3 = 1; a slope too small to be told from
  // zero is raised, which moves the plane by less than the error promised.
  std::sort(m.begin(), m.end());
  m[0] = std::max(m[0], 1e-5 * total);
  m[1] = std::max(m[1], 1e-5 * total);
  const double sum = m[0] + m[1] + m[2];
  for (double& value : m) value /= sum;
  const double plane = std::clamp(0.5 - 0.5 * distance_mm / total, 0.0, 1.0);
  const double alpha = std::min(plane, 1.0 - plane);
  const double m12 = m[0] + m[1];
  double share = 0.0;
  if (alpha < m[0]) {
    share = alpha * alpha * alpha / (6.0 * m[0] * m[1] * m[2]);
  } else if (alpha < m[1]) {
    share = alpha * (alpha - m[0]) / (2.0 * m[1] * m[2]) + m[0] * m[0] / (6.0 * m[1] * m[2]);
  } else if (alpha < std::min(m12, m[2])) {
    share = (alpha * alpha * (3.0 * m12 - alpha) + m[0] * m[0] * (m[0] - 3.0 * alpha) +
             m[1] * m[1] * (m[1] - 3.0 * alpha)) /
            (6.0 * m[0] * m[1] * m[2]);
  } else if (m[2] < m12) {
    share = (alpha * alpha * (3.0 - 2.0 * alpha) + m[0] * m[0] * (m[0] - 3.0 * alpha) +
             m[1] * m[1] * (m[1] - 3.0 * alpha) + m[2] * m[2] * (m[2] - 3.0 * alpha)) /
            (6.0 * m[0] * m[1] * m[2]);
  } else {
    share = (2.0 * alpha - m12) / (2.0 * m[2]);
  }
  return std::clamp(plane < 0.5 ? share : 1.0 - share, 0.0, 1.0);
}

void cover(const Grid& grid, const Block& block, const std::vector<Body>& bodies,
           const CoverOptions& options,
           const std::function<void(const Block&, const Shares&, bool whole)>& emit) {
  assert(bodies.size() <= kMostBodies);
  Cover state{grid, bodies, options, emit, grid.spacing_mm(), grid.spacing_mm(), {}, {}};
  if (options.thickness_mm > 0.0) state.box_mm.z() = options.thickness_mm;
  state.axes = grid.mm_from_index.linear().colwise().normalized();
  for (int a = 0; a < 3; ++a) {
    state.parts[a] =
        std::max(1, static_cast<int>(std::ceil(state.box_mm[a] / options.flat_mm - 1e-9)));
  }
  Shares shares{};
  std::fill_n(shares.begin(), bodies.size(), kUnsettled);
  state.settle(block, shares);
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
