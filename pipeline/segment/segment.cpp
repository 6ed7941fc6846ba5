#include "pipeline/segment/segment.h"

#include <algorithm>
#include <numeric>
#include <sstream>
#include <utility>

#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/segment/anatomy.h"
#include "pipeline/segment/atria.h"
#include "pipeline/segment/bad_frames.h"
#include "pipeline/segment/chambers.h"
#include "pipeline/segment/competition.h"
#include "pipeline/segment/connected.h"
#include "pipeline/segment/coverage.h"
#include "pipeline/segment/denoise.h"
#include "pipeline/segment/drawn_ends.h"
#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/segment/fat_layer.h"
#include "pipeline/segment/followed_seeds.h"
#include "pipeline/segment/from_prior.h"
#include "pipeline/segment/groundwork.h"
#include "pipeline/segment/known_labels.h"
#include "pipeline/segment/known_seeds.h"
#include "pipeline/segment/long_axis.h"
#include "pipeline/segment/looks.h"
#include "pipeline/segment/open_base.h"
#include "pipeline/segment/outer_layer.h"
#include "pipeline/segment/outer_surface.h"
#include "pipeline/segment/papillary.h"
#include "pipeline/segment/prior_ground.h"
#include "pipeline/segment/seed_ground.h"
#include "pipeline/segment/seeds.h"
#include "pipeline/segment/shading.h"
#include "pipeline/segment/slice_gain.h"
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
/// What is brighter, over blood, tells nothing of motion.
constexpr double kBrightest = 1.5;

/// Levels from drawn seeds, for images in which no chamber was recognised.
TissueLevels levels_from_seeds(const ImageCycle<float>& images, const LabelImages& seeds,
                               TissueLevels levels) {
  std::array<std::vector<float>, TravelCost::kLabels> values;
  for (std::size_t p = 0; p < seeds.size(); ++p) {
    for (std::size_t v = 0; v < seeds[p].size(); ++v) {
      if (seeds[p][v] != kUnlabelled) values[seeds[p][v]].push_back(images.phases[p][v]);
    }
  }
  if (!values[kLabelLvBlood].empty()) levels.blood = median_of(values[kLabelLvBlood]);
  if (!values[kLabelLvMyocardium].empty()) {
    levels.muscle = median_of(values[kLabelLvMyocardium]);
    part_marked(levels);
  }
  return levels;
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
  ImageCycle<float> even = without_shading(images, find_shading(images.grid, stats));
  const std::vector<double> gains = slice_gains(even);
  return without_slice_gains(std::move(even), gains);
}

/// Where a stroke was drawn, or the pool is drawn on beyond the base, the heart has another edge.
void keep_where_alike(const LabelImages& labels, const ImageCycle<std::uint8_t>& whole,
                      std::vector<std::vector<FatEdge>>& edges) {
  for (std::size_t p = 0; p < edges.size(); ++p) {
    std::erase_if(edges[p], [&](const FatEdge& edge) {
      return (labels[p][edge.voxel] != 0) != (whole.phases[p][edge.voxel] != 0);
    });
  }
}

}  // namespace

