#pragma once
/// A network's opinion of a slice that hangs less on how the slice lies: the mean of its
/// probabilities over half turns.

#include <array>
#include <vector>

#include "pipeline/prior/network.h"

namespace beatlas::prior {

/// How a slice is shown. `swapped`: `below` is shown as `above` and the other way round, as it is
/// when a body is turned about an axis in the slice's plane.
struct Orientation {
  bool mirrored_columns = false;
  bool mirrored_rows = false;
  bool swapped = false;
};

/// The half turns about the three axes of a stack, in the order in which they are used; none of
/// them shows a mirror image.
inline constexpr std::array<Orientation, 4> kOrientations{{
    {false, false, false},
    {true, false, true},
    {true, true, false},
    {false, true, true},
}};

/// Which of kOrientations an image is shown in.
struct Turns {
  int first = 0;
  int count = 1;
};

/// Of a model of so many orientations. Of a beat of many phases each image has half of them, and
/// its neighbours in space and time, from and to which labels grow, have the others: the time of
/// two networks for what four know.
[[nodiscard]] Turns turns_of(int orientations, int phases, int slice, int phase);

/// @param input [channel][row][column], see fill_input
/// @param probabilities [output][row][column], replaced: of each pixel 1 in sum, > 0 or underflowed
void run_turned(Network& network, const ModelCard& card, const std::vector<float>& input, int width,
                int height, const Turns& turns, std::vector<float>& probabilities);

}  // namespace beatlas::prior
