#pragma once
#include <vector>

#include "runtime/field/field_query.h"

namespace beatlas::assess {

/// A point of a field's zero level; workspace [mm].
struct SurfacePoint {
  Vec3 x = Vec3::Zero();
  double area_mm2 = 0;  ///< the piece of surface it stands for
};

/// Points of the zero level at time t: one on every lattice edge whose ends differ in sign, found
/// by the false position with halving. The edges along the three axes cross a piece of surface of
/// area A and normal n (|nx| + |ny| + |nz|) A / h^2 times, hence the area of each.
[[nodiscard]] std::vector<SurfacePoint> zero_level(const field::FieldQuery& query, double t_s);

}  // namespace beatlas::assess
