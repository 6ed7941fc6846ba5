#include "pipeline/assess/touch.h"

#include <algorithm>

namespace beatlas::assess {

MakeTouch touch_of(std::shared_ptr<const field::FieldQuery> field, double stiffness_n_per_m) {
  haptics::TwoStepOptions options;
  options.stiffness_n_per_m = stiffness_n_per_m;
  return [field, options] {
    auto model = std::make_shared<haptics::TwoStepModel>(field, options);
    return [model](const Vec3& x, double t) { return model->evaluate(x, t); };
  };
}

MakeTouch touch_of(std::shared_ptr<const field::SampledQuery> query, double stiffness_n_per_m) {
  return [query, stiffness_n_per_m] {
    return [query, stiffness_n_per_m, direction = Vec3(0, 0, 0)](const Vec3& x, double t) mutable {
      const field::FieldSample sample = query->sample(x, t);
      haptics::Contact out;
      out.distance_mm = sample.distance_mm;
      out.depth_mm = std::max(0.0, -sample.distance_mm);
      out.touching = out.depth_mm > 0;
      const bool too_deep = out.touching && !sample.in_band;
      out.normal = too_deep && !direction.isZero() ? direction : query->field().normal(sample, x);
      out.surface_velocity_mm_s = field::FieldQuery::normal_velocity_mm_s(sample);
      out.force_n = haptics::contact_force_n(stiffness_n_per_m, out.distance_mm, out.normal);
      out.proxy_mm = x + out.depth_mm * out.normal;
      direction = out.touching ? out.normal : Vec3(0, 0, 0);
      return out;
    };
  };
}

}  // namespace beatlas::assess
