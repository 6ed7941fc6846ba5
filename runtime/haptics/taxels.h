#pragma once
/// What a fingertip feels beside the force: how the pressure under it is spread, for tactile
/// displays and for the picture.
///
/// The ball of radius R has gone d deep, along the normal n of the contact. With g(u, v) the gap
/// that would lie between ball and surface if they only just touched, over the plane of contact,
/// Hertz's pressure of a ball or an ellipsoid on a flat or curved body is
///
///   p(u, v) = c K(u, v) sqrt(max(0, d - 2 g(u, v))),   g = r^2 / (2 R) + phi(u, v),
///
/// which for a ball on a plane or on a ball is p0 sqrt(1 - r^2 / a^2) with a^2 = R d (Hertz 1882;
/// Johnson 1985, section 4.2). Where curvatures differ, B over A, the ellipse of contact is (B /
/// A)^(1/2) times as long as wide, for Hertz's about (B / A)^(2/3). phi is the body's own distance
/// over the plane, so that an edge, a groove or a vessel shows; K is the stiffness at the place, so
/// that a scar does. c makes the sum of all pressures the normal force that is felt.
///
/// A fingertip of points (shell.h) knows the pressure at each of them, and fills in a map itself.

#include <array>
#include <memory>

#include "runtime/haptics/contact_field.h"
#include "runtime/haptics/stiffness.h"

namespace beatlas::haptics {

struct Published;

/// A ball that touches; workspace frame.
struct BallContact {
  Vec3 proxy_mm = Vec3::Zero();  ///< where the ball's centre would be, had it not gone in
  Vec3 normal = Vec3::Zero();    ///< outward unit vector; zero: nothing is touched
  Vec3 force_n = Vec3::Zero();   ///< on the user
  double depth_mm = 0;           ///< of the ball's centre under the proxy, along the normal
  Vec3 right = Vec3::UnitX();  ///< which way the columns run; what of it is along n does not count
};

/// The same of the newest tick of a servo whose tool is a ball.
[[nodiscard]] BallContact ball_contact(const Published& seen, const Vec3& right) noexcept;

struct TaxelMap {
  static constexpr int kSide = 8;
  static constexpr std::size_t kTaxels = std::size_t{kSide} * kSide;
  static constexpr double kKpaPerNMm2 = 1000;  ///< 1 N/mm^2 = 1 MPa
  /// Mean pressure on each taxel [kPa], row after row, columns along `right`, rows along `up`.
  std::array<float, kTaxels> pressure_kpa{};
  double pitch_mm = 0;            ///< from taxel to taxel
  double area_mm2 = 0;            ///< of contact
  double peak_kpa = 0;            ///< the greatest pressure anywhere, not of a taxel
  Vec3 centre_mm = Vec3::Zero();  ///< of the map, on the plane of contact
  Vec3 right = Vec3::Zero();      ///< unit vectors; zero where nothing is touched
  Vec3 up = Vec3::Zero();
};

/// A unit vector across the unit vector `n`, along `wished` if that is not along n.
[[nodiscard]] Vec3 across(const Vec3& n, const Vec3& wished) noexcept;

struct TaxelOptions {
  static constexpr double kLeastRadiusMm = 0.5;
  static constexpr double kMostRadiusMm = 50;
  static constexpr double kLeastPitchMm = 0.05;
  static constexpr double kMostPitchMm = 20;
  double radius_mm = 8;  ///< [mm] within these: of the ball
  double pitch_mm = 0;   ///< [mm] 0.05..20; 0: a quarter of the radius, the ball's whole width
  std::shared_ptr<const StiffnessMap> map = nullptr;  ///< as the force model's
};

/// Serves one thread; `under` allocates nothing.
class Taxels {
 public:
  /// @throws Error{InvalidInput} if there is no field or an option is out of range.
  Taxels(std::shared_ptr<const ContactField> field, const TaxelOptions& options);

  /// @param t [s] of the field. A force that pulls or is no number gives a map without pressure.
  [[nodiscard]] TaxelMap under(const BallContact& contact, double t) noexcept;

 private:
  static constexpr int kNodes = TaxelMap::kSide + 1;  ///< corners of taxels, along a side
  using Nodes = std::array<double, std::size_t{kNodes} * kNodes>;
  /// What the parts of taxels in contact have in common.
  struct Touched {
    int parts = 0;
    double peak = 0;  ///< greatest of what is proportional to pressure
  };

  /// Over the parts of a taxel: the sum of what is proportional to pressure.
  /// @param stiffness at the nodes; only read where the options name a map
  [[nodiscard]] double sum_of_parts(int row, int column, double depth_mm, const Nodes& stiffness,
                                    Touched& touched) const noexcept;

  std::shared_ptr<const ContactField> field_;
  TaxelOptions options_;
  std::unique_ptr<ContactBatch> batch_;
  std::array<Vec3, std::size_t{kNodes} * kNodes> points_mm_;
  std::array<FieldSample, std::size_t{kNodes} * kNodes> samples_;
};

}  // namespace beatlas::haptics
