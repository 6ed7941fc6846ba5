#pragma once
/// Which of some positions along a line are a stack of evenly spaced slices.

#include <string>
#include <vector>

namespace beatlas::ingest {

/// Neighbouring gaps of an even stack may differ from their median by this share.
inline constexpr double kMostUneven = 0.10;
/// From this share on the unevenness is told.
inline constexpr double kNotedUneven = 0.01;
/// More than this share of the positions must belong to an even stack.
inline constexpr double kLeastKept = 0.8;
/// So many slices of a stack may have one among them that is not there,
inline constexpr int kSlicesPerHole = 5;
/// where its neighbours lie no farther apart than this: twice as far as the slices of hearts that
/// the prior learned from (`exam_slice`, `exam_gap` of pipeline/phantom/family.json). Of cine-exam,
/// whose slices lie 17.7 mm apart, without one of them LV volumes were off by up to 10 and 22 %
/// (EDV, ESV).
inline constexpr double kWidestHoleMm = 32;
/// A slice of a loose stack lies no farther from its even place than this share of the spacing,
inline constexpr double kMostOff = 0.25;
/// and its gaps differ from their median, or from two, by no more than this share of it: of one
/// half-way between, nothing tells whether a slice is missing there.
inline constexpr double kLooseGap = 0.35;

/// How slices may lie to be a stack.
enum class Spacing {
  Even,       ///< in steps of one length, but for strays, which are left
  Loose,      ///< all of them, about as even places lie, between two of which one may be missing
  WithHoles,  ///< as Even, and one slice may be missing between two that are there
};

struct EvenStack {
  std::vector<int> members;  ///< indices into the positions, in their order; at least 3
  std::vector<int> numbers;  ///< [member] of its slice in the even stack, from 0, ascending
  double spacing_mm = 0;     ///< mean gap, or the median if they differ by more than kNotedUneven;
                             ///< of a loose stack by least squares
  double first_mm = 0;       ///< position of the first slice of the even stack
  double worst_gap = 0;      ///< largest deviation of a gap from the median, as a share of it
  double worst_off_mm = 0;   ///< farthest that a member lies from its even place
};

/// The longest run of evenly spaced positions, less its holes, the narrower of two as long; or all
/// positions as a loose stack.
/// @param positions_mm ascending, no two alike
/// @throws Error{InvalidInput} if it has fewer than 3 members or leaves a fifth of the positions
///         or more, or has more than one hole in kSlicesPerHole slices, or two side by side: then
///         slices are missing or they are spaced unevenly.
[[nodiscard]] EvenStack find_even_stack(const std::vector<double>& positions_mm,
                                        Spacing spacing = Spacing::Even);

/// The even stacks that interleave: two or more of 3 positions and more, of one spacing, that lie
/// over each other and between each other's positions, and to which all positions belong. None
/// where positions are not of that kind: parts on both sides of a hole are no stacks.
/// @param positions_mm ascending, no two alike
[[nodiscard]] std::vector<std::vector<int>> even_parts(const std::vector<double>& positions_mm);

}  // namespace beatlas::ingest
