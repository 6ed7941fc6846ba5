#include "pipeline/phantom/still.h"

#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/phantom/arms.h"

namespace beatlas::phantom {
namespace {

std::vector<Body> bodies_of(const std::vector<ThoraxBody>& tissues) {
  std::vector<Body> out;
  for (const ThoraxBody& tissue : tissues) {
    Body body;
    body.surface = [&tissue](const Vec3& lps) { return tissue.surface(lps); };
    body.inside = [&tissue](const Vec3& lps) { return tissue.surface(lps).distance_mm < 0.0; };
    out.push_back(std::move(body));
  }
  return out;
}

/// Calls add(voxel, signal, lps) with the signal of tissues painted over air for every voxel of a
/// grid of the imaging grid's size; lps is nominal, as if no slice were shifted.
template <class F>
void paint(const Grid& grid, const std::vector<SliceAcquisition>& slices,
           const std::vector<ThoraxBody>& tissues, double air, const CoverOptions& options,
           const F& add) {
  const std::vector<Body> bodies = bodies_of(tissues);
  const std::vector<Block> tiles = tiles_of(grid);
  parallel_for(tiles.size(), [&](std::size_t n) {
    const Grid moved = shifted_grid(grid, slices[static_cast<std::size_t>(tiles[n].first[2])]);
    cover(moved, tiles[n], bodies, options, [&](const Block& block, const Shares& shares) {
      double signal = air;
      for (std::size_t b = 0; b < tissues.size(); ++b) {
        signal += shares[b] * (tissues[b].signal - signal);
      }
      for_each_voxel(block, [&](int i, int j, int k) { add(i, j, k, signal); });
    });
  });
}

/// How often the image repeats along its phase-encoding axis until it has shown all of the arms.
int repeats(const PhantomSpec& spec, const Grid& grid, int axis) {
  const double field_mm = grid.size[axis] * grid.spacing_mm()[axis];
  const Vec3 centre =
      grid.mm(0.5 * (grid.size[0] - 1), 0.5 * (grid.size[1] - 1), 0.5 * (grid.size[2] - 1));
  const double far_mm =
      arms_reach_mm(spec.anatomy) + (centre - spec.anatomy.origin_lps_mm).norm() + 0.5 * field_mm;
  constexpr int kMost = 8;
  return std::min(kMost, static_cast<int>(std::ceil(far_mm / field_mm)));
}

}  // namespace

CoverOptions cover_options(const ScannerSpec& scanner) {
  CoverOptions out;
  out.thickness_mm = scanner.slice_thickness_mm;
  out.partial_volume = scanner.partial_volume;
  out.sigma_mm = {scanner.in_plane_sigma_mm, scanner.in_plane_sigma_mm, scanner.slice_sigma_mm};
  constexpr double kFlatOfBlurMm = 3.0;
  if (!out.sigma_mm.isZero(0.0)) out.flat_mm = kFlatOfBlurMm;
  return out;
}

std::vector<Block> tiles_of(const Grid& grid) { return blocks_of(grid, {64, 64, 1}); }

StillImages still_images(const PhantomSpec& spec, const Signals& signals,
                         const std::vector<SliceAcquisition>& slices, const CoverOptions& options) {
  const Grid grid = spec.imaging_grid();
  const CoilBias bias(spec);
  StillImages out;
  out.behind.resize(grid.count());
  paint(grid, slices, thorax(spec.anatomy, signals), signals.air, options,
        [&](int i, int j, int k, double signal) {
          out.behind[grid.offset(i, j, k)] = static_cast<float>(signal);
        });
  if (bias.on()) {
    out.bias.resize(grid.count());
    parallel_for(static_cast<std::size_t>(grid.size[2]), [&](std::size_t slice) {
      const Block all{{0, 0, static_cast<int>(slice)}, {grid.size[0], grid.size[1], 1}};
      for_each_voxel(all, [&](int i, int j, int k) {
        out.bias[grid.offset(i, j, k)] = static_cast<float>(bias.at(grid.mm(i, j, k)));
      });
    });
  }
  if (spec.scanner.arms) {
    out.arms.resize(grid.count(), 0.0F);
    const int axis = spec.scanner.phase_encoding == "i" ? 0 : 1;
    const Vec3 field = grid.size[axis] * grid.mm_from_index.linear().col(axis);
    const int most = repeats(spec, grid, axis);
    for (int n = -most; n <= most; ++n) {
      Grid beside = grid;
      beside.mm_from_index.translation() += n * field;
      paint(beside, slices, arms(spec.anatomy, signals), signals.air, options,
            [&](int i, int j, int k, double signal) {
              if (signal == 0.0) return;
              out.arms[grid.offset(i, j, k)] +=
                  static_cast<float>(signal * (bias.on() ? bias.at(beside.mm(i, j, k)) : 1.0));
            });
    }
  }
  return out;
}

}  // namespace beatlas::phantom
