#pragma once
#include "pipeline/core/shapes.h"

namespace beatlas::field {

/// Takes off what flickers from phase to phase and is no motion of the heart. The samples' course
/// over the cycle is taken apart into harmonics; each is compared with what it is around (a cube of
/// 12 mm, the bend with place taken into account): motion is shared by neighbours, noise is not,
/// and in the highest harmonics there is hardly anything else, so those tell how much of it there
/// is. Of what a sample has beside its neighbours that share is taken off which noise makes up of
/// its power there (Lee 1980, a local Wiener filter). The mean over the cycle stays, as do samples
/// that are clamped in any phase, and cycles of fewer than 8 phases. Samples stay within the
/// field's clamp. The same bits for any number of threads.
void take_off_flicker(FieldCycle& field);

}  // namespace beatlas::field
