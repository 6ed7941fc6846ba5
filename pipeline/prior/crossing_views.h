#pragma once
/// Long-axis views beside the stack: what they know of the slices that they cross.

#include <vector>

#include "pipeline/prior/prior.h"

namespace beatlas::prior {

/// Makes one prior of the network's word on the stack and its word on views that cross it.
///
/// In each slice either the network knows what it sees, or, with a probability u, it does not.
/// Where it knows, slice and view are two looks at the same tissue: their probabilities are
/// multiplied, as far beside the view as its own thickness goes. Where it does not, the view tells
/// alone, as far beside it as tissue stays the same. u is the likeliest for what both say along the
/// lines in which they meet, in all phases together (expectation maximisation of the mixture's
/// weight, Dempster 1977). Breath-holds move slices against views: a view is blurred by as much, so
/// that it tells what is where and leaves to the slice where exactly it ends. A view that, over all
/// the slices, does not know is heeded by so much less.
///
/// Compared and multiplied are blood of the left heart, blood of the right, muscle of the LV, and
/// none of them. Which part of the left or right heart it is the slice knows better: in views of
/// real exams the network takes an atrium for its ventricle at end-diastole.
/// @param views of one slice each, of the stack's phases and outputs; those that lie within 30
/// degrees of the slices' own direction tell nothing
/// @return [slice] u; 0 where no view crosses it
std::vector<double> heed_views(const std::vector<PriorCycle>& views, PriorCycle& stack);

}  // namespace beatlas::prior
