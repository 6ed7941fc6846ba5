#include "runtime/atlas/field_transform.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace beatlas::atlas {
namespace {

constexpr std::size_t kEdge = FieldPayload::kBlockEdge;

std::size_t at(int n) { return static_cast<std::size_t>(n); }

double kept(double cosine) { return (2 + cosine) / 3; }

// GCC and Clang map it to SSE2 or NEON.
using Lanes = float __attribute__((vector_size(16)));

Lanes load(const float* from) noexcept {
  Lanes out;
  std::memcpy(&out, from, sizeof out);
  return out;
}
void store(float* to, const Lanes& lanes) noexcept { std::memcpy(to, &lanes, sizeof lanes); }

/// Along an axis of which samples are kStride apart, for all kStride lines side by side. Even
/// frequencies are symmetric about the middle, odd ones antisymmetric.
template <std::size_t kStride>
void inverse_lines(float* data, const std::array<float, 64>& cosines) noexcept {
  for (std::size_t line = 0; line < kStride; line += 4) {
    std::array<Lanes, kEdge> in;
    for (std::size_t k = 0; k < kEdge; ++k) in[k] = load(data + k * kStride + line);
    for (std::size_t n = 0; n < kEdge / 2; ++n) {
      const float* c = cosines.data() + n;
      const Lanes even = (c[0] * in[0] + c[16] * in[2]) + (c[32] * in[4] + c[48] * in[6]);
      const Lanes odd = (c[8] * in[1] + c[24] * in[3]) + (c[40] * in[5] + c[56] * in[7]);
      store(data + n * kStride + line, even + odd);
      store(data + (kEdge - 1 - n) * kStride + line, even - odd);
    }
  }
}

/// Along the rows, after scaling each term.
void inverse_rows(float* data, float scale, const std::array<float, 512>& scales,
                  const std::array<float, 64>& cosines) noexcept {
  std::array<Lanes, kEdge> first;  // samples 0..3 of each cosine
  for (std::size_t k = 0; k < kEdge; ++k) first[k] = load(cosines.data() + kEdge * k);
  for (std::size_t row = 0; row < 512; row += kEdge) {
    const Lanes a = load(data + row) * (scale * load(scales.data() + row));
    const Lanes b = load(data + row + 4) * (scale * load(scales.data() + row + 4));
    const Lanes even = (a[0] * first[0] + a[2] * first[2]) + (b[0] * first[4] + b[2] * first[6]);
    const Lanes odd = (a[1] * first[1] + a[3] * first[3]) + (b[1] * first[5] + b[3] * first[7]);
    store(data + row, even + odd);
    const Lanes rest = even - odd;
    store(data + row + 4, __builtin_shufflevector(rest, rest, 3, 2, 1, 0));
  }
}

/// Rounded to the nearest and held within 16 bits.
void store_counts(std::int16_t* to, Lanes a, Lanes b) noexcept {
  constexpr float kMost = 32767;
#if defined(__SSE2__)
  const __m128 low = _mm_set1_ps(-kMost);
  const __m128 high = _mm_set1_ps(kMost);
  const __m128i counts = _mm_packs_epi32(_mm_cvtps_epi32(_mm_max_ps(low, _mm_min_ps(high, a))),
                                         _mm_cvtps_epi32(_mm_max_ps(low, _mm_min_ps(high, b))));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), counts);
#else
  for (int n = 0; n < 4; ++n) {
    to[n] = static_cast<std::int16_t>(std::lrint(std::clamp(a[n], -kMost, kMost)));
    to[n + 4] = static_cast<std::int16_t>(std::lrint(std::clamp(b[n], -kMost, kMost)));
  }
#endif
}

}  // namespace

