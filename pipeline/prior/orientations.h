#pragma once
/// A network's opinion of a slice that hangs less on how the slice lies and how large it is: the
/// mean of its probabilities over quarter and half turns, every other one of them enlarged.

#include <array>
#include <cstddef>
#include <vector>

#include "pipeline/prior/network.h"

namespace beatlas::prior {

/// How a slice is shown: mirrored first, then with rows and columns exchanged. `swapped`: `below`
/// is shown as `above` and the other way round, as it is when a body is turned about an axis in the
/// slice's plane. `enlarged`: by kEnlarged.
struct Orientation {
  bool mirrored_columns = false;
  bool mirrored_rows = false;
  bool transposed = false;
  bool swapped = false;
  bool enlarged = false;
};

/// By an eighth: drawn hearts do not tell it from none or a quarter, one real exam does (README).
inline constexpr double kEnlarged = 1.125;

/// The turns that leave a square slice in its place, in the order in which they are used; none of
/// them shows a mirror image. A half turn of an exam shows the same ones in another order.
inline constexpr std::array<Orientation, 8> kOrientations{{
    {false, false, false, false, false},
    {true, false, true, false, true},
    {true, true, false, false, false},
    {false, true, true, false, true},
    {true, false, false, true, false},
    {false, false, true, true, true},
    {false, true, false, true, false},
    {true, true, true, true, true},
}};

/// Which of kOrientations an image is shown in.
struct Turns {
  int first = 0;
  int count = 1;
};

/// Of a model of so many orientations, for each image of an exam. Few images are shown in all of
/// them. Of many each has a part, at least two, and its neighbours in space and time, from and to
/// which labels grow, have the others: the time of two networks for what eight know.
class TurnsOfImages {
 public:
  TurnsOfImages(int orientations, std::size_t images);
  [[nodiscard]] Turns of(int slice, int phase) const;

 private:
  int orientations_;
  int count_;
  int parts_;
};

/// @param input [channel][row][column], see fill_input
/// @param probabilities [output][row][column], replaced: of each pixel 1 in sum, > 0 or underflowed
void run_turned(Network& network, const ModelCard& card, const std::vector<float>& input, int width,
                int height, const Turns& turns, std::vector<float>& probabilities);

}  // namespace beatlas::prior
