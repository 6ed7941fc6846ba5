#include "runtime/field/field_query.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "runtime/base/error.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace beatlas::field {
namespace {

using atlas::FieldPayload;

// Four consecutive phases of one sample; GCC and Clang map it to SSE2 or NEON.
using Phases4 = float __attribute__((vector_size(16)));

constexpr double kShortestDirection = 0.05;  // |gradient|; about 1 wherever there is one surface
constexpr int kEdge = FieldPayload::kBlockEdge;

struct Weights {
  std::array<double, 4> value;
  std::array<double, 4> slope;  // per unit of u
};

// Centred cubic B-spline at u + 1, u, u - 1, u - 2 and its derivative, 0 <= u < 1.
Weights bspline(double u) {
  const double v = 1 - u;
  const double u2 = u * u;
  const double v2 = v * v;
  return {{v * v2 / 6, 2.0 / 3 - u2 * (1 - 0.5 * u), 2.0 / 3 - v2 * (1 - 0.5 * v), u * u2 / 6},
          {-0.5 * v2, u * (1.5 * u - 2), v * (2 - 1.5 * v), 0.5 * u2}};
}

// The four phases around a time, as indices; most often they lie side by side.
struct PhaseWindow {
  std::array<int, 4> index;
  bool adjacent;
};

PhaseWindow phase_window(int n, int phases) {
  PhaseWindow window{};
  for (int a = 0; a < 4; ++a) {
    window.index[static_cast<std::size_t>(a)] = (n + a - 1 + phases) % phases;
  }
  window.adjacent = n >= 1 && n + 2 < phases;
  return window;
}

Phases4 load_adjacent(const std::int16_t* from) {
#if defined(__SSE2__)
  const __m128i packed = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(from));
  return _mm_cvtepi32_ps(_mm_srai_epi32(_mm_unpacklo_epi16(packed, packed), 16));
#else
  return Phases4{static_cast<float>(from[0]), static_cast<float>(from[1]),
                 static_cast<float>(from[2]), static_cast<float>(from[3])};
#endif
}

Phases4 load(const std::int16_t* sample, const PhaseWindow& window) {
  if (window.adjacent) return load_adjacent(sample + window.index[0]);
  std::array<std::int16_t, 4> wrapped{};
  for (std::size_t a = 0; a < 4; ++a) wrapped[a] = sample[window.index[a]];
  return load_adjacent(wrapped.data());
}

Phases4 constant(float value) { return Phases4{value, value, value, value}; }

int popcount8(unsigned bits) { return std::popcount(static_cast<std::uint8_t>(bits)); }

// The part of the four support samples of one axis that lies in one block.
struct Span {
  int block;
  int local;  // first sample within the block
  int at;     // its place among the four
  int count;
};

// first >= -3: rounds towards lower blocks.
std::array<Span, 2> spans(int first) {
  const int block = (first + kEdge) / kEdge - 1;
  const int local = first - block * kEdge;
  const int count = std::min(4, kEdge - local);
  return {{{block, local, 0, count}, {block + 1, 0, count, 4 - count}}};
}

double dot(const std::array<double, 4>& weights, const Phases4& lanes) {
  return (weights[0] * static_cast<double>(lanes[0]) + weights[1] * static_cast<double>(lanes[1])) +
         (weights[2] * static_cast<double>(lanes[2]) + weights[3] * static_cast<double>(lanes[3]));
}

}  // namespace

FieldQuery::FieldQuery(std::shared_ptr<const FieldPayload> payload, double rr_interval_s)
    : payload_(std::move(payload)), rr_interval_s_(rr_interval_s) {
  if (!payload_) throw_invalid("there is no distance field to query; open the atlas with it");
  if (!(rr_interval_s > 0) || !std::isfinite(rr_interval_s)) {
    throw_invalid("the R-R interval of a distance field must be a positive number of seconds");
  }
  phases_per_s_ = payload_->phases / rr_interval_s_;
  samples_per_mm_ = 1 / payload_->voxel_mm;
  row_ranks_.resize(payload_->leaves.size());
  for (std::size_t l = 0; l < row_ranks_.size(); ++l) {
    int rank = 0;
    for (unsigned row = 0; row < 64; ++row) {
      row_ranks_[l][row] = static_cast<std::uint16_t>(rank);
      rank += popcount8(
          static_cast<unsigned>(payload_->leaves[l].active[row / 8] >> (8 * (row % 8)) & 0xFFU));
    }
  }
  find_centre();
}

