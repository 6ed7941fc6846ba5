#pragma once
/// What a servo renders: a model of contact and the length of the beat. Made here for an atlas's
/// field; whoever has a model of his own fills in a `Scene`.

#include <memory>

#include "runtime/haptics/proxy.h"
#include "runtime/haptics/two_step.h"

namespace beatlas::haptics {

/// What is touched, and how. The model holds what it needs.
struct Scene {
  std::unique_ptr<ForceModel> model;
  double period_s = 1;  ///< of the atlas's cycle [s] > 0
};

/// The proxy on the field of an atlas: the model to use.
/// @throws Error{InvalidInput} as ProxyModel does.
[[nodiscard]] Scene proxy_scene(std::shared_ptr<const field::FieldQuery> field,
                                const ProxyOptions& options);

/// Paper A's model on the field of an atlas.
/// @throws Error{InvalidInput} as TwoStepModel does.
[[nodiscard]] Scene two_step_scene(std::shared_ptr<const field::FieldQuery> field,
                                   const TwoStepOptions& options);

}  // namespace beatlas::haptics
