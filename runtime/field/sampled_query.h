#pragma once
/// The same field asked more cheaply, as a developer may choose and as paper A did: from samples on
/// the lattice and at the stored frames instead of from the spline between them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "runtime/field/field_query.h"

namespace beatlas::field {

enum class SpatialMode : std::uint8_t {
  NearestVoxel,  ///< the sample of the nearest lattice point (paper A's way with its voxels)
  Trilinear,     ///< between the eight lattice points around
  Cubic,         ///< the spline of FieldQuery
};

enum class TemporalMode : std::uint8_t {
  NearestFrame,   ///< the stored frame nearest in time
  Linear,         ///< between the two stored frames around (paper A: 15 frames/s to 1000)
  PeriodicCubic,  ///< the spline of FieldQuery
};

inline constexpr std::array kSpatialModes{SpatialMode::NearestVoxel, SpatialMode::Trilinear,
                                          SpatialMode::Cubic};
inline constexpr std::array kTemporalModes{TemporalMode::NearestFrame, TemporalMode::Linear,
                                           TemporalMode::PeriodicCubic};

/// "nearest", "trilinear", "cubic"; "nearest", "linear", "cubic".
[[nodiscard]] std::string_view mode_name(SpatialMode mode) noexcept;
[[nodiscard]] std::string_view mode_name(TemporalMode mode) noexcept;

/// Immutable and thread-safe. In space, samples are the values of the package's spline at its
/// lattice points, held as counts of the payload's step: as much memory again as the payload's
/// coefficients. Cubic in space asks the spline, once or (Linear) at two frames.
class SampledQuery {
 public:
  /// @param field the spline that is sampled; kept alive
  /// @throws Error{InvalidInput} if there is no field.
  SampledQuery(std::shared_ptr<const FieldQuery> field, SpatialMode space, TemporalMode time);

  /// As FieldQuery::sample, of another function: piecewise constant or linear where a mode is.
  /// `gradient` is that function's derivative; of NearestVoxel, which has none, the central
  /// difference of its neighbours. `rate_mm_s` likewise, of NearestFrame that of the frames around.
  [[nodiscard]] FieldSample sample(const Vec3& x, double t) const noexcept;

  [[nodiscard]] const FieldQuery& field() const noexcept { return *field_; }

 private:
  /// Phases and weights that give the value and the rate at a time.
  struct TimeWeights {
    std::array<int, 4> phase{};
    std::array<float, 4> value{};
    std::array<float, 4> rate{};  ///< per second
    int count = 0;
  };
  /// Distance and rate of a lattice point [mm], [mm/s].
  struct Node {
    float distance = 0;
    float rate = 0;
    bool active = false;
  };

  /// Where a lattice point's phases begin in `samples_`, a row apart; -1 in a block without a leaf.
  struct Stored {
    std::ptrdiff_t first = -1;
    double clamp_mm = 0;  ///< what stands for one that is not stored
  };

  [[nodiscard]] Stored stored(int i, int j, int k) const noexcept;
  [[nodiscard]] TimeWeights weights_at(double t) const noexcept;
  [[nodiscard]] Node node(int i, int j, int k, const TimeWeights& time) const noexcept;
  [[nodiscard]] FieldSample nearest(const Vec3& index, const TimeWeights& time) const noexcept;
  [[nodiscard]] FieldSample trilinear(const Vec3& index, const TimeWeights& time) const noexcept;
  [[nodiscard]] FieldSample spline(const Vec3& x, double t) const noexcept;
  [[nodiscard]] FieldSample at_clamp(bool inside) const noexcept;
  [[nodiscard]] FieldSample clamped(FieldSample raw) const noexcept;
  void take_samples();
  /// The spline at a lattice point, one sum a phase [counts]: a coefficient in time still.
  void sum_in_space(const Index3& point, std::vector<float>& sum) const;
  /// @param first where a lattice point's phases begin in `samples_`; values [counts], one a phase
  void store_phases(std::size_t first, const std::vector<float>& values);

  std::shared_ptr<const FieldQuery> field_;
  SpatialMode space_;
  TemporalMode time_;
  std::vector<std::int16_t> samples_;  ///< as the payload's coefficients, counts of step_mm; of
                                       ///< PeriodicCubic coefficients in time
};

}  // namespace beatlas::field
