#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "runtime/atlas/payloads.h"
#include "runtime/base/geometry.h"

namespace beatlas::field {

struct Contracted;
struct TapWeights;

/// The field at one point and time; workspace frame. All members are those of one function,
/// phi = clamp(spline, -inner_mm, outer_mm): its value and its exact derivatives.
struct FieldSample {
  double distance_mm = 0;        ///< negative inside; clamped outside the band, its sign right
  Vec3 gradient = Vec3::Zero();  ///< d phi / d x, about unit length in the band, 0 where clamped
  double rate_mm_s = 0;          ///< d phi / d t; the surface moves with -rate / |gradient| along n
  /// The distance lies at least a voxel within both clamps, where the spline's support is complete
  /// and its error is that of the samples. False where it is clamped, and in the last voxel before.
  bool in_band = false;
};

/// Evaluates a FieldPayload: C2 in space and time within the band, continuous everywhere, periodic
/// in time. Immutable and thread-safe; holds the payload and little else.
class FieldQuery {
 public:
  /// @param payload as the reader checked it; its indices are trusted from here on
  /// @param rr_interval_s [s] > 0
  /// @throws Error{InvalidInput} if there is no payload or the interval is no positive number.
  FieldQuery(std::shared_ptr<const atlas::FieldPayload> payload, double rr_interval_s);

  /// @param x workspace [mm], any point; t [s], any time (taken modulo the R-R interval).
  /// Outside the lattice, and for a point or time that is no number: outer_mm, gradient 0.
  [[nodiscard]] FieldSample sample(const Vec3& x, double t) const noexcept;

  /// Outward unit normal at x, where `at_x` is the sample there: along the gradient; where it is
  /// too short to be a direction (clamped, or midway between two walls) away from `centre_mm`;
  /// zero only at the centre itself.
  [[nodiscard]] Vec3 normal(const FieldSample& at_x, const Vec3& x) const noexcept;

  /// Velocity of the surface along n [mm/s], -rate / |gradient|; 0 where there is no gradient.
  [[nodiscard]] static double normal_velocity_mm_s(const FieldSample& sample) noexcept;

  /// Centroid over the cycle of the samples inside [mm].
  [[nodiscard]] const Vec3& centre_mm() const noexcept { return centre_mm_; }
  [[nodiscard]] double rr_interval_s() const noexcept { return rr_interval_s_; }
  [[nodiscard]] int phases() const noexcept { return payload_->phases; }
  [[nodiscard]] const atlas::FieldPayload& payload() const noexcept { return *payload_; }

 private:
  friend class ShellQuery;
  struct Support;
  /// Where the four phases around a time begin in a row of coefficients.
  using PhaseWindow = std::array<std::size_t, 4>;
  struct Moment {
    const PhaseWindow* window = nullptr;  ///< none for what is no time
    float u = 0;                          ///< from the second phase to the third, 0..1
  };

  /// From sums of counts to a sample.
  struct Finish {
    double mm = 0;  ///< a count
    double per_mm = 0;
    double mm_s = 0;
    double inner_mm = 0;
    double outer_mm = 0;
    double voxel_mm = 0;

    [[nodiscard]] inline FieldSample sample(const Contracted& rows,
                                            const TapWeights& taps) const noexcept;
  };

  void find_centre();
  [[nodiscard]] Moment moment_at(double t) const noexcept;
  template <bool kSplit>
  [[nodiscard]] static Contracted contract(const Support& support, const TapWeights& taps) noexcept;

  std::shared_ptr<const atlas::FieldPayload> payload_;
  std::vector<std::int32_t> bordered_;  ///< payload's blocks with one outside around them
  std::vector<std::int16_t> outside_;   ///< a leaf of the clamp
  std::vector<std::int16_t> inside_;
  std::vector<PhaseWindow> windows_;  ///< [phase before]
  std::size_t leaf_size_ = 0;         ///< coefficients
  Finish finish_;
  double rr_interval_s_;
  double beats_per_s_ = 0;
  double phases_per_s_ = 0;
  double samples_per_mm_ = 0;
  Vec3 centre_mm_ = Vec3::Zero();
};

}  // namespace beatlas::field
