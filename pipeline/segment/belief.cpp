#include "pipeline/segment/belief.h"

#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/core/structure_mask.h"
#include "pipeline/segment/known_ground.h"

namespace beatlas::segment {
namespace {

/// Half of what the base moves in a beat (phantom/family.json): what is missed is no farther.
constexpr double kAboutMm = 12.5;

/// Sets what lies up to `reach` beside what is set, along lines of a slice.
/// @param lines as many as there are, so far from each other in memory; @param step along a line
void widen(std::vector<std::uint8_t>& slice, int lines, std::size_t apart, std::size_t step,
           int reach) {
  const auto length = static_cast<int>(slice.size()) / lines;
  std::vector<std::uint8_t> line(static_cast<std::size_t>(length));
  for (int n = 0; n < lines; ++n) {
    std::uint8_t* first = slice.data() + static_cast<std::size_t>(n) * apart;
    for (int i = 0; i < length; ++i) {
      line[static_cast<std::size_t>(i)] = first[static_cast<std::size_t>(i) * step];
    }
    int last = -reach - 1;  // where something was set, from either side
    for (int i = 0; i < length; ++i) {
      if (line[static_cast<std::size_t>(i)] != 0) last = i;
      if (i - last <= reach) first[static_cast<std::size_t>(i) * step] = 1;
    }
    last = length + reach;
    for (int i = length - 1; i >= 0; --i) {
      if (line[static_cast<std::size_t>(i)] != 0) last = i;
      if (last - i <= reach) first[static_cast<std::size_t>(i) * step] = 1;
    }
  }
}

/// [voxel] probability of the structure.
std::vector<float> probability_of(Structure structure, const std::vector<std::uint8_t>& outputs,
                                  const std::vector<std::vector<float>>& by_output) {
  std::vector<float> out(by_output.front().size(), 0.0F);
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    if (!label_in_structure(outputs[o], structure)) continue;
    for (std::size_t v = 0; v < out.size(); ++v) out[v] += by_output[o][v];
  }
  return out;
}

/// To a tenth [mm2], as a study keeps it: nothing that is made of it depends on less.
SliceBelief rounded(const SliceBelief& slice) {
  const auto tenth = [](double area) { return std::round(area * 10) / 10; };
  return {tenth(slice.labelled_mm2), tenth(slice.expected_mm2), tenth(slice.agreed_mm2)};
}

/// A slice of which somebody told what it is.
SliceBelief told_belief(const std::vector<std::uint8_t>& labels, std::size_t first,
                        std::size_t count, Structure structure, double pixel_mm2) {
  const auto begin = labels.begin() + static_cast<std::ptrdiff_t>(first);
  const double area =
      pixel_mm2 * static_cast<double>(std::count_if(
                      begin, begin + static_cast<std::ptrdiff_t>(count),
                      [&](std::uint8_t label) { return label_in_structure(label, structure); }));
  return rounded({area, area, area});
}

double pixel_mm2_of(const Grid& grid) {
  const Vec3 spacing = grid.spacing_mm();
  return spacing[0] * spacing[1];
}

/// [slice][pixel] what lies within kAboutMm of the heart: of its labels in any phase, in the slice
/// and the next ones. What else looks like a ventricle is another body.
std::vector<std::vector<std::uint8_t>> about_heart(const ImageCycle<std::uint8_t>& labels) {
  const Grid& grid = labels.grid;
  const Vec3 spacing = grid.spacing_mm();
  const auto width = static_cast<std::size_t>(grid.size[0]);
  std::vector<std::vector<std::uint8_t>> out(static_cast<std::size_t>(grid.size[2]),
                                             std::vector<std::uint8_t>(grid.slice_count(), 0));
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int near = std::max(0, k - 1); near <= std::min(grid.size[2] - 1, k + 1); ++near) {
      for (const std::vector<std::uint8_t>& phase : labels.phases) {
        for (std::size_t v = 0; v < grid.slice_count(); ++v) {
          if (phase[grid.offset(0, 0, near) + v] != kLabelBackground) {
            out[static_cast<std::size_t>(k)][v] = 1;
          }
        }
      }
    }
  }
  parallel_for(out.size(), [&](std::size_t k) {
    widen(out[k], grid.size[1], width, 1, static_cast<int>(kAboutMm / spacing[0]));
    widen(out[k], grid.size[0], 1, width, static_cast<int>(kAboutMm / spacing[1]));
  });
  return out;
}

