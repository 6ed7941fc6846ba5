#pragma once
/// Long-axis views beside the stack: what they know of the slices that they cross.

#include <vector>

#include "pipeline/prior/prior.h"

namespace beatlas::prior {

/// What came of asking views.
struct HeededViews {
  int views = 0;                ///< how many of them cross the slices and know
  std::vector<double> unknown;  ///< [slice] u, see heed_views; 0 where no view crosses it
};

/// Whether a view lies 30 degrees or more across the slices of a stack; others tell nothing.
[[nodiscard]] bool crosses(const Grid& view, const Grid& stack);

/// Makes one prior of the network's word on the stack and its word on views that cross it.
///
/// In each slice either the network knows what it sees, or, with a probability u, it does not.
/// Where it knows, slice and view are two looks at the same tissue: their probabilities are
/// multiplied, as far beside the view as its own thickness goes. Where it does not, the view tells
/// alone, as far beside it as tissue stays the same. u is the likeliest for what both say along the
/// lines in which they meet, in all phases together (expectation maximisation of the mixture's
/// weight, Dempster 1977). Breath-holds move slices against views: a view is blurred by as much, so
/// that it tells what is where and leaves to the slice where exactly it ends. A view that, over all
/// the slices, does not know is heeded by so much less, and from a half on not at all.
///
/// Compared and multiplied are blood of the left heart, blood of the right, muscle of the LV, and
/// none of them. Which part of the left or right heart it is the slice knows better, where it
/// knows: in views of real exams the network takes an atrium for its ventricle at end-diastole. In
/// slices in which it sees an atrium in any phase, views are asked for the right heart alone.
/// @param views of one slice each, of the stack's phases and outputs
HeededViews heed_views(const std::vector<PriorCycle>& views, PriorCycle& stack);

}  // namespace beatlas::prior
