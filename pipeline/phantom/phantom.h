#pragma once
/// The phantom: a beating heart whose every surface is known in closed form at every moment.
///
/// Structures (runtime/atlas/structures.h): lv_blood and lv_myocardium from two ellipsoids of
/// revolution cut at the base plane; rv_blood an ellipsoid cut flat, without the LV's epicardial
/// ellipsoid; heart, filled, the LV's epicardial ellipsoid to its base plane united with the RV's
/// outer ellipsoid to its own. All points patient LPS [mm], times [s] taken modulo R-R.

#include <memory>
#include <vector>

#include "pipeline/phantom/solid.h"
#include "pipeline/phantom/spec.h"
#include "runtime/atlas/structures.h"

namespace beatlas::phantom {

/// The phantom at one moment. Immutable, thread-safe.
class Frame {
 public:
  /// @param s share of the stroke volume that has left, 0..1
  Frame(const Anatomy& anatomy, double s);

  /// Signed distance [mm] to the structure's boundary, negative inside; exact to 1e-7 mm.
  [[nodiscard]] double distance_mm(Structure structure, const Vec3& lps) const;
  /// The same with the nearest point and the outward unit normal there, in LPS.
  [[nodiscard]] Nearest nearest(Structure structure, const Vec3& lps) const;
  [[nodiscard]] bool contains(Structure structure, const Vec3& lps) const;
  /// See atlas Label; the structures do not overlap but for `heart`, which holds all.
  [[nodiscard]] std::uint8_t label_at(const Vec3& lps) const;
  /// Exact for the LV; for rv_blood and heart to 1e-5 ml (see common_ml).
  [[nodiscard]] double volume_ml(Structure structure) const;
  /// Distance to the nearest crease of the structure's surface, to 0.15 mm.
  [[nodiscard]] double crease_distance_mm(Structure structure, const Vec3& lps) const;
  /// Points on the structure's surface, about spacing_mm apart. Deterministic.
  [[nodiscard]] std::vector<Vec3> sample_surface(Structure structure, double spacing_mm) const;

  [[nodiscard]] const HeartShape& shape() const { return shape_; }

 private:
  [[nodiscard]] const Solid& solid(Structure structure) const;

  HeartShape shape_;
  Affine lps_from_heart_;
  Affine heart_from_lps_;
  std::vector<Solid> solids_;  // in the order of kAllStructures
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

  /// The phantom at t; built in about a millisecond and kept for a while. Thread-safe.
  [[nodiscard]] std::shared_ptr<const Frame> frame(double t_s) const;

  [[nodiscard]] double distance_mm(Structure structure, const Vec3& lps, double t_s) const;
  [[nodiscard]] bool contains(Structure structure, const Vec3& lps, double t_s) const;
  /// Gradient of the distance: the outward unit normal of the nearest surface point.
  [[nodiscard]] Vec3 normal(Structure structure, const Vec3& lps, double t_s) const;
  /// Velocity [mm/s] of the surface nearest to lps along its outward normal: minus the time
  /// derivative of the distance, a central difference over 60 us (error below 0.01 mm/s).
  [[nodiscard]] double velocity_mm_s(Structure structure, const Vec3& lps, double t_s) const;
  [[nodiscard]] double volume_ml(Structure structure, double t_s) const;
  [[nodiscard]] std::uint8_t label_at(const Vec3& lps, double t_s) const;
  /// Whether lps is within band_mm of a crease of the structure's surface.
  [[nodiscard]] bool on_crease(Structure structure, const Vec3& lps, double t_s,
                               double band_mm) const;
  [[nodiscard]] std::vector<Vec3> sample_surface(Structure structure, double t_s,
                                                 double spacing_mm) const;

 private:
  struct Cache;

  PhantomSpec spec_;
  std::string identity_;
  std::shared_ptr<Cache> cache_;
};

}  // namespace beatlas::phantom
