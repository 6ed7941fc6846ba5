#pragma once
/// Slices of one stack that do not share a field of view: planned again, or each for itself.

#include <optional>
#include <vector>

#include "pipeline/ingest/stack_candidates.h"

namespace beatlas::ingest {

/// A candidate of ordinary cines of one contrast with guests of its plane that go on with its even
/// spacing, fill a hole in it, or stand for a slice of fewer than half of its phases; nothing if
/// none does. A guest is of the candidate's contrast and heart rate, has half of its phases, and
/// shows the middle of its field of view; of several at one step originals count, then the one of
/// most frames, then the later series.
/// @param images that the candidate's sets count in
[[nodiscard]] std::optional<Candidate> completed(const Candidate& candidate,
                                                 const std::vector<DicomImage>& images);

/// Of planes that are nearly parallel to each other all ordinary cines of one contrast, on the
/// pixels of the plane that has most of them; of kLeastSlices slices and more.
/// @param without_stack only contrasts of which no single plane has as many slices
[[nodiscard]] std::vector<Candidate> gathered(const std::vector<Plane>& planes, bool without_stack);

/// Whether a candidate's slices were acquired among those of another, which holds them all: by
/// series, its slices and the others follow each other in turns, not one acquisition after the
/// other.
[[nodiscard]] bool acquired_among(const Candidate& part, const Candidate& whole);

}  // namespace beatlas::ingest
