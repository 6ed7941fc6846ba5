#pragma once
#include <vector>

#include "pipeline/phantom/thorax.h"

namespace beatlas::phantom {

/// The arms, left and right beside the chest: skin fat, muscle and bone of each, in painting order
/// over air. Cylinders along z, 175 mm from the heart's origin (larger with the heart, as the
/// thorax); the skin's semi-axes are 36 and 42 mm.
[[nodiscard]] std::vector<ThoraxBody> arms(const Anatomy& anatomy, const Signals& signals);

/// How far they reach from the heart's origin to the left and right [mm].
[[nodiscard]] double arms_reach_mm(const Anatomy& anatomy);

}  // namespace beatlas::phantom
