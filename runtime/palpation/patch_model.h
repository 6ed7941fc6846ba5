#pragma once
/// Paper B's muscle under a device on any atlas: the depth below the beating surface goes into the
/// patch (patch.h), whose stiffness K_v + K_e(t) + pi p R follows the atlas's own cycle; K_e and
/// the filling pressure p are those of the natural beat of the parameters' circulation, or p of one
/// that it shares with other fingers.

#include <memory>
#include <optional>

#include "runtime/haptics/contact.h"
#include "runtime/haptics/contact_field.h"
#include "runtime/palpation/atlas_muscle.h"
#include "runtime/palpation/common_circulation.h"
#include "runtime/palpation/elastance.h"
#include "runtime/palpation/parameters.h"
#include "runtime/palpation/patch.h"

namespace beatlas::palpation {

struct PatchModelOptions {
  PalpationParameters parameters = {};
  double long_axis = 0.5;  ///< 0 apex .. 1 base: which muscle
  int segment = 0;         ///< 1..17, 0: healthy
  /// Of the place itself, where an atlas tells it (regions.h); none: the segment's
  std::optional<Tissue> tissue = std::nullopt;
  double end_diastole_s = 0;  ///< where in the field's cycle contraction begins
  double radius_mm = 0;       ///< 0..20: of the fingertip, a ball; 0: a point
  /// Where an atlas has a map: the muscle is that of the place that is touched, tick by tick, and
  /// long_axis, segment and tissue are of no account. Of the same parameters.
  std::shared_ptr<const AtlasMuscle> muscle = nullptr;
  /// Where several fingers share one: the pressure, the wall's motion and what gives way are its,
  /// those of now instead of the natural beat's. Whoever ticks the model tells it where this is.
  std::shared_ptr<CommonCirculation> circulation = nullptr;
  std::size_t finger = 0;  ///< of the circulation's
};

/// Force along the distance's gradient, of the size of the patch's: it relaxes under the finger and
/// comes back slowly. The body must be thicker than twice the depth, as for the two-step model; a
/// field without a direction (its clamp) is taken to point away from its middle.
class PatchModel final : public haptics::ForceModel {
 public:
  /// @throws Error{InvalidInput} if there is no field or a parameter is out of range.
  PatchModel(std::shared_ptr<const haptics::ContactField> field, const PatchModelOptions& options);

  [[nodiscard]] haptics::Contact evaluate(const haptics::ServoState& state,
                                          const haptics::Moment& moment) noexcept override;
  /// The wall is whole again.
  void reset() noexcept override;
  [[nodiscard]] haptics::ModelMemory memory() const noexcept override;
  void restore(const haptics::ModelMemory& memory) noexcept override;
  [[nodiscard]] bool take_over(const haptics::ForceModel& before) noexcept override;

 private:
  std::shared_ptr<const haptics::ContactField> field_;
  VerticalPatch patch_;
  VerticalPatch whole_;
  ElastanceCurve curve_;
  double end_diastole_s_;
  double radius_mm_;
  NaturalWall natural_;
  PatchConstants constants_;  // without an atlas's muscle
  std::shared_ptr<const AtlasMuscle> muscle_;
  LvWall::Trail trail_;
  std::shared_ptr<CommonCirculation> circulation_;
  std::size_t finger_;
  bool told_shortening_;  // S_n is a parameter, not the beat's
};

}  // namespace beatlas::palpation
