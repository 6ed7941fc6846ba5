#pragma once
/// An atlas that is examined: its left ventricle's wall, where a finger gets at it, and its muscle
/// with lesions hidden in it.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/app/touch.h"
#include "runtime/app/ventricle.h"
#include "runtime/atlas/atlas.h"
#include "runtime/exercise/lesion.h"
#include "runtime/field/field_query.h"

namespace beatlas::app {

/// Of a trial's servo, played or played once more. @param heart_rate_per_min 0: the atlas's own
[[nodiscard]] haptics::ServoOptions exercise_servo_options(double heart_rate_per_min);

class ExerciseGround {
 public:
  /// Opens a package for an exercise. @param told what the heart has beside what is hidden
  /// @throws Error{InvalidInput} if it has no map of the LV's wall, or as take_muscle
  ExerciseGround(const std::string& package, const ToldMuscle& told, double tool_radius_mm);

  [[nodiscard]] const exercise::Ground& ground() const noexcept { return *ground_; }
  [[nodiscard]] const palpation::LvWall& wall() const noexcept { return *wall_; }
  [[nodiscard]] const std::shared_ptr<const field::FieldQuery>& field() const noexcept {
    return field_;
  }
  [[nodiscard]] const atlas::Manifest& manifest() const noexcept { return manifest_; }
  [[nodiscard]] const atlas::SurfacePayload& endocardium() const noexcept { return *endocardium_; }
  [[nodiscard]] double end_diastole_s() const noexcept { return touch_.end_diastole_s; }
  /// [vertex] palpation::over_wall, where the heart's surface lies square to the wall
  [[nodiscard]] const std::vector<std::optional<Vec3>>& over() const noexcept { return over_; }
  /// Nothing is hidden in it.
  [[nodiscard]] const palpation::AtlasMuscle& muscle() const noexcept { return *muscle_; }
  /// exercise::harmful_force_n of this heart's circulation.
  [[nodiscard]] double harmful_force_n() const noexcept { return harmful_n_; }

  /// What is touched where these lesions are hidden: of a circulation that they have made ill, too.
  [[nodiscard]] haptics::Scene scene(const std::vector<exercise::Lesion>& lesions) const;

 private:
  atlas::Manifest manifest_;
  std::shared_ptr<const field::FieldQuery> field_;
  std::shared_ptr<const atlas::SurfacePayload> endocardium_;
  std::shared_ptr<const palpation::LvWall> wall_;
  TouchOptions touch_;
  std::vector<std::optional<Vec3>> over_;
  std::unique_ptr<exercise::Ground> ground_;
  std::shared_ptr<const palpation::AtlasMuscle> muscle_;
  double harmful_n_ = 0;
};

}  // namespace beatlas::app
