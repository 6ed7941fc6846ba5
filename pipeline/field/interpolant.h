#pragma once
#include <span>

#include "pipeline/core/grid.h"

namespace beatlas::field {

/// Reads a lattice of samples between its nodes: tensor product of cubic convolution
/// (pipeline/core/cubic_convolution.h). Beyond the lattice the border's value goes
/// on. Looks at the samples it is given and owns nothing; safe to use from several threads.
class Interpolant {
 public:
  struct Sample {
    double value = 0;
    Vec3 gradient = Vec3::Zero();  ///< per [mm] of the grid's frame
  };

  /// @pre samples.size() == grid.count(); the grid's map is invertible.
  Interpolant(const Grid& grid, std::span<const float> samples);

  /// @param mm position in the grid's frame
  [[nodiscard]] double value(const Vec3& mm) const noexcept;
  [[nodiscard]] Sample sample(const Vec3& mm) const noexcept;

  /// Walks from `mm` to the zero surface along the gradient (Newton's method), in steps of at most
  /// `max_step_mm`. Stops early where the gradient vanishes. At creases it may end off the surface;
  /// the caller looks at value().
  [[nodiscard]] Vec3 project_to_zero(const Vec3& mm, double max_step_mm) const noexcept;

 private:
  Grid grid_;
  std::span<const float> samples_;
  Affine index_from_mm_;
  Eigen::Matrix3d gradient_from_index_;
};

}  // namespace beatlas::field
