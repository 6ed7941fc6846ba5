#include "pipeline/segment/segment.h"

#include <algorithm>
#include <optional>

#include "pipeline/core/parallel.h"
#include "pipeline/core/segmented_volume.h"
#include "pipeline/core/slices.h"
#include "pipeline/edges/coverage.h"
#include "pipeline/edges/outer_surface.h"
#include "pipeline/edges/papillary.h"
#include "pipeline/edges/smooth_outlines.h"
#include "pipeline/motion/bad_frames.h"
#include "pipeline/motion/phase_motion.h"
#include "pipeline/prior/courses.h"
#include "pipeline/segment/belief.h"
#include "pipeline/segment/beyond_base.h"
#include "pipeline/segment/connected.h"
#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/segment/followed_seeds.h"
#include "pipeline/segment/known_ground.h"
#include "pipeline/segment/lv_section.h"
#include "pipeline/segment/prior_ground.h"
#include "pipeline/segment/seed_ground.h"
#include "pipeline/segment/thin_walls.h"
#include "pipeline/segment/threshold_growing.h"
#include "pipeline/segment/valve_planes.h"
#include "pipeline/segment/ventricle_ends.h"
#include "pipeline/tissue/denoise.h"
#include "pipeline/tissue/shading.h"
#include "pipeline/tissue/tissue.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

/// Changes below this share of the edge between muscle and blood are texture.
constexpr double kTexture = 0.2;
/// What is brighter, over blood, tells nothing of motion.
constexpr double kBrightest = 1.5;
/// [mm] What a step to the next phase counts as: a beat is as long as this, a phase at least and at
/// most so much of it.
constexpr double kBeatMm = 45;
constexpr double kLeastPhaseMm = 1.5;
constexpr double kMostPhaseMm = 30;

/// A part of an exam in which labels are to grow, and what is known of it.
struct Task {
  const ImageCycle<float>& stack;  ///< the whole, bad frames mended
  const SegmentOptions& options;
  const std::vector<Seed>& given;
  bool by_prior = false;  ///< else marks alone tell where the heart is
  double pixel_mm = 0;    ///< of what tells it: the prior's, or the images'
  Box box = {};
  std::vector<Seed> drawn = {};   ///< of those given, the ones that reach the box
  KnownLabels known = {};         ///< in the box
  ImageCycle<float> images = {};  ///< of the box, evenly lit
  float lifted = 0;               ///< added to every value of them
  double noise = 0;               ///< of them
  LabelImages marks = {};         ///< what was drawn, kUnlabelled elsewhere
  Ground ground = {};

  [[nodiscard]] bool thick() const { return are_thick_slices(stack.grid.spacing_mm()[2]); }
};

[[noreturn]] void throw_no_heart(bool asked_prior) {
  if (asked_prior) {
    throw_invalid(
        "no heart found: nothing in the images looks like a left ventricle; give seeds of its "
        "blood, its muscle and of background with --seeds, or another stack of the exam with "
        "--stack");
  }
  throw_invalid(
      "nothing tells where the heart is: no prior is asked; give seeds of the left ventricle's "
      "blood, its muscle and of background with --seeds, or leave '--prior none' out");
}

LabelImages marks_in(const Grid& grid, std::size_t phases, const std::vector<Seed>& drawn) {
  LabelImages marks(phases, std::vector<std::uint8_t>(grid.count(), kUnlabelled));
  draw_seeds(grid, drawn, marks);
  return marks;
}

/// Drawn marks, and where there are none what is known.
LabelImages with_known(LabelImages marks, const KnownLabels& known) {
  for (std::size_t n = 0; n < known.phases.size(); ++n) {
    std::vector<std::uint8_t>& phase = marks[static_cast<std::size_t>(known.phases[n])];
    const std::vector<std::uint8_t>& labels = known.labels.phases[n];
    for (std::size_t v = 0; v < phase.size(); ++v) {
      if (phase[v] == kUnlabelled && labels[v] != kLabelBackground) phase[v] = labels[v];
    }
  }
  return marks;
}

/// Some scanners store magnitudes with an offset: the least value is none. @return what was added
float lift(ImageCycle<float>& images) {
  float least = 0;
  for (const std::vector<float>& phase : images.phases) {
    least = std::min(least, *std::min_element(phase.begin(), phase.end()));
  }
  if (least >= 0) return 0;
  for (std::vector<float>& phase : images.phases) {
    for (float& value : phase) value -= least;
  }
  return -least;
}

/// Levels of images before they were lifted.
tissue::TissueLevels before_lift(tissue::TissueLevels levels, float added) {
  for (double* level :
       {&levels.blood, &levels.rv_blood, &levels.muscle, &levels.threshold, &levels.dark}) {
    *level -= static_cast<double>(added);
  }
  return levels;
}

