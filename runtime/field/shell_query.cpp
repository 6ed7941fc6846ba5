#include "runtime/field/shell_query.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/field/blocks.h"
#include "runtime/field/spline_lanes.h"

namespace beatlas::field {
namespace {

using atlas::FieldPayload;

// Summing a sample in time costs about a sixtieth of what it saves a point.
constexpr std::size_t kSamplesAPoint = 64;

int block_of(int sample) { return (sample + kEdge) / kEdge - 1; }  // sample >= -kEdge

// Of a block in the lattice or beyond it.
std::int32_t entry_of(const FieldPayload& field, int bx, int by, int bz) noexcept {
  const auto [nx, ny, nz] = field.block_count;
  if (bx < 0 || bx >= nx || by < 0 || by >= ny || bz < 0 || bz >= nz) {
    return FieldPayload::kOutside;
  }
  return field.blocks[at(bx) + at(nx) * (at(by) + at(ny) * at(bz))];
}

// What the four phases around a time give to its value and its rate.
struct TimeTaps {
  std::array<Lanes, 4> value;
  std::array<Lanes, 4> rate;
  std::array<std::size_t, 4> phase;  // where each begins in a row of coefficients
};

// Sums the samples of a row of a block in time.
void sum_row(const std::int16_t* row, const TimeTaps& taps, float* value, float* rate) noexcept {
  for (std::size_t half = 0; half < kEdge; half += 4) {
    Lanes now{};
    Lanes change{};
    for (std::size_t a = 0; a < 4; ++a) {
      const Lanes counts = load_counts(row + taps.phase[a] + half);
      // As FieldQuery sums: the first product is not added to 0, which would lose its sign.
      now = a == 0 ? taps.value[a] * counts : now + taps.value[a] * counts;
      change = a == 0 ? taps.rate[a] * counts : change + taps.rate[a] * counts;
    }
    std::memcpy(value + half, &now, sizeof now);
    std::memcpy(rate + half, &change, sizeof change);
  }
}

}  // namespace

// Samples that a shell's points need; along x whole blocks.
struct ShellQuery::Box {
  std::array<int, 3> first{};
  std::array<std::size_t, 3> size{};  // 0: no point reaches the lattice

