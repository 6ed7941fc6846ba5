#pragma once
/// What a segmentation is asked for, and what a person tells it.

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/alarm/options.h"
#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"

namespace beatlas::segment {

/// What a technician marked with one label in one phase: a ball around a place, or a stroke.
struct Seed {
  std::uint8_t label = 0;  ///< see atlas Label; 0 is background
  Vec3 lps_mm = Vec3::Zero();
  double radius_mm = 2.0;
  int phase = 0;  ///< phase it was drawn in; -1 = every phase
  /// A stroke goes straight from lps_mm through these places; none: a ball.
  std::vector<Vec3> stroke_lps_mm = {};
  bool painted = false;  ///< a run of an image's voxels, which has no number of its own
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
  /// Of the leak alarm, which whoever calls segment_exam asks afterwards.
  alarm::LeakOptions leak;
};

/// Labels that were made elsewhere, of some phases.
struct KnownLabels {
  LabelCycle labels;        ///< on the exam's grid, an image for each of:
  std::vector<int> phases;  ///< ascending
};

}  // namespace beatlas::segment
