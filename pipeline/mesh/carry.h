#pragma once
#include <vector>

#include "pipeline/field/interpolant.h"
#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {

/// Moves a mesh from phase to phase. A field says how far the surface moves along its normal and
/// nothing about the way along it; of all ways to reach a phase's surface this takes the one whose
/// displacement from the reference phase changes least over the mesh:
///
///   sum_ij w_ij |u_i - u_j|^2 + stiffness * sum_i w_i (n_i . d_i + phi_i / |grad phi_i|)^2 -> min,
///
/// u the displacement from the reference, d the step, w the cotangent weights of the reference
/// (a membrane), solved by Gauss-Newton steps with conjugate gradients, then put on the zero
/// surface. A base that descends so draws the side wall along with it instead of folding over it.
class Carrier {
 public:
  explicit Carrier(const TriangleMesh& reference);

  /// @param start positions near the phase, for instance of the phase before
  [[nodiscard]] std::vector<Vec3> carry(std::vector<Vec3> start,
                                        const field::Interpolant& phase) const;

 private:
  using Columns = Eigen::Matrix3Xd;

  /// One Gauss-Newton step; returns the longest way a vertex went.
  double step(std::vector<Vec3>& points, const field::Interpolant& phase) const;
  void laplacian(const Columns& x, Columns& out) const;

  std::vector<Vec3> reference_;
  Neighbours neighbours_;
  std::vector<double> total_;  ///< sum of weights at each vertex
};

}  // namespace beatlas::mesh
