#include "pipeline/segment/from_prior.h"

#include <algorithm>
#include <optional>

#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/register/phase_motion.h"
#include "pipeline/segment/anatomy.h"
#include "pipeline/segment/bad_frames.h"
#include "pipeline/segment/chambers.h"
#include "pipeline/segment/connected.h"
#include "pipeline/segment/coverage.h"
#include "pipeline/segment/denoise.h"
#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/segment/fat_layer.h"
#include "pipeline/segment/followed_seeds.h"
#include "pipeline/segment/known_ground.h"
#include "pipeline/segment/known_seeds.h"
#include "pipeline/segment/lv_section.h"
#include "pipeline/segment/outer_surface.h"
#include "pipeline/segment/papillary.h"
#include "pipeline/segment/prior_ground.h"
#include "pipeline/segment/seed_ground.h"
#include "pipeline/segment/shading.h"
#include "pipeline/segment/tissue.h"
#include "pipeline/segment/valves.h"
#include "pipeline/segment/ventricle_ends.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

/// An atrium or vessel that comes and goes through the beat is in view in part, or is none: it is
/// rest of heart then. No atrium gives away three quarters of its volume (Kawel-Boehm 2020,
/// doi:10.1186/s12968-020-00683-3: 40 to 70 % of the left one).
/// @return a sentence each
std::vector<std::string> drop_what_comes_and_goes(ImageCycle<std::uint8_t>& labels) {
  std::vector<std::string> told;
  for (const Structure structure : kBeyondBase) {
    const std::uint8_t label = label_of(structure);
    std::size_t least = labels.grid.count();
    std::size_t most = 0;
    for (const std::vector<std::uint8_t>& phase : labels.phases) {
      const auto voxels = static_cast<std::size_t>(std::count(phase.begin(), phase.end(), label));
      least = std::min(least, voxels);
      most = std::max(most, voxels);
    }
    if (most == 0 || 4 * least >= most) continue;
    for (std::vector<std::uint8_t>& phase : labels.phases) {
      std::replace(phase.begin(), phase.end(), label, std::uint8_t{kLabelRestOfHeart});
    }
    told.push_back(std::string(structure_name(structure)) +
                   " is in view in a part of the beat alone; it counts as rest of the heart");
  }
  return told;
}

