#pragma once
#include <memory>
#include <vector>

#include "pipeline/phantom/drawn_truth.h"
#include "pipeline/phantom/phantom.h"
#include "runtime/atlas/manifest.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::assess {

/// Whether a package was made from images of this phantom.
/// By the identity that its images carried (provenance/phantom_identity), which tells apart any
/// two phantoms, also those that differ in noise alone. Without one: by image lattice (in any
/// order of its axes), number of frames and R-R interval, and by what no segmentation of these
/// images could give: a volume not half or twice the true one at its largest, a heart 25 mm from
/// its place, an LV smallest more than 0.3 cycles from the true moment.
/// @throws Error{InvalidInput} saying what differs, if it was not.
void demand_same_phantom(const atlas::Manifest& manifest,
                         const std::vector<std::shared_ptr<const atlas::FieldPayload>>& fields,
                         const phantom::Phantom& truth);

/// Whether a package was made from the images of this draw, by the identity that they carried.
/// @throws Error{InvalidInput} if it was not, or has other phases
void demand_same_draw(const atlas::Manifest& manifest, const phantom::DrawnTruth& truth);

}  // namespace beatlas::assess
