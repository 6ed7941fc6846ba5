#pragma once
/// An exam of a heart of the family: a stack of images, as a scanner would take it of a person
/// drawn at random, with its truth.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/phantom/drawn_heart.h"

namespace beatlas::phantom {

/// Seeds below it are for training and tuning; those who judge take others.
inline constexpr std::uint32_t kFirstJudgingSeed = 10000;
inline constexpr std::uint32_t kMostDrawSeed = 99999999;
inline constexpr int kMostDrawnViews = 6;
inline constexpr const char* kDrawnTruthFormat = "beatlas-drawn-truth";
inline constexpr int kDrawnTruthVersion = 1;
inline constexpr std::uint32_t kMostDrawAttempts = 40;

struct DrawnExamOptions {
  int most_voxels = 2000000;  ///< of all slices and phases together; 1100000 or more
  int views = 0;              ///< 0..kMostDrawnViews long-axis views beside the stack
};

struct DrawnExam {
  Cine cine;
  std::vector<Cine> views;  ///< of one slice each; what they show is no part of `identity`
  double slice_thickness_mm = 0;
  double view_thickness_mm = 0;  ///< 0 without views
  LabelCycle labels;         ///< truth, by the centre of each voxel, of the slices' nominal places
  LabelCycle source_labels;  ///< the same where the slices were as acquired: moved by breath-holds
  std::string identity;      ///< SHA-256 of what was drawn
  /// {"format": "beatlas-drawn-truth", "version": 1, "identity", "seed", "attempt", "purpose":
  ///  "training" or "judging", "has_heart", "rendering": "box" or "profile", "rr_interval_s",
  ///  "times_s" [], "contraction" [], "stack": {"plane", "columns", "slices", "pixel_mm",
  ///  "distance_mm", "thickness_mm", "shifts_mm" [slice][i, j], "in_view"}, "drawn": numbers of the
  ///  family, "measured": the same as they came out, "ejection_fraction", "volume_error_ml",
  ///  "structures": [{"name", "volume_ml" []}]}. Volumes are of whole structures, in view or not.
  nlohmann::json truth;
};

/// The exam of a seed. A draw that no person and no scanner could be (see the limits in
/// family.json) is drawn again, from seed + 100000000 * attempt. The same bytes for any number of
/// threads.
/// @param seed at most kMostDrawSeed
[[nodiscard]] DrawnExam drawn_exam(std::uint32_t seed, const DrawnExamOptions& options,
                                   StageContext& context);

/// What drawn_exam draws from a seed at an attempt.
[[nodiscard]] Family exam_family(std::uint32_t seed, std::uint32_t attempt);

/// [label][ml] of a heart at a moment, by points of a lattice of 8 mm / per_edge in its frame;
/// truth.json's volumes are of 2 mm. How far that is off the implicit body is "volume_error_ml":
/// tests/unit/phantom/drawn_exam_test.cpp compares it with a lattice of 0.8 mm.
[[nodiscard]] std::array<double, 8> drawn_volumes_ml(const DrawnHeart& heart, float contraction,
                                                     int per_edge);

}  // namespace beatlas::phantom
