#pragma once
/// A proxy that the moving surface carries along: the god-object (Zilles and Salisbury 1995) and
/// the finger-proxy (Ruspini et al. 1997) on a signed distance that moves and deforms.
///
/// The proxy is where the tool would be had it not gone in. Every tick, at the tick's own time, it
/// goes to the nearest point to the tool that can be reached without passing through the surface:
/// where phi(p, t) >= radius. The surface is linearised at the proxy, so its own movement since the
/// tick before pushes the proxy like a plane that has come nearer; no finite difference in time is
/// taken. Then
///
///   F = K |p - x| n,   n = (p - x) / |p - x|,
///
/// which for a smooth body equals paper A's K depth n, and keeps its side of a thin wall, its
/// direction however deep, and a groove's edge where a distance has no direction.
///
/// With friction a second point sticks to the surface until it lies outside of the friction cone,
/// then follows at the cone's edge (Harwin and Melder 2002): F_t = K (stuck - p), |F_t| <= mu F_n.

#include <memory>

#include "runtime/haptics/contact.h"
#include "runtime/haptics/contact_field.h"
#include "runtime/haptics/half_spaces.h"
#include "runtime/haptics/stiffness.h"

namespace beatlas::haptics {

struct ProxyOptions {
  double stiffness_n_per_m = 150;  ///< [N/m] 1..5000: K, where `map` does not say otherwise
  double radius_mm = 0;            ///< [mm] of a sphere; 0: a point. At most the field's reach
  double half_length_mm = 0;  ///< [mm] 0..100: of a capsule's axis, along the tool's z; 0: a sphere
  /// [N s/m] 0..100: C of a spring and a damper in series beside K, the standard linear solid. It
  /// answers the depth and never sees a velocity, so an encoder's step D is felt as at most
  /// (K + damper_spring) D.
  double damping_n_s_per_m = 0;
  double damper_spring_n_per_m = 500;  ///< [N/m] 1..5000: of the spring in series with C
  std::shared_ptr<const StiffnessMap> map = nullptr;  ///< asked at the contact point
  /// 0..1, mu of Coulomb's dry friction while the tool sticks, and (0..static) while it slides. The
  /// surface is known to move along its normal only: a tool that sticks is not taken along
  /// sideways.
  double friction_static = 0;
  double friction_dynamic = 0;
};

/// A point, a sphere or a capsule on one body. A capsule is turned by the device alone: its proxy
/// has the tool's orientation, so it is held off in place, and what would turn it is its torque
/// (capsule_axis.h).
class ProxyModel final : public ForceModel {
 public:
  /// @throws Error{InvalidInput} if there is no field or an option is out of range.
  ProxyModel(std::shared_ptr<const ContactField> field, const ProxyOptions& options);

  /// `normal`: direction of the force; out of contact that of the field. A tool that starts inside
  /// is led out along the field's directions first, in one tick; so is one that touched nothing and
  /// comes from more than 100 mm away in a tick. Costs two samples out of contact,
  /// most often four in contact and at most kMostSamples; a
  /// capsule takes as many searches of its axis.
  [[nodiscard]] Contact evaluate(const ServoState& state, const Moment& moment) noexcept override;
  [[nodiscard]] Contact evaluate(const Vec3& x, double t, double elapsed_s = 0) noexcept;

  void reset() noexcept override;
  [[nodiscard]] ModelMemory memory() const noexcept override;
  void restore(const ModelMemory& memory) noexcept override;
  [[nodiscard]] bool take_over(const ForceModel& before) noexcept override;

  static constexpr int kMostSamples = 20;  ///< but for the tick that places the proxy

 private:
  struct Slide;

  /// Of the tool with its centre at p: a capsule's least distance along its axis.
  [[nodiscard]] FieldSample tool_at(const Vec3& p, double t) noexcept;
  void place(const Vec3& x, double t) noexcept;
  void carry(const Vec3& x, double t) noexcept;
  [[nodiscard]] Slide slide(const Vec3& x, double t) noexcept;
  /// Force along the surface, given the frictionless contact at the time t.
  [[nodiscard]] Vec3 friction_n(const Contact& contact, double stiffness, double t) noexcept;
  [[nodiscard]] double damped_force_n(double stiffness, double depth_mm, double elapsed_s) noexcept;

  std::shared_ptr<const ContactField> field_;
  ProxyOptions options_;
  double longest_step_mm_;

  // Of one tick.
  Vec3 half_axis_mm_;
  double share_ = 0;  // where on the axis the last sample was nearest, -1..1

  // What a tick leaves for the next one.
  bool placed_ = false;
  bool touching_ = false;
  Vec3 proxy_mm_ = Vec3::Zero();
  Vec3 direction_ = Vec3::Zero();  // last one known; where the field has none it serves on
  double time_s_ = 0;              // the field's
  double speed_mm_s_ = 0;          // of the surface at the proxy, outward, in the field's time
  bool one_plane_ = false;         // a single plane held the proxy
  double depth_mm_ = 0;
  double damper_n_ = 0;  // force of the damper's branch
  bool sticks_ = false;  // there is a point that friction holds, and it has not slid
  bool rubs_ = false;    // there is a point that friction holds
  Vec3 stuck_mm_ = Vec3::Zero();
};

}  // namespace beatlas::haptics
