#include "pipeline/segment/segment.h"

#include <algorithm>
#include <numeric>
#include <sstream>

#include "pipeline/core/parallel.h"
#include "pipeline/segment/anatomy.h"
#include "pipeline/segment/chambers.h"
#include "pipeline/segment/competition.h"
#include "pipeline/segment/coverage.h"
#include "pipeline/segment/denoise.h"
#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/segment/known_seeds.h"
#include "pipeline/segment/long_axis.h"
#include "pipeline/segment/papillary.h"
#include "pipeline/segment/seeds.h"
#include "pipeline/segment/shading.h"
#include "pipeline/segment/taper.h"
#include "pipeline/segment/threshold_growing.h"
#include "pipeline/segment/tissue.h"
#include "pipeline/segment/valves.h"
#include "pipeline/segment/ventricle_ends.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

/// Changes below this share of the edge between muscle and blood are texture.
constexpr double kTexture = 0.2;

/// Levels from drawn seeds, for images in which no chamber was recognised.
TissueLevels levels_from_seeds(const ImageCycle<float>& images, const LabelImages& seeds,
                               TissueLevels levels) {
  std::array<std::vector<float>, TravelCost::kLabels> values;
  for (std::size_t p = 0; p < seeds.size(); ++p) {
    for (std::size_t v = 0; v < seeds[p].size(); ++v) {
      if (seeds[p][v] != kUnlabelled) values[seeds[p][v]].push_back(images.phases[p][v]);
    }
  }
  const auto middle = [](std::vector<float>& list) {
    const auto at = list.begin() + static_cast<std::ptrdiff_t>(list.size() / 2);
    std::nth_element(list.begin(), at, list.end());
    return static_cast<double>(*at);
  };
  if (!values[kLabelLvBlood].empty()) levels.blood = middle(values[kLabelLvBlood]);
  if (!values[kLabelLvMyocardium].empty()) {
    levels.muscle = middle(values[kLabelLvMyocardium]);
    if (!(levels.blood > levels.muscle)) {
      throw_invalid(
          "seeds of muscle lie on tissue that is no darker than blood; move them, or those of "
          "blood");
    }
    levels.threshold = 0.5 * (levels.blood + levels.muscle);
    levels.dark = 0.5 * levels.muscle;
  }
  return levels;
}

/// Seeds found in slices across the LV's long axis, where ventricles look their best, on the grid
/// of the images; `chambers` become those of these slices. Empty if they show no ventricle.
LabelImages upright_seeds(const ImageCycle<float>& images, const std::vector<Seed>& drawn,
                          Chambers& chambers, StageContext& context) {
  const ImageCycle<float> upright = across_axis(images, *chambers.axis);
  const TemporalStats stats = temporal_stats(upright);
  Chambers found = find_chambers(upright, stats, context);
  if (!found.found_lv()) return {};
  found.axis = chambers.axis;
  found.height_mm = found.axis->heights_mm(upright.grid);
  adopt_seeds(upright, drawn, found);
  const LabelImages there = automatic_seeds(upright, stats, found);
  chambers = std::move(found);
  chambers.height_mm = chambers.axis->heights_mm(images.grid);

  LabelImages seeds(images.phases.size(), std::vector<std::uint8_t>(images.grid.count()));
  const Affine to_upright =
      upright.grid.mm_from_index.inverse(Eigen::Affine) * images.grid.mm_from_index;
  const Grid& grid = images.grid;
  parallel_for(static_cast<std::size_t>(grid.size[2]), [&](std::size_t slice) {
    const auto k = static_cast<int>(slice);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 at = to_upright * Vec3(i, j, k);
        const Index3 near{static_cast<int>(std::lround(at[0])),
                          static_cast<int>(std::lround(at[1])),
                          static_cast<int>(std::lround(at[2]))};
        const bool inside = upright.grid.contains(near[0], near[1], near[2]);
        for (std::size_t p = 0; p < seeds.size(); ++p) {
          // What lies farther out than those slices reach is no heart.
          std::uint8_t& seed = seeds[p][grid.offset(i, j, k)];
          seed = kLabelBackground;
          if (inside) seed = there[p][upright.grid.offset(near[0], near[1], near[2])];
        }
      }
    }
  });
  return seeds;
}

