#pragma once
/// The space between a beating heart and its pericardium, for a thin tool in it (a pipe that drains
/// an effusion, as Nakao et al. wished for): free where there is fluid, contact with the heart's
/// outside on one side and with the pericardium on the other.
///
/// An atlas shows no pericardium. It is taken for a sac that gives way little from beat to beat
/// (Freeman and LeWinter, Circ Res 1984) and lies everywhere as far outside of the place that the
/// heart reaches in its cycle as the effusion is thick, which an echocardiogram tells: so it stands
/// still, and the space is that wide at end-diastole and wider where the wall has drawn in.

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "runtime/haptics/contact_field.h"

namespace beatlas::haptics {

struct PericardialOptions {
  static constexpr double kThinnestMm = 1;
  static constexpr double kThickestMm = 40;
  double effusion_mm =
      10;                ///< [mm] within these: fluid between the heart at its largest and the sac
  double step_mm = 2.5;  ///< [mm] 0.5..10: of the lattice on which the sac is kept
  int phases = 20;       ///< 1..200: at which the heart is looked at
};

class PericardialField final : public ContactField {
 public:
  /// Takes about a second.
  /// @param heart negative inside  @param low_mm, high_mm around it at any time
  /// @throws Error{InvalidInput} if there is no heart, the box is none, or an option is out of
  /// range
  PericardialField(std::shared_ptr<const ContactField> heart, const Vec3& low_mm,
                   const Vec3& high_mm, const PericardialOptions& options);

  /// Of the heart and the sac the nearer one.
  [[nodiscard]] FieldSample sample(const Vec3& x, double t) const noexcept override;
  /// Into the fluid.
  [[nodiscard]] Vec3 outward(const Vec3& x) const noexcept override;
  [[nodiscard]] double resolution_mm() const noexcept override { return heart_->resolution_mm(); }
  [[nodiscard]] double reach_mm() const noexcept override;
  [[nodiscard]] double period_s() const noexcept override { return heart_->period_s(); }

  /// The sac for a picture: where the values reach `effusion_mm`.
  struct Lattice {
    Vec3 low_mm;  ///< of the first node; axes are the frame's, the first runs fastest
    double step_mm;
    std::array<int, 3> size;
    std::span<const float> values_mm;
    double effusion_mm;
  };
  [[nodiscard]] Lattice lattice() const noexcept {
    return {low_mm_, step_mm_, size_, envelope_mm_, effusion_mm_};
  }

 private:
  struct Sac {
    double distance_mm = 0;  ///< of the heart at its largest, outside positive
    Vec3 gradient = Vec3::Zero();
  };
  [[nodiscard]] std::size_t index(int i, int j, int k) const noexcept;
  void find_envelope(int phases);
  void spread(std::vector<bool>& known);
  /// Lowers the distance of a node that is not known to what its neighbours allow.
  void lower_to_neighbours(const std::array<int, 3>& at) noexcept;
  [[nodiscard]] Sac envelope_at(const Vec3& x) const noexcept;

  std::shared_ptr<const ContactField> heart_;
  double effusion_mm_;
  double step_mm_;
  Vec3 low_mm_;
  std::array<int, 3> size_{};
  std::vector<float> envelope_mm_;  ///< distance to the heart at its largest
};

/// Around the heart of an atlas. @throws Error{InvalidInput} as PericardialField
[[nodiscard]] std::shared_ptr<const PericardialField> pericardial_space_of(
    const std::shared_ptr<const field::FieldQuery>& heart, double effusion_mm);

}  // namespace beatlas::haptics
