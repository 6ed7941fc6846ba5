#include "runtime/field/field_query.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/field/blocks.h"
#include "runtime/field/spline_lanes.h"

namespace beatlas::field {
namespace {

using atlas::FieldPayload;

constexpr double kShortestDirection = 0.05;  // |gradient|; about 1 wherever there is one surface

double share_of_beat(double beats) {
  constexpr double kExact = 9e15;  // beyond, a double has no fraction
  if (!(std::abs(beats) < kExact)) return 0;
  const auto whole = static_cast<double>(static_cast<std::int64_t>(beats));
  return whole > beats ? beats - whole + 1 : beats - whole;
}

// Sum of places [samples], each with its share, for their centroid.
struct WeightedSum {
  Vec3 sum = Vec3::Zero();
  double weight = 0;

  void add(const Vec3& index, double share) {
    sum += share * index;
    weight += share;
  }
};

// Of each sample of a row, at how many phases it is inside.
std::array<int, kEdge> phases_inside(const std::int16_t* row, int phases) {
  std::array<int, kEdge> inside{};
  for (int p = 0; p < phases; ++p, row += kEdge) {
    for (std::size_t x = 0; x < inside.size(); ++x) inside[x] += row[x] < 0 ? 1 : 0;
  }
  return inside;
}

// Adds the samples inside of the leaf that begins at sample `first`, by their share of the cycle.
void add_leaf(const FieldPayload& field, std::int32_t entry, const Vec3& first, WeightedSum& to) {
  for (int row = 0; row < kEdge * kEdge; ++row) {
    const int y = row % kEdge;
    const int z = row / kEdge;
    const std::array<int, kEdge> inside =
        phases_inside(field.coefficients.data() + field.row_at(entry, y, z), field.phases);
    for (int x = 0; x < kEdge; ++x) {
      if (inside[at(x)] == 0) continue;
      to.add(first + Vec3(x, y, z), static_cast<double>(inside[at(x)]) / field.phases);
    }
  }
}

// The four samples of a row's support, one lane each, at four phases in turn.
template <bool kSplit>
struct Row {
  const std::int16_t* left;
  const std::int16_t* right;  // the block beyond, if the support is split
  int in_left;

