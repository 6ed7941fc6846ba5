#pragma once
/// The phantom: a beating heart whose every surface is known in closed form at every moment.
///
/// Parts (part.h): lv_blood and lv_myocardium from two ellipsoids of revolution cut at the base
/// plane; rv_blood an ellipsoid cut flat, without the LV's epicardial ellipsoid; the atria spheres
/// on the valve planes, the aorta a cylinder; heart, filled, the LV's epicardial ellipsoid to its
/// base plane united with the RV's outer ellipsoid to its own and what stands on them with its
/// walls. All points patient LPS [mm], times [s] taken modulo R-R.

#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "pipeline/phantom/heart_shape.h"
#include "pipeline/phantom/spec.h"

namespace beatlas::phantom {

/// The phantom at one moment. Immutable, thread-safe; each part is built when first asked for, in
/// some milliseconds.
class Frame {
 public:
  /// @param s share of the stroke volume that has left, 0..1
  Frame(const Anatomy& anatomy, double s);

  /// Whether this heart has the part.
  [[nodiscard]] bool has(PartArgument part) const { return !solid(part).empty(); }
  /// Signed distance [mm] to the part's boundary, negative inside; exact to 1e-7 mm. Infinite if
  /// the heart has no such part.
  [[nodiscard]] double distance_mm(PartArgument part, const Vec3& lps) const;
  /// The same with the nearest point and the outward unit normal there, in LPS.
  [[nodiscard]] Nearest nearest(PartArgument part, const Vec3& lps) const;
  [[nodiscard]] bool contains(PartArgument part, const Vec3& lps) const;
  /// How far the surface nearest to lps moves along its outward normal while s changes by one
  /// [mm]: minus d distance / d s, in closed form.
  [[nodiscard]] double surface_speed_mm(PartArgument part, const Vec3& lps) const;
  /// See atlas Label; atria, aorta and RV wall are the rest of the heart.
  [[nodiscard]] std::uint8_t label_at(const Vec3& lps) const;
  /// To 1e-4 ml, see Solid::volume_ml.
  [[nodiscard]] double volume_ml(PartArgument part) const { return solid(part).volume_ml(); }
  /// Distance to the nearest crease of the part's surface, see Solid.
  [[nodiscard]] double crease_distance_mm(PartArgument part, const Vec3& lps) const;
  /// Points on the part's surface, about spacing_mm apart. Deterministic.
  [[nodiscard]] std::vector<Vec3> sample_surface(PartArgument part, double spacing_mm) const;

  [[nodiscard]] const HeartShape& shape() const { return shape_; }

 private:
  struct Built {
    std::once_flag solid_once;
    std::once_flag rates_once;
    std::unique_ptr<const Solid> solid;
    std::vector<Primitive> rates;
  };
  [[nodiscard]] const Solid& solid(Part part) const;

  Anatomy anatomy_;
  double s_;
  HeartShape shape_;
  Affine lps_from_heart_;
  Affine heart_from_lps_;
  mutable std::array<Built, kAllParts.size()> built_;
};

class Phantom {
 public:
  /// @throws Error{InvalidInput} as check_spec.
  explicit Phantom(PhantomSpec spec);

  [[nodiscard]] const PhantomSpec& spec() const { return spec_; }
  /// Time of phase p: p / phases of the R-R interval.
  [[nodiscard]] double phase_time_s(int phase) const;
  /// SHA-256 of the spec: two phantoms are the same if and only if theirs are.
  [[nodiscard]] const std::string& identity() const { return identity_; }

  /// The phantom at t, kept for a while. Thread-safe.
  [[nodiscard]] std::shared_ptr<const Frame> frame(double t_s) const;

  [[nodiscard]] double distance_mm(PartArgument part, const Vec3& lps, double t_s) const;
  [[nodiscard]] bool contains(PartArgument part, const Vec3& lps, double t_s) const;
  /// Gradient of the distance: the outward unit normal of the nearest surface point.
  [[nodiscard]] Vec3 normal(PartArgument part, const Vec3& lps, double t_s) const;
  /// Velocity [mm/s] of the surface nearest to lps along its outward normal: minus the time
  /// derivative of the distance, in closed form (Frame::surface_speed_mm times ds/dt).
  [[nodiscard]] double velocity_mm_s(PartArgument part, const Vec3& lps, double t_s) const;
  [[nodiscard]] double volume_ml(PartArgument part, double t_s) const;
  [[nodiscard]] std::uint8_t label_at(const Vec3& lps, double t_s) const;
  /// Whether lps is within band_mm of a crease of the part's surface.
  [[nodiscard]] bool on_crease(PartArgument part, const Vec3& lps, double t_s,
                               double band_mm) const;
  [[nodiscard]] std::vector<Vec3> sample_surface(PartArgument part, double t_s,
                                                 double spacing_mm) const;

 private:
  struct Cache;

  PhantomSpec spec_;
  std::string identity_;
  std::shared_ptr<Cache> cache_;
};

}  // namespace beatlas::phantom
