#pragma once
/// Where the left ventricle opens towards its atrium and the aorta, as its endocardium shows it.

#include <vector>

#include "runtime/atlas/payloads.h"
#include "runtime/haptics/tube_field.h"

namespace beatlas::palpation {

/// The opening in every phase: what of the endocardium's basal quarter has no wall beside it. Its
/// radius is half of that of a circle as large, for what of it is the mitral valve and what the
/// aortic one the map does not tell, and neither opens as wide as the base.
/// @param endocardium, map of lv_blood of one package, of one level
/// @throws Error{InvalidInput} if they are not of one surface and cycle, or a phase has no opening.
[[nodiscard]] std::vector<haptics::Opening> base_opening(const atlas::SurfacePayload& endocardium,
                                                         const atlas::SurfaceMapPayload& map);

}  // namespace beatlas::palpation
