#include "pipeline/phantom/heart_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "runtime/base/error.h"

namespace beatlas::phantom {
namespace {

double mix(double from, double to, double s) { return from + (to - from) * s; }

LvState mix(const LvState& a, const LvState& b, double s) {
  return {mix(a.radius_mm, b.radius_mm, s), mix(a.length_mm, b.length_mm, s),
          mix(a.base_mm, b.base_mm, s), mix(a.apex_wall_mm, b.apex_wall_mm, s)};
}

/// Volume over pi A^2 of an ellipsoid with semi-axes A, A, c below b above its centre.
double cut_length_mm(double c, double b) { return b - b * b * b / (3.0 * c * c) + 2.0 * c / 3.0; }

double cut_ellipsoid_over_pi(double radius, double length, double base) {
  return radius * radius * cut_length_mm(length, base);
}

/// Unscaled.
Ellipsoid shell_of(const Anatomy& anatomy, const LvState& lv, double mural) {
  const LvState& ed = anatomy.lv_end_diastole;
  const double muscle = cut_ellipsoid_over_pi(ed.radius_mm + anatomy.lv_wall_mm,
                                              ed.length_mm + ed.apex_wall_mm, ed.base_mm) -
                        cut_ellipsoid_over_pi(ed.radius_mm, ed.length_mm, ed.base_mm);
  const double cavity = cut_ellipsoid_over_pi(lv.radius_mm, lv.length_mm, lv.base_mm);
  const double length = lv.length_mm + mural * lv.apex_wall_mm;
  const double radius =
      std::sqrt((cavity + mural * muscle) / cut_ellipsoid_over_pi(1.0, length, lv.base_mm));
  return {{0, 0, anatomy.apex_mm + lv.apex_wall_mm + lv.length_mm}, {radius, radius, length}};
}

Ellipsoid grown(const Ellipsoid& e, double by_mm) {
  return {e.centre_mm, e.semi_axes_mm + Vec3::Constant(by_mm)};
}

Ellipsoid moved(Ellipsoid e, const Vec3& by_mm) {
  e.centre_mm += by_mm;
  return e;
}

Ellipsoid ball(const Vec3& centre, double radius) { return {centre, Vec3::Constant(radius)}; }

/// On the plane z = valve_z, which cuts it in a disc of the valve's radius.
AtriumShape atrium_shape(const Atria& atria, const Atrium& atrium, double s, double axis_x,
                         double valve_z) {
  const double radius = mix(atrium.radius_end_diastole_mm, atrium.radius_end_systole_mm, s);
  const double height = std::sqrt(radius * radius - atria.valve_radius_mm * atria.valve_radius_mm);
  const Vec3 centre(axis_x + atrium.x_mm, atrium.y_mm, valve_z + height);
  return {ball(centre, radius), ball(centre, radius + atria.wall_mm)};
}

std::array<Ellipsoid, 2> papillary_shape(const PapillaryMuscles& muscles, double s,
                                         double cavity_radius, double centre_z, double turn_rad) {
  const double radius = mix(muscles.radius_end_diastole_mm, muscles.radius_end_systole_mm, s);
  const double half =
      mix(muscles.half_length_end_diastole_mm, muscles.half_length_end_systole_mm, s);
  std::array<Ellipsoid, 2> out;
  // On the side of the free wall, in front and behind.
  constexpr std::array<double, 2> kAnglesDeg{130.0, 235.0};
  for (std::size_t n = 0; n < out.size(); ++n) {
    const double angle = kAnglesDeg[n] * std::numbers::pi / 180.0 + turn_rad;
    const double off = muscles.off_axis * cavity_radius;
    out[n] = {Vec3(off * std::cos(angle), off * std::sin(angle), centre_z - 0.4 * half),
              Vec3(radius, radius, half)};
  }
  return out;
}

InfarctShape infarct_shape(const Anatomy& anatomy) {
  const Infarct& infarct = anatomy.infarct;
  const LvState& ed = anatomy.lv_end_diastole;
  const Ellipsoid cavity = shell_of(anatomy, ed, 0.0);
  const Ellipsoid epicardium = shell_of(anatomy, ed, 1.0);
  const double angle = infarct.angle_deg * std::numbers::pi / 180.0;
  const double u = std::clamp((infarct.z_mm - cavity.centre_mm.z()) / ed.length_mm, -0.98, 0.98);
  const double radius = ed.radius_mm * std::sqrt((1.0 - u) * (1.0 + u)) + 0.5 * anatomy.lv_wall_mm;
  const Vec3 centre(radius * std::cos(angle), radius * std::sin(angle), infarct.z_mm);
  // Beside the ball of the cavity there is muscle all round.
  const double rim = std::max(2.0, anatomy.lv_wall_mm - infarct.thinning_mm);
  return {grown(cavity, infarct.thinning_mm), grown(epicardium, infarct.bulge_mm),
          ball(centre, infarct.radius_mm), ball(centre, infarct.radius_mm + rim)};
}

void scale(Ellipsoid& e, double k) {
  e.centre_mm *= k;
  e.semi_axes_mm *= k;
}

void scale(HeartShape& shape, double k) {
  for (Ellipsoid* e : {&shape.lv_cavity, &shape.lv_epicardium, &shape.rv_cavity, &shape.rv_outer}) {
    scale(*e, k);
  }
  shape.lv_base_z_mm *= k;
  shape.rv_cut_z_mm *= k;
  for (auto* atrium : {&shape.la, &shape.ra}) {
    if (!*atrium) continue;
    scale((*atrium)->blood, k);
    scale((*atrium)->outer, k);
  }
  if (shape.aorta) {
    scale(shape.aorta->lumen, k);
    scale(shape.aorta->outer, k);
    shape.aorta->foot_z_mm *= k;
    shape.aorta->top_z_mm *= k;
  }
  if (shape.papillary_muscles) {
    for (Ellipsoid& e : *shape.papillary_muscles) scale(e, k);
  }
  if (shape.fat) {
    scale(shape.fat->lv, k);
    scale(shape.fat->rv, k);
    shape.fat->lv_top_z_mm *= k;
    shape.fat->rv_top_z_mm *= k;
  }
  if (shape.infarct) {
    for (Ellipsoid* e : {&shape.infarct->cavity, &shape.infarct->epicardium,
                         &shape.infarct->cavity_ball, &shape.infarct->epicardium_ball}) {
      scale(*e, k);
    }
  }
}

/// index + 1 of a primitive for its inside, the negative for its outside.
using Literals = std::vector<int>;

class Builder {
 public:
  int add(const Primitive& primitive) {
    out_.primitives.push_back(primitive);
    return static_cast<int>(out_.primitives.size());
  }
  void cell(const Literals& literals) {
    Cell cell;
    for (int literal : literals) cell.push_back({std::abs(literal) - 1, literal > 0});
    out_.cells.push_back(std::move(cell));
  }
  /// The intersection of `literals`, outside of the intersection of `bodies`: outside of any.
  void cell_without(const Literals& literals, const Literals& bodies) {
    for (int body : bodies) {
      Literals each = literals;
      each.push_back(-body);
      cell(each);
    }
  }
  Construction take() { return std::move(out_); }

