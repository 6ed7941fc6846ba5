/// A field at its own samples, beside the query that a trainer feels it with.
#include "pipeline/assess/lattice_of_field.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "pipeline/pack/pack.h"
#include "runtime/field/field_query.h"

namespace beatlas::assess {
namespace {

/// A ball that grows and moves through six phases, near a side of its lattice.
FieldCycle beating_ball() {
  FieldCycle out;
  out.structure = Structure::Heart;
  out.voxel_mm = 1.5;
  out.inner_mm = 6;
  out.outer_mm = 7.5;
  Grid& grid = out.distance_mm.grid;
  grid.size = {44, 40, 48};
  grid.mm_from_index = Eigen::Translation3d(10, -20, 30) * Eigen::Scaling(out.voxel_mm);
  for (int p = 0; p < 6; ++p) {
    const double beat = std::cos(p * std::acos(-1.0) / 3);
    const Vec3 centre = grid.mm(21 + beat, 19.5, 23 - 2 * beat);
    std::vector<float> distance;
    for (int n = 0; n < 44 * 40 * 48; ++n) {
      const double mm = (grid.mm(n % 44, n / 44 % 40, n / 1760) - centre).norm() - 19 - 2 * beat;
      distance.push_back(static_cast<float>(std::clamp(mm, -out.inner_mm, out.outer_mm)));
    }
    out.distance_mm.phases.push_back(std::move(distance));
    out.volume_ml.push_back(1);
  }
  return out;
}

TEST(LatticeOfField, IsWhatTheQueryGivesAtTheSamples) {
  const auto payload =
      std::make_shared<const atlas::FieldPayload>(pack::stored_field(beating_ball(), {}));
  const field::FieldQuery query(payload, 0.9);
  double worst_mm = 0;
  double worst_slope = 0;
  std::size_t near = 0;
  std::size_t clamped = 0;
  for (std::size_t phase = 0; phase < 6; ++phase) {
    const LatticeOfField lattice = lattice_of_field(*payload, phase);
    std::size_t n = 0;
    std::size_t slope = 0;
    for (int k = 0; k < lattice.size[2]; ++k) {
      for (int j = 0; j < lattice.size[1]; ++j) {
        for (int i = 0; i < lattice.size[0]; ++i, ++n) {
          const field::FieldSample there =
              query.sample(payload->origin_mm + payload->voxel_mm * Vec3(i, j, k),
                           0.9 * static_cast<double>(phase) / 6);
          const double mm = lattice.distance_mm[n];
          worst_mm = std::max(worst_mm, std::abs(mm - there.distance_mm));
          clamped += there.in_band ? 0 : 1;
          if (std::abs(mm) >= 0.5 * payload->voxel_mm) continue;
          ASSERT_LT(slope, lattice.slopes.size());
          worst_slope =
              std::max(worst_slope, std::abs(lattice.slopes[slope++] - there.gradient.norm()));
          ++near;
        }
      }
    }
    EXPECT_EQ(n, lattice.distance_mm.size());
    EXPECT_EQ(slope, lattice.slopes.size());
  }
  EXPECT_GT(near, 10000U);
  EXPECT_GT(clamped, 10000U) << "what is clamped must be tried, too";
  // Both sum up counts of 0.02 mm and less in single precision.
  EXPECT_LT(worst_mm, 1e-4);
  EXPECT_LT(worst_slope, 1e-4);
}

}  // namespace
}  // namespace beatlas::assess
