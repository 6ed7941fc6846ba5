#pragma once
#include <cstdint>
#include <vector>

#include "pipeline/field/interpolant.h"
#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {

/// Moves a mesh from phase to phase. A field says how far the surface moves along its normal and
/// nothing about the way along it; of all ways to reach a phase's surface this takes the one whose
/// displacement from the reference phase changes least over the mesh:
///
///   sum_ij w_ij |u_i - u_j|^2 + k sum_i c_i w_i (n_i . d_i + phi_i / |grad phi_i|)^2 -> min,
///
/// u the displacement from the reference, d the step, w the cotangent weights of the reference
/// (a membrane), n the field's normal, c how well it agrees with the mesh's own (so that no vertex
/// is drawn to the far side of a thin wall); Gauss-Newton steps with conjugate gradients. A base
/// that descends so draws the side wall along with it instead of folding over it.
class Carrier {
 public:
  explicit Carrier(const TriangleMesh& reference);

  /// From the surface of one phase to that of another. Long ways are gone in parts, over blends of
  /// the two phases' samples, each part about as long as a voxel.
  /// @param start on the surface of `from`; both phases are samples on `grid`
  [[nodiscard]] std::vector<Vec3> carry(std::vector<Vec3> start, const Grid& grid,
                                        const std::vector<float>& from,
                                        const std::vector<float>& to) const;

 private:
  /// A column of four for each vertex, the last one 0: they fill a register. Singles, for what they
  /// lose is far below what conjugate gradients leave.
  using Columns = Eigen::Matrix4Xf;

  /// One Gauss-Newton step; returns the longest way a vertex went.
  /// @param tolerance where conjugate gradients end, of the largest residual of the whole way (its
  ///   square is `most_energy`), so that the last steps, which are short, take few rounds
  double step(std::vector<Vec3>& points, const field::Interpolant& phase, double tolerance,
              double& most_energy) const;
  [[nodiscard]] Eigen::Vector4f laplacian_at(std::size_t vertex, const Columns& x) const;

  struct Link {
    std::uint32_t to = 0;
    float weight = 0;
  };

  std::vector<Vec3> reference_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> first_;  ///< [vertex] of its neighbours
  std::vector<Link> links_;
  std::vector<float> total_;  ///< sum of weights at each vertex
};

}  // namespace beatlas::mesh
