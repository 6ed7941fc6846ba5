#include "runtime/haptics/scene.h"

#include <utility>

namespace beatlas::haptics {

Scene proxy_scene(std::shared_ptr<const field::FieldQuery> field, const ProxyOptions& options) {
  auto body = std::make_shared<const AtlasField>(std::move(field));
  const double period_s = body->period_s();
  return {.model = std::make_unique<ProxyModel>(std::move(body), options), .period_s = period_s};
}

Scene two_step_scene(std::shared_ptr<const field::FieldQuery> field,
                     const TwoStepOptions& options) {
  // The model refuses what is no field, so the cycle's length is asked for only afterwards.
  const field::FieldQuery* const asked = field.get();
  auto model = std::make_unique<TwoStepModel>(std::move(field), options);
  return {.model = std::move(model), .period_s = asked->rr_interval_s()};
}

}  // namespace beatlas::haptics
