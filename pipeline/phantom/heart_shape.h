#pragma once
/// The heart at one moment, as primitives and the solids made of them; heart frame [mm], scaled.

#include <array>
#include <optional>

#include "pipeline/phantom/anatomy.h"
#include "pipeline/phantom/part.h"
#include "pipeline/phantom/solid.h"

namespace beatlas::phantom {

struct AtriumShape {
  Ellipsoid blood;
  Ellipsoid outer;
};

struct AortaShape {
  Ellipsoid lumen;  ///< a cylinder along z
  Ellipsoid outer;
  double foot_z_mm = 0;  ///< of the wall, a little below the base plane
  double top_z_mm = 0;
};

struct FatShape {
  Ellipsoid lv;
  Ellipsoid rv;
  double lv_top_z_mm = 0;
  double rv_top_z_mm = 0;
};

/// Still, whatever the moment.
struct InfarctShape {
  Ellipsoid cavity;
  Ellipsoid epicardium;
  Ellipsoid cavity_ball;
  Ellipsoid epicardium_ball;
};

struct HeartShape {
  Ellipsoid lv_cavity;
  Ellipsoid lv_epicardium;
  double lv_base_z_mm = 0;
  Ellipsoid rv_cavity;
  Ellipsoid rv_outer;
  double rv_cut_z_mm = 0;
  std::optional<AtriumShape> la;
  std::optional<AtriumShape> ra;
  std::optional<AortaShape> aorta;
  std::optional<std::array<Ellipsoid, 2>> papillary_muscles;
  std::optional<FatShape> fat;
  std::optional<InfarctShape> infarct;
};

/// The LV wall across follows from the muscle's volume at end diastole (without infarct):
///   V = pi A^2 (b - b^3 / (3 C^2) + 2 C / 3)  for semi-axes A, A, C cut b above the centre.
/// Every other length is linear in s.
/// @param s share of the stroke volume that has left, 0..1 (and a little beyond)
[[nodiscard]] HeartShape heart_shape(const Anatomy& anatomy, double s);

/// The shell of the LV's wall between whose cavity and itself lies the share `mural` (0..1) of the
/// muscle's volume; 0 is the endocardium, 1 the epicardium (without infarct).
[[nodiscard]] Ellipsoid lv_shell(const Anatomy& anatomy, double s, double mural);

/// Turn about the long axis, from the RV toward the front, of what lies at a height 0 (apex) .. 1
/// (base).
[[nodiscard]] double torsion_rad(const Anatomy& anatomy, double s, double height);

struct Construction {
  std::vector<Primitive> primitives;
  std::vector<Cell> cells;  ///< none: the heart has no such part
};

/// The same primitives in the same order at every moment of one anatomy.
[[nodiscard]] Construction construction(const HeartShape& shape, Part part);

/// d/ds of the primitives of a part, as Solid::outward_speed takes them; central difference, error
/// below 1e-7 of a rate.
[[nodiscard]] std::vector<Primitive> primitive_rates(const Anatomy& anatomy, double s, Part part);

/// Volume [ml] of an ellipsoid below the plane z = cut_z_mm.
[[nodiscard]] double cut_ellipsoid_ml(const Ellipsoid& ellipsoid, double cut_z_mm);

/// @throws Error{InvalidInput} if a wall is too thin in some phase, or bodies that must not touch
/// do.
void check_walls(const Anatomy& anatomy);

}  // namespace beatlas::phantom
