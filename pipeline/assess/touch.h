#pragma once
/// What a user feels at a place and a time, however it is found: the one thing that is compared
/// with the truth.

#include <functional>
#include <memory>

#include "runtime/field/sampled_query.h"
#include "runtime/haptics/two_step.h"

namespace beatlas::assess {

/// Workspace [mm], [s] -> contact. May remember the direction of the contact between calls, so each
/// path wants its own.
using Touch = std::function<haptics::Contact(const Vec3& x, double t_s)>;
using MakeTouch = std::function<Touch()>;

/// The two-step model of runtime/haptics on the spline.
/// @param stiffness_n_per_m as TwoStepOptions
[[nodiscard]] MakeTouch touch_of(std::shared_ptr<const field::FieldQuery> field,
                                 double stiffness_n_per_m);

/// The same law on a cheaper interpolation: K max(0, -distance) n; deeper than directions are known
/// the last one known.
[[nodiscard]] MakeTouch touch_of(std::shared_ptr<const field::SampledQuery> query,
                                 double stiffness_n_per_m);

}  // namespace beatlas::assess
