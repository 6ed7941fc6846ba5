#pragma once
/// The values that pass between segment, register, field, mesh and pack.

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/core/belief.h"
#include "pipeline/core/grid.h"
#include "pipeline/core/leak_alarm.h"
#include "pipeline/core/long_axis.h"
#include "runtime/atlas/structures.h"

namespace beatlas {

/// Label (see atlas Label) of every voxel of every phase, on the source's grid.
using LabelCycle = ImageCycle<std::uint8_t>;

/// The fraction 0..1 of every voxel that lies in a structure, on a part of the source's grid
/// that holds the heart with a margin; outside that part the coverage is 0.
struct CoverageCycle {
  Grid grid;              ///< a part of the source's grid
  Index3 first{0, 0, 0};  ///< its first voxel in the source's grid
  std::map<Structure, std::vector<std::vector<float>>> phases;  ///< [structure][phase][voxel]
};

/// Where the valve's plane is thought to be that ends a structure on the side of the base, taken as
/// parallel to the slices: they are too thick for the image to show it. It tells heights along the
/// axis. Shapes and volumes end as their slices do, half-way to the next one.
struct ValvePlane {
  int base_step = 0;  ///< +1: the structure lies at smaller slice index than the plane, -1: larger
  std::vector<double> k;  ///< [phase] slice index of the plane, fractional, in the source's grid
};

/// How well a boundary is known where it crosses a voxel.
struct BoundaryPoint {
  std::uint32_t voxel = 0;  ///< of the coverage's grid
  float sigma_mm = 0;       ///< standard deviation [mm] of its place, along the surface's normal
};

/// [structure][phase][point], voxels ascending. Voxels that a boundary crosses in the plane of the
/// slices; phases and places whose labels were drawn by hand or came from elsewhere have none.
using BoundaryUncertainty = std::map<Structure, std::vector<std::vector<BoundaryPoint>>>;

/// What segmentation gives.
struct Segmentation {
  LabelCycle labels;
  CoverageCycle coverage;
  BoundaryUncertainty uncertainty;
  Belief belief;                                 ///< of the ventricles and the heart
  int end_diastole = 0;                          ///< phase of the largest LV (or heart) volume
  int end_systole = 0;                           ///< phase of the smallest
  std::map<Structure, ValvePlane> valve_planes;  ///< of thick slices alone
  std::optional<LongAxis> axis;                  ///< none without a left ventricle
  std::vector<std::string> warnings;
  std::vector<LeakAlarm> alarms;  ///< that rang, see alarm/alarm.h
};

/// A structure in the workspace on an isotropic lattice, as a level function: negative inside,
/// zero on the surface, close to linear across it, not yet a distance. Grid frame: workspace [mm].
struct ShapeCycle {
  Structure structure{};
  ImageCycle<float> level;
};

/// Signed distance [mm], negative inside, clamped to [-inner_mm, outer_mm], on an isotropic
/// lattice of the workspace [mm] that holds the structure in every phase with a margin.
struct FieldCycle {
  Structure structure{};
  ImageCycle<float> distance_mm;
  double voxel_mm = 0;
  double inner_mm = 0;
  double outer_mm = 0;
  std::vector<double> volume_ml;  ///< enclosed volume of each phase
};

/// One closed surface a phase, one connectivity; workspace [mm]; triangles counter-clockwise
/// seen from outside.
struct SurfaceCycle {
  Structure structure{};
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::vector<Vec3f>> positions;  ///< [phase][vertex]
};

}  // namespace beatlas
