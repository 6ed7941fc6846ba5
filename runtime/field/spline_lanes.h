#pragma once
/// Cubic B-splines on four floats at once: what FieldQuery and ShellQuery share. Not an interface.

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "runtime/field/field_query.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace beatlas::field {

/// GCC and Clang map it to SSE2 or NEON.
using Lanes = float __attribute__((vector_size(16)));

template <int kLane>
Lanes spread(const Lanes& from) noexcept {
  return __builtin_shufflevector(from, from, kLane, kLane, kLane, kLane);
}

inline Lanes load_floats(const float* from) noexcept {
  Lanes out;
  std::memcpy(&out, from, sizeof out);
  return out;
}

/// Weights of the four samples around a place, [tap], in a lane for each axis.
struct TapWeights {
  std::array<Lanes, 4> value;
  std::array<Lanes, 4> slope;  ///< per unit of u

  /// The four taps of one axis side by side.
  template <int kAxis>
  [[nodiscard]] Lanes values() const noexcept {
    return Lanes{value[0][kAxis], value[1][kAxis], value[2][kAxis], value[3][kAxis]};
  }
  template <int kAxis>
  [[nodiscard]] Lanes slopes() const noexcept {
    return Lanes{slope[0][kAxis], slope[1][kAxis], slope[2][kAxis], slope[3][kAxis]};
  }
};

/// Centred cubic B-spline at u + 1, u, u - 1, u - 2 and its derivative, 0 <= u < 1.
inline TapWeights bspline(const Lanes& u) noexcept {
  const Lanes v = 1 - u;
  const Lanes u2 = u * u;
  const Lanes v2 = v * v;
  constexpr float kSixth = 1.0F / 6;
  constexpr float kTwoThirds = 2.0F / 3;
  return {{kSixth * v * v2, kTwoThirds - u2 * (1 - 0.5F * u), kTwoThirds - v2 * (1 - 0.5F * v),
           kSixth * u * u2},
          {-0.5F * v2, u * (1.5F * u - 2), v * (2 - 1.5F * v), 0.5F * u2}};
}

#if defined(__SSE2__)
inline Lanes to_floats(__m128i packed) noexcept {
  return _mm_cvtepi32_ps(_mm_srai_epi32(_mm_unpacklo_epi16(packed, packed), 16));
}
/// Four counts side by side.
inline Lanes load_counts(const std::int16_t* from) noexcept {
  return to_floats(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(from)));
}
/// The last `in_left` (1..3) of four counts, then the first of four others.
inline Lanes load_counts(const std::int16_t* left, const std::int16_t* right,
                         int in_left) noexcept {
  const __m128i a = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(left));
  const __m128i b = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(right));
  return to_floats(_mm_or_si128(_mm_srl_epi64(a, _mm_cvtsi32_si128(16 * (4 - in_left))),
                                _mm_sll_epi64(b, _mm_cvtsi32_si128(16 * in_left))));
}
#else
inline Lanes load_counts(const std::int16_t* from) noexcept {
  return Lanes{static_cast<float>(from[0]), static_cast<float>(from[1]),
               static_cast<float>(from[2]), static_cast<float>(from[3])};
}
inline Lanes load_counts(const std::int16_t* left, const std::int16_t* right,
                         int in_left) noexcept {
  std::array<std::int16_t, 4> joined{};
  for (int n = 0; n < 4; ++n) {
    joined[static_cast<std::size_t>(n)] = n < in_left ? left[4 - in_left + n] : right[n - in_left];
  }
  return load_counts(joined.data());
}
#endif

/// The sums of four vectors, each in its lane.
inline Lanes sums(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d) noexcept {
  const Lanes ab = __builtin_shufflevector(a, b, 0, 4, 1, 5) +
                   __builtin_shufflevector(a, b, 2, 6, 3, 7);  // a0+a2 b0+b2 a1+a3 b1+b3
  const Lanes cd =
      __builtin_shufflevector(c, d, 0, 4, 1, 5) + __builtin_shufflevector(c, d, 2, 6, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

inline float sum(const Lanes& a) noexcept { return (a[0] + a[2]) + (a[1] + a[3]); }

/// Where a point lies in a lattice: its cell, and how far into it, 0..1.
struct Place {
  std::array<int, 3> cell;
  std::array<float, 3> u;
};

/// False for a point that no spline of the lattice reaches, and for what is no number.
inline bool find_place(const atlas::FieldPayload& field, double samples_per_mm, const Vec3& x,
                       Place& place) noexcept {
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    const double g = (x[axis] - field.origin_mm[axis]) * samples_per_mm;
    if (!(g >= -2 && g < field.block_count[a] * atlas::FieldPayload::kBlockEdge + 1)) return false;
    // Without a call into the mathematics library, which plain x86-64 needs for std::floor.
    const int whole = static_cast<int>(g);
    place.cell[a] = static_cast<double>(whole) > g ? whole - 1 : whole;
    place.u[a] = static_cast<float>(g - place.cell[a]);
  }
  return true;
}

/// The spline's sums along y and z of rows along x: each lane a place along x.
struct Contracted {
  Lanes value;    ///< weights along y and z
  Lanes along_y;  ///< slope along y, weight along z
  Lanes along_z;
  Lanes rate;

  /// Sums of the rows of tap z along y: value, its derivative along y, rate.
  void add(const TapWeights& taps, std::size_t z, const Lanes& of_value, const Lanes& of_y,
           const Lanes& of_rate) noexcept {
    const Lanes weight = spread<2>(taps.value[z]);
    value += weight * of_value;
    along_y += weight * of_y;
    along_z += spread<2>(taps.slope[z]) * of_value;
    rate += weight * of_rate;
  }
};

inline FieldSample FieldQuery::Finish::sample(const Contracted& rows,
                                              const TapWeights& taps) const noexcept {
  const Lanes w = taps.values<0>();
  const Lanes all =
      sums(w * rows.value, taps.slopes<0>() * rows.value, w * rows.along_y, w * rows.along_z);
  FieldSample out;
  const double distance = mm * static_cast<double>(all[0]);
  if (!(distance > -inner_mm && distance < outer_mm)) {
    out.distance_mm = distance < 0 ? -inner_mm : outer_mm;
    return out;
  }
  out.distance_mm = distance;
  out.gradient = per_mm * Vec3(static_cast<double>(all[1]), static_cast<double>(all[2]),
                               static_cast<double>(all[3]));
  out.rate_mm_s = mm_s * static_cast<double>(sum(w * rows.rate));
  out.in_band = distance > voxel_mm - inner_mm && distance < outer_mm - voxel_mm;
  return out;
}

}  // namespace beatlas::field
