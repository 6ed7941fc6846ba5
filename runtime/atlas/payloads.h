#pragma once
/// What a package's binary payloads decode to. The pipeline's `pack` room fills these, the reader
/// returns them, `runtime/field` and the viewer use them. All positions: workspace frame, [mm].

#include <array>
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
/// and `blocks`. A block is wholly outside, wholly inside or a leaf. In a leaf the active samples
/// have their coefficients of all phases side by side; an inactive one has the same constant
/// coefficient in every phase: +outer_mm / step_mm, or -inner_mm / step_mm where its inside bit
/// is set.
struct FieldPayload {
  static constexpr int kBlockEdge = 8;
  static constexpr int kBlockSamples = 512;
  static constexpr std::int32_t kOutside = -1;
  static constexpr std::int32_t kInside = -2;
  using Mask = std::array<std::uint64_t, 8>;  ///< bit x + 8 y of word z

  struct Leaf {
    Mask active{};
    Mask inside{};                 ///< sign of inactive samples; 0 for active ones
    std::uint32_t first_active{};  ///< rank of this leaf's first active sample
  };

  Structure structure{};
  Vec3 origin_mm = Vec3::Zero();  ///< position of sample (0, 0, 0)
  double voxel_mm = 0;
  Index3 block_count{0, 0, 0};
  int phases = 0;
  double step_mm = 0;   ///< distance of one count
  double inner_mm = 0;  ///< > 0; distances are clamped to [-inner_mm, outer_mm]
  double outer_mm = 0;
  std::vector<std::int32_t> blocks;        ///< kOutside, kInside or an index into `leaves`
  std::vector<Leaf> leaves;                ///< in order of their block
  std::vector<std::int16_t> coefficients;  ///< [active sample in leaf order][phase]
};

/// One closed triangle surface with the same connectivity in every phase; triangles are
/// counter-clockwise seen from outside.
struct SurfacePayload {
  Structure structure{};
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::vector<Vec3f>> positions;  ///< [phase][vertex]
};

}  // namespace beatlas::atlas