  [[nodiscard]] std::size_t count() const { return size[0] * size[1] * size[2]; }
};

ShellQuery::ShellQuery(std::shared_ptr<const FieldQuery> field, std::size_t most_samples)
    : field_(std::move(field)), values_(most_samples), rates_(most_samples) {
  if (!field_) throw_invalid("there is no distance field to query; open the atlas with it");
}

std::size_t ShellQuery::samples_for(double width_mm, double voxel_mm) {
  constexpr double kWidest = 64;
  // The support of a point reaches one sample before its cell and two beyond.
  const double side = std::floor(width_mm / voxel_mm) + 5;
  if (!(side < kWidest)) return std::size_t{64} * 64 * 64;
  const auto samples = static_cast<std::size_t>(side);
  const std::size_t blocks = (samples + 2 * kEdge - 2) / kEdge;  // along x, wherever it begins
  return samples * samples * blocks * kEdge;
}

ShellQuery::Box ShellQuery::box_of(std::span<const Vec3> x) const noexcept {
  // In millimetres first, cut to what any spline of the lattice reaches; a comparison with what is
  // no number leaves a bound as it is.
  constexpr double kFar = std::numeric_limits<double>::max();
  std::array<double, 3> low{kFar, kFar, kFar};
  std::array<double, 3> high{-kFar, -kFar, -kFar};
  for (const Vec3& point : x) {
    for (std::size_t a = 0; a < 3; ++a) {
      const double along = point[static_cast<Eigen::Index>(a)];
      low[a] = along < low[a] ? along : low[a];
      high[a] = along > high[a] ? along : high[a];
    }
  }
  const FieldPayload& field = field_->payload();
  Box box;
  std::array<int, 3> last;
  for (std::size_t a = 0; a < 3; ++a) {
    const double origin = field.origin_mm[static_cast<Eigen::Index>(a)];
    const int most = kEdge * field.block_count[a];
    const auto cell = [&](double mm) {
      return static_cast<int>(std::floor(std::clamp((mm - origin) * field_->samples_per_mm_, -3.0,
                                                    static_cast<double>(most + 1))));
    };
    const int first = std::max(cell(low[a]), -2);
    last[a] = std::min(cell(high[a]), most);
    if (first > last[a]) return {};
    box.first[a] = first - 1;
    box.size[a] = at(last[a] + 3 - box.first[a]);
  }
  const int last_block = block_of(last[0] + 2);
  box.first[0] = kEdge * block_of(box.first[0]);
  box.size[0] = at(kEdge * (last_block + 1) - box.first[0]);
  return box;
}

void ShellQuery::collapse(const Box& box, const FieldQuery::Moment& moment) noexcept {
  const FieldPayload& field = field_->payload();
  const TapWeights taps = bspline(Lanes{0, 0, 0, moment.u});
  const TimeTaps time{{spread<3>(taps.value[0]), spread<3>(taps.value[1]), spread<3>(taps.value[2]),
                       spread<3>(taps.value[3])},
                      {spread<3>(taps.slope[0]), spread<3>(taps.slope[1]), spread<3>(taps.slope[2]),
                       spread<3>(taps.slope[3])},
                      *moment.window};
  float* value = values_.data();
  float* rate = rates_.data();
  for (std::size_t z = 0; z < box.size[2]; ++z) {
    const int k = box.first[2] + static_cast<int>(z);
    const int bz = block_of(k);
    for (std::size_t y = 0; y < box.size[1]; ++y) {
      const int j = box.first[1] + static_cast<int>(y);
      const int by = block_of(j);
      for (std::size_t x = 0; x < box.size[0]; x += kEdge, value += kEdge, rate += kEdge) {
        const int bx = block_of(box.first[0] + static_cast<int>(x));
        const std::int32_t entry = entry_of(field, bx, by, bz);
        const std::int16_t* row =
            entry >= 0
                ? field.coefficients.data() + field.row_at(entry, j - kEdge * by, k - kEdge * bz)
            : entry == FieldPayload::kInside ? field_->inside_.data()
                                             : field_->outside_.data();
        sum_row(row, time, value, rate);
      }
    }
  }
}

void ShellQuery::sample(std::span<const Vec3> x, double t, std::span<FieldSample> out) noexcept {
  const std::size_t count = std::min(x.size(), out.size());
  x = x.first(count);
  const FieldPayload& field = field_->payload();
  const FieldQuery::Moment moment = field_->moment_at(t);
  const Box box = box_of(x);
  if (moment.window == nullptr || box.count() == 0 || box.count() > values_.size() ||
      box.count() > kSamplesAPoint * count) {
    for (std::size_t n = 0; n < count; ++n) out[n] = field_->sample(x[n], t);
    return;
  }
  collapse(box, moment);
  const std::size_t to_y = box.size[0];
  const std::size_t to_z = box.size[0] * box.size[1];
  const FieldQuery::Finish finish = field_->finish_;
  Place place;
  for (std::size_t n = 0; n < count; ++n) {
    if (!find_place(field, field_->samples_per_mm_, x[n], place)) {
      out[n] = FieldSample{};
      out[n].distance_mm = field.outer_mm;
      continue;
    }
    const TapWeights taps = bspline(Lanes{place.u[0], place.u[1], place.u[2], moment.u});
    const std::size_t corner = at(place.cell[0] - 1 - box.first[0]) +
                               to_y * at(place.cell[1] - 1 - box.first[1]) +
                               to_z * at(place.cell[2] - 1 - box.first[2]);
    const float* values = values_.data() + corner;
    const float* rates = rates_.data() + corner;
    const std::array<Lanes, 4> w{spread<1>(taps.value[0]), spread<1>(taps.value[1]),
                                 spread<1>(taps.value[2]), spread<1>(taps.value[3])};
    const std::array<Lanes, 4> dw{spread<1>(taps.slope[0]), spread<1>(taps.slope[1]),
                                  spread<1>(taps.slope[2]), spread<1>(taps.slope[3])};
    Contracted rows{};
    for (std::size_t z = 0; z < 4; ++z) {
      Lanes value{};
      Lanes along_y{};
      Lanes rate{};
      for (std::size_t y = 0; y < 4; ++y) {
        const std::size_t row = z * to_z + y * to_y;
        const Lanes now = load_floats(values + row);
        value += w[y] * now;
        along_y += dw[y] * now;
        rate += w[y] * load_floats(rates + row);
      }
      rows.add(taps, z, value, along_y, rate);
    }
    out[n] = finish.sample(rows, taps);
  }
}

}  // namespace beatlas::field
