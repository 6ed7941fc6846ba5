#pragma once
/// Sub-voxel edges: how much of a voxel at a boundary lies inside, from the intensities on its
/// two sides.

#include <vector>

#include "pipeline/core/shapes.h"

namespace beatlas::edges {

/// A structure's boundary in one phase.
struct Boundary {
  std::vector<float> coverage;        ///< 0..1 of each voxel; 0.5 lies on the boundary
  std::vector<BoundaryPoint> points;  ///< in voxels that the boundary crosses in plane, ascending
};

struct BoundaryInput {
  const Grid& grid;
  const std::vector<float>& image;
  const std::vector<std::uint8_t>& inside;  ///< 1 in the structure
  /// Voxels inside that may tell the inner level, and any that may tell the outer one outside:
  /// under an outer surface only muscle, beside a cavity only its wall. Where one has none nearby,
  /// others must do.
  const std::vector<std::uint8_t>& tells_inner;
  const std::vector<std::uint8_t>& tells_outer;
  /// Voxels inside that tell the inner level where they come to the surface themselves: blood at a
  /// heart's open base has no wall before it. May be null.
  const std::vector<std::uint8_t>* bare = nullptr;
  /// Whether muscle may lie inside that counts as inside: trabeculae of a cavity.
  bool trabeculated = false;
  /// Whether what lies along its outside may look like inside: pericardium, fat's dark rim.
  bool rimmed = false;
  double contrast = 0;  ///< least difference of the two levels that is trusted
  double noise = 0;     ///< standard deviation of the intensities where they are not dark
};

/// Intensities are magnitudes, see magnitude.h. In slices thinner than kThickSlicesMm a voxel holds
/// a mean over as much as the outline moves from slice to slice, and so does coverage.
/// Trabeculae count as cavity, and half-way between blood and wall lies among them: how much of
/// them an outline takes in is a convention that no edge tells. Labels follow it in the mean. So of
/// the mean shift inward of a cavity's outlines, all slices together, only that part counts which
/// is likelier an error of the labels than trabeculae: s^2 / (s^2 + t^2), with the labels' error s
/// and the thickness t that the muscle inside had, were it packed against the wall.
/// Pericardium and, in images of water and fat out of phase, a line as dark as muscle lie along the
/// outside of the LV's wall, so that its edges lie outward. Labels tell how large such a rimmed
/// structure is, all slices together, and edges tell its shape: the mean shift by edges is taken
/// back, also where no edge tells the place.
/// Where levels do not differ the boundary runs between the voxels, smoothed.
/// A point's standard deviation is that of the shift by which intensities moved the outline there:
/// the image's noise, carried through that shift (it averages along the outline, so it lies below
/// the limit of a single profile, sqrt(2 sqrt(pi) s p) / CNR, by the root of their number), and how
/// badly one edge between two levels fits what is seen; times what a way in plane is along the
/// surface's normal. Where nothing but the labels tells the place, half of the most that
/// intensities may move them.
[[nodiscard]] Boundary find_boundary(const BoundaryInput& input);

/// The same from the mask alone: coverage of its outline, smoothed in plane.
[[nodiscard]] std::vector<float> outline_coverage(const Grid& grid,
                                                  const std::vector<std::uint8_t>& inside);

}  // namespace beatlas::edges
