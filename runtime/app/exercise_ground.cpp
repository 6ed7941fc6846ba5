#include "runtime/app/exercise_ground.h"

#include "runtime/base/error.h"
#include "runtime/exercise/findings.h"
#include "runtime/palpation/fit.h"
#include "runtime/palpation/over_wall.h"

namespace beatlas::app {

namespace {

/// Cosine of 45 degrees.
constexpr double kSquare = 0.70710678;

}  // namespace

haptics::ServoOptions exercise_servo_options(double heart_rate_per_min) {
  haptics::ServoOptions out;
  if (heart_rate_per_min > 0) out.heart.rate_per_min = heart_rate_per_min;
  return out;
}

ExerciseGround::ExerciseGround(const std::string& package, const ToldMuscle& told,
                               double tool_radius_mm) {
  const atlas::Atlas atlas = atlas::Atlas::open(
      package, needs_of_press(atlas::Atlas::open(package, atlas::Needs{}).manifest()));
  if (!atlas.surface_map(Structure::LvBlood)) {
    throw_invalid(package +
                  " has no map of the LV's wall, in which lesions could be hidden; build it again "
                  "from images of a left and a right ventricle");
  }
  manifest_ = atlas.manifest();
  field_ = std::make_shared<const field::FieldQuery>(atlas.field(Structure::Heart),
                                                     manifest_.rr_interval_s);
  touch_.model = "patch";
  touch_.radius_mm = tool_radius_mm;
  touch_.end_diastole_s = manifest_.rr_interval_s * manifest_.end_diastole / field_->phases();
  wall_ = take_muscle(told, atlas, package, touch_);
  endocardium_ = atlas.surface(Structure::LvBlood);
  // Where the heart's surface turns away from the wall a finger presses on other muscle, too.
  const auto is_square = [this](const Vec3& place, const Vec3& outward) {
    const Vec3 normal = field_->normal(field_->sample(place, touch_.end_diastole_s), place);
    return normal.dot(outward) >= kSquare;
  };
  std::vector<bool> touchable;
  for (std::uint32_t v = 0; v < wall_->vertex_count(); ++v) {
    over_.push_back(wall_->wall_mm()[v] > 0
                        ? palpation::over_wall(*wall_, v, *field_, touch_.end_diastole_s)
                        : std::nullopt);
    if (over_.back() && !is_square(*over_.back(), wall_->outward(v))) over_.back().reset();
    touchable.push_back(over_.back().has_value());
  }
  ground_ = std::make_unique<exercise::Ground>(
      exercise::Ground{.wall = *wall_, .touchable = std::move(touchable)});
  muscle_ = std::make_shared<const palpation::AtlasMuscle>(wall_, touch_.tissue, touch_.parameters);
  harmful_n_ = exercise::harmful_force_n(
      palpation::natural_beat(touch_.parameters.whole_circulation()).aortic_low_mmhg,
      touch_.parameters.contractile.finger_area_cm2);
}

haptics::Scene ExerciseGround::scene(const std::vector<exercise::Lesion>& lesions) const {
  TouchOptions touch = touch_;
  exercise::hide_lesions(lesions, *wall_, touch.tissue);
  touch.parameters.infarct = touch.tissue.infarct;
  return make_scene(field_, touch, wall_);
}

}  // namespace beatlas::app
