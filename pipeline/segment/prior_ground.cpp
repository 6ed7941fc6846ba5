#include "pipeline/segment/prior_ground.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/core/words.h"
#include "pipeline/segment/connected.h"
#include "pipeline/segment/looks.h"
#include "pipeline/tissue/tissue.h"
#include "runtime/atlas/structures.h"

namespace beatlas::segment {
namespace {

constexpr double kRoomMm = 20;    ///< beside what the prior takes for heart
constexpr float kSure = 0.9F;     ///< probability of a seed
constexpr double kLeastLvMl = 4;  ///< 40 ml at an EF of 90 %, phantom/family.json
/// Muscle of an LV over its blood: a ball of 400 ml has a wall of 2 mm then, half of the thinnest
/// of the family.
constexpr double kLeastWall = 0.125;

/// Label of the prior's grid at a voxel of the part: that of the pixel in which its centre lies.
class LikeliestAt {
 public:
  LikeliestAt(const LabelCycle& likeliest, const Grid& part)
      : labels_(likeliest),
        to_prior_(likeliest.grid.mm_from_index.inverse(Eigen::Affine) * part.mm_from_index) {}

  [[nodiscard]] std::uint8_t operator()(std::size_t phase, int i, int j, int k) const {
    const Vec3 at = to_prior_ * Vec3(i, j, k);
    const auto near = [&](int a) {
      return std::clamp(static_cast<int>(std::lround(at[a])), 0, labels_.grid.size[a] - 1);
    };
    return labels_.phases[phase][labels_.grid.offset(near(0), near(1), near(2))];
  }