/// Where the heart is, what its tissues look like, and what each label costs in each voxel.
Task lay_ground(const ImageCycle<float>& stack, const std::vector<Seed>& given,
                const SegmentOptions& options, const KnownLabels& known,
                const prior::PriorCycle* prior, StageContext& context) {
  context.progress(0, "where the heart is");
  std::optional<LabelCycle> likeliest;
  if (prior != nullptr) likeliest = likeliest_labels(*prior);
  // Where the prior overlooks the heart, what a person marked counts alone.
  const bool by_prior = likeliest && holds_heart(*likeliest);
  LabelImages told;
  if (!by_prior) {
    told = with_known(marks_in(stack.grid, stack.phases.size(), given), known);
    if (!tell_heart(told, known)) throw_no_heart(prior != nullptr);
  }
  const Grid& told_on = by_prior ? prior->grid : stack.grid;
  Task task{.stack = stack,
            .options = options,
            .given = given,
            .by_prior = by_prior,
            .pixel_mm = told_on.spacing_mm().head<2>().maxCoeff()};
  task.drawn = given;
  const Box found =
      by_prior ? box_of_heart(stack.grid, *likeliest) : box_of_marks(stack.grid, told);
  task.box = box_with_seeds(stack.grid, box_with_labels(stack.grid, found, known), task.drawn);
  task.known = crop(known, task.box);
  task.images = crop(stack, task.box);
  task.lifted = lift(task.images);
  if (options.even_shading) {
    task.images = tissue::without_shading(
        task.images, tissue::find_shading(task.images.grid, tissue::temporal_stats(task.images)));
  }
  task.noise = tissue::noise_level(task.images);
  context.check_cancelled();
  context.progress(0.1, "seeds");
  task.marks = marks_in(task.images.grid, task.images.phases.size(), task.drawn);
  if (by_prior) {
    task.ground = lay_prior_ground(task.images, *prior, *likeliest);
    hold_known(task.known, task.ground);
    hold_marks(task.images.grid, task.drawn, task.marks, task.ground);
  } else {
    task.ground = lay_seed_ground(task.images, with_known(task.marks, task.known), task.noise);
    hold_known(task.known, task.ground);
  }
  return task;
}

/// The competition on the task's ground. Marks alone tell more once something has grown from them:
/// then it grows again, from a ground that knows what grew.
ImageCycle<std::uint8_t> grow(Task& task, StageContext& context) {
  const tissue::TissueLevels& levels = task.ground.levels;
  const double contrast = std::max(levels.blood - levels.muscle, 1e-6);
  context.progress(0.25, "noise");
  const double phase_step_mm =
      std::clamp(kBeatMm / task.images.phase_count(), kLeastPhaseMm, kMostPhaseMm);
  const ImageCycle<float> calm =
      tissue::denoised(task.images, task.options.denoise ? task.noise : 0, phase_step_mm);
  std::optional<motion::PhaseMotion> motion;
  if (task.options.follow_motion) {
    context.progress(0.35, "motion");
    motion = motion::phase_motion(calm, kBrightest * levels.blood);
  }
  StageContext growing = context.part(0.4, 0.6, "growing");
  const double edge_free = std::max(3 * tissue::noise_level(calm), kTexture * contrast);
  const auto labels_on = [&](const Ground& ground) {
    return grow_in_competition({.images = calm,
                                .seeds = ground.seeds,
                                .prices = ground.prices,
                                .phase_step_mm = phase_step_mm,
                                .motion = motion ? &*motion : nullptr,
                                .edge_free = edge_free,
                                .edge_cost = task.options.edge_cost_mm / contrast},
                               growing);
  };
  ImageCycle<std::uint8_t> labels = labels_on(task.ground);
  if (task.by_prior) return labels;
  const auto one_cavity = [&] {
    for (const std::uint8_t cavity : {kLabelLvBlood, kLabelRvBlood}) {
      keep_largest_of_each_slice({cavity}, kLabelBackground, labels);
    }
  };
  one_cavity();
  task.ground =
      lay_seed_ground(task.images, with_known(task.marks, task.known), task.noise, &labels);
  hold_known(task.known, task.ground);
  labels = labels_on(task.ground);
  one_cavity();
  return labels;
}

/// What a person said stays, whatever is done to labels.
void hold(const Task& task, ImageCycle<std::uint8_t>& labels) {
  put_known(task.known, labels);
  for (std::size_t p = 0; p < task.marks.size(); ++p) {
    for (std::size_t v = 0; v < task.marks[p].size(); ++v) {
      if (task.marks[p][v] != kUnlabelled) labels.phases[p][v] = task.marks[p][v];
    }
  }
}

