#pragma once
/// How stiff paper B's muscle is from place to place under a fingertip: what haptics::Taxels asks.

#include <memory>

#include "runtime/haptics/stiffness.h"
#include "runtime/palpation/atlas_muscle.h"
#include "runtime/palpation/elastance.h"

namespace beatlas::palpation {

/// K_v + K_e(t) of the place, as PatchModel's under the finger; what fills the ventricle pushes
/// alike everywhere and is left out. Serves one thread: it remembers where it looked.
class PatchStiffness final : public haptics::StiffnessMap {
 public:
  /// @param period_s of the field's cycle  @param end_diastole_s where in it contraction begins
  /// @throws Error{InvalidInput} if there is no muscle, or as ElastanceCurve
  PatchStiffness(std::shared_ptr<const AtlasMuscle> muscle, const PalpationParameters& parameters,
                 double period_s, double end_diastole_s);

  [[nodiscard]] double n_per_m(const Vec3& surface_mm, double t) const noexcept override;

 private:
  std::shared_ptr<const AtlasMuscle> muscle_;
  ElastanceCurve curve_;
  double end_diastole_s_;
  mutable LvWall::Trail trail_;
};

}  // namespace beatlas::palpation