  [[nodiscard]] Lanes at_phase(std::size_t offset) const {
    if constexpr (kSplit) return load_counts(left + offset, right + offset, in_left);
    return load_counts(left + offset);
  }
};

}  // namespace

// Where the support of a place and time begins.
struct FieldQuery::Support {
  std::array<int, 3> local;                 // first sample, within its block
  std::array<const std::int16_t*, 8> base;  // of the blocks of its corners, x fastest
  const PhaseWindow* window;
  std::size_t row;  // counts from row to row
};

FieldQuery::FieldQuery(std::shared_ptr<const FieldPayload> payload, double rr_interval_s)
    : payload_(std::move(payload)), rr_interval_s_(rr_interval_s) {
  if (!payload_) throw_invalid("there is no distance field to query; open the atlas with it");
  if (!(rr_interval_s > 0) || !std::isfinite(rr_interval_s)) {
    throw_invalid("the R-R interval of a distance field must be a positive number of seconds");
  }
  beats_per_s_ = 1 / rr_interval_s_;
  phases_per_s_ = payload_->phases / rr_interval_s_;
  samples_per_mm_ = 1 / payload_->voxel_mm;
  finish_ = {payload_->step_mm,
             payload_->step_mm * samples_per_mm_,
             payload_->step_mm * phases_per_s_,
             payload_->inner_mm,
             payload_->outer_mm,
             payload_->voxel_mm};
  leaf_size_ = at(FieldPayload::kBlockSamples) * at(payload_->phases);
  outside_.assign(leaf_size_, payload_->clamp_count(false));
  inside_.assign(leaf_size_, payload_->clamp_count(true));
  const int phases = payload_->phases;
  windows_.resize(at(phases));
  for (int n = 0; n < phases; ++n) {
    for (int a = 0; a < 4; ++a) {
      windows_[at(n)][at(a)] = at(kEdge * ((n + a - 1 + phases) % phases));
    }
  }
  const Index3& blocks = payload_->block_count;
  bordered_.assign(at(blocks[0] + 2) * at(blocks[1] + 2) * at(blocks[2] + 2),
                   FieldPayload::kOutside);
  auto from = payload_->blocks.begin();
  for (int z = 1; z <= blocks[2]; ++z) {
    for (int y = 1; y <= blocks[1]; ++y, from += blocks[0]) {
      std::copy_n(
          from, blocks[0],
          bordered_.begin() + static_cast<std::ptrdiff_t>(
                                  1 + at(blocks[0] + 2) * (at(y) + at(blocks[1] + 2) * at(z))));
    }
  }
  find_centre();
}

void FieldQuery::find_centre() {
  const FieldPayload& field = *payload_;
  WeightedSum inside;
  for_each_block(field, [&](const Index3& at_sample, std::int32_t entry) {
    const Vec3 first(at_sample[0], at_sample[1], at_sample[2]);
    if (entry == FieldPayload::kInside) {
      inside.add(first + Vec3::Constant(0.5 * (kEdge - 1)), FieldPayload::kBlockSamples);
    }
    if (entry >= 0) add_leaf(field, entry, first, inside);
  });
  const Index3& blocks = field.block_count;
  if (!(inside.weight > 0)) inside.add(0.5 * kEdge * Vec3(blocks[0], blocks[1], blocks[2]), 1);
  centre_mm_ = field.origin_mm + field.voxel_mm / inside.weight * inside.sum;
}

FieldQuery::Moment FieldQuery::moment_at(double t) const noexcept {
  const double beats = t * beats_per_s_;
  if (!std::isfinite(beats)) return {};
  const int phases = payload_->phases;
  const double s = share_of_beat(beats) * phases;
  const int n = std::min(static_cast<int>(s), phases - 1);
  return {&windows_[at(n)], static_cast<float>(s - n)};
}

// Contracts in time, then along y and z, four places along x side by side.
template <bool kSplit>
Contracted FieldQuery::contract(const Support& support, const TapWeights& taps) noexcept {
  const std::array<Lanes, 4> t{spread<3>(taps.value[0]), spread<3>(taps.value[1]),
                               spread<3>(taps.value[2]), spread<3>(taps.value[3])};
  const std::array<Lanes, 4> dt{spread<3>(taps.slope[0]), spread<3>(taps.slope[1]),
                                spread<3>(taps.slope[2]), spread<3>(taps.slope[3])};
  const std::array<Lanes, 4> w{spread<1>(taps.value[0]), spread<1>(taps.value[1]),
                               spread<1>(taps.value[2]), spread<1>(taps.value[3])};
  const std::array<Lanes, 4> dw{spread<1>(taps.slope[0]), spread<1>(taps.slope[1]),
                                spread<1>(taps.slope[2]), spread<1>(taps.slope[3])};
  const PhaseWindow& phase = *support.window;
  const auto first = static_cast<std::ptrdiff_t>(kSplit ? 4 : support.local[0]);
  Contracted out{};
  for (std::size_t z = 0; z < 4; ++z) {
    const int k = support.local[2] + static_cast<int>(z);
    const auto* base = &support.base[k >= kEdge ? 4 : 0];
    const std::size_t layer = at((k & (kEdge - 1)) * kEdge);
    Lanes value{};
    Lanes along_y{};
    Lanes rate{};
#pragma GCC unroll 1
    for (std::size_t y = 0; y < 4; ++y) {
      const int j = support.local[1] + static_cast<int>(y);
      const auto* block = base + (j >= kEdge ? 2 : 0);
      const std::size_t row_at = (layer + at(j & (kEdge - 1))) * support.row;
      const Row<kSplit> row{block[0] + row_at + first, block[1] + row_at, kEdge - support.local[0]};
      const Lanes a = row.at_phase(phase[0]);
      Lanes now = t[0] * a;
      Lanes change = dt[0] * a;
      const Lanes b = row.at_phase(phase[1]);
      now += t[1] * b;
      change += dt[1] * b;
      const Lanes c = row.at_phase(phase[2]);
      now += t[2] * c;
      change += dt[2] * c;
      const Lanes d = row.at_phase(phase[3]);
      now += t[3] * d;
      change += dt[3] * d;
      value += w[y] * now;
      along_y += dw[y] * now;
      rate += w[y] * change;
    }
    out.add(taps, z, value, along_y, rate);
  }
  return out;
}

FieldSample FieldQuery::sample(const Vec3& x, double t) const noexcept {
  const FieldPayload& field = *payload_;
  FieldSample out;
  out.distance_mm = field.outer_mm;
  Place place;
  if (!find_place(field, samples_per_mm_, x, place)) return out;
  Support support;
  std::array<int, 3> block;
  for (std::size_t a = 0; a < 3; ++a) {
    const int first = place.cell[a] - 1 + kEdge;  // counted from the border
    block[a] = first / kEdge;
    support.local[a] = first % kEdge;
  }
  const Moment moment = moment_at(t);
  if (moment.window == nullptr) return out;
  support.window = moment.window;
  support.row = at(kEdge * field.phases);

  const std::size_t to_y = at(field.block_count[0] + 2);
  const std::size_t to_z = to_y * at(field.block_count[1] + 2);
  const std::size_t corner = at(block[0]) + to_y * at(block[1]) + to_z * at(block[2]);
  constexpr int kLastWhole = kEdge - 4;
  const std::array<std::size_t, 3> beyond{support.local[0] > kLastWhole ? 1 : std::size_t{0},
                                          support.local[1] > kLastWhole ? to_y : 0,
                                          support.local[2] > kLastWhole ? to_z : 0};
  std::int32_t highest = -3;
  std::int32_t lowest = 0;
  for (std::size_t n = 0; n < 8; ++n) {
    const std::int32_t entry =
        bordered_[corner + ((n & 1U) != 0 ? beyond[0] : 0) + ((n & 2U) != 0 ? beyond[1] : 0) +
                  ((n & 4U) != 0 ? beyond[2] : 0)];
    highest = std::max(highest, entry);
    lowest = std::min(lowest, entry);
    support.base[n] = entry >= 0 ? field.coefficients.data() + at(entry) * leaf_size_
                      : entry == FieldPayload::kInside ? inside_.data()
                                                       : outside_.data();
  }
  if (highest < 0 && highest == lowest) {
    if (highest == FieldPayload::kInside) out.distance_mm = -field.inner_mm;
    return out;
  }
  const TapWeights taps = bspline(Lanes{place.u[0], place.u[1], place.u[2], moment.u});
  return finish_.sample(
      beyond[0] != 0 ? contract<true>(support, taps) : contract<false>(support, taps), taps);
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