/// What a section of the LV looks like, smooth outlines, one heart and one of each cavity.
void make_one_heart(const Task& task, ImageCycle<std::uint8_t>& labels) {
  fill_cavity(task.by_prior ? task.ground.seeds : task.marks, labels);
  add_thin_walls(task.images, task.ground.levels, labels);
  edges::smooth_outlines(labels, task.options.outline_sigma_mm);
  reach_walls(task.images, task.ground.levels, task.pixel_mm, labels);
  trim_wall(labels);
  keep_largest_of_each_slice({kLabelLvBlood, kLabelLvMyocardium}, kLabelBackground, labels);
  hold(task, labels);
  keep_connected_heart(labels);
  const std::uint8_t apart = task.by_prior ? kLabelRestOfHeart : kLabelBackground;
  keep_stacked(kLabelLvBlood, kLabelLvMyocardium, apart, labels);
  keep_one_body({kLabelLvBlood, kLabelLvMyocardium}, apart, labels);
  for (const std::uint8_t cavity : {kLabelRvBlood, kLabelLaBlood, kLabelRaBlood, kLabelAorta}) {
    keep_largest({cavity}, apart, labels);
  }
  hold(task, labels);  // Also of what is apart from its structure a person's word stands.
  // What the prior took for one may come apart as the images are asked.
  if (task.given.empty() && task.known.phases.empty() && !holds_heart(labels)) throw_no_heart(true);
}

/// Atria and vessels become rest of the heart.
void merge_beyond_base(ImageCycle<std::uint8_t>& labels) {
  for (std::vector<std::uint8_t>& phase : labels.phases) {
    std::transform(phase.begin(), phase.end(), phase.begin(), ventricles_apart);
  }
}

/// Takes fat off the heart's labels, where it lies about it. @return [phase] what is known of its
/// edge there
std::vector<std::vector<edges::FatEdge>> take_fat_off(const Task& task,
                                                      ImageCycle<std::uint8_t>& labels) {
  std::vector<std::vector<edges::FatEdge>> none(labels.phases.size());
  const auto tissues = edges::levels_with_fat(task.images, task.noise, task.ground.levels, labels);
  if (!tissues || (task.thick() && tissues->fat <= tissues->blood)) return none;
  std::vector<std::uint8_t> stay(labels.phases.size(), 0);
  for (const int p : task.known.phases) stay[static_cast<std::size_t>(p)] = 1;
  auto found = task.thick() ? edges::strip_fat_layer(task.images, *tissues, stay, labels)
                            : edges::fit_outer_surface(task.images, *tissues, stay, labels);
  hold(task, labels);
  return found;
}

/// Coverage by the images' edges. Through thin slices an edge is looked for from where the labels
/// end: what they missed by more than that is found from where the first look had moved it.
edges::Covered cover_task(const Task& task, bool atria, ImageCycle<std::uint8_t>& labels) {
  const double still_noise = std::min(task.noise, tissue::noise_level(task.stack));
  const std::vector<Structure> structures =
      atria ? std::vector<Structure>(kAllStructures.begin(), kAllStructures.end())
            : std::vector<Structure>(kVentricular.begin(), kVentricular.end());
  const auto look = [&](const std::vector<std::vector<edges::FatEdge>>& under_fat) {
    return edges::cover(task.images, labels, task.box, task.ground.levels, still_noise, under_fat,
                        structures);
  };
  const auto follow = [&](const edges::Covered& covered) {
    edges::follow_coverage(covered.coverage, labels);
    hold(task, labels);
  };
  if (!task.thick()) follow(look({}));
  const std::vector<std::vector<edges::FatEdge>> under_fat = take_fat_off(task, labels);
  // The outside is known by now, and does not hang on what counts as cavity.
  if (task.options.papillary == Papillary::Muscle) {
    edges::papillary_muscles_to_wall(task.images, task.ground.levels, labels);
    hold(task, labels);
  }
  edges::Covered covered = look(under_fat);
  if (task.thick()) return covered;
  follow(covered);
  return covered;
}

/// As segment_by_threshold, of a task whose ground is laid.
Segmentation segment_by_window(const Task& task) {
  if (!task.known.phases.empty()) {
    throw_invalid("the method threshold makes nothing of labels of some phases; use competition");
  }
  return segment_by_threshold(task.stack, task.given, task.ground.seeds, task.box,
                              before_lift(task.ground.levels, task.lifted), task.options);
}

/// Atria and the aorta as far as they are bodies that could be drawn: one or two thick slices of
/// them are none. In thin ones ventricles come out the same whether a scene draws atria or not.
/// @return sentences on those that were not believed
std::vector<std::string> keep_beyond_base(const Task& task, const Belief& belief,
                                          ImageCycle<std::uint8_t>& labels) {
  if (!task.thick()) return drop_doubtful_beyond_base(belief, labels);
  merge_beyond_base(labels);
  return {};
}

