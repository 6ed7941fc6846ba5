#include "pipeline/phantom/true_coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/core/parallel.h"
#include "pipeline/phantom/cover.h"
#include "pipeline/phantom/still.h"

namespace beatlas::phantom {
namespace {

constexpr double kSampleMm = 3;  ///< between the points that tell how far the heart reaches
constexpr int kEdge = 8;         ///< of a block of voxels

/// The part of the grid that holds the heart of every phase, with room for what lies between
/// samples.
Block box_of(const Phantom& phantom, const Grid& grid) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  const Affine index_from_lps = grid.mm_from_index.inverse();
  for (int phase = 0; phase < phantom.spec().phases; ++phase) {
    const auto frame = phantom.frame(phantom.phase_time_s(phase));
    for (const Vec3& lps : frame->sample_surface(Structure::Heart, kSampleMm)) {
      const Vec3 index = index_from_lps * lps;
      low = low.cwiseMin(index);
      high = high.cwiseMax(index);
    }
  }
  const Vec3 room = 2 * kSampleMm * grid.spacing_mm().cwiseInverse();
  Block box;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    box.first[a] = std::max(0, static_cast<int>(std::floor(low[axis] - room[axis])));
    const int last =
        std::min(grid.size[a] - 1, static_cast<int>(std::ceil(high[axis] + room[axis])));
    box.size[a] = last - box.first[a] + 1;
  }
  return box;
}

}  // namespace

CoverageCycle true_coverage(const Phantom& phantom, StageContext& context) {
  const Grid whole = phantom.spec().imaging_grid();
  const Block box = box_of(phantom, whole);
  CoverageCycle out;
  out.first = box.first;
  out.grid = whole.part(box.first, box.size);
  const auto first = phantom.frame(phantom.phase_time_s(0));
  std::vector<Structure> structures;
  for (const Structure structure : kAllStructures) {
    if (first->has(structure)) structures.push_back(structure);
  }
  const std::vector<Block> blocks = blocks_of(out.grid, {kEdge, kEdge, kEdge});
  for (int phase = 0; phase < phantom.spec().phases; ++phase) {
    context.check_cancelled();
    const auto frame = phantom.frame(phantom.phase_time_s(phase));
    std::vector<Body> bodies;
    std::vector<float*> shares_of;
    for (const Structure structure : structures) {
      Body& body = bodies.emplace_back();
      body.surface = [&frame, structure](const Vec3& lps) {
        const Nearest nearest = frame->nearest(structure, lps);
        return SignedPlane{nearest.distance_mm, nearest.outward};
      };
      body.inside = [&frame, structure](const Vec3& lps) {
        return frame->contains(structure, lps);
      };
      body.within = structure == Structure::Heart ? -1 : 0;
      shares_of.push_back(out.phases[structure].emplace_back(out.grid.count(), 0.0F).data());
    }
    parallel_for(blocks.size(), [&](std::size_t n) {
      cover(out.grid, blocks[n], bodies, {}, [&](const Block& block, const Shares& shares) {
        for_each_voxel(block, [&](int i, int j, int k) {
          const std::size_t voxel = out.grid.offset(i, j, k);
          for (std::size_t s = 0; s < shares_of.size(); ++s) shares_of[s][voxel] = shares[s];
        });
      });
    });
    context.progress(static_cast<double>(phase + 1) / phantom.spec().phases);
  }
  return out;
}

}  // namespace beatlas::phantom