void FieldQuery::find_centre() {
  const FieldPayload& field = *payload_;
  Vec3 sum = Vec3::Zero();
  double weight = 0;
  const auto add = [&](const Vec3& index, double share) {
    sum += share * index;
    weight += share;
  };
  std::size_t block = 0;
  for (int bz = 0; bz < field.block_count[2]; ++bz) {
    for (int by = 0; by < field.block_count[1]; ++by) {
      for (int bx = 0; bx < field.block_count[0]; ++bx, ++block) {
        const Vec3 first = kEdge * Vec3(bx, by, bz);
        const std::int32_t entry = field.blocks[block];
        if (entry == FieldPayload::kInside) {
          add(first + Vec3::Constant(0.5 * (kEdge - 1)), FieldPayload::kBlockSamples);
        }
        if (entry < 0) continue;
        const FieldPayload::Leaf& leaf = field.leaves[static_cast<std::size_t>(entry)];
        const std::int16_t* coefficients =
            field.coefficients.data() +
            static_cast<std::size_t>(leaf.first_active) * static_cast<std::size_t>(field.phases);
        for (int s = 0; s < FieldPayload::kBlockSamples; ++s) {
          const auto word = static_cast<std::size_t>(s / 64);
          const std::uint64_t bit = std::uint64_t{1} << (s % 64);
          const Vec3 index = first + Vec3(s % 8, s / 8 % 8, s / 64);
          if ((leaf.active[word] & bit) != 0) {
            const auto inside = std::count_if(coefficients, coefficients + field.phases,
                                              [](std::int16_t c) { return c < 0; });
            if (inside > 0) add(index, static_cast<double>(inside) / field.phases);
            coefficients += field.phases;
          } else if ((leaf.inside[word] & bit) != 0) {
            add(index, 1);
          }
        }
      }
    }
  }
  const Index3& blocks = field.block_count;
  if (!(weight > 0)) add(0.5 * kEdge * Vec3(blocks[0], blocks[1], blocks[2]), 1);
  centre_mm_ = field.origin_mm + field.voxel_mm / weight * sum;
}

