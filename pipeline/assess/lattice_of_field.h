#pragma once
/// A stored field at the samples of its own lattice, all of a phase at once: what
/// FieldQuery::sample gives there, without looking every sample's neighbours up anew.

#include <vector>

#include "runtime/atlas/payloads.h"
#include "runtime/base/geometry.h"

namespace beatlas::assess {

struct LatticeOfField {
  Index3 size{0, 0, 0};
  std::vector<float> distance_mm;  ///< clamped; x runs fastest
  std::vector<float> slopes;       ///< |gradient| of samples within half a voxel of the surface
};

/// At the samples a cubic B-spline weighs its coefficients 1/6, 4/6, 1/6 along every axis and in
/// time, and its derivative -1/2, 0, 1/2 (Unser, IEEE Signal Processing Magazine 16, 1999).
[[nodiscard]] LatticeOfField lattice_of_field(const atlas::FieldPayload& field, std::size_t phase);

}  // namespace beatlas::assess
