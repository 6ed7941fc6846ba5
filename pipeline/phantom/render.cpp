#include "pipeline/phantom/render.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/phantom/cover.h"
#include "pipeline/phantom/noise.h"

namespace beatlas::phantom {
namespace {

constexpr Index3 kBlockEdge{32, 32, 16};
constexpr double kMostCounts = 4095.0;  // 12 bit

template <class F>
void for_each_voxel(const Block& block, const F& visit) {
  for (int k = block.first[2]; k < block.first[2] + block.size[2]; ++k) {
    for (int j = block.first[1]; j < block.first[1] + block.size[1]; ++j) {
      for (int i = block.first[0]; i < block.first[0] + block.size[0]; ++i) visit(i, j, k);
    }
  }
}

/// Signal of the thorax without the heart, blood = 1.
std::vector<float> background(const Grid& grid, const std::vector<Tissue>& tissues, double air,
                              const CoverOptions& options) {
  std::vector<Body> bodies;
  for (const Tissue& tissue : tissues) {
    bodies.emplace_back([&tissue](const Vec3& lps) { return tissue.surface(lps); });
  }
  std::vector<float> out(grid.count());
  const std::vector<Block> blocks = blocks_of(grid, kBlockEdge);
  parallel_for(blocks.size(), [&](std::size_t n) {
    cover(grid, blocks[n], bodies, options, [&](const Block& block, const Shares& shares, bool) {
      double signal = air;
      for (std::size_t b = 0; b < tissues.size(); ++b) {
        signal += shares[b] * (tissues[b].signal - signal);
      }
      for_each_voxel(block, [&](int i, int j, int k) {
        out[grid.offset(i, j, k)] = static_cast<float>(signal);
      });
    });
  });
  return out;
}

/// What moves, from the outside to the inside.
constexpr std::array kPainted{Part::PericardialFat, Part::Heart,           Part::LvBlood,
                              Part::RvBlood,        Part::LaBlood,         Part::RaBlood,
                              Part::Aorta,          Part::PapillaryMuscles};

/// Shares of a voxel; they add up to 1.
struct Mixture {
  double background = 1;
  double fat = 0;
  double muscle = 0;
  double blood = 0;
};

/// The shares come from different planes near creases, so that bodies that lie within each other
/// may not do so by their shares: the inner one wins.
Mixture mixture_of(const Shares& shares) {
  double pools = 0.0;
  for (std::size_t n = 2; n < 7; ++n) pools += shares[n];
  const double papillary = std::min<double>(pools, shares[7]);
  const double within = std::min(1.0, pools);
  const double heart = std::max<double>(shares[1], within);
  const double pericardium = std::max<double>(shares[0], heart);
  const double blood = std::max(0.0, within - papillary);
  return {1.0 - pericardium, pericardium - heart, heart - blood, blood};
}

struct Imager {
  const PhantomSpec& spec;
  const Grid& grid;
  const Signals& signals;
  const CoverOptions& options;
  const std::vector<float>& behind;

  double counts(double signal, std::size_t voxel, int phase) const {
    double value = signal * kBloodCounts;
    if (std::isfinite(spec.snr_blood)) {
      const double sigma = kBloodCounts / spec.snr_blood;
      const auto noise = normal_pair(voxel, static_cast<std::uint32_t>(phase),
                                     static_cast<std::uint32_t>(spec.noise_seed));
      const double real = value + sigma * noise[0];
      const double imaginary = sigma * noise[1];
      value = std::sqrt(real * real + imaginary * imaginary);
    }
    return std::clamp(std::round(value), 0.0, kMostCounts);
  }

  void image(const Frame& frame, const Block& whole_block, int phase, std::vector<float>& image,
             std::vector<std::uint8_t>& labels) const {
    std::vector<Body> bodies;
    for (Part part : kPainted) {
      bodies.emplace_back([&frame, part](const Vec3& lps) {
        const Nearest nearest = frame.nearest(part, lps);
        return SignedPlane{nearest.distance_mm, nearest.outward};
      });
    }
    cover(grid, whole_block, bodies, options,
          [&](const Block& block, const Shares& shares, bool whole) {
            const Mixture mixture = mixture_of(shares);
            const bool outside = whole && mixture.background == 1.0;
            for_each_voxel(block, [&](int i, int j, int k) {
              const std::size_t voxel = grid.offset(i, j, k);
              const double signal = mixture.background * behind[voxel] + mixture.fat * signals.fat +
                                    mixture.muscle * signals.myocardium +
                                    mixture.blood * signals.blood;
              image[voxel] = static_cast<float>(counts(signal, voxel, phase));
              labels[voxel] =
                  outside ? std::uint8_t{kLabelBackground} : frame.label_at(grid.mm(i, j, k));
            });
          });
  }
};

}  // namespace

Rendering render(const Phantom& phantom, StageContext& context) {
  const PhantomSpec& spec = phantom.spec();
  const Grid grid = spec.imaging_grid();
  const Signals signals;
  CoverOptions options;
  options.thickness_mm = spec.slice_thickness_mm;
  options.partial_volume = spec.partial_volume;
  const std::vector<float> behind =
      background(grid, thorax(spec.anatomy, signals), signals.air, options);

  Rendering out;
  out.cine.images.grid = grid;
  out.labels.grid = grid;
  out.cine.rr_interval_s = spec.rr_interval_s;
  const Imager imager{spec, grid, signals, options, behind};
  const std::vector<Block> blocks = blocks_of(grid, kBlockEdge);
  for (int phase = 0; phase < spec.phases; ++phase) {
    context.check_cancelled();
    std::vector<float> image(grid.count());
    std::vector<std::uint8_t> labels(grid.count());
    const auto frame = phantom.frame(phantom.phase_time_s(phase));
    parallel_for(blocks.size(),
                 [&](std::size_t n) { imager.image(*frame, blocks[n], phase, image, labels); });
    out.cine.images.phases.push_back(std::move(image));
    out.labels.phases.push_back(std::move(labels));
    out.cine.frame_times_s.push_back(phantom.phase_time_s(phase));
    context.progress(static_cast<double>(phase + 1) / spec.phases);
  }
  return out;
}

}  // namespace beatlas::phantom
