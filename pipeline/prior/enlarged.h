#pragma once
/// Hearts smaller than any that a network was trained on, shown as large as those in the middle.

#include "pipeline/core/exam.h"
#include "pipeline/prior/model.h"
#include "pipeline/prior/prior.h"

namespace beatlas::prior {

/// How many times larger, along each axis, the heart is to be shown: until its LV is the geometric
/// mean of ModelCard::lv_ml, or images hold no more than the network sees of them. 1 where the LV
/// is at least as large as the smallest of these, and where none was seen.
/// @param looked at the whole of some phases; others may be empty
[[nodiscard]] double enlargement(const PriorCycle& looked, const Grid& stack,
                                 const ModelCard& card);

/// The same voxels in a larger space: all places are so many times as far from the origin.
[[nodiscard]] Grid enlarged(Grid grid, double times);
[[nodiscard]] Exam enlarged(Exam exam, double times);

}  // namespace beatlas::prior
