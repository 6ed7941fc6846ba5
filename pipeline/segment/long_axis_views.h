#pragma once
/// The LV's two ends as long-axis views beside the stack show them: between slices far apart the
/// stack itself shows neither.

#include <optional>
#include <string>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/grid.h"

namespace beatlas::segment {

struct ViewSearch {
  const std::vector<Cine>& views;          ///< one slice each
  const ImageCycle<std::uint8_t>& labels;  ///< the stack's, as grown
  std::vector<int> lv_slices;              ///< that show the LV at end-diastole, ascending
  int base_step = 0;                       ///< +1 if the base lies towards larger k, -1 if smaller
  int end_diastole = 0;
};

/// Slice indices in the labels' grid, fractional, where the LV's axis meets
struct LvEndsInViews {
  std::vector<double> base_k;  ///< [phase] the mitral plane
  std::vector<double> apex_k;  ///< [phase] the apical end of the cavity; empty if that was not seen
  int views = 0;               ///< that run along the LV
};

/// In every view that runs along the LV (its axis within 12 mm and 20 degrees of the plane) the
/// wall on each side is followed from slices that the stack shows it in toward the base, until it
/// is less than half as thick: there the leaflet hinges. Blood and muscle are what the labels make
/// them there. The plane is where most hinges of all views and of neighbouring phases lie; the
/// apical end is where the blood about the axis ends.
/// @return none if no view runs along the LV (`trouble` stays empty), or if the hinges do not agree
/// or lie where the stack has no base; then `trouble` says which, in a sentence.
[[nodiscard]] std::optional<LvEndsInViews> find_lv_ends_in_views(const ViewSearch& search,
                                                                 std::string& trouble);

}  // namespace beatlas::segment
