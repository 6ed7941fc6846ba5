#pragma once
/// What hangs together: a heart is one body, a ventricle one cavity.

#include <cstdint>

#include "pipeline/core/exam.h"

namespace beatlas::segment {

/// Keeps in each phase what hangs together with the heart's largest part, through space and time.
void keep_connected_heart(ImageCycle<std::uint8_t>& labels);

/// Of the right ventricle's blood each phase keeps its largest part; the others are rest of heart:
/// where the outflow tract comes into a thick slice, no other slice joins it to the ventricle yet.
/// Nothing in thin slices.
void keep_connected_rv(ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