/// [slice of the part] whether a mark lies on what the prior thought to be less likely than not.
std::vector<bool> disputed_slices(const prior::PriorCycle& prior,
                                  const std::vector<std::vector<float>>& by_output,
                                  const std::vector<std::uint8_t>& marks, const Grid& grid) {
  std::vector<bool> out(static_cast<std::size_t>(grid.size[2]), false);
  for (std::size_t v = 0; v < marks.size(); ++v) {
    if (marks[v] == kUnlabelled) continue;
    float likely = 0;
    for (std::size_t o = 0; o < by_output.size(); ++o) {
      if (prior.labels[o] == marks[v]) likely += by_output[o][v];
    }
    if (likely < 0.5F) out[v / grid.slice_count()] = true;
  }
  return out;
}

}  // namespace

Belief belief_in(const prior::PriorCycle& prior, const ImageCycle<std::uint8_t>& labels,
                 const Box& box, const Told& told, const std::vector<Structure>& structures) {
  const Grid& grid = labels.grid;
  const auto phases = static_cast<std::size_t>(labels.phase_count());
  const auto slices = static_cast<std::size_t>(prior.grid.size[2]);
  const double pixel_mm2 = pixel_mm2_of(grid);
  Belief out;
  for (const Structure structure : structures) {
    out[structure].assign(phases, std::vector<SliceBelief>(slices));
  }
  const std::vector<std::vector<std::uint8_t>> about = about_heart(labels);
  parallel_for(phases, [&](std::size_t p) {
    const std::vector<std::vector<float>> by_output =
        prior::probabilities_on(prior, static_cast<int>(p), grid);
    const std::vector<bool> disputed = disputed_slices(prior, by_output, told.marks[p], grid);
    for (const Structure structure : structures) {
      std::vector<float> likely = probability_of(structure, prior.labels, by_output);
      expect_known(told.known, static_cast<int>(p), structure, likely);
      const std::vector<std::uint8_t> inside = where(labels.phases[p], structure);
      for (int k = 0; k < grid.size[2]; ++k) {
        SliceBelief& slice = out.at(
            structure)[p][static_cast<std::size_t>(box.first[2]) + static_cast<std::size_t>(k)];
        if (disputed[static_cast<std::size_t>(k)]) {
          slice = told_belief(labels.phases[p], grid.offset(0, 0, k), grid.slice_count(), structure,
                              pixel_mm2);
          continue;
        }
        double labelled = 0;
        double expected = 0;
        double agreed = 0;
        const std::vector<std::uint8_t>& near = about[static_cast<std::size_t>(k)];
        const std::size_t first = grid.offset(0, 0, k);
        for (std::size_t v = first; v < first + near.size(); ++v) {
          if (near[v - first] == 0) continue;
          const auto probability = static_cast<double>(likely[v]);
          expected += probability;
          if (inside[v] == 0) continue;
          labelled += 1;
          agreed += probability;
        }
        slice = rounded({labelled * pixel_mm2, expected * pixel_mm2, agreed * pixel_mm2});
      }
    }
  });
  return out;
}

void believe_painted(const LabelCycle& before, const LabelCycle& after, Belief& belief) {
  const Grid& grid = after.grid;
  const double pixel_mm2 = pixel_mm2_of(grid);
  const auto count = static_cast<std::ptrdiff_t>(grid.slice_count());
  for (std::size_t p = 0; p < after.phases.size(); ++p) {
    for (int k = 0; k < grid.size[2]; ++k) {
      const std::size_t first = grid.offset(0, 0, k);
      const auto was = before.phases[p].begin() + static_cast<std::ptrdiff_t>(first);
      const auto is = after.phases[p].begin() + static_cast<std::ptrdiff_t>(first);
      if (std::equal(was, was + count, is)) continue;
      for (auto& [structure, phases] : belief) {
        phases[p][static_cast<std::size_t>(k)] =
            told_belief(after.phases[p], first, grid.slice_count(), structure, pixel_mm2);
      }
    }
  }
}

}  // namespace beatlas::segment
