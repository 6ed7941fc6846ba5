#include "pipeline/shape/smooth_level.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace beatlas::shape {
namespace {

using Phase = std::vector<float>;

constexpr double kSharpMm = 2.0;   ///< Gaussian beside creases
constexpr float kNear = 0.15F;     ///< level up to which both are linear in the distance
constexpr double kBesideMm = 4.0;  ///< Gaussian of how far beside a crease is
constexpr float kFrom = 3.0F;      ///< apart by so often the median a crease begins to count
constexpr float kTo = 6.0F;        ///< and from this on it does in full
constexpr int kCell = 2;           ///< edge [lattice steps] of a cell, for what varies slowly

Phase gaussian(const Phase& level, const Grid& lattice, double sigma_mm) {
  const double sigma = sigma_mm / lattice.spacing_mm()[0];
  Phase planes(level.size());
  for (int z = 0; z < lattice.size[2]; ++z) {
    const std::size_t first = lattice.offset(0, 0, z);
    const cv::Mat from(lattice.size[1], lattice.size[0], CV_32F,
                       const_cast<float*>(level.data()) + first);
    cv::Mat to(lattice.size[1], lattice.size[0], CV_32F, planes.data() + first);
    cv::GaussianBlur(from, to, {0, 0}, sigma, sigma, cv::BORDER_REPLICATE);
  }
  const int wide = static_cast<int>(lattice.slice_count());
  const cv::Mat columns(lattice.size[2], wide, CV_32F, planes.data());
  const int radius = std::max(1, static_cast<int>(std::ceil(4 * sigma)));
  const cv::Mat kernel = cv::getGaussianKernel(2 * radius + 1, sigma, CV_32F);
  Phase out(level.size());
  cv::Mat to(lattice.size[2], wide, CV_32F, out.data());
  cv::sepFilter2D(columns, to, CV_32F, cv::Mat::ones(1, 1, CV_32F), kernel, {-1, -1}, 0,
                  cv::BORDER_REPLICATE);
  return out;
}

/// Less a share of the second derivatives; none across the lattice's rim.
Phase without_bend(const Phase& level, const Grid& lattice, const Vec3& bend_mm2) {
  const Vec3 share = bend_mm2 / (lattice.spacing_mm()[0] * lattice.spacing_mm()[0]);
  const auto [sx, sy, sz] = std::array<float, 3>{
      static_cast<float>(share[0]), static_cast<float>(share[1]), static_cast<float>(share[2])};
  const auto [nx, ny, nz] = lattice.size;
  Phase out(level.size());
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      const auto row = [&](int b, int c) { return level.data() + lattice.offset(0, b, c); };
      const float* here = row(y, z);
      const bool inner_y = y > 0 && y + 1 < ny;
      const bool inner_z = z > 0 && z + 1 < nz;
      const float* before = inner_y ? row(y - 1, z) : here;
      const float* after = inner_y ? row(y + 1, z) : here;
      const float* below = inner_z ? row(y, z - 1) : here;
      const float* above = inner_z ? row(y, z + 1) : here;
      float* to = out.data() + lattice.offset(0, y, z);
      for (int x = 0; x < nx; ++x) {
        to[x] = here[x] - sy * (before[x] - 2 * here[x] + after[x]) -
                sz * (below[x] - 2 * here[x] + above[x]);
      }
      for (int x = 1; x + 1 < nx; ++x) to[x] -= sx * (here[x - 1] - 2 * here[x] + here[x + 1]);
    }
  }
  return out;
}

/// Sums of a lattice's values over cells of kCell steps.
struct Cells {
  Grid grid;
  Phase sum;

