#include "runtime/field/sampled_query.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/field/blocks.h"

namespace beatlas::field {
namespace {

using atlas::FieldPayload;

// At a lattice point a cubic B-spline is 1/6, 4/6, 1/6 of three coefficients along each axis.
constexpr std::array<float, 3> kCentred{1.F / 6, 4.F / 6, 1.F / 6};

// The values of a periodic cubic B-spline in time at its frames, from its coefficients.
void values_at_frames(const std::vector<float>& coefficients, std::vector<float>& values) {
  const std::size_t count = coefficients.size();
  for (std::size_t p = 0; p < count; ++p) {
    values[p] = kCentred[0] * coefficients[(p + count - 1) % count] +
                kCentred[1] * coefficients[p] + kCentred[2] * coefficients[(p + 1) % count];
  }
}

float time_sum(const std::array<float, 4>& weights, const std::array<float, 4>& values) {
  return (weights[0] * values[0] + weights[1] * values[1]) +
         (weights[2] * values[2] + weights[3] * values[3]);
}

}  // namespace

std::string_view mode_name(SpatialMode mode) noexcept {
  switch (mode) {
    case SpatialMode::NearestVoxel:
      return "nearest";
    case SpatialMode::Trilinear:
      return "trilinear";
    case SpatialMode::Cubic:
      break;
  }
  return "cubic";
}

std::string_view mode_name(TemporalMode mode) noexcept {
  switch (mode) {
    case TemporalMode::NearestFrame:
      return "nearest";
    case TemporalMode::Linear:
      return "linear";
    case TemporalMode::PeriodicCubic:
      break;
  }
  return "cubic";
}

SampledQuery::SampledQuery(std::shared_ptr<const FieldQuery> field, SpatialMode space,
                           TemporalMode time)
    : field_(std::move(field)), space_(space), time_(time) {
  if (!field_) throw_invalid("there is no distance field to sample; open the atlas with it");
  if (space_ == SpatialMode::Cubic) return;
  take_samples();
}

void SampledQuery::take_samples() {
  const FieldPayload& field = field_->payload();
  const auto count = static_cast<std::size_t>(field.phases);
  samples_.resize(field.coefficients.size());
  std::vector<float> sum(count);
  std::vector<float> values(count);
  for_each_block(field, [&](const Index3& first, std::int32_t entry) {
    if (entry < 0) return;
    for (int s = 0; s < FieldPayload::kBlockSamples; ++s) {
      const Index3 local{s % 8, s / 8 % 8, s / 64};
      sum_in_space({first[0] + local[0], first[1] + local[1], first[2] + local[2]}, sum);
      if (time_ != TemporalMode::PeriodicCubic) values_at_frames(sum, values);
      store_phases(field.row_at(entry, local[1], local[2]) + at(local[0]),
                   time_ == TemporalMode::PeriodicCubic ? sum : values);
    }
  });
}

void SampledQuery::sum_in_space(const Index3& point, std::vector<float>& sum) const {
  const FieldPayload& field = field_->payload();
  std::fill(sum.begin(), sum.end(), 0.F);
  for (int n = 0; n < 27; ++n) {
    const int a = n % 3;
    const int b = n / 3 % 3;
    const int c = n / 9;
    const float weight = kCentred[at(a)] * kCentred[at(b)] * kCentred[at(c)];
    const Stored neighbour = stored(point[0] + a - 1, point[1] + b - 1, point[2] + c - 1);
    if (neighbour.first < 0) {
      const auto value = static_cast<float>(neighbour.clamp_mm / field.step_mm);
      for (float& each : sum) each += weight * value;
      continue;
    }
    const std::int16_t* from = field.coefficients.data() + neighbour.first;
    for (std::size_t p = 0; p < sum.size(); ++p) {
      sum[p] += weight * static_cast<float>(from[p * kEdge]);
    }
  }
}

void SampledQuery::store_phases(std::size_t first, const std::vector<float>& values) {
  std::size_t to = first;
  for (const float value : values) {
    samples_[to] = static_cast<std::int16_t>(std::lround(std::clamp(value, -32767.F, 32767.F)));
    to += kEdge;
  }
}

SampledQuery::TimeWeights SampledQuery::weights_at(double t) const noexcept {
  const int phases = field_->phases();
  const double rr_s = field_->rr_interval_s();
  const double beats = t / rr_s;
  const double s = (beats - std::floor(beats)) * phases;
  const double frame = std::min(std::floor(s), phases - 1.0);
  const int n = static_cast<int>(frame);
  const double v = s - frame;
  const double per_s = phases / rr_s;
  TimeWeights out;
  const auto set = [&](int offset, double value, double rate) {
    const auto at = static_cast<std::size_t>(out.count++);
    out.phase[at] = (n + offset + phases) % phases;
    out.value[at] = static_cast<float>(value);
    out.rate[at] = static_cast<float>(rate * per_s);
  };
  switch (time_) {
    case TemporalMode::NearestFrame: {
      const int nearest = v < 0.5 ? 0 : 1;
      set(nearest, 1, 0);
      set(nearest - 1, 0, -0.5);
      set(nearest + 1, 0, 0.5);
      break;
    }
    case TemporalMode::Linear:
      set(0, 1 - v, -1);
      set(1, v, 1);
      break;
    case TemporalMode::PeriodicCubic: {
      const double w = 1 - v;
      set(-1, w * w * w / 6, -0.5 * w * w);
      set(0, 2.0 / 3 - v * v * (1 - 0.5 * v), v * (1.5 * v - 2));
      set(1, 2.0 / 3 - w * w * (1 - 0.5 * w), w * (2 - 1.5 * w));
      set(2, v * v * v / 6, 0.5 * v * v);
      break;
    }
  }
  return out;
}

SampledQuery::Stored SampledQuery::stored(int i, int j, int k) const noexcept {
  const FieldPayload& field = field_->payload();
  Stored out;
  out.clamp_mm = field.outer_mm;
  if (i < 0 || j < 0 || k < 0) return out;
  const int bx = i / kEdge;
  const int by = j / kEdge;
  const int bz = k / kEdge;
  if (bx >= field.block_count[0] || by >= field.block_count[1] || bz >= field.block_count[2]) {
    return out;
  }
  const std::int32_t entry =
      field
          .blocks[at(bx) + at(field.block_count[0]) * (at(by) + at(field.block_count[1]) * at(bz))];
  if (entry == FieldPayload::kInside) out.clamp_mm = -field.inner_mm;
  if (entry < 0) return out;
  out.first =
      static_cast<std::ptrdiff_t>(field.row_at(entry, j % kEdge, k % kEdge) + at(i % kEdge));
  return out;
}

SampledQuery::Node SampledQuery::node(int i, int j, int k, const TimeWeights& time) const noexcept {
  const Stored at = stored(i, j, k);
  Node out;
  out.distance = static_cast<float>(at.clamp_mm);
  if (at.first < 0) return out;
  const std::int16_t* from = samples_.data() + at.first;
  std::array<float, 4> values{};
  for (std::size_t a = 0; a < static_cast<std::size_t>(time.count); ++a) {
    values[a] = static_cast<float>(from[time.phase[a] * kEdge]);
  }
  const auto step = static_cast<float>(field_->payload().step_mm);
  out.distance = step * time_sum(time.value, values);
  out.rate = step * time_sum(time.rate, values);
  out.active = true;
  return out;
}

FieldSample SampledQuery::at_clamp(bool inside) const noexcept {
  FieldSample out;
  out.distance_mm = inside ? -field_->payload().inner_mm : field_->payload().outer_mm;
  return out;
}

FieldSample SampledQuery::clamped(FieldSample raw) const noexcept {
  const FieldPayload& field = field_->payload();
  const double distance = raw.distance_mm;
  if (!(distance > -field.inner_mm && distance < field.outer_mm)) {
    return at_clamp(distance < 0);
  }
  raw.in_band =
      distance > field.voxel_mm - field.inner_mm && distance < field.outer_mm - field.voxel_mm;
  return raw;
}

FieldSample SampledQuery::nearest(const Vec3& index, const TimeWeights& time) const noexcept {
  const int i = static_cast<int>(std::lround(index.x()));
  const int j = static_cast<int>(std::lround(index.y()));
  const int k = static_cast<int>(std::lround(index.z()));
  const Node here = node(i, j, k, time);
  FieldSample out;
  out.distance_mm = static_cast<double>(here.distance);
  if (!here.active) return at_clamp(here.distance < 0);
  out.rate_mm_s = static_cast<double>(here.rate);
  const auto difference = [&](const Node& after, const Node& before) {
    return static_cast<double>(after.distance - before.distance);
  };
  out.gradient = Vec3(difference(node(i + 1, j, k, time), node(i - 1, j, k, time)),
                      difference(node(i, j + 1, k, time), node(i, j - 1, k, time)),
                      difference(node(i, j, k + 1, time), node(i, j, k - 1, time))) /
                 (2 * field_->payload().voxel_mm);
  return clamped(out);
}

FieldSample SampledQuery::trilinear(const Vec3& index, const TimeWeights& time) const noexcept {
  const Vec3 cell = index.array().floor();
  const Vec3 u = index - cell;
  const int i = static_cast<int>(cell.x());
  const int j = static_cast<int>(cell.y());
  const int k = static_cast<int>(cell.z());
  FieldSample out;
  bool some_active = false;
  for (int corner = 0; corner < 8; ++corner) {
    const int a = corner & 1;
    const int b = corner >> 1 & 1;
    const int c = corner >> 2;
    const Node at = node(i + a, j + b, k + c, time);
    some_active = some_active || at.active;
    const double wx = a != 0 ? u.x() : 1 - u.x();
    const double wy = b != 0 ? u.y() : 1 - u.y();
    const double wz = c != 0 ? u.z() : 1 - u.z();
    const auto distance = static_cast<double>(at.distance);
    out.distance_mm += wx * wy * wz * distance;
    out.rate_mm_s += wx * wy * wz * static_cast<double>(at.rate);
    out.gradient += distance * Vec3((a != 0 ? 1 : -1) * wy * wz, (b != 0 ? 1 : -1) * wx * wz,
                                    (c != 0 ? 1 : -1) * wx * wy);
  }
  if (!some_active) return at_clamp(out.distance_mm < 0);
  out.gradient /= field_->payload().voxel_mm;
  return clamped(out);
}

FieldSample SampledQuery::spline(const Vec3& x, double t) const noexcept {
  if (time_ == TemporalMode::PeriodicCubic) return field_->sample(x, t);
  const double frame_s = field_->rr_interval_s() / field_->phases();
  const double s = t / frame_s;
  if (time_ == TemporalMode::NearestFrame) return field_->sample(x, std::floor(s + 0.5) * frame_s);
  const double frame = std::floor(s);
  const double v = s - frame;
  const FieldSample a = field_->sample(x, frame * frame_s);
  const FieldSample b = field_->sample(x, (frame + 1) * frame_s);
  FieldSample out;
  out.distance_mm = (1 - v) * a.distance_mm + v * b.distance_mm;
  out.gradient = (1 - v) * a.gradient + v * b.gradient;
  out.rate_mm_s = (b.distance_mm - a.distance_mm) / frame_s;
  return clamped(out);
}

FieldSample SampledQuery::sample(const Vec3& x, double t) const noexcept {
  if (space_ == SpatialMode::Cubic) return spline(x, t);
  const FieldPayload& field = field_->payload();
  FieldSample outside;
  outside.distance_mm = field.outer_mm;
  const Vec3 index = (x - field.origin_mm) / field.voxel_mm;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double size = field.block_count[static_cast<std::size_t>(axis)] * kEdge;
    if (!(index[axis] >= -2 && index[axis] < size + 1)) return outside;
  }
  if (!std::isfinite(t / field_->rr_interval_s())) return outside;
  const TimeWeights time = weights_at(t);
  return space_ == SpatialMode::NearestVoxel ? nearest(index, time) : trilinear(index, time);
}

}  // namespace beatlas::field
