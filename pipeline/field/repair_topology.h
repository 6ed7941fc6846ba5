#pragma once
#include <vector>

#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"

namespace beatlas::field {

/// Makes the surface of every phase one sphere, the same one all the cycle (see make_balls), and
/// the samples distances to it again. So what a finger feels is what is drawn. Only samples whose
/// nearest surface may have changed are touched: those farther from every changed sample than from
/// the surface, by more than two voxels, stay as they are. The others get the distance to the
/// surface of the changed samples (level_surface). What was mended is told in the log.
/// Deterministic, the same bits for any number of threads.
void repair_topology(FieldCycle& field, const StageContext& context);

/// The same of all structures of a scene, so that those beside each other still agree where they
/// meet: the heart, for itself, and within it the wall, then cavities and vessels, each of which
/// leaves what those before it gained, and with it what that cuts off. One that would lose its
/// deepest place to another, which encloses it on all sides, leaves it nothing. What the wall and
/// the LV's cavity had to gain beyond the heart the heart takes in: these three are made for every
/// scene, and are the same in each.
/// @param fields on lattices that share their axes and samples, as build_field makes them
/// @throws Error{InvalidInput} for fields of different phases or voxels, and for a phase that has
/// no sample inside
void repair_topology(std::vector<FieldCycle>& fields, const StageContext& context);

}  // namespace beatlas::field
