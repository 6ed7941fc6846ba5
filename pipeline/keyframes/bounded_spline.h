#pragma once
#include <functional>
#include <vector>

#include "pipeline/keyframes/periodic_spline.h"

namespace beatlas::keyframes {

/// What a shape encloses [ml] whose keys are weighted so.
using VolumeOf = std::function<double(const Eigen::VectorXd& weights)>;

struct BoundedSpline {
  PeriodicSpline spline;
  std::vector<std::size_t> held;  ///< keys at which it is C1, ascending; elsewhere it is C2
};

/// The periodic spline through keys, one for all shapes, whose volumes between two keys at uneven
/// times go no further beyond both keys' than 0.25 % of the largest key's. Where the C2 spline
/// does, as where a slope over a short interval is carried into a long one, the slopes at the
/// interval's ends are held: the mean of the chords to both neighbours at which the volume that
/// beats most changes as in monotone piecewise cubics (Fritsch and Butland, SIAM J. Sci. Stat.
/// Comput. 5, 1984, 300-304: none at its extremes); if that is not enough, none. Lost there: the
/// bend jumps, and a peak of volume between two keys is not guessed. Intervals that are as long as
/// their neighbours, within a quarter, are never touched: of even times it is the C2 spline.
/// @param volumes one a shape, one or more
/// @throws Error{InvalidInput} as PeriodicSpline does.
[[nodiscard]] BoundedSpline bounded_spline(const std::vector<double>& at,
                                           const std::vector<VolumeOf>& volumes);

}  // namespace beatlas::keyframes
