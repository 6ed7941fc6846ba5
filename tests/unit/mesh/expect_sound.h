#pragma once
#include <string>

#include <gtest/gtest.h>

#include "pipeline/mesh/mesh.h"

namespace beatlas::mesh {

/// What every surface must be, whatever its shape.
inline void expect_sound(const SurfaceCycle& surface) {
  const MeshQuality quality = measure_quality(surface);
  EXPECT_TRUE(quality.closed_manifold);
  EXPECT_EQ(quality.euler_number, 2);
  for (std::size_t p = 0; p < quality.phases.size(); ++p) {
    SCOPED_TRACE("phase " + std::to_string(p));
    EXPECT_EQ(quality.phases[p].flipped_triangles, 0);
    EXPECT_EQ(quality.phases[p].self_intersections, 0);
    EXPECT_GT(quality.phases[p].percentile_1_angle_deg, 20.0);
    EXPECT_GT(quality.phases[p].least_angle_deg, 10.0);
    EXPECT_GT(quality.phases[p].volume_ml, 0.0);
  }
}

}  // namespace beatlas::mesh