  explicit Cells(const Grid& lattice) {
    for (std::size_t a = 0; a < 3; ++a) grid.size[a] = (lattice.size[a] + kCell - 1) / kCell;
    grid.mm_from_index = lattice.mm_from_index *
                         Eigen::Translation3d(Vec3::Constant(0.5 * (kCell - 1))) *
                         Eigen::Scaling(static_cast<double>(kCell));
    sum.resize(grid.count());
  }
  float& of(int x, int y, int z) { return sum[grid.offset(x / kCell, y / kCell, z / kCell)]; }
  void spread() { sum = gaussian(sum, grid, kBesideMm); }
};

/// Linear between the middles of cells.
float between(const Cells& cells, const Index3& voxel) {
  std::array<int, 3> low{};
  std::array<float, 3> u{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double x = std::clamp((voxel[a] - 0.5 * (kCell - 1)) / kCell, 0.0,
                                std::max(0.0, cells.grid.size[a] - 1.0));
    low[a] = std::clamp(static_cast<int>(x), 0, std::max(0, cells.grid.size[a] - 2));
    u[a] = static_cast<float>(x - low[a]);
  }
  float out = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const std::array<int, 3> up{corner & 1, corner >> 1 & 1, corner >> 2};
    float weight = 1;
    std::array<int, 3> cell{};
    for (std::size_t a = 0; a < 3; ++a) {
      weight *= up[a] != 0 ? u[a] : 1 - u[a];
      cell[a] = std::min(low[a] + up[a], cells.grid.size[a] - 1);
    }
    out += weight * cells.sum[cells.grid.offset(cell[0], cell[1], cell[2])];
  }
  return out;
}

}  // namespace

void smooth_evenly(Phase& level, const Grid& lattice, const Vec3& bend_mm2) {
  level = without_bend(gaussian(level, lattice, kSmoothMm), lattice, bend_mm2);
}

void smooth_between_creases(Phase& level, const Grid& lattice, const Vec3& voxel_mm) {
  const auto smoothed = [&](double sigma_mm) {
    return without_bend(gaussian(level, lattice, sigma_mm), lattice,
                        Vec3::Constant(sigma_mm * sigma_mm) + voxel_mm.cwiseAbs2() / 12);
  };
  Phase sharp = smoothed(kSharpMm);
  level = smoothed(kSmoothMm);
  // As steep as the other: then both tell distances, and their mean has the mean's zero.
  for (float& value : sharp) value *= static_cast<float>(kSharpMm / kSmoothMm);
  Phase apart;
  Cells square(lattice);
  Cells count(lattice);
  for (int z = 0; z < lattice.size[2]; ++z) {
    for (int y = 0; y < lattice.size[1]; ++y) {
      std::size_t v = lattice.offset(0, y, z);
      for (int x = 0; x < lattice.size[0]; ++x, ++v) {
        if (std::abs(level[v]) > kNear && std::abs(sharp[v]) > kNear) continue;
        const float by = sharp[v] - level[v];
        apart.push_back(std::abs(by));
        square.of(x, y, z) += by * by;
        count.of(x, y, z) += 1;
      }
    }
  }
  if (apart.empty()) return;
  const auto middle = apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2);
  std::nth_element(apart.begin(), middle, apart.end());
  const float usual = *middle;
  if (!(usual > 0)) return;
  square.spread();
  count.spread();
  Cells share(lattice);
  for (std::size_t cell = 0; cell < share.sum.size(); ++cell) {
    const float times =
        std::sqrt(std::max(0.0F, square.sum[cell]) / std::max(count.sum[cell], 1e-6F)) / usual;
    const float u = std::clamp((times - kFrom) / (kTo - kFrom), 0.0F, 1.0F);
    share.sum[cell] = u * u * (3 - 2 * u);
  }
  for (int z = 0; z < lattice.size[2]; ++z) {
    for (int y = 0; y < lattice.size[1]; ++y) {
      std::size_t v = lattice.offset(0, y, z);
      for (int x = 0; x < lattice.size[0]; ++x, ++v) {
        const float by = sharp[v] - level[v];
        if (by != 0) level[v] += between(share, {x, y, z}) * by;
      }
    }
  }
}

}  // namespace beatlas::shape
