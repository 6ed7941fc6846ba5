#include "pipeline/segment/known_ground.h"

#include <algorithm>
#include <array>

#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/tissue/tissue.h"
#include "runtime/atlas/structures.h"

namespace beatlas::segment {
namespace {

constexpr std::uint8_t kDearest = 255;

/// Which labels an image has, kLabelBackground left out; atria and vessels are rest of heart.
std::array<bool, kLastLabel + 1> labels_in(const std::vector<std::uint8_t>& image) {
  std::array<bool, kLastLabel + 1> out{};
  for (const std::uint8_t label : image) {
    if (label != kLabelUnknown) out[label] = true;
  }
  for (const std::uint8_t label : {kLabelLaBlood, kLabelRaBlood, kLabelAorta}) {
    out[label] = out[kLabelRestOfHeart];
  }
  out[kLabelBackground] = false;
  return out;
}

}  // namespace

Box box_with_labels(const Grid& grid, const Box& box, const KnownLabels& known) {
  return widened(grid, box, box_around(grid, known.labels.phases));
}

KnownLabels crop(const KnownLabels& known, const Box& box) {
  if (known.phases.empty()) return {};
  return {crop(known.labels, box), known.phases};
}

void hold_marks(const Grid& grid, const std::vector<Seed>& seeds, const LabelImages& marks,
                Ground& ground) {
  for (const Seed& seed : seeds) {
    Seed around = seed;
    around.radius_mm *= 2;
    for (const std::size_t v : voxels_of(grid, around)) {
      for (std::size_t p = 0; p < marks.size(); ++p) {
        if (seed.phase >= 0 && static_cast<std::size_t>(seed.phase) != p) continue;
        if (ground.seeds[p][v] != seed.label) ground.seeds[p][v] = kUnlabelled;
        ground.prices.phases[p][v * VoxelPrices::kLabels + seed.label] = VoxelPrices::kUnits;
      }
    }
  }
  for (std::size_t p = 0; p < marks.size(); ++p) {
    for (std::size_t v = 0; v < marks[p].size(); ++v) {
      if (marks[p][v] != kUnlabelled) ground.seeds[p][v] = marks[p][v];
    }
  }
}

void hold_known(const KnownLabels& known, Ground& ground) {
  for (std::size_t n = 0; n < known.phases.size(); ++n) {
    const std::vector<std::uint8_t>& image = known.labels.phases[n];
    const auto p = static_cast<std::size_t>(known.phases[n]);
    const std::array<bool, kLastLabel + 1> has = labels_in(image);
    std::vector<std::uint8_t>& seeds = ground.seeds[p];
    std::uint8_t* prices = ground.prices.phases[p].data();
    for (std::size_t v = 0; v < image.size(); ++v, prices += VoxelPrices::kLabels) {
      if (image[v] == kLabelUnknown) continue;
      if (image[v] != kLabelBackground) {
        seeds[v] = image[v];
        prices[image[v]] = VoxelPrices::kUnits;
        continue;
      }
      if (seeds[v] <= kLastLabel && has[seeds[v]]) seeds[v] = kUnlabelled;
      for (std::size_t label = 0; label < has.size(); ++label) {
        if (has[label]) prices[label] = kDearest;
      }
    }
  }
}

void expect_known(const KnownLabels& known, int phase, Structure structure,
                  std::vector<float>& probability) {
  const auto at = std::find(known.phases.begin(), known.phases.end(), phase);
  if (at == known.phases.end()) return;
  const std::vector<std::uint8_t>& image =
      known.labels.phases[static_cast<std::size_t>(at - known.phases.begin())];
  const std::array<bool, kLastLabel + 1> has = labels_in(image);
  bool drawn = true;  // every label of the structure, so that where none is it is not
  for (std::uint8_t label = kLabelBackground + 1; label <= kLastLabel; ++label) {
    if (label_in_structure(label, structure) && !has[label]) drawn = false;
  }
  for (std::size_t v = 0; v < image.size(); ++v) {
    if (image[v] == kLabelUnknown || (image[v] == kLabelBackground && !drawn)) continue;
    probability[v] = label_in_structure(image[v], structure) ? 1.0F : 0.0F;
  }
}

void put_known(const KnownLabels& known, ImageCycle<std::uint8_t>& labels) {
  for (std::size_t n = 0; n < known.phases.size(); ++n) {
    const std::vector<std::uint8_t>& image = known.labels.phases[n];
    const std::array<bool, kLastLabel + 1> has = labels_in(image);
    std::vector<std::uint8_t>& phase = labels.phases[static_cast<std::size_t>(known.phases[n])];
    for (std::size_t v = 0; v < image.size(); ++v) {
      if (image[v] == kLabelUnknown) continue;
      if (image[v] != kLabelBackground) {
        phase[v] = image[v];
      } else if (has[phase[v]]) {
        const bool wall = phase[v] == kLabelLvBlood && !has[kLabelLvMyocardium];
        phase[v] = wall ? kLabelLvMyocardium : kLabelBackground;
      }
    }
  }
}

}  // namespace beatlas::segment