 private:
  const LabelCycle& labels_;
  Affine to_prior_;
};

using ByLabel = std::array<std::vector<float>, kLabels>;

/// What one phase tells before anything grows.
struct PhaseGround {
  std::vector<std::uint8_t> seeds;
  Looks counts{};  ///< of intensities, each voxel by its labels' probabilities
  ByLabel sure;    ///< intensities of the seeds
};

/// @param likely [label][voxel] probabilities  @param likeliest_at as LikeliestAt, of (i, j, k)
template <class LabelAt>
PhaseGround read_phase(const Grid& grid, const std::vector<float>& image, const Bins& bins,
                       const std::vector<std::vector<float>>& likely, const LabelAt& likeliest_at) {
  PhaseGround out;
  out.seeds.assign(image.size(), kUnlabelled);
  for_each_voxel(grid, [&](int i, int j, int k, std::size_t v) {
    const std::uint8_t here = likeliest_at(i, j, k);
    const float value = image[v];
    const std::size_t bin = bins.of(value);
    for (std::size_t l = 0; l < kLabels; ++l) {
      if (likely[l][v] > 0.5F) out.counts[l][bin] += static_cast<double>(likely[l][v]);
    }
    if (likely[here][v] < kSure) {
      // Sure of something that does not hang together with the heart: it is none.
      if (here == kLabelBackground && likely[0][v] < 0.5F) out.seeds[v] = kLabelBackground;
      return;
    }
    out.seeds[v] = here;
    out.sure[here].push_back(value);
  });
  return out;
}

/// Levels by the medians of what is sure.
tissue::TissueLevels levels_of(ByLabel& sure) {
  tissue::TissueLevels levels;
  levels.blood = tissue::median_of(sure[kLabelLvBlood]);
  levels.rv_blood =
      sure[kLabelRvBlood].empty() ? levels.blood : tissue::median_of(sure[kLabelRvBlood]);
  levels.muscle = tissue::median_of(sure[kLabelLvMyocardium]);
  levels.part();
  return levels;
}

}  // namespace

LabelCycle likeliest_labels(const prior::PriorCycle& prior) {
  LabelCycle out{prior.grid, {}};
  out.phases.resize(prior.phases.size());
  const std::size_t count = prior.grid.count();
  parallel_for(prior.phases.size(), [&](std::size_t p) {
    out.phases[p].resize(count);
    for (std::size_t v = 0; v < count; ++v) out.phases[p][v] = prior.likeliest(p, v);
  });
  keep_connected_heart(out);
  keep_largest({kLabelLvBlood, kLabelLvMyocardium}, kLabelBackground, out);
  keep_largest({kLabelLvBlood}, kLabelBackground, out);
  keep_largest_of_each_slice({kLabelLvBlood, kLabelLvMyocardium}, kLabelBackground, out);
  keep_largest({kLabelRvBlood}, kLabelBackground, out);
  return out;
}

bool holds_heart(const LabelCycle& likeliest) {
  const double ml = likeliest.grid.voxel_ml();
  return std::any_of(likeliest.phases.begin(), likeliest.phases.end(), [&](const auto& phase) {
    const auto volume = [&](std::uint8_t label) {
      return ml * static_cast<double>(std::count(phase.begin(), phase.end(), label));
    };
    const double blood = volume(kLabelLvBlood);
    return blood >= kLeastLvMl && volume(kLabelLvMyocardium) >= kLeastWall * blood;
  });
}

Box box_of_heart(const Grid& stack, const LabelCycle& likeliest) {
  const Box found = box_around(likeliest.grid, likeliest.phases);
  if (found.empty()) return {};
  const Affine to_stack = stack.mm_from_index.inverse(Eigen::Affine) * likeliest.grid.mm_from_index;
  Box out;
  for (int a = 0; a < 3; ++a) {
    const auto s = static_cast<std::size_t>(a);
    Vec3 low = Vec3::Zero();
    low[a] = found.first[s] - 0.5;
    Vec3 high = Vec3::Zero();
    high[a] = found.first[s] + found.size[s] - 0.5;
    const double room = a == 2 ? 1.0 : kRoomMm / stack.spacing_mm()[a];
    const int first = static_cast<int>(std::floor((to_stack * low)[a] + 0.5 - room));
    const int end = static_cast<int>(std::ceil((to_stack * high)[a] + 0.5 + room));
    out.first[s] = std::max(0, first);
    out.size[s] = std::min(stack.size[s], end) - out.first[s];
  }
  return out;
}

std::optional<std::string> labelled_after_views(const prior::PriorCycle& prior) {
  constexpr double kMost = 0.5;
  std::vector<std::string> slices;
  for (std::size_t k = 0; k < prior.unknown.size(); ++k) {
    if (prior.unknown[k] > kMost) slices.push_back(std::to_string(k));
  }
  if (slices.empty()) return {};
  const std::string list = listed(slices);
  return (slices.size() == 1 ? "slice " + list + " is" : "slices " + list + " are") +
         " labelled after the long-axis views across the stack, which show something else there "
         "than the prior sees in the slice; look whether the outlines are right, and if not paint "
         "them or give seeds";
}

Ground lay_prior_ground(const ImageCycle<float>& images, const prior::PriorCycle& prior,
                        const LabelCycle& likeliest) {
  const Grid& grid = images.grid;
  const std::size_t count = grid.count();
  const auto phases = static_cast<std::size_t>(images.phase_count());
  const LikeliestAt likeliest_at(likeliest, grid);
  const Bins bins(images);
  // Probabilities of a phase, and what they and the one heart say of seeds.
  const auto probabilities = [&](std::size_t p) {
    std::vector<std::vector<float>> by_output =
        prior::probabilities_on(prior, static_cast<int>(p), grid);
    std::vector<std::vector<float>> out_by_label(kLabels, std::vector<float>(count, 1e-4F));
    for (std::size_t o = 0; o < prior.labels.size(); ++o) {
      out_by_label[prior.labels[o]] = std::move(by_output[o]);
    }
    return out_by_label;
  };
  std::vector<PhaseGround> found(phases);
  parallel_for(phases, [&](std::size_t p) {
    found[p] = read_phase(grid, images.phases[p], bins, probabilities(p),
                          [&](int i, int j, int k) { return likeliest_at(p, i, j, k); });
  });
  Ground out;
  Looks all{};
  ByLabel sure;
  for (PhaseGround& phase : found) {
    for (std::size_t l = 0; l < kLabels; ++l) {
      for (std::size_t b = 0; b < kLookBins; ++b) all[l][b] += phase.counts[l][b];
      sure[l].insert(sure[l].end(), phase.sure[l].begin(), phase.sure[l].end());
    }
    out.seeds.push_back(std::move(phase.seeds));
  }
  found.clear();
  const Looks densities = densities_of(all);
  out.levels = levels_of(sure);

  out.prices.phases.resize(phases);
  parallel_for(phases, [&](std::size_t p) {
    const std::vector<std::vector<float>> likely = probabilities(p);
    std::vector<std::uint8_t>& prices = out.prices.phases[p];
    prices.resize(count * kLabels);
    for (std::size_t v = 0; v < count; ++v) {
      const std::size_t bin = bins.of(images.phases[p][v]);
      std::array<double, kLabels> weight{};
      for (std::size_t l = 0; l < kLabels; ++l) {
        weight[l] = static_cast<double>(likely[l][v]) * densities[l][bin];
      }
      set_prices(weight, prices.data() + v * kLabels);
    }
  });
  return out;
}

}  // namespace beatlas::segment
