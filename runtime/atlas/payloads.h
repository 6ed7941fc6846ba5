#pragma once
/// What a package's binary payloads decode to. The pipeline's `pack` room fills these, the reader
/// returns them, `runtime/field` and the viewer use them. All positions: workspace frame, [mm].

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/atlas/structures.h"
#include "runtime/base/geometry.h"

namespace beatlas::atlas {

/// Signed distance of one structure (negative inside) over the cycle, as coefficients of a
/// tensor product of cubic B-splines: three in space, one periodic in time.
///
///   phi(x, t) = step_mm * sum_{a,p} c[i+a][n+p] B(u_a) B(v_p),  B the centred cubic B-spline,
///
/// where (x - origin_mm) / voxel_mm = i + u, and t / rr * phases = n + v, phase index modulo
/// `phases`. Coefficients are prefiltered, so phi interpolates the sampled distance.
///
/// Layout: the grid is `block_count` blocks of 8 x 8 x 8 samples, x fastest in blocks, samples
/// and `blocks`. A block is wholly outside, wholly inside or a leaf. A leaf has the coefficients of
/// all its samples, in which the eight samples of a row along x lie side by side, row after row the
/// phases, so that one look-up of a row serves every phase: [leaf][z][y][phase][x]. Every
/// coefficient of another block is `clamp_count`, just beyond the clamp.
struct FieldPayload {
  static constexpr int kBlockEdge = 8;
  static constexpr int kBlockSamples = 512;
  static constexpr std::int32_t kOutside = -1;
  static constexpr std::int32_t kInside = -2;

  Structure structure{};
  Vec3 origin_mm = Vec3::Zero();  ///< position of sample (0, 0, 0)
  double voxel_mm = 0;
  Index3 block_count{0, 0, 0};
  int phases = 0;
  double step_mm = 0;   ///< distance of one count
  double inner_mm = 0;  ///< > 0; distances are clamped to [-inner_mm, outer_mm]
  double outer_mm = 0;
  std::vector<std::int32_t> blocks;        ///< kOutside, kInside or the leaf's number, 0, 1, ...
  std::vector<std::int16_t> coefficients;  ///< [leaf][z][y][phase][x]

  [[nodiscard]] std::size_t leaf_count() const noexcept {
    return coefficients.size() / (std::size_t{kBlockSamples} * static_cast<std::size_t>(phases));
  }
  /// Where a leaf's row along x begins in `coefficients`; the row's next phase is kBlockEdge on.
  [[nodiscard]] std::size_t row_at(std::int32_t leaf, int y, int z) const noexcept {
    constexpr std::size_t kEdge = kBlockEdge;
    return ((static_cast<std::size_t>(leaf) * kEdge + static_cast<std::size_t>(z)) * kEdge +
            static_cast<std::size_t>(y)) *
           kEdge * static_cast<std::size_t>(phases);
  }
  /// The coefficient of every sample of a block without a leaf: one to two counts beyond the clamp,
  /// so that a rounded sum of such is clamped too.
  [[nodiscard]] std::int16_t clamp_count(bool inside) const noexcept {
    const double count = std::floor((inside ? inner_mm : outer_mm) / step_mm) + 2;
    const double most = std::min(count, 32767.0);
    return static_cast<std::int16_t>(inside ? -most : most);
  }
};

/// One closed triangle surface with the same connectivity in every phase; triangles are
/// counter-clockwise seen from outside. Levels of detail are surfaces of their own: each has its
/// own vertices, and they move with the same muscle.
struct SurfacePayload {
  Structure structure{};
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::vector<Vec3f>> positions;  ///< [phase][vertex]
  int level = 0;  ///< of Manifest::surface_edges_mm: 0 the finest, 1 the next coarser, ...
};

/// What the vertices of a surface on a ventricle's wall are called, and how thick the wall is
/// there. Names belong to the muscle: they are those of the first phase and stay with the vertex.
struct SurfaceMapPayload {
  Structure structure{};
  std::vector<float> long_axis;  ///< [vertex] 0 at the wall's apical end .. 1 at the base plane
  /// [vertex] about the long axis, 0 in the middle of the anterior wall, towards the septum,
  /// 0..2 pi
  std::vector<float> angle_rad;
  std::vector<std::uint8_t> segment;  ///< [vertex] 1..17 (Cerqueira et al., AHA 2002), 0 on the RV
  /// [phase][vertex] [mm] from endocardium to epicardium along the endocardium's normal; 0: there
  /// is no wall, as on the flat base. On the RV that of the free wall; 0 also where the images do
  /// not resolve it, so that what is told is of its thicker part.
  std::vector<std::vector<float>> thickness_mm;
  int level = 0;  ///< of the surface that it is a map of
};

/// Intensities of the source's images around the heart, on their own lattice and at their phases,
/// for drawing; what the images hold below their noise is left out. volume.h gives images of it.
///
/// Blocks of 8 x 8 x 8 samples, x fastest in blocks and samples; the last along an axis may reach
/// beyond `size`. counts lie as a field's coefficients: [block][z][y][phase][x].
struct VolumePayload {
  static constexpr int kBlockEdge = FieldPayload::kBlockEdge;

  Index3 size{0, 0, 0};                              ///< samples along x, y, z
  Affine workspace_from_index = Affine::Identity();  ///< centre of a sample -> workspace [mm]
  int phases = 0;
  double offset = 0;  ///< intensity = offset + step * count
  double step = 0;
  double noise = 0;  ///< standard deviation of the images' noise, as estimated when packed
  std::vector<std::int16_t> counts;

  [[nodiscard]] int block_count(std::size_t axis) const noexcept {
    return (size[axis] + kBlockEdge - 1) / kBlockEdge;
  }
  [[nodiscard]] std::size_t sample_count() const noexcept {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]);
  }
  /// Where a block's row along x begins in `counts`; the row's next phase is kBlockEdge on.
  [[nodiscard]] std::size_t row_at(int block_x, int y, int z) const noexcept {
    constexpr std::size_t kEdge = kBlockEdge;
    const auto n = [](int value) { return static_cast<std::size_t>(value); };
    const std::size_t block =
        n(block_x) + n(block_count(0)) * (n(y) / kEdge + n(block_count(1)) * (n(z) / kEdge));
    return ((block * kEdge + n(z) % kEdge) * kEdge + n(y) % kEdge) * kEdge * n(phases);
  }
};

}  // namespace beatlas::atlas