LeafTransform::LeafTransform(int phases, Of of) : phases_(phases) {
  const auto scale_of = [of](double share) { return of == Of::Spline ? 1 / share : 1.0; };
  weights_ = cycle_modes(phases);
  mode_scales_.resize(at(phases));
  for (int m = 0; m < phases; ++m) {
    mode_scales_[at(m)] = static_cast<float>(scale_of(kept(cosine_of_turn(frequency(m), phases))));
  }
  phase_weights_.resize(weights_.size());
  for (int m = 0; m < phases; ++m) {
    for (int p = 0; p < phases; ++p) {
      phase_weights_[at(p * phases + m)] = static_cast<float>(weight(m, p));
    }
  }
  for (int k = 0; k < 8; ++k) {
    for (int s = 0; s < 8; ++s) {
      cosines_[at(8 * k + s)] =
          (k == 0 ? std::sqrt(0.125) : 0.5) * cosine_of_turn(k * (2 * s + 1), 32);
      cosines_f_[at(8 * k + s)] = static_cast<float>(cosines_[at(8 * k + s)]);
    }
  }
  std::iota(order_.begin(), order_.end(), std::uint16_t{0});
  const auto key = [](int place) {
    const int i = place % 8;
    const int j = place / 8 % 8;
    const int l = place / 64;
    return 1000 * (i + j + l) + i * i + j * j + l * l;
  };
  std::stable_sort(order_.begin(), order_.end(), [&](int a, int b) { return key(a) < key(b); });
  for (int rank = 0; rank < kSamples; ++rank) {
    const int place = order_[at(rank)];
    const double share = kept(cosine_of_turn(place % 8, 16)) *
                         kept(cosine_of_turn(place / 8 % 8, 16)) *
                         kept(cosine_of_turn(place / 64, 16));
    place_scales_[at(rank)] = static_cast<float>(scale_of(share));
    scales_[at(place)] = place_scales_[at(rank)];
  }
}

LeafTransform::Inverse::Inverse(const LeafTransform& transform)
    : transform_(&transform),
      terms_(at(transform.phases_) * kSamples),
      used_(at(transform.phases_)) {
  cosine_.reserve(used_.size());
  sine_.reserve(used_.size());
}

void LeafTransform::Inverse::clear() noexcept {
  for (std::size_t m = 0; m < used_.size(); ++m) {
    if (used_[m] == 0) continue;
    std::fill_n(terms_.begin() + static_cast<std::ptrdiff_t>(m * kSamples), kSamples, 0.0F);
    used_[m] = 0;
  }
}

void LeafTransform::Inverse::to_coefficients(float quantum, std::int16_t* to) noexcept {
  const LeafTransform& transform = *transform_;
  const std::size_t phases = at(transform.phases_);
  cosine_.clear();
  sine_.clear();
  for (std::size_t m = 0; m < phases; ++m) {
    if (used_[m] == 0) continue;
    (m % 2 == 1 || m == 0 ? cosine_ : sine_).push_back(m * kSamples);
    float* mode = terms_.data() + m * kSamples;
    inverse_rows(mode, quantum * transform.mode_scales_[m], transform.scales_,
                 transform.cosines_f_);
    for (std::size_t z = 0; z < kEdge; ++z) inverse_lines<8>(mode + 64 * z, transform.cosines_f_);
    inverse_lines<64>(mode, transform.cosines_f_);
  }
  // Cosines are the same at phases p and n - p, sines the opposite. Two rows at once.
  const std::size_t row_size = kEdge * phases;
  for (std::size_t row = 0; row < 64; row += 2, to += 2 * row_size) {
    const float* modes = terms_.data() + kEdge * row;
    for (std::size_t p = 0; 2 * p <= phases; ++p) {
      const float* weights = transform.phase_weights_.data() + p * phases;
      const auto sum = [&](const std::vector<std::size_t>& of) {
        std::array<Lanes, 4> out{};
        for (const std::size_t mode : of) {
          const float weight = weights[mode / kSamples];
          out[0] += weight * load(modes + mode);
          out[1] += weight * load(modes + mode + 4);
          out[2] += weight * load(modes + mode + 8);
          out[3] += weight * load(modes + mode + 12);
        }
        return out;
      };
      const std::array<Lanes, 4> even = sum(cosine_);
      const std::array<Lanes, 4> odd = sum(sine_);
      std::int16_t* phase = to + kEdge * p;
      store_counts(phase, even[0] + odd[0], even[1] + odd[1]);
      store_counts(phase + row_size, even[2] + odd[2], even[3] + odd[3]);
      if (p == 0 || 2 * p == phases) continue;
      phase = to + kEdge * (phases - p);
      store_counts(phase, even[0] - odd[0], even[1] - odd[1]);
      store_counts(phase + row_size, even[2] - odd[2], even[3] - odd[3]);
    }
  }
}

}  // namespace beatlas::atlas