/// What was marked wins over what the prior is sure of: within a ball of twice the radius nothing
/// else is seeded, and the label marked costs least. Elsewhere the ground stays as it was.
void give_way(const Grid& grid, const std::vector<Seed>& drawn, const LabelImages& marks,
              PriorGround& ground) {
  for (const Seed& seed : drawn) {
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

[[noreturn]] void throw_no_heart() {
  throw_invalid(
      "no heart found: nothing in the images looks like a left ventricle; give seeds with "
      "--seeds, or another stack of the exam with --stack");
}

/// @param prior null: seeds alone tell
Segmentation grown(const Exam& exam, const std::vector<Seed>& given, const SegmentOptions& options,
                   const KnownLabels& known_labels, const prior::PriorCycle* prior,
                   StageContext& context) {
  const std::vector<BadFrame> bad = bad_frames(exam.stack.images);
  ImageCycle<float> mended;
  if (!bad.empty()) mended = without_bad_frames(exam.stack.images, bad);
  const ImageCycle<float>& stack = bad.empty() ? exam.stack.images : mended;
  if (stack.phase_count() < 2) {
    throw_invalid("only one phase: a beating heart needs at least two");
  }
  check_seeds(given, stack.grid, stack.phase_count());
  context.progress(0, "where the heart is");
  std::vector<Seed> drawn = given;
  std::optional<LabelCycle> likeliest;
  if (prior != nullptr) likeliest = likeliest_labels(*prior);
  if (likeliest && !holds_heart(*likeliest)) throw_no_heart();
  const Box found =
      likeliest ? box_of_heart(stack.grid, *likeliest) : box_of_marks(stack.grid, given);
  const Box box =
      box_with_seeds(stack.grid, box_with_labels(stack.grid, found, known_labels), drawn);
  const KnownLabels known = crop(known_labels, box);
  ImageCycle<float> images = crop(stack, box);
  if (options.even_shading) {
    images = without_shading(images, find_shading(images.grid, temporal_stats(images)));
  }
  const double noise = noise_level(images);
  context.check_cancelled();
  context.progress(0.1, "seeds");
  LabelImages marks(images.phases.size(),
                    std::vector<std::uint8_t>(images.grid.count(), kUnlabelled));
  draw_seeds(images.grid, drawn, marks);
  PriorGround ground = likeliest ? lay_prior_ground(images, *prior, *likeliest)
                                 : lay_seed_ground(images, marks, noise);
  hold_known(known, ground);
  if (likeliest) give_way(images.grid, drawn, marks, ground);
  const TissueLevels& levels = ground.levels;
  const double contrast = std::max(levels.blood - levels.muscle, 1e-6);

  context.progress(0.25, "noise");
  const double phase_step_mm = std::clamp(45.0 / images.phase_count(), 1.5, 30.0);
  const ImageCycle<float> calm = denoised(images, options.denoise ? noise : 0, phase_step_mm);
  std::optional<reg::PhaseMotion> motion;
  if (options.follow_motion && images.phase_count() > 1) {
    context.progress(0.35, "motion");
    motion = reg::phase_motion(calm, 1.5 * levels.blood);
  }
  StageContext growing = context.part(0.4, 0.6, "growing");
  const LabelImages no_classes;
  const TravelCost no_table(1);
  const auto grow = [&] {
    ImageCycle<std::uint8_t> out =
        grow_in_competition({.images = calm,
                             .classes = no_classes,
                             .seeds = ground.seeds,
                             .cost = no_table,
                             .phase_step_mm = phase_step_mm,
                             .motion = motion ? &*motion : nullptr,
                             .edge_free = std::max(3 * noise_level(calm), 0.2 * contrast),
                             .edge_cost = options.edge_cost_mm / contrast,
                             .prices = &ground.prices},
                            growing);
    if (likeliest) return out;
    for (const std::uint8_t cavity : {kLabelLvBlood, kLabelRvBlood}) {
      keep_largest_of_each_slice({cavity}, kLabelBackground, out);
    }
    return out;
  };
  ImageCycle<std::uint8_t> labels = grow();
  if (!likeliest) {
    ground = lay_seed_ground(images, marks, noise, &labels);
    labels = grow();
  }
  motion.reset();
  ground.prices = {};
  context.progress(0.65, "outlines");
  fill_cavity(likeliest ? ground.seeds : marks, labels);
  ground.seeds = {};
  smooth_outlines(labels, options.outline_sigma_mm);
  trim_wall(labels);
  if (options.papillary == Papillary::Muscle) papillary_muscles_to_wall(images, levels, labels);
  keep_largest_of_each_slice({kLabelLvBlood, kLabelLvMyocardium}, kLabelBackground, labels);
  const auto hold_marks = [&] {
    put_known(known, labels);
    for (std::size_t p = 0; p < marks.size(); ++p) {
      for (std::size_t v = 0; v < marks[p].size(); ++v) {
        if (marks[p][v] != kUnlabelled) labels.phases[p][v] = marks[p][v];
      }
    }
  };
  hold_marks();
  keep_connected_heart(labels);
  const std::uint8_t apart = likeliest ? kLabelRestOfHeart : kLabelBackground;
  for (const std::uint8_t ventricle : {kLabelLvBlood, kLabelRvBlood}) {
    keep_within_fullest(ventricle, kLabelLvMyocardium, apart, labels);
  }
  keep_cavity_of_each_phase(kLabelLvBlood, kLabelLvMyocardium, apart, labels);
  for (const std::uint8_t cavity : {kLabelRvBlood, kLabelLaBlood, kLabelRaBlood, kLabelAorta}) {
    keep_largest_of_each_phase(cavity, apart, labels);
  }
  // What the prior took for one may come apart as the images are asked.
  if (given.empty() && known.phases.empty() && !holds_heart(labels)) throw_no_heart();
  const int base_step = base_step_from(labels);  // Atria tell, so before they are merged.
  std::vector<std::string> part_view;
  // One or two thick slices of an atrium are no body that could be drawn.
  const bool atria = options.atria && stack.grid.spacing_mm()[2] < kThickSlicesMm;
  if (atria) {
    part_view = drop_what_comes_and_goes(labels);
  } else {
    for (std::vector<std::uint8_t>& phase : labels.phases) {
      std::transform(phase.begin(), phase.end(), phase.begin(), ventricles_apart);
    }
  }

  context.progress(0.85, "boundaries within voxels");
  Segmentation out;
  out.warnings = told(bad, stack.grid.size[2]);
  out.warnings.insert(out.warnings.end(), part_view.begin(), part_view.end());
  const double still_noise = std::min(noise, noise_level(stack));
  const std::vector<Structure> structures =
      atria ? std::vector<Structure>(kAllStructures.begin(), kAllStructures.end())
            : std::vector<Structure>(kVentricular.begin(), kVentricular.end());
  Covered covered = cover(images, labels, box, levels, still_noise, {}, structures);
  if (stack.grid.spacing_mm()[2] < kThickSlicesMm) {
    // Through thin slices an edge is looked for from where the labels end: what they missed by more
    // than that is found from where the first look had moved it.
    follow_coverage(covered.coverage, labels);
    hold_marks();
    covered = cover(images, labels, box, levels, still_noise, {}, structures);
    follow_coverage(covered.coverage, labels);
    hold_marks();
  }
  out.coverage = std::move(covered.coverage);
  out.uncertainty = std::move(covered.uncertainty);
  if (out.coverage.phases.count(Structure::Heart) == 0) {
    throw_invalid("no heart found: what grew from the seeds is empty");
  }
  const std::vector<std::string> ignored = seeds_not_followed(labels, given, marks);
  out.warnings.insert(out.warnings.end(), ignored.begin(), ignored.end());
  if (stack.grid.spacing_mm()[2] >= kThickSlicesMm) {
    out.base_cuts = flat_base_cuts(labels, base_step);
    for (auto& [structure, cut] : out.base_cuts) {
      for (double& k : cut.k) k += box.first[2];
    }
  }
  find_ends(out);
  out.labels.grid = stack.grid;
  put_back(labels, box, out.labels);
  out.axis = ventricle_axis(out, {});
  return out;
}

}  // namespace

bool prior_tells(const prior::PriorCycle* prior, const SegmentOptions& options) {
  return prior != nullptr && options.method == Method::Competition &&
         holds_heart(likeliest_labels(*prior));
}

Segmentation segment_from_prior(const Exam& exam, const std::vector<Seed>& given,
                                const SegmentOptions& options, const KnownLabels& known,
                                const prior::PriorCycle& prior, StageContext& context) {
  return grown(exam, given, options, known, &prior, context);
}

Segmentation segment_from_seeds(const Exam& exam, const std::vector<Seed>& given,
                                const SegmentOptions& options, StageContext& context) {
  return grown(exam, given, options, {}, nullptr, context);
}

}  // namespace beatlas::segment
