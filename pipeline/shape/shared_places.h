#pragma once
/// One place, one structure: what shapes that were made apart both claim is settled between them.

#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas::shape {

/// Makes the shapes of structures agree with each other, phase by phase. Labels give every voxel to
/// one structure; but between slices, and beyond the last of them, every surface is interpolated
/// for itself, so that two structures may claim the same place and the heart may end within what it
/// holds (of a real exam in slices 17.7 mm apart up to 13 ml of muscle lay outside of the heart).
/// - Of two beside each other phi_a becomes max(phi_a, (phi_a - phi_b) / 2): what both claim is
///   parted in its middle (Losasso, Shinar, Selle and Fedkiw, ACM TOG 25, 2006, who close gaps so,
///   too; here a gap is a wall).
/// - The heart holds them all: where a ventricle's or its muscle's phi_a is below the heart's phi,
///   both become their mean. Where both surfaces are one, as on the LV's free wall, neither so
///   moves by the noise of both.
/// - An atrium or a vessel gives way to ventricles and their muscle, max(phi_a, -phi_b), and to the
///   heart, max(phi_a, phi): these are the same whether atria are known or not.
/// @param shapes in the order of kAllStructures
/// @pre lattices have the same edge, and origins at multiples of it; the heart's holds what is
/// inside of the others
void settle_shared_places(std::vector<ShapeCycle>& shapes);

}  // namespace beatlas::shape