FieldSample FieldQuery::sample(const Vec3& x, double t) const noexcept {
  const FieldPayload& field = *payload_;
  FieldSample out;
  out.distance_mm = field.outer_mm;

  // Place in the lattice; the comparisons also turn away what is no number.
  std::array<Weights, 3> space{};
  std::array<std::array<Span, 2>, 3> span{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double g =
        (x[static_cast<Eigen::Index>(a)] - field.origin_mm[static_cast<Eigen::Index>(a)]) *
        samples_per_mm_;
    if (!(g >= -2 && g < field.block_count[a] * kEdge + 1)) return out;
    const double cell = std::floor(g);
    space[a] = bspline(g - cell);
    span[a] = spans(static_cast<int>(cell) - 1);
  }
  const double beats = t / rr_interval_s_;
  if (!std::isfinite(beats)) return out;
  const double s = (beats - std::floor(beats)) * field.phases;
  const double phase = std::min(std::floor(s), field.phases - 1.0);
  const Weights time = bspline(s - phase);
  const PhaseWindow window = phase_window(static_cast<int>(phase), field.phases);

  // Gather the 64 support samples, z slowest.
  const auto outside = static_cast<float>(field.outer_mm / field.step_mm);
  const auto inside = static_cast<float>(-field.inner_mm / field.step_mm);
  std::array<Phases4, 64> c;
  bool some_outside = false;
  bool some_inside = false;
  bool some_active = false;
  for (const Span& sz : span[2]) {
    for (const Span& sy : span[1]) {
      for (const Span& sx : span[0]) {
        if (sz.count == 0 || sy.count == 0 || sx.count == 0) continue;
        std::int32_t entry = FieldPayload::kOutside;
        if (sx.block >= 0 && sx.block < field.block_count[0] && sy.block >= 0 &&
            sy.block < field.block_count[1] && sz.block >= 0 && sz.block < field.block_count[2]) {
          const auto at = [](int n) { return static_cast<std::size_t>(n); };
          entry = field.blocks[at(sx.block) +
                               at(field.block_count[0]) *
                                   (at(sy.block) + at(field.block_count[1]) * at(sz.block))];
        }
        for (int z = 0; z < sz.count; ++z) {
          for (int y = 0; y < sy.count; ++y) {
            Phases4* to = &c[static_cast<std::size_t>(((sz.at + z) * 4 + sy.at + y) * 4 + sx.at)];
            if (entry < 0) {
              const bool is_inside = entry == FieldPayload::kInside;
              (is_inside ? some_inside : some_outside) = true;
              const Phases4 value = constant(is_inside ? inside : outside);
              for (int i = 0; i < sx.count; ++i) to[i] = value;
              continue;
            }
            const auto l = static_cast<std::size_t>(entry);
            const FieldPayload::Leaf& leaf = field.leaves[l];
            const auto word = static_cast<std::size_t>(sz.local + z);
            const int row = sy.local + y;
            const auto active = static_cast<unsigned>(leaf.active[word] >> (8 * row) & 0xFFU);
            const unsigned before = active & ((1U << sx.local) - 1U);
            const int skipped = before == (1U << sx.local) - 1U ? sx.local : popcount8(before);
            const std::int16_t* from = field.coefficients.data() +
                                       (static_cast<std::size_t>(leaf.first_active) +
                                        row_ranks_[l][word * 8 + static_cast<std::size_t>(row)] +
                                        static_cast<std::size_t>(skipped)) *
                                           static_cast<std::size_t>(field.phases);
            for (int i = 0; i < sx.count; ++i) {
              const unsigned bit = 1U << (sx.local + i);
              if ((active & bit) != 0) {
                to[i] = load(from, window);
                from += field.phases;
                some_active = true;
              } else {
                const bool is_inside = (leaf.inside[word] >> (8 * row) & bit) != 0;
                (is_inside ? some_inside : some_outside) = true;
                to[i] = constant(is_inside ? inside : outside);
              }
            }
          }
        }
      }
    }
  }

  if (!some_active && some_inside != some_outside) {  // exactly the clamp, not a rounded sum
    if (some_inside) out.distance_mm = -field.inner_mm;
    return out;
  }

  // Contract along y and z with the four phases side by side, then along x, then in time.
  std::array<Phases4, 4> value{};
  std::array<Phases4, 4> along_y{};
  std::array<Phases4, 4> along_z{};
  for (std::size_t z = 0; z < 4; ++z) {
    std::array<Phases4, 4> plane{};
    std::array<Phases4, 4> plane_y{};
    for (std::size_t y = 0; y < 4; ++y) {
      const auto w = static_cast<float>(space[1].value[y]);
      const auto d = static_cast<float>(space[1].slope[y]);
      for (std::size_t i = 0; i < 4; ++i) {
        const Phases4& sample = c[(z * 4 + y) * 4 + i];
        plane[i] += w * sample;
        plane_y[i] += d * sample;
      }
    }
    const auto w = static_cast<float>(space[2].value[z]);
    const auto d = static_cast<float>(space[2].slope[z]);
    for (std::size_t i = 0; i < 4; ++i) {
      value[i] += w * plane[i];
      along_y[i] += w * plane_y[i];
      along_z[i] += d * plane[i];
    }
  }
  Phases4 phi{};
  Phases4 phi_x{};
  Phases4 phi_y{};
  Phases4 phi_z{};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto w = static_cast<float>(space[0].value[i]);
    const auto d = static_cast<float>(space[0].slope[i]);
    phi += w * value[i];
    phi_x += d * value[i];
    phi_y += w * along_y[i];
    phi_z += w * along_z[i];
  }
  const double distance = field.step_mm * dot(time.value, phi);
  if (!(distance > -field.inner_mm && distance < field.outer_mm)) {
    out.distance_mm = distance < 0 ? -field.inner_mm : field.outer_mm;
    return out;
  }
  out.distance_mm = distance;
  const double per_mm = field.step_mm * samples_per_mm_;
  out.gradient =
      per_mm * Vec3(dot(time.value, phi_x), dot(time.value, phi_y), dot(time.value, phi_z));
  out.rate_mm_s = field.step_mm * phases_per_s_ * dot(time.slope, phi);
  out.in_band =
      distance > field.voxel_mm - field.inner_mm && distance < field.outer_mm - field.voxel_mm;
  return out;
}

Vec3 FieldQuery::normal(const FieldSample& at_x, const Vec3& x) const noexcept {
  const double length = at_x.gradient.norm();
  if (length >= kShortestDirection) return at_x.gradient / length;
  const Vec3 away = x - centre_mm_;
  const double distance = away.norm();
  return distance > 0 && std::isfinite(distance) ? Vec3(away / distance) : Vec3::Zero();
}

double FieldQuery::normal_velocity_mm_s(const FieldSample& sample) noexcept {
  const double length = sample.gradient.norm();
  return length >= kShortestDirection ? -sample.rate_mm_s / length : 0;
}

}  // namespace beatlas::field
