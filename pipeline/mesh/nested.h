#pragma once
/// Structures that touch: muscle and the blood in it, cavities in the heart.

#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas::mesh {

/// Moves vertices so that surfaces of different structures do not pass through each other where the
/// structures share a wall. Their fields agree (see shape/shared_places.h), but flat triangles
/// cut across a curved wall (by 0.03 mm with edges of 2 mm), and a mesh lies off its surface where
/// it bridges what other phases have open. Of two distances phi_a, phi_b on such a wall,
/// (phi_a - phi_b) / 2 (of blood beside muscle; (phi_a + phi_b) / 2 of a cavity inside the heart)
/// is zero on the middle between both. Where a vertex, the middle of an edge or of a triangle lies
/// beyond it, less a gap of 0.01 mm, the vertices around go back along its gradient, by the least
/// sum of squares that will do. Of a ventricle and what lies beyond its base the latter goes back
/// alone: ventricles are parted first, and are the same whether atria are known or not. What
/// crosses all the same goes farther from where it is, with the triangles around it, until it does
/// not or has gone 1.2 mm. Nothing else moves, and no vertex so far that it turned a triangle by
/// more than 45 degrees or made one thinner than 11: there they may still cross, as where a mesh
/// lacks a part that the other has. The same bits for any number of threads.
/// @param surfaces of one level of detail  @param fields of their structures, the same phases;
/// structures of which either is missing are left as they are
/// @param held structures whose surfaces stay as they are, for a person made them so
void part_structures(std::vector<SurfaceCycle>& surfaces, const std::vector<FieldCycle>& fields,
                     const std::vector<Structure>& held = {});

}  // namespace beatlas::mesh
