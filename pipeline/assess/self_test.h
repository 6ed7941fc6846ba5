#pragma once
/// An exam as its own test: slices and phases are hidden in turn, foretold from the others by what
/// makes the atlas of them, and compared with their own contours. No expert is asked, and no truth:
/// what is measured is what lies between slices and phases, not where the contours lie in them.
/// Slices left out to compare interpolations: Grevera and Udupa, IEEE TMI 17, 1998.

#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/assess/statistics.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/shape/workspace.h"

namespace beatlas::assess {

/// How far what was foretold of a structure lies from its own contours.
struct HiddenError {
  Structure structure{};
  int contours = 0;  ///< slices and phases that were compared
  /// [mm] along the surface's normal, weighted by the contours' length; bias > 0: foretold too far
  /// out. Errors beyond shape::kLevelReachMm count as that.
  DistanceStatistics mm;
};

/// A slice in a phase that was foretold badly.
struct HiddenPlace {
  Structure structure{};
  int slice = 0;  ///< of the stack
  int phase = 0;
  DistanceStatistics mm;
};

struct SelfTest {
  double slices_apart_mm = 0;     ///< those that foretell: twice the stack's own distance
  std::vector<int> slice_phases;  ///< in which slices were hidden: end-diastole and end-systole
  /// Of slices between two that show the structure; of those beside its ends, where one neighbour
  /// does not, in thick slices of the apex alone.
  std::vector<HiddenError> between_slices;
  std::vector<HiddenError> at_ends;
  double phases_apart_s = 0;  ///< those that foretell: twice the exam's own; 0: none was hidden
  std::vector<HiddenError> between_phases;
  std::vector<HiddenPlace> worst;  ///< slices between two others, the worst first, at most five
};

/// Every slice is hidden once: every other one foretells those between, but for which thick one is
/// the last before a valve, as no other tells. Every phase is hidden once,
/// at most twelve that lie evenly over the beat, foretold as a cubic in time does in the middle
/// between four; of fewer than eight phases none.
/// @param found as the study holds it
/// @param stack the whole grid of the images
/// @throws Error{InvalidInput} if there are fewer than four slices with a heart, which cannot
/// foretell each other
[[nodiscard]] SelfTest self_test(const Segmentation& found, const Grid& stack, double rr_interval_s,
                                 const shape::RegisterOptions& options, StageContext& context);

/// See schemas/assess.schema.json.
[[nodiscard]] nlohmann::json to_json(const SelfTest& found);

/// What half of the slices says of the structure between them, as a stack of its own, in the phases
/// named. For tests.
/// @param parity of the coverage's slices that are kept, 0 or 1
[[nodiscard]] Segmentation every_other_slice(const Segmentation& found, const Grid& stack,
                                             int parity, const std::vector<int>& phases);

}  // namespace beatlas::assess
