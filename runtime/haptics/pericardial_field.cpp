#include "runtime/haptics/pericardial_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::haptics {
namespace {

constexpr double kBeyondMm = 5;     // of the lattice outside of the sac
constexpr double kLargestMm = 600;  // along an axis
constexpr float kFar = std::numeric_limits<float>::max();

/// Of the cubic B-spline, and its derivative: what is read between nodes has no edges.
struct Weights {
  std::array<double, 4> value;
  std::array<double, 4> slope;
};
Weights weights(double u) noexcept {
  const double v = 1 - u;
  return {{v * v * v / 6, (3 * u * u * u - 6 * u * u + 4) / 6, (3 * v * v * v - 6 * v * v + 4) / 6,
           u * u * u / 6},
          {-v * v / 2, (3 * u * u - 4 * u) / 2, (4 * v - 3 * v * v) / 2, u * u / 2}};
}

/// The solution of |grad d| = 1 at a node from the least neighbour along each axis (Zhao, "A fast
/// sweeping method for Eikonal equations", 2005).
double from_neighbours(std::array<double, 3> least, double step) noexcept {
  std::sort(least.begin(), least.end());
  double d = least[0] + step;
  if (d <= least[1]) return d;
  d = (least[0] + least[1] +
       std::sqrt(std::max(0.0, 2 * step * step - std::pow(least[0] - least[1], 2)))) /
      2;
  if (d <= least[2]) return d;
  const double sum = least[0] + least[1] + least[2];
  const double squares = least[0] * least[0] + least[1] * least[1] + least[2] * least[2];
  return (sum + std::sqrt(std::max(0.0, sum * sum - 3 * (squares - step * step)))) / 3;
}

}  // namespace

PericardialField::PericardialField(std::shared_ptr<const ContactField> heart, const Vec3& low_mm,
                                   const Vec3& high_mm, const PericardialOptions& options)
    : heart_(std::move(heart)), effusion_mm_(options.effusion_mm), step_mm_(options.step_mm) {
  if (!heart_) throw_invalid("there is no heart for a pericardium; open the atlas with its field");
  if (!(effusion_mm_ >= PericardialOptions::kThinnestMm &&
        effusion_mm_ <= PericardialOptions::kThickestMm)) {
    throw_invalid("an effusion must be from 1 to 40 mm thick");
  }
  if (!(step_mm_ >= 0.5 && step_mm_ <= 10) || options.phases < 1 || options.phases > 200) {
    throw_invalid("a pericardium's lattice must be of 0.5 to 10 mm, of 1 to 200 phases");
  }
  const Vec3 whole_mm = high_mm - low_mm;
  if (!low_mm.allFinite() || !(whole_mm.minCoeff() > 0) || !(whole_mm.maxCoeff() < kLargestMm)) {
    throw_invalid("the box around the heart must have a size below 600 mm along each axis");
  }
  const double beyond_mm = effusion_mm_ + kBeyondMm + 2 * step_mm_;
  low_mm_ = low_mm - Vec3::Constant(beyond_mm);
  for (std::size_t a = 0; a < 3; ++a) {
    size_[a] =
        static_cast<int>(std::ceil((whole_mm[static_cast<int>(a)] + 2 * beyond_mm) / step_mm_)) + 1;
  }
  find_envelope(options.phases);
}

std::size_t PericardialField::index(int i, int j, int k) const noexcept {
  return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) +
          static_cast<std::size_t>(j)) *
             static_cast<std::size_t>(size_[0]) +
         static_cast<std::size_t>(i);
}

void PericardialField::find_envelope(int phases) {
  envelope_mm_.resize(index(0, 0, size_[2]));
  std::vector<bool> known(envelope_mm_.size(), false);
  for (int k = 0; k < size_[2]; ++k) {
    for (int j = 0; j < size_[1]; ++j) {
      for (int i = 0; i < size_[0]; ++i) {
        const Vec3 x = low_mm_ + step_mm_ * Vec3(i, j, k);
        double least = std::numeric_limits<double>::infinity();
        bool in_band = false;
        for (int p = 0; p < phases; ++p) {
          const FieldSample sample = heart_->sample(x, heart_->period_s() * p / phases);
          if (!(sample.distance_mm < least)) continue;
          least = sample.distance_mm;
          // Where the field ends its distance is a bound, and says inside from outside alone.
          in_band = sample.distance_mm < 0 || sample.in_band;
        }
        known[index(i, j, k)] = in_band;
        envelope_mm_[index(i, j, k)] = in_band ? static_cast<float>(least) : kFar;
      }
    }
  }
  spread(known);
}

