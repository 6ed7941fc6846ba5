#pragma once
#include <vector>

#include "runtime/base/geometry.h"

namespace beatlas::assess {

/// A signed error and the share of surface it stands for.
struct Weighted {
  double value = 0;
  double weight = 1;
};

struct DistanceStatistics {
  double mean = 0;     ///< of magnitudes
  double rms = 0;      ///< root of the mean square
  double p95 = 0;      ///< smallest magnitude that 95 % of the weight do not exceed
  double maximum = 0;  ///< of magnitudes
  double bias = 0;     ///< signed mean
};

/// The two lists pooled, each with half of the weight; one list alone has all of it.
/// All zero if both are empty. Order of summation is that of the lists: the same on any machine.
[[nodiscard]] DistanceStatistics pooled_statistics(const std::vector<Weighted>& one,
                                                   const std::vector<Weighted>& other);

/// Gives figures that have a distance's names its values, as PhaseErrors and DrawnErrors.
template <class Errors>
void set_distances(const DistanceStatistics& statistics, Errors& errors) {
  errors.mean_mm = statistics.mean;
  errors.rms_mm = statistics.rms;
  errors.p95_mm = statistics.p95;
  errors.hausdorff_mm = statistics.maximum;
  errors.bias_mm = statistics.bias;
}

/// Angle between two directions [degrees], also where it is too small for its cosine; 180 where
/// either has no length, as a normal that is missing is as wrong as one can be.
[[nodiscard]] double angle_deg(const Vec3& a, const Vec3& b);

}  // namespace beatlas::assess
