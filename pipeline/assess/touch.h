#pragma once
/// What a user feels at a place and a time, however it is found: the one thing that is compared
/// with the truth.

#include <functional>
#include <memory>

#include "pipeline/assess/force_error.h"
#include "runtime/field/sampled_query.h"

namespace beatlas::assess {

/// A contact for one path; see ForceCandidate.
using MakeTouch = std::function<ForceAt()>;

/// The two-step model of runtime/haptics on the spline.
/// @param stiffness_n_per_m as TwoStepOptions
[[nodiscard]] MakeTouch touch_of(std::shared_ptr<const field::FieldQuery> field,
                                 double stiffness_n_per_m);

/// The same law on a cheaper interpolation: K max(0, -distance) n; deeper than directions are known
/// the last one known.
[[nodiscard]] MakeTouch touch_of(std::shared_ptr<const field::SampledQuery> query,
                                 double stiffness_n_per_m);

}  // namespace beatlas::assess
