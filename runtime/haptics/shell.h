#pragma once
/// Area contact: a rigid shell of points, each with its share of the tool's surface, on a bed of
/// springs (Winkler's foundation; voxmap point-shell, McNeely et al. 1999). With c the bed's
/// stiffness per area and a_i the area of point i,
///
///   F = sum_i c a_i max(0, -phi(x_i)) n(x_i),   M = sum_i (x_i - x) x F_i.
///
/// A point knows no proxy: the body must be thicker than twice the depth.

#include <memory>
#include <vector>

#include "runtime/haptics/contact.h"
#include "runtime/haptics/contact_field.h"
#include "runtime/haptics/taxels.h"

namespace beatlas::haptics {

/// Points of a tool's surface in the tool's frame, its centre at the origin.
struct Shell {
  std::vector<Vec3> points_mm;
  std::vector<double> areas_mm2;  ///< one for each point, >= 0
  /// Unit vectors out of the tool, one for each point, for the area of contact as the plane of
  /// contact sees it; none: areas count whole.
  std::vector<Vec3> normals = {};

  static constexpr std::size_t kMostPoints = 10000;
};

/// A fingertip: half a sphere on the side of -z of the tool's frame, evenly covered.
/// @param radius_mm 0.1..50; @param points 1..Shell::kMostPoints. @throws Error{InvalidInput}
[[nodiscard]] Shell fingertip(double radius_mm, std::size_t points);

struct ShellOptions {
  /// [N/m^3] 1e3..1e9: c. The default makes 100 mm^2 of flat contact as stiff as 150 N/m.
  double foundation_n_per_m3 = 1.5e6;
};

class ShellModel final : public ForceModel {
 public:
  /// @throws Error{InvalidInput} if there is no field, no point, an area or a normal that is none,
  /// or an option is out of range.
  ShellModel(std::shared_ptr<const ContactField> field, const Shell& shell,
             const ShellOptions& options);

  /// `depth_mm`, `distance_mm`, `surface_velocity_mm_s`: of the deepest point; out of contact the
  /// distance is a lower bound. `normal`: of the force. Points that cannot touch are passed over by
  /// the distance at the middle of their cluster; what is left is asked in one batch.
  [[nodiscard]] Contact evaluate(const ServoState& state, const Moment& moment) noexcept override;

  /// The last tick's taxels are gone; the next tick is the same with and without it.
  void reset() noexcept override;
  [[nodiscard]] ModelMemory memory() const noexcept override { return {}; }
  void restore(const ModelMemory& /*memory*/) noexcept override {}

  /// How the pressure of the last tick is spread, for who called it: the pressure c depth of each
  /// point, along the force, over a square as large as the point's area. The map's middle is the
  /// tool's centre on the plane of contact, so that a map as wide as the tool covers it. A point
  /// within the map counts whole; one beside it is felt by no taxel, but counts in area and peak.
  /// The sum of a map that covers the contact is the force. On a flat bed taxels of a fingertip of
  /// 2000 points are within 2 % of the peak from their mean.
  /// @param pitch_mm 0.05..20; 0: a quarter of the tool's radius; another gives a map without
  /// pressure, as a force that is no number does
  [[nodiscard]] TaxelMap taxels(const Vec3& right, double pitch_mm = 0) const noexcept;

  /// Samples that the last tick took.
  [[nodiscard]] std::size_t samples() const noexcept { return samples_; }

 private:
  struct Cluster {
    Vec3 centre_mm;
    double radius_mm;
    std::size_t first;
    std::size_t count;
  };

  [[nodiscard]] Vec3 outward_of(std::size_t asked) const noexcept;

  std::shared_ptr<const ContactField> field_;
  double foundation_n_per_mm3_;
  double bound_mm_ = 0;          // farthest point from the tool's centre
  std::vector<Vec3> points_mm_;  // tool frame, cluster by cluster
  std::vector<double> areas_mm2_;
  std::vector<Vec3> normals_;  // tool frame; empty: none are known
  std::vector<Cluster> clusters_;
  std::size_t samples_ = 0;
  std::unique_ptr<ContactBatch> batch_;

  // Room for a tick, and what is left of the last one.
  std::vector<Vec3> asked_mm_;
  std::vector<std::size_t> asked_point_;
  std::vector<FieldSample> answers_;
  std::size_t asked_ = 0;  // points whose answers these are
  Vec3 position_mm_ = Vec3::Zero();
  Eigen::Matrix3d turn_ = Eigen::Matrix3d::Identity();
  Vec3 force_n_ = Vec3::Zero();
};

/// The taxels of the newest tick of a servo whose tool is such a shell, for another thread than the
/// servo's: `model` is one of that thread's own, on the same field, and feels the tick once more.
/// The pressures are as much smaller as the safety stage made the force.
/// @param t [s] of the field
[[nodiscard]] TaxelMap taxels_of(ShellModel& model, const Published& seen, double t,
                                 const Vec3& right, double pitch_mm = 0) noexcept;

}  // namespace beatlas::haptics