/// In bSSFP fat is brighter than blood by two fifths of what parts blood from muscle and more;
/// inflow and noise make blood brighter, too.
double fat_level(const TissueLevels& levels, double noise) {
  const double contrast = levels.blood - levels.muscle;
  return levels.rv_blood + std::min(0.2 * contrast + 3 * noise, 0.45 * contrast);
}

ImageCycle<float> evenly_lit(ImageCycle<float> images, const SegmentOptions& options) {
  if (!options.even_shading) return images;
  const TemporalStats stats = temporal_stats(images);
  return without_shading(images, find_shading(images.grid, stats));
}

}  // namespace

Segmentation segment_exam(const Exam& exam, const std::vector<Seed>& given,
                          const SegmentOptions& options, StageContext& context,
                          const KnownLabels& known_labels) {
  const ImageCycle<float>& stack = exam.stack.images;
  if (stack.phase_count() < 2) {
    throw_invalid("only one phase: a beating heart needs at least two");
  }
  check_seeds(given, stack.grid, stack.phase_count());
  const TemporalStats whole = temporal_stats(stack);
  std::vector<Seed> drawn = given;
  const Box box = box_with_seeds(
      stack.grid, box_with_labels(stack.grid, find_moving_box(stack.grid, whole), known_labels),
      drawn);
  const ImageCycle<float> images = evenly_lit(crop(stack, box), options);
  const KnownLabels known = crop(known_labels, box);
  context.check_cancelled();
  const TemporalStats stats = temporal_stats(images);
  Chambers chambers = find_chambers(images, stats, context);
  context.check_cancelled();

  adopt_seeds(images, drawn, chambers);
  if (known.phases.empty()) {
    // What is known elsewhere tells where ventricles end.
    chambers.axis = find_long_axis(images, chambers, options.tricuspid_excursion_mm);
  }
  if (chambers.axis) chambers.height_mm = chambers.axis->heights_mm(images.grid);
  LabelImages seeds;
  if (chambers.axis) seeds = upright_seeds(images, drawn, chambers, context);
  if (seeds.empty()) seeds = automatic_seeds(images, stats, chambers);
  seed_known(images, known, chambers.levels, seeds);
  draw_seeds(images.grid, drawn, seeds);
  if (!chambers.found_lv() && !(drawn.empty() && known.phases.empty())) {
    chambers.levels = levels_from_seeds(images, seeds, chambers.levels);
  }
  const bool any_heart = std::any_of(seeds.begin(), seeds.end(), [](const auto& phase) {
    return std::any_of(phase.begin(), phase.end(),
                       [](std::uint8_t s) { return s != kUnlabelled && s != kLabelBackground; });
  });
  if (!any_heart) {
    throw_invalid(
        "no heart found: no blood pool that beats, neither inside a ring of muscle nor alone; "
        "give seeds with --seeds");
  }

  if (options.method == Method::Threshold) {
    if (!known.phases.empty()) {
      throw_invalid("the method threshold makes nothing of labels of some phases; use competition");
    }
    return segment_by_threshold(exam, given, seeds, box, chambers.levels, options);
  }

  const std::vector<std::vector<std::uint8_t>> classes =
      classify(stats, chambers, images.phases.size());
  const double phase_step_mm = std::clamp(45.0 / images.phase_count(), 1.5, 30.0);
  const ImageCycle<float> calm = denoised(images, options.denoise ? stats.noise : 0, phase_step_mm);
  const double noise = options.denoise ? noise_level(calm) : stats.noise;
  if (chambers.found_lv()) chambers.levels.fat = fat_level(chambers.levels, noise);
  const TravelCost cost = travel_cost(chambers.levels, noise);
  const double contrast = chambers.levels.blood - chambers.levels.muscle;
  ImageCycle<std::uint8_t> labels = grow_in_competition(
      {calm, classes, seeds, cost, phase_step_mm, std::max(3 * noise, kTexture * contrast),
       options.edge_cost_mm / contrast},
      context);
  LabelImages marks;
  if (!drawn.empty()) {
    marks.assign(images.phases.size(), std::vector<std::uint8_t>(images.grid.count(), kUnlabelled));
    draw_seeds(images.grid, drawn, marks);
  }
  const std::vector<std::uint8_t> rest = near_known_rest(known);
  parallel_for(images.phases.size(), [&](std::size_t p) {
    const std::vector<std::uint8_t> grown = labels.phases[p];
    tidy_phase(images.grid, calm.phases[p], chambers, static_cast<int>(p),
               marks.empty() ? std::vector<std::uint8_t>() : marks[p], labels.phases[p]);
    keep_known_rest(rest, grown, labels.phases[p]);
  });
  bound_apex(chambers, labels);
  smooth_outlines(labels, options.outline_sigma_mm, known);
  cut_at_base(chambers, labels);
  const VentricleEnds ends =
      find_ventricle_ends(images, exam.views, labels, chambers, options.tricuspid_excursion_mm);
  redraw_mixed_slices(chambers, ends, labels);
  clear_mixed_atria(chambers, ends, labels);
  wall_atria(images, chambers, ends, labels);
  if (options.papillary == Papillary::Muscle) {
    papillary_muscles_to_wall(images, chambers.levels, labels);
  }
  if (!drawn.empty()) {
    // What was drawn stays as it was drawn, whatever the tidying thinks of it.
    for (std::size_t p = 0; p < marks.size(); ++p) {
      for (std::size_t v = 0; v < marks[p].size(); ++v) {
        if (marks[p][v] != kUnlabelled) labels.phases[p][v] = marks[p][v];
      }
    }
  }
  drop_unknown_labels(known, labels);
  keep_connected_heart(labels);

  Segmentation out;
  // Coverage keeps the whole pool: its outline in plane says where the shape is cut.
  Covered covered = ends.lv || ends.rv ? cover(images, continued_to_base(chambers, ends, labels),
                                               box, chambers.levels, stats.noise)
                                       : cover(images, labels, box, chambers.levels, stats.noise);
  out.coverage = std::move(covered.coverage);
  out.uncertainty = std::move(covered.uncertainty);
  if (!ends.trouble.empty()) out.warnings.push_back(ends.trouble);
  out.base_cuts =
      part_ventricles_from_atria(labels, chambers, ends, options.tricuspid_excursion_mm);
  for (auto& [structure, cut] : out.base_cuts) {
    for (double& k : cut.k) k += box.first[2];
  }
  if (out.coverage.phases.count(Structure::Heart) == 0) {
    throw_invalid("no heart found: what grew from the seeds is empty");
  }
  if (out.coverage.phases.count(Structure::LvBlood) == 0) {
    out.warnings.emplace_back("no left ventricle was recognised; the atlas holds the heart alone");
  } else if (out.coverage.phases.count(Structure::RvBlood) == 0) {
    out.warnings.emplace_back("no right ventricle was recognised");
  }
  find_ends(out);

  out.labels.grid = stack.grid;
  out.labels.phases.assign(stack.phases.size(), std::vector<std::uint8_t>(stack.grid.count(), 0));
  for (std::size_t p = 0; p < stack.phases.size(); ++p) {
    for (int k = 0; k < box.size[2]; ++k) {
      for (int j = 0; j < box.size[1]; ++j) {
        const auto from =
            labels.phases[p].begin() + static_cast<std::ptrdiff_t>(images.grid.offset(0, j, k));
        std::copy(
            from, from + box.size[0],
            out.labels.phases[p].begin() + static_cast<std::ptrdiff_t>(stack.grid.offset(
                                               box.first[0], box.first[1] + j, box.first[2] + k)));
      }
    }
  }
  out.axis = ventricle_axis(out, chambers.axis);
  return out;
}

}  // namespace beatlas::segment
