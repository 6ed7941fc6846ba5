#pragma once
/// What is told of the stack that was chosen.

#include <string>
#include <vector>

#include "pipeline/ingest/stack_candidates.h"
#include "pipeline/ingest/stack_choice.h"

namespace beatlas::ingest {

inline constexpr std::size_t kMostListed = 9;      ///< possible stacks told in full
inline constexpr std::size_t kListedInErrors = 4;  ///< the same where one sentence must hold them

/// A number as printf prints it.
[[nodiscard]] std::string with_digits(const char* format, double value);

/// The list of possible stacks, at most `most` of them and the chosen one, and why that was taken.
/// @param chosen an index; beyond the last: none
[[nodiscard]] std::string listed(const std::vector<Candidate>& candidates, std::size_t chosen,
                                 bool asked, std::size_t most = kMostListed);

/// By what the stack is timed, and what was odd.
/// @param frames what most slices have
/// @throws Error{InvalidInput} if too much of the cycle was never imaged.
void tell_timing(const ChosenCine& stack, int frames, std::vector<std::string>& decisions);

/// Where the widest gap between a stack's slices lies, and what lies in it; a clause to put behind
/// another.
/// @param found the stack's slices, with those that were not kept
[[nodiscard]] std::string hole_told(const Slices& kept, const Slices& found);

/// That slices of two acquisitions may be mixed.
[[nodiscard]] std::string mixed_told();

}  // namespace beatlas::ingest