/// What is known of the ventricle as a whole once its labels and coverage are.
void finish(const Task& task, const BaseSide& base, const ImageCycle<std::uint8_t>& labels,
            Segmentation& out) {
  if (task.thick() && base.step != 0) {
    out.valve_planes = estimated_valve_planes(labels, base.step);
    for (auto& [structure, plane] : out.valve_planes) {
      for (double& k : plane.k) k += task.box.first[2];
    }
  }
  find_ends(out);
  out.labels.grid = task.stack.grid;
  put_back(labels, task.box, out.labels);
  out.axis = ventricle_axis(out);
  if (base.across && base.step != 0) {
    const std::vector<std::string> cut = cut_ends(out, base.step);
    out.warnings.insert(out.warnings.end(), cut.begin(), cut.end());
  }
  if (!out.axis && out.coverage.phases.count(Structure::LvMyocardium) != 0) {
    out.warnings.emplace_back(
        "the left ventricle's long axis is not known, since its apex or a base is not seen in "
        "every phase; nothing on the wall is named by AHA segment, and no thickness is told");
  }
}

}  // namespace

Segmentation segment_exam(const Exam& exam, const std::vector<Seed>& given,
                          const SegmentOptions& options, StageContext& context,
                          const KnownLabels& known, const prior::PriorCycle* prior) {
  const std::vector<motion::BadFrame> bad = motion::bad_frames(exam.stack.images);
  ImageCycle<float> mended;
  if (!bad.empty()) mended = motion::without_bad_frames(exam.stack.images, bad);
  const ImageCycle<float>& stack = bad.empty() ? exam.stack.images : mended;
  if (stack.phase_count() < 2) {
    throw_invalid("only one phase: a beating heart needs at least two");
  }
  check_seeds(given, stack.grid, stack.phase_count());
  std::optional<prior::PriorCycle> held;
  if (prior != nullptr) {
    held = *prior;
    prior::hold_courses(*held);
  }
  Task task = lay_ground(stack, given, options, known, held ? &*held : nullptr, context);
  held.reset();
  const std::vector<std::string> doubts = doubtful_seeds(task.images, given, task.ground.levels);
  if (options.method == Method::Threshold) {
    Segmentation out = segment_by_window(task);
    const std::vector<std::string> frames =
        motion::told(bad, stack.grid.size[2], stack.phase_count());
    out.warnings.insert(out.warnings.begin(), frames.begin(), frames.end());
    out.warnings.insert(out.warnings.end(), doubts.begin(), doubts.end());
    return out;
  }
  ImageCycle<std::uint8_t> labels = grow(task, context);
  task.ground.prices = {};
  context.progress(0.65, "outlines");
  make_one_heart(task, labels);
  task.ground.seeds = {};
  const BaseSide base = base_side(labels);  // Atria tell, so before they are merged.
  if (base.across && base.step != 0) {
    close_wall(base.step, labels);
    hold(task, labels);
  }
  Segmentation out;
  const auto believed = [&](const auto& structures, const ImageCycle<std::uint8_t>& of) {
    if (!task.by_prior) return Belief();
    return belief_in(*prior, of, task.box, {.marks = task.marks, .known = task.known},
                     {structures.begin(), structures.end()});
  };
  out.warnings = motion::told(bad, stack.grid.size[2], stack.phase_count());
  const auto tell = [&](const std::vector<std::string>& sentences) {
    out.warnings.insert(out.warnings.end(), sentences.begin(), sentences.end());
  };
  tell(doubts);
  if (task.by_prior) {
    if (const auto sentence = labelled_after_views(*prior)) tell({*sentence});
  }
  const bool atria = !task.thick();
  const std::vector<std::string> dropped =
      keep_beyond_base(task, atria ? believed(kBeyondBase, labels) : Belief(), labels);
  if (options.atria) tell(dropped);
  context.progress(0.85, "boundaries within voxels");
  edges::Covered covered = cover_task(task, atria, labels);
  out.coverage = std::move(covered.coverage);
  out.uncertainty = std::move(covered.uncertainty);
  if (out.coverage.phases.count(Structure::Heart) == 0) {
    throw_invalid("no heart found: what grew from the seeds is empty");
  }
  ImageCycle<std::uint8_t> kept = labels;
  put_known(task.known, kept);
  tell(seeds_not_followed(labels, kept, given, task.marks));
  if (atria && !options.atria) {
    merge_beyond_base(labels);
    for (const Structure structure : kBeyondBase) {
      out.coverage.phases.erase(structure);
      out.uncertainty.erase(structure);
    }
  }
  out.belief = believed(kVentricular, labels);
  finish(task, base, labels, out);
  return out;
}

}  // namespace beatlas::segment