// Outwards from the band in which the heart's field knows its distance.
void PericardialField::spread(std::vector<bool>& known) {
  constexpr int kRounds = 2;  // of eight directions: no way around the heart turns more often
  for (int sweep = 0; sweep < 8 * kRounds; ++sweep) {
    const auto along = [&](int axis, int n) {
      return (sweep >> axis) % 2 == 0 ? n : size_[static_cast<std::size_t>(axis)] - 1 - n;
    };
    for (int c = 0; c < size_[2]; ++c) {
      for (int b = 0; b < size_[1]; ++b) {
        for (int a = 0; a < size_[0]; ++a) {
          const std::array<int, 3> at{along(0, a), along(1, b), along(2, c)};
          if (!known[index(at[0], at[1], at[2])]) lower_to_neighbours(at);
        }
      }
    }
  }
}

void PericardialField::lower_to_neighbours(const std::array<int, 3>& at) noexcept {
  std::array<double, 3> least{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double nearest = static_cast<double>(kFar);
    for (const int side : {-1, 1}) {
      std::array<int, 3> next = at;
      next[axis] += side;
      if (next[axis] < 0 || next[axis] >= size_[axis]) continue;
      nearest =
          std::min(nearest, static_cast<double>(envelope_mm_[index(next[0], next[1], next[2])]));
    }
    least[axis] = nearest;
  }
  if (*std::min_element(least.begin(), least.end()) >= static_cast<double>(kFar)) return;
  float& here = envelope_mm_[index(at[0], at[1], at[2])];
  here = std::min(here, static_cast<float>(from_neighbours(least, step_mm_)));
}

PericardialField::Sac PericardialField::envelope_at(const Vec3& x) const noexcept {
  Sac out;
  if (!x.allFinite()) return out;
  // Beyond the lattice as at its border: the sac lies within.
  const Vec3 at = (x - low_mm_) / step_mm_;
  std::array<int, 3> first{};
  std::array<Weights, 3> w{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double held = std::clamp(at[static_cast<int>(axis)], 1.0, size_[axis] - 2.0 - 1e-9);
    first[axis] = static_cast<int>(held) - 1;
    w[axis] = weights(held - std::floor(held));
  }
  for (std::size_t c = 0; c < 4; ++c) {
    for (std::size_t b = 0; b < 4; ++b) {
      const std::size_t row =
          index(first[0], first[1] + static_cast<int>(b), first[2] + static_cast<int>(c));
      for (std::size_t a = 0; a < 4; ++a) {
        const auto mm = static_cast<double>(envelope_mm_[row + a]);
        out.distance_mm += mm * w[0].value[a] * w[1].value[b] * w[2].value[c];
        out.gradient += mm * Vec3(w[0].slope[a] * w[1].value[b] * w[2].value[c],
                                  w[0].value[a] * w[1].slope[b] * w[2].value[c],
                                  w[0].value[a] * w[1].value[b] * w[2].slope[c]);
      }
    }
  }
  out.gradient /= step_mm_;
  return out;
}

FieldSample PericardialField::sample(const Vec3& x, double t) const noexcept {
  FieldSample heart = heart_->sample(x, t);
  const Sac sac = envelope_at(x);
  const double to_sac_mm = effusion_mm_ - sac.distance_mm;
  if (heart.distance_mm <= to_sac_mm) return heart;
  FieldSample out;
  out.distance_mm = to_sac_mm;
  out.gradient = -sac.gradient;
  out.in_band = true;
  return out;
}

Vec3 PericardialField::outward(const Vec3& x) const noexcept {
  const Vec3 away = heart_->outward(x);
  return envelope_at(x).distance_mm > effusion_mm_ / 2 ? Vec3(-away) : away;
}

double PericardialField::reach_mm() const noexcept {
  constexpr double kShare = 0.4;  // a tool that fills the space has no place in it to be free
  return std::min(heart_->reach_mm(), kShare * effusion_mm_);
}

std::shared_ptr<const PericardialField> pericardial_space_of(
    const std::shared_ptr<const field::FieldQuery>& heart, double effusion_mm) {
  if (!heart) throw_invalid("there is no heart for a pericardium; open the atlas with its field");
  const atlas::FieldPayload& payload = heart->payload();
  Vec3 high_mm = payload.origin_mm;
  for (int a = 0; a < 3; ++a) {
    high_mm[a] += payload.voxel_mm * atlas::FieldPayload::kBlockEdge *
                  payload.block_count[static_cast<std::size_t>(a)];
  }
  const int phases = std::clamp(heart->phases(), 1, 200);
  return std::make_shared<const PericardialField>(
      std::make_shared<const AtlasField>(heart), payload.origin_mm, high_mm,
      PericardialOptions{.effusion_mm = effusion_mm, .phases = phases});
}

}  // namespace beatlas::haptics
