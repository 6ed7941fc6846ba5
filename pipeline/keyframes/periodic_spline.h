#pragma once
#include <vector>

#include <Eigen/Core>

namespace beatlas::keyframes {

/// The periodic cubic spline through keys at given places of a cycle: C2 everywhere. It is linear
/// in the keys, so keys may be numbers, places or distances.
class PeriodicSpline {
 public:
  /// @param at of the keys in the cycle, ascending, 0 <= at < 1; three or more
  /// @throws Error{InvalidInput} if they are not.
  explicit PeriodicSpline(std::vector<double> at);

  /// What to weight the keys with for the value at `share` of the cycle; they add up to 1.
  [[nodiscard]] Eigen::VectorXd weights(double share) const;

 private:
  std::vector<double> at_;
  Eigen::MatrixXd bend_;  ///< [key][key] second derivative at a key from all keys' values
};

/// Where the keys of a contraction stand that relaxation runs through backwards, and which key it
/// is: keys 0..K-1 evenly over `share` of the cycle, then K-2..1 evenly over the rest.
struct ThereAndBack {
  std::vector<double> at;
  std::vector<int> key;
};
/// @param keys two or more; @param share 0..1 of the cycle, both excluded
/// @throws Error{InvalidInput}
[[nodiscard]] ThereAndBack there_and_back(int keys, double share);

}  // namespace beatlas::keyframes
