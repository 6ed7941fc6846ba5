#pragma once
/// The one place where possible stacks are ranked.

#include <string>
#include <vector>

#include "pipeline/ingest/stack_candidates.h"

namespace beatlas::ingest {

/// Tells of every candidate how well the views meet along its normal, and whether it may be the
/// short axis; then puts the best first. What counts, in this order:
/// an ordinary cine; no secondary copies; trigger times and 8 phases; a short axis; the contrast of
/// the exam's cines; number of slices, two thirds of it where they share no field of view; one
/// field of view; one contrast; originals; views of its frame of reference; not mixed; one series;
/// number of phases; then, of one contrast and direction, the later series, else the scan's order
/// of planes.
///
/// A short axis may be each stack that has half of the best one's evidence: the share of views that
/// meet along its normal, and 0.25 for a normal that is oblique to the patient.
void rank_candidates(std::vector<Candidate>& candidates, const std::vector<Plane>& planes);

/// Why the first of two candidates comes before the second; a clause.
[[nodiscard]] std::string why_before(const Candidate& first, const Candidate& second);

/// What else might have been the short axis, told of the one that was chosen; empty if nothing.
[[nodiscard]] std::string other_axis_told(const std::vector<Candidate>& candidates,
                                          std::size_t chosen);

/// An equal stack at another heart rate that was left; empty if there is none.
[[nodiscard]] std::string other_rate_told(const std::vector<Candidate>& candidates,
                                          std::size_t chosen);

}  // namespace beatlas::ingest
