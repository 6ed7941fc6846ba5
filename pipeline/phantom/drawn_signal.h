#pragma once
/// From tissues to what a scanner makes of them: contrast, blood that flows, coil, blur, ghosts,
/// noise, and the channels that a network is shown.

#include <array>
#include <vector>

#include "pipeline/phantom/drawn_heart.h"
#include "pipeline/phantom/drawn_slices.h"

namespace beatlas::phantom {

inline constexpr auto kTissues = static_cast<std::size_t>(Tissue::Count);
using TissueSignals = std::array<float, kTissues>;

/// Signal of every tissue, blood of the LV 1, but where the contrast is random.
[[nodiscard]] TissueSignals draw_signals(const Family& family);
/// Of any vessel or chamber; of any wall.
[[nodiscard]] bool is_blood(Tissue tissue);
[[nodiscard]] bool is_muscle(Tissue tissue);

/// Tissues of each pixel's centre and of two places beside it: [place][pixel].
using TissueImage = std::array<std::array<Tissue, DrawnSample::kPixels>, 3>;

/// @param family draws the scanner, apart from what drew the heart
/// @param frames of the slice through the beat, one or more; @param shown which of them is labelled
/// @param neighbours the slices below and above in the same moment
[[nodiscard]] DrawnSample imaged(const Family& family, const std::vector<TissueImage>& frames,
                                 std::size_t shown, const std::array<TissueImage, 2>& neighbours);

}  // namespace beatlas::phantom