Segmentation segment_exam(const Exam& exam, const std::vector<Seed>& given,
                          const SegmentOptions& options, StageContext& context,
                          const KnownLabels& known_labels, SolveMemory* memory,
                          const prior::PriorCycle* prior) {
  // Seeds of a person count where the prior overlooked the heart: they grow without it then.
  const bool marked = !given.empty() || !known_labels.phases.empty();
  if (prior != nullptr && options.method == Method::Competition &&
      (!marked || prior_tells(prior, options))) {
    if (memory != nullptr) *memory = {};
    return segment_from_prior(exam, given, options, known_labels, *prior, context);
  }
  if (known_labels.phases.empty() && options.method == Method::Competition && tell_heart(given)) {
    if (memory != nullptr) *memory = {};
    return segment_from_seeds(exam, given, options, context);
  }
  const std::vector<BadFrame> bad = bad_frames(exam.stack.images);
  ImageCycle<float> mended;
  if (!bad.empty()) mended = without_bad_frames(exam.stack.images, bad);
  const ImageCycle<float>& stack = bad.empty() ? exam.stack.images : mended;
  if (stack.phase_count() < 2) {
    throw_invalid("only one phase: a beating heart needs at least two");
  }
  check_seeds(given, stack.grid, stack.phase_count());
  std::optional<KeptSolve> before =
      memory != nullptr && known_labels.phases.empty()
          ? recall(std::exchange(*memory, {}), stack.grid, stack.phase_count(), given)
          : std::nullopt;
  context.progress(0, "where the heart beats");
  std::vector<Seed> drawn = given;
  const Box moving =
      before ? before->ground.moving : find_moving_box(stack.grid, temporal_stats(stack));
  const Box box =
      box_with_seeds(stack.grid, box_with_labels(stack.grid, moving, known_labels), drawn);
  const ImageCycle<float> images = evenly_lit(crop(stack, box), options);
  const KnownLabels known = crop(known_labels, box);
  context.check_cancelled();
  context.progress(0.1, "chambers");
  // What is known in two phases and more tells where ventricles end.
  Groundwork ground =
      before ? std::move(before->ground)
             : lay_groundwork(images, moving, box, drawn, known.phases.size() < 2,
                              base_step_of(known.labels), options.tricuspid_excursion_mm, context);
  Chambers chambers = ground.chambers;
  const double image_noise = ground.noise;
  // About the heart most voxels change as it beats, which looks like noise; of a whole image few
  // do.
  const double still_noise = std::min(image_noise, noise_level(stack));
  LabelImages seeds = ground.automatic;
  seed_known(images, known, chambers.found_lv(), chambers.levels, seeds);
  draw_seeds(images.grid, drawn, seeds);
  if (!chambers.found_lv() && !(drawn.empty() && known.phases.empty())) {
    chambers.levels = levels_from_seeds(images, seeds, chambers.levels);
  }
  const std::vector<std::string> doubts = doubtful_seeds(images, given, chambers.levels);
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
    Segmentation out = segment_by_threshold(exam, given, seeds, box, chambers.levels, options);
    out.warnings.insert(out.warnings.end(), doubts.begin(), doubts.end());
    return out;
  }

  std::vector<std::vector<std::uint8_t>> classes =
      classify(ground.motion, chambers, images.phases.size());
  context.progress(0.3, "noise");
  const double phase_step_mm = std::clamp(45.0 / images.phase_count(), 1.5, 30.0);
  ImageCycle<float> calm = denoised(images, options.denoise ? image_noise : 0, phase_step_mm);
  const double noise = options.denoise ? noise_level(calm) : image_noise;
  if (chambers.found_lv()) chambers.levels.fat = fat_level(chambers.levels, noise);
  const TravelCost cost = travel_cost(chambers.levels, noise);
  const double contrast = chambers.levels.blood - chambers.levels.muscle;
  std::optional<reg::PhaseMotion> motion;
  if (options.follow_motion) {
    context.progress(0.35, "motion");
    motion = reg::phase_motion(calm, kBrightest * chambers.levels.blood);
  }
  StageContext growing = context.part(0.4, 0.6, "growing");
  ImageCycle<std::uint8_t> labels = grow_in_competition(
      {calm, classes, seeds, cost, phase_step_mm, motion ? &*motion : nullptr,
       std::max(3 * noise, kTexture * contrast), options.edge_cost_mm / contrast},
      growing);
  // Of a long cycle each of these is large; nothing after growing looks at them.
  motion.reset();
  classes = {};
  seeds = {};
  LabelImages marks(images.phases.size(),
                    std::vector<std::uint8_t>(images.grid.count(), kUnlabelled));
  draw_seeds(images.grid, drawn, marks);
  const std::vector<std::uint8_t> rest = near_known_rest(known);
  LabelImages grown = labels.phases;
  parallel_for(images.phases.size(), context.part(0.6, 0.65), "tidying phase", [&](std::size_t p) {
    if (before && before->grown[p] == grown[p] && before->drawn[p] == marks[p]) {
      labels.phases[p] = before->tidied[p];
      return;
    }
    tidy_phase(images.grid, calm.phases[p], chambers, static_cast<int>(p), marks[p],
               labels.phases[p]);
    keep_known_rest(rest, grown[p], labels.phases[p]);
  });
  LabelImages tidied = labels.phases;
  context.progress(0.65, "outlines");
  bound_apex(chambers, labels);
  LabelImages bounded = labels.phases;
  smooth_outlines(labels, options.outline_sigma_mm, known,
                  before ? SmoothedBefore{&before->bounded, &before->smoothed} : SmoothedBefore{});
  if (memory != nullptr) {
    *memory = {};
    if (known.phases.empty() && chambers.found_lv()) {
      *memory = kept(images.grid, {std::move(ground), std::move(grown), marks, std::move(tidied),
                                   std::move(bounded), labels.phases});
    }
  }
  before.reset();
  ground = {};
  grown = tidied = bounded = {};
  context.progress(0.75, "where ventricles end");
  strip_outer_layer(images, image_noise, chambers, labels);
  cut_at_base(chambers, labels);
  VentricleEnds ends =
      find_ventricle_ends(images, exam.views, labels, chambers, options.tricuspid_excursion_mm);
  if (chambers.found_lv()) {
    reach_drawn_slices(drawn_reach(images.grid, marks, chambers.base_step), chambers.base_step,
                       ends);
  }
  redraw_mixed_slices(images, chambers, ends, labels);
  clear_mixed_atria(chambers, ends, labels);
  wall_atria(images, chambers, ends, labels);
  if (options.papillary == Papillary::Muscle) {
    papillary_muscles_to_wall(images, chambers.levels, labels);
  }
  const VoxelCycle beyond_wall = keep_connected_rv(labels);
  std::vector<std::uint8_t> stay(images.phases.size(), 0);
  for (const int p : known.phases) stay[static_cast<std::size_t>(p)] = 1;
  std::vector<std::vector<FatEdge>> under_fat(images.phases.size());
  if (const auto tissues = levels_with_fat(images, image_noise, chambers.levels, labels)) {
    if (images.grid.spacing_mm()[2] < kThickSlicesMm) {
      under_fat = fit_outer_surface(images, *tissues, stay, labels);
    } else if (tissues->fat > tissues->blood) {
      under_fat = strip_fat_layer(images, *tissues, stay, labels);
    }
  }
  LabelImages stripped = labels.phases;
  // What was drawn stays as it was drawn, whatever the tidying thinks of it.
  for (std::size_t p = 0; p < marks.size(); ++p) {
    for (std::size_t v = 0; v < marks[p].size(); ++v) {
      if (marks[p][v] != kUnlabelled) labels.phases[p][v] = marks[p][v];
    }
  }
  drop_unknown_labels(known, labels);
  keep_connected_heart(labels);

  context.progress(0.85, "boundaries within voxels");
  Segmentation out;
  // Coverage keeps the whole pool: its outline in plane says where the shape is cut.
  ImageCycle<std::uint8_t> whole =
      ends.lv || ends.rv ? continued_to_base(images, chambers, ends, labels) : labels;
  keep_where_alike(stripped, whole, under_fat);
  stripped = {};
  Covered covered = cover(images, whole, box, chambers.levels, still_noise, under_fat);
  whole = {};
  out.coverage = std::move(covered.coverage);
  out.uncertainty = std::move(covered.uncertainty);
  out.warnings = told(bad, stack.grid.size[2]);
  out.warnings.insert(out.warnings.end(), doubts.begin(), doubts.end());
  if (!ends.trouble.empty()) out.warnings.push_back(ends.trouble);
  out.base_cuts =
      part_ventricles_from_atria(labels, chambers, ends, options.tricuspid_excursion_mm);
  const std::vector<std::string> ignored = seeds_not_followed(labels, given, marks);
  out.warnings.insert(out.warnings.end(), ignored.begin(), ignored.end());
  marks = {};
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
  put_back(labels, box, out.labels);
  out.axis = ventricle_axis(out, chambers.axis);
  if (options.atria && known.phases.empty() && out.axis) {
    context.progress(0.95, "atria");
    // Fat beyond the ventricle's wall is as bright as an atrium's blood.
    const VoxelCycle fat = relabel(beyond_wall, kLabelRestOfHeart, kLabelRvBlood, labels);
    const std::vector<Structure> found =
        part_atria(calm, chambers.levels, *out.axis, out.end_diastole, labels);
    (void)relabel(fat, kLabelRvBlood, kLabelRestOfHeart, labels);
    calm = {};
    Covered beyond = cover(images, labels, box, chambers.levels, still_noise, {}, found);
    out.coverage.phases.merge(beyond.coverage.phases);
    out.uncertainty.merge(beyond.uncertainty);
    put_back(labels, box, out.labels);
  }
  return out;
}

}  // namespace beatlas::segment