 private:
  Construction out_;
};

/// What stands on the ventricles: atria and aorta with their walls, the still part of an infarct.
/// The caps of the atria below the valve planes lie in the ventricles.
void add_rest_of_heart(Builder& b, const HeartShape& shape) {
  if (shape.la) b.cell({b.add(shape.la->outer)});
  if (shape.ra) b.cell({b.add(shape.ra->outer)});
  if (shape.aorta) {
    b.cell({b.add(shape.aorta->outer), -b.add(Below{shape.aorta->foot_z_mm}),
            b.add(Below{shape.aorta->top_z_mm})});
  }
  if (shape.infarct) {
    b.cell({b.add(shape.infarct->epicardium), b.add(shape.infarct->epicardium_ball)});
  }
}

Construction heart(const HeartShape& shape) {
  Builder b;
  b.cell({b.add(shape.lv_epicardium), b.add(Below{shape.lv_base_z_mm})});
  b.cell({b.add(shape.rv_outer), b.add(Below{shape.rv_cut_z_mm})});
  add_rest_of_heart(b, shape);
  return b.take();
}

Construction lv_blood(const HeartShape& shape) {
  Builder b;
  b.cell({b.add(shape.lv_cavity), b.add(Below{shape.lv_base_z_mm})});
  if (shape.infarct) {
    b.cell({b.add(shape.infarct->cavity), b.add(shape.infarct->cavity_ball)});
  }
  return b.take();
}

Construction lv_myocardium(const HeartShape& shape) {
  Builder b;
  const int epicardium = b.add(shape.lv_epicardium);
  const int cavity = b.add(shape.lv_cavity);
  const int base = b.add(Below{shape.lv_base_z_mm});
  if (!shape.infarct) {
    b.cell({epicardium, -cavity, base});
    return b.take();
  }
  const int still_cavity = b.add(shape.infarct->cavity);
  const int cavity_ball = b.add(shape.infarct->cavity_ball);
  const int still = b.add(shape.infarct->epicardium);
  const int ball = b.add(shape.infarct->epicardium_ball);
  for (int outside : {still_cavity, cavity_ball}) {
    b.cell({epicardium, -cavity, base, -outside});
    b.cell({still, ball, -cavity, -outside});
  }
  return b.take();
}

Construction rv(const HeartShape& shape, bool wall) {
  Builder b;
  const int cavity = b.add(shape.rv_cavity);
  const int epicardium = b.add(shape.lv_epicardium);
  const int cut = b.add(Below{shape.rv_cut_z_mm});
  const Literals cell = wall ? Literals{b.add(shape.rv_outer), -cavity, -epicardium, cut}
                             : Literals{cavity, -epicardium, cut};
  if (shape.infarct) {
    b.cell_without(cell, {b.add(shape.infarct->epicardium), b.add(shape.infarct->epicardium_ball)});
  } else {
    b.cell(cell);
  }
  return b.take();
}

Construction la_blood(const HeartShape& shape) {
  Builder b;
  if (!shape.la) return {};
  Literals cell{b.add(shape.la->blood), -b.add(Below{shape.lv_base_z_mm})};
  if (shape.aorta) cell.push_back(-b.add(shape.aorta->outer));
  b.cell(cell);
  return b.take();
}

Construction ra_blood(const HeartShape& shape) {
  Builder b;
  if (!shape.ra) return {};
  Literals cell{b.add(shape.ra->blood), -b.add(Below{shape.rv_cut_z_mm})};
  if (shape.la) cell.push_back(-b.add(shape.la->outer));
  if (shape.aorta) cell.push_back(-b.add(shape.aorta->outer));
  // Over the LV it may reach down to the base plane.
  b.cell_without(cell, {b.add(shape.lv_epicardium), b.add(Below{shape.lv_base_z_mm})});
  return b.take();
}

Construction aorta(const HeartShape& shape) {
  Builder b;
  if (!shape.aorta) return {};
  b.cell({b.add(shape.aorta->lumen), -b.add(Below{shape.lv_base_z_mm}),
          b.add(Below{shape.aorta->top_z_mm})});
  return b.take();
}

Construction papillary_muscles(const HeartShape& shape) {
  Builder b;
  if (!shape.papillary_muscles) return {};
  const int cavity = b.add(shape.lv_cavity);
  const int base = b.add(Below{shape.lv_base_z_mm});
  for (const Ellipsoid& muscle : *shape.papillary_muscles) b.cell({b.add(muscle), cavity, base});
  return b.take();
}

Construction pericardial_fat(const HeartShape& shape) {
  Builder b;
  if (!shape.fat) return {};
  b.cell({b.add(shape.fat->lv), b.add(Below{shape.fat->lv_top_z_mm})});
  b.cell({b.add(shape.fat->rv), b.add(Below{shape.fat->rv_top_z_mm})});
  add_rest_of_heart(b, shape);  // the ventricles lie within their fat
  return b.take();
}

}  // namespace

Ellipsoid lv_shell(const Anatomy& anatomy, double s, double mural) {
  Ellipsoid out = shell_of(anatomy, mix(anatomy.lv_end_diastole, anatomy.lv_end_systole, s), mural);
  scale(out, anatomy.scale);
  return out;
}

double torsion_rad(const Anatomy& anatomy, double s, double height) {
  return (1.0 - height) * s * anatomy.torsion_deg * std::numbers::pi / 180.0;
}

HeartShape heart_shape(const Anatomy& anatomy, double s) {
  const LvState state = mix(anatomy.lv_end_diastole, anatomy.lv_end_systole, s);
  const RvState& rd = anatomy.rv_end_diastole;
  const RvState& rs = anatomy.rv_end_systole;
  HeartShape out;
  out.lv_cavity = shell_of(anatomy, state, 0.0);
  out.lv_epicardium = shell_of(anatomy, state, 1.0);
  const double centre_z = out.lv_cavity.centre_mm.z();
  out.lv_base_z_mm = centre_z + state.base_mm;
  out.rv_cavity = {
      {mix(rd.centre_x_mm, rs.centre_x_mm, s), 0.0, mix(rd.centre_z_mm, rs.centre_z_mm, s)},
      rd.semi_axes_mm + (rs.semi_axes_mm - rd.semi_axes_mm) * s};
  out.rv_outer = grown(out.rv_cavity, anatomy.rv_wall_mm);
  out.rv_cut_z_mm = mix(rd.cut_mm, rs.cut_mm, s);
  if (anatomy.atria.present) {
    out.la = atrium_shape(anatomy.atria, anatomy.atria.left, s, 0.0, out.lv_base_z_mm);
    out.ra = atrium_shape(anatomy.atria, anatomy.atria.right, s, out.rv_cavity.centre_mm.x(),
                          out.rv_cut_z_mm);
  }
  if (anatomy.aorta.present) {
    const AortaRoot& aorta = anatomy.aorta;
    constexpr double kFootMm = 1.0;  // the wall starts within the muscle
    const double outer = aorta.radius_mm + aorta.wall_mm;
    const double endless = std::numeric_limits<double>::infinity();
    const Vec3 centre(aorta.x_mm, aorta.y_mm, out.lv_base_z_mm);
    out.aorta = AortaShape{{centre, {aorta.radius_mm, aorta.radius_mm, endless}},
                           {centre, {outer, outer, endless}},
                           out.lv_base_z_mm - kFootMm,
                           out.lv_base_z_mm + aorta.length_mm};
  }
  if (anatomy.papillary_muscles.present) {
    // They turn with the wall they spring from, half-way up.
    out.papillary_muscles = papillary_shape(anatomy.papillary_muscles, s, state.radius_mm, centre_z,
                                            torsion_rad(anatomy, s, 0.5));
  }
  if (anatomy.pericardial_fat.present) {
    // An ellipsoid grown by half and moved by half would touch the old one behind.
    constexpr double kBehindMm = 0.1;
    const double half = 0.5 * anatomy.pericardial_fat.front_mm;
    const Vec3 forward(0.0, half, 0.0);
    out.fat = FatShape{moved(grown(out.lv_epicardium, half + kBehindMm), forward),
                       moved(grown(out.rv_outer, half + kBehindMm), forward),
                       out.lv_base_z_mm + half, out.rv_cut_z_mm + half};
  }
  if (anatomy.infarct.present) out.infarct = infarct_shape(anatomy);
  scale(out, anatomy.scale);
  return out;
}

Construction construction(const HeartShape& shape, Part part) {
  switch (part) {
    case Part::Heart:
      return heart(shape);
    case Part::LvBlood:
      return lv_blood(shape);
    case Part::RvBlood:
      return rv(shape, false);
    case Part::LvMyocardium:
      return lv_myocardium(shape);
    case Part::RvWall:
      return rv(shape, true);
    case Part::LaBlood:
      return la_blood(shape);
    case Part::RaBlood:
      return ra_blood(shape);
    case Part::Aorta:
      return aorta(shape);
    case Part::PapillaryMuscles:
      return papillary_muscles(shape);
    case Part::Pericardium:
      return pericardial_fat(shape);
  }
  return {};
}

std::vector<Primitive> primitive_rates(const Anatomy& anatomy, double s, Part part) {
  constexpr double kStep = 1e-4;
  std::vector<Primitive> after = construction(heart_shape(anatomy, s + kStep), part).primitives;
  const std::vector<Primitive> before =
      construction(heart_shape(anatomy, s - kStep), part).primitives;
  constexpr double kPerStep = 0.5 / kStep;
  for (std::size_t n = 0; n < after.size(); ++n) {
    if (auto* ellipsoid = std::get_if<Ellipsoid>(&after[n])) {
      const auto& old = std::get<Ellipsoid>(before[n]);
      ellipsoid->centre_mm = kPerStep * (ellipsoid->centre_mm - old.centre_mm);
      ellipsoid->semi_axes_mm = kPerStep * (ellipsoid->semi_axes_mm - old.semi_axes_mm);
    } else {
      auto& plane = std::get<Below>(after[n]);
      plane.z_mm = kPerStep * (plane.z_mm - std::get<Below>(before[n]).z_mm);
    }
  }
  return after;
}

double cut_ellipsoid_ml(const Ellipsoid& e, double cut_z_mm) {
  const double c = e.semi_axes_mm.z();
  const double b = std::clamp(cut_z_mm - e.centre_mm.z(), -c, c);
  return std::numbers::pi * e.semi_axes_mm.x() * e.semi_axes_mm.y() * cut_length_mm(c, b) * 1e-3;
}

void check_walls(const Anatomy& anatomy) {
  for (double s : {0.0, 0.5, 1.0}) {
    const HeartShape shape = heart_shape(anatomy, s);
    if (!(shape.lv_epicardium.semi_axes_mm.x() > shape.lv_cavity.semi_axes_mm.x() + 0.5)) {
      throw_invalid(
          "anatomy: the LV's muscle is too little for a wall of 0.5 mm in every phase; "
          "raise lv_wall_mm");
    }
    const Construction blood = construction(shape, Part::RvBlood);
    if (Solid(blood.primitives, blood.cells, 2.0).volume_ml() <
        0.05 * cut_ellipsoid_ml(shape.rv_cavity, shape.rv_cut_z_mm)) {
      throw_invalid("anatomy: the RV lies inside the LV; move its centre_x_mm away");
    }
    if (shape.infarct) {
      const Ellipsoid& ball = shape.infarct->epicardium_ball;
      if (ball.centre_mm.z() + ball.semi_axes_mm.z() > shape.lv_base_z_mm) {
        throw_invalid(
            "anatomy/infarct reaches the LV's base plane; lower its z_mm or its radius_mm");
      }
      if (!(shape.infarct->epicardium.semi_axes_mm.x() >
            shape.infarct->cavity.semi_axes_mm.x() + 0.5)) {
        throw_invalid("anatomy/infarct leaves a wall below 0.5 mm; lower its thinning_mm");
      }
    }
  }
}

}  // namespace beatlas::phantom
