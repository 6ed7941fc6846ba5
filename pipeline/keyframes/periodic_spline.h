#pragma once
#include <cstddef>
#include <map>
#include <vector>

#include <Eigen/Core>

namespace beatlas::keyframes {

/// As Eigen counts.
[[nodiscard]] inline Eigen::Index at_index(std::size_t n) { return static_cast<Eigen::Index>(n); }

/// The periodic cubic spline through keys at given places of a cycle: C2 everywhere, but C1 at keys
/// whose slope is held. It is linear in the keys, so keys may be numbers, places or distances.
class PeriodicSpline {
 public:
  /// @param at of the keys in the cycle, ascending, 0 <= at < 1; three or more
  /// @param held [key] its slope, per cycle, as what to weight all keys with; others follow from a
  /// bend without a jump
  /// @throws Error{InvalidInput} if `at` is not so.
  explicit PeriodicSpline(std::vector<double> at,
                          const std::map<std::size_t, Eigen::VectorXd>& held = {});

  /// What to weight the keys with for the value at `share` of the cycle; they add up to 1.
  [[nodiscard]] Eigen::VectorXd weights(double share) const;
  /// From the key to the next one, around the end of the cycle if need be.
  [[nodiscard]] double gap(std::size_t key) const noexcept;

 private:
  std::vector<double> at_;
  Eigen::MatrixXd slopes_;  ///< [key][key] slope at a key from all keys' values
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
