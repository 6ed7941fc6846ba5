#pragma once
/// Exam -> labels and sub-voxel coverage of the heart's structures, by seeded region growing in
/// competition, foreground against background, through all phases.

#include <string>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/segment/alarm.h"

namespace beatlas::prior {
struct PriorCycle;
}

namespace beatlas::segment {

/// What a technician marked with one label in one phase: a ball around a place, or a stroke.
struct Seed {
  std::uint8_t label = 0;  ///< see atlas Label; 0 is background
  Vec3 lps_mm = Vec3::Zero();
  double radius_mm = 2.0;
  int phase = 0;  ///< phase it was drawn in; -1 = every phase
  /// A stroke goes straight from lps_mm through these places; none: a ball.
  std::vector<Vec3> stroke_lps_mm = {};
};

enum class Method {
  Competition,  ///< all labels grow at once, see competition.h
  Threshold,    ///< LV blood alone, where a window of intensity reaches, see threshold_growing.h:
                ///< the method of paper A, which leaks; for comparison
};

/// What papillary muscles and trabeculae as dark as muscle, inside the LV's pool, count as.
enum class Papillary { Cavity, Muscle };

/// Where labels from elsewhere were drawn, if slices were moved back at import.
enum class LabelsDrawnOn {
  Imaged,   ///< on the images as they came: each slice's labels are moved with it
  Aligned,  ///< on the study's images: they stay
};

/// Which voxels touch.
enum class Neighbours { Faces, All };

struct SegmentOptions {
  bool even_shading = true;  ///< the coil's shading is taken off, see shading.h
  bool denoise = true;       ///< noise is smoothed, edges are not, before growing; see denoise.h
  /// Labels grow from phase to phase along the motion that the images show, see phase_motion.h;
  /// off: from a voxel to the same voxel.
  bool follow_motion = true;
  Method method = Method::Competition;
  Papillary papillary = Papillary::Cavity;
  /// Atria and the aorta's root become structures of their own where the prior sees them, in stacks
  /// of thin slices.
  bool atria = true;
  /// [mm] 0..100: what crossing an edge as high as that between muscle and blood costs a label, in
  /// millimetres of easy travel. 0: labels meet half-way between seeds whatever lies between.
  double edge_cost_mm = 20;
  /// [mm] 0.5..5: Gaussian that smooths the labels' outlines in plane.
  double outline_sigma_mm = 2;
  /// [the images' intensity] 0..1e6: ends of the window of Method::Threshold. 0: from the levels of
  /// blood and muscle that the images show: half-way between them, and as far beyond blood.
  double threshold_low = 0;
  double threshold_high = 0;
  Neighbours threshold_neighbours = Neighbours::Faces;
  /// The model whose prior is asked for first (pipeline/prior): NAME.onnx, "" for the built-in one,
  /// "none" for none. segment_exam is given what it said.
  std::string prior;
  /// Of labels given from elsewhere, see labels_on_grid; segment_exam takes them as they are.
  LabelsDrawnOn labels_drawn_on = LabelsDrawnOn::Imaged;
  /// Of leak_alarms, which whoever calls segment_exam asks afterwards.
  LeakOptions leak;
};

/// @throws Error{InvalidInput} if a seed or a place of a stroke lies outside the images, has no
/// known label or phase, or a radius that is not within 0..50 mm.
void check_seeds(const std::vector<Seed>& seeds, const Grid& grid, int phases);

/// Labels that were made elsewhere, of some phases.
struct KnownLabels {
  LabelCycle labels;        ///< on the exam's grid, an image for each of:
  std::vector<int> phases;  ///< ascending
};

/// Without a prior that holds a heart, seeds or known labels have to tell where the heart is (see
/// seed_ground.h); beside one they win over it.
/// @param known labels to grow the other phases from, which hold in their own, see known_ground.h
/// @param prior of this exam's stack, what its voxels are likely to be; null: nothing was learned
/// @throws Error{InvalidInput} if no heart is found or nothing tells where it is, if there is one
/// phase alone, as check_seeds
[[nodiscard]] Segmentation segment_exam(const Exam& exam, const std::vector<Seed>& seeds,
                                        const SegmentOptions& options, StageContext& context,
                                        const KnownLabels& known = {},
                                        const prior::PriorCycle* prior = nullptr);

/// Enclosed volume [ml] of a structure in every phase, from coverage.
[[nodiscard]] std::vector<double> volume_curve_ml(const CoverageCycle& coverage,
                                                  Structure structure);

}  // namespace beatlas::segment
