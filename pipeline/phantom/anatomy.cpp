#include "pipeline/phantom/anatomy.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "pipeline/phantom/json_vector.h"

namespace beatlas::phantom {
namespace {

double mix(double from, double to, double s) { return from + (to - from) * s; }

LvState mix(const LvState& a, const LvState& b, double s) {
  return {mix(a.radius_mm, b.radius_mm, s), mix(a.length_mm, b.length_mm, s),
          mix(a.base_mm, b.base_mm, s), mix(a.apex_wall_mm, b.apex_wall_mm, s)};
}

/// Volume over pi A^2 of an ellipsoid with semi-axes A, A, c below b above its centre.
double cut_length_mm(double c, double b) { return b - b * b * b / (3.0 * c * c) + 2.0 * c / 3.0; }

/// Integral of h(x) = q sqrt(1 - ((x - centre) / p)^2) from the left end of the ellipse to x.
double half_area(double p, double q, double centre, double x) {
  const double u = std::clamp((x - centre) / p, -1.0, 1.0);
  return 0.5 * p * q * (u * std::sqrt((1.0 - u) * (1.0 + u)) + std::asin(u) + std::numbers::pi / 2);
}

/// Area common to two ellipses with centres on one horizontal line.
double common_area(const Ellipse& a, const Ellipse& b) {
  const double left = std::max(a.centre_mm.x() - a.semi_x_mm, b.centre_mm.x() - b.semi_x_mm);
  const double right = std::min(a.centre_mm.x() + a.semi_x_mm, b.centre_mm.x() + b.semi_x_mm);
  if (!(left < right)) return 0.0;
  // Squared half heights q^2 (1 - ((x - c) / p)^2) as c0 + c1 x + c2 x^2; they cross at the roots
  // of the difference.
  const auto coefficients = [](const Ellipse& e, double sign, std::array<double, 3>& c) {
    const double ratio = e.semi_y_mm * e.semi_y_mm / (e.semi_x_mm * e.semi_x_mm);
    const double x = e.centre_mm.x();
    c[0] += sign * (e.semi_y_mm * e.semi_y_mm - ratio * x * x);
    c[1] += sign * 2.0 * ratio * x;
    c[2] -= sign * ratio;
  };
  std::array<double, 3> c{};
  coefficients(a, 1.0, c);
  coefficients(b, -1.0, c);
  std::vector<double> cuts{left, right};
  const auto add = [&](double x) {
    if (x > left && x < right) cuts.push_back(x);
  };
  const double discriminant = c[1] * c[1] - 4.0 * c[2] * c[0];
  if (discriminant >= 0.0) {
    const double q = -0.5 * (c[1] + std::copysign(std::sqrt(discriminant), c[1]));
    if (c[2] != 0.0) add(q / c[2]);
    if (q != 0.0) add(c[0] / q);
  }
  std::sort(cuts.begin(), cuts.end());
  double area = 0.0;
  for (std::size_t n = 0; n + 1 < cuts.size(); ++n) {
    const double x = 0.5 * (cuts[n] + cuts[n + 1]);
    const bool a_lower = c[0] + x * (c[1] + x * c[2]) < 0.0;
    const Ellipse& e = a_lower ? a : b;
    area += 2.0 * (half_area(e.semi_x_mm, e.semi_y_mm, e.centre_mm.x(), cuts[n + 1]) -
                   half_area(e.semi_x_mm, e.semi_y_mm, e.centre_mm.x(), cuts[n]));
  }
  return area;
}

template <class F>
double adaptive_simpson(const F& f, double a, double fa, double m, double fm, double b, double fb,
                        double whole, double tolerance, int depth) {
  const double left_m = 0.5 * (a + m);
  const double right_m = 0.5 * (m + b);
  const double fl = f(left_m);
  const double fr = f(right_m);
  const double left = (m - a) / 6.0 * (fa + 4.0 * fl + fm);
  const double right = (b - m) / 6.0 * (fm + 4.0 * fr + fb);
  const double error = left + right - whole;
  if (depth <= 0 || std::abs(error) <= 15.0 * tolerance) return left + right + error / 15.0;
  return adaptive_simpson(f, a, fa, left_m, fl, m, fm, left, 0.5 * tolerance, depth - 1) +
         adaptive_simpson(f, m, fm, right_m, fr, b, fb, right, 0.5 * tolerance, depth - 1);
}

nlohmann::json lv_to_json(const LvState& lv) {
  return {{"radius_mm", lv.radius_mm},
          {"length_mm", lv.length_mm},
          {"base_mm", lv.base_mm},
          {"apex_wall_mm", lv.apex_wall_mm}};
}

nlohmann::json rv_to_json(const RvState& rv) {
  return {{"centre_x_mm", rv.centre_x_mm},
          {"centre_z_mm", rv.centre_z_mm},
          {"semi_axes_mm", to_json(rv.semi_axes_mm)},
          {"cut_mm", rv.cut_mm}};
}

void read_lv(JsonObject& parent, const std::string& key, LvState& lv) {
  if (!parent.has(key)) return;
  JsonObject object(parent.at(key), parent.path() + "/" + key);
  object.read("radius_mm", lv.radius_mm, 3.0, 80.0);
  object.read("length_mm", lv.length_mm, 5.0, 120.0);
  object.read("base_mm", lv.base_mm, -100.0, 100.0);
  object.read("apex_wall_mm", lv.apex_wall_mm, 0.5, 40.0);
  object.finish();
}

void read_rv(JsonObject& parent, const std::string& key, RvState& rv) {
  if (!parent.has(key)) return;
  JsonObject object(parent.at(key), parent.path() + "/" + key);
  object.read("centre_x_mm", rv.centre_x_mm, -100.0, 100.0);
  object.read("centre_z_mm", rv.centre_z_mm, -100.0, 100.0);
  read_vector(object, "semi_axes_mm", rv.semi_axes_mm, 3.0, 120.0);
  object.read("cut_mm", rv.cut_mm, -150.0, 150.0);
  object.finish();
}

}  // namespace

Affine lps_from_heart(const Anatomy& anatomy) {
  const Vec3 z = -anatomy.apex_direction_lps.normalized();
  const Vec3 x = (anatomy.rv_direction_lps - anatomy.rv_direction_lps.dot(z) * z).normalized();
  Affine out = Affine::Identity();
  out.linear().col(0) = x;
  out.linear().col(1) = z.cross(x);
  out.linear().col(2) = z;
  out.translation() = anatomy.origin_lps_mm;
  return out;
}

HeartShape heart_shape(const Anatomy& anatomy, double s) {
  const double k = anatomy.scale;
  const LvState& ed = anatomy.lv_end_diastole;
  const LvState lv = mix(ed, anatomy.lv_end_systole, s);
  const auto epicardial_ml_over_pi = [&](double radius, const LvState& state) {
    return radius * radius * cut_length_mm(state.length_mm + state.apex_wall_mm, state.base_mm);
  };
  const auto cavity_ml_over_pi = [](const LvState& state) {
    return state.radius_mm * state.radius_mm * cut_length_mm(state.length_mm, state.base_mm);
  };
  const double muscle =
      epicardial_ml_over_pi(ed.radius_mm + anatomy.lv_wall_mm, ed) - cavity_ml_over_pi(ed);
  const double radius =
      std::sqrt((cavity_ml_over_pi(lv) + muscle) / epicardial_ml_over_pi(1.0, lv));
  const double centre_z = anatomy.apex_mm + lv.apex_wall_mm + lv.length_mm;
  const double long_epi = lv.length_mm + lv.apex_wall_mm;

  const RvState& rd = anatomy.rv_end_diastole;
  const RvState& rs = anatomy.rv_end_systole;
  const Vec3 rv_centre(mix(rd.centre_x_mm, rs.centre_x_mm, s), 0.0,
                       mix(rd.centre_z_mm, rs.centre_z_mm, s));
  const Vec3 rv_axes = rd.semi_axes_mm + (rs.semi_axes_mm - rd.semi_axes_mm) * s;

  HeartShape out;
  out.lv_cavity = {k * Vec3(0, 0, centre_z), k * Vec3(lv.radius_mm, lv.radius_mm, lv.length_mm)};
  out.lv_epicardium = {k * Vec3(0, 0, centre_z), k * Vec3(radius, radius, long_epi)};
  out.lv_base_z_mm = k * (centre_z + lv.base_mm);
  out.rv_cavity = {k * rv_centre, k * rv_axes};
  out.rv_outer = {k * rv_centre, k * Vec3(rv_axes + Vec3::Constant(anatomy.rv_wall_mm))};
  out.rv_cut_z_mm = k * mix(rd.cut_mm, rs.cut_mm, s);
  return out;
}

double cut_ellipsoid_ml(const Ellipsoid& e, double cut_z_mm) {
  const double c = e.semi_axes_mm.z();
  const double b = std::clamp(cut_z_mm - e.centre_mm.z(), -c, c);
  return std::numbers::pi * e.semi_axes_mm.x() * e.semi_axes_mm.y() * cut_length_mm(c, b) * 1e-3;
}

double common_ml(const Ellipsoid& a, const Ellipsoid& b, double cut_z_mm) {
  const double low =
      std::max(a.centre_mm.z() - a.semi_axes_mm.z(), b.centre_mm.z() - b.semi_axes_mm.z());
  const double high = std::min(
      {a.centre_mm.z() + a.semi_axes_mm.z(), b.centre_mm.z() + b.semi_axes_mm.z(), cut_z_mm});
  if (!(low < high)) return 0.0;
  const auto area = [&](double z) {
    Ellipse first;
    Ellipse second;
    if (!section(a, z, first) || !section(b, z, second)) return 0.0;
    return common_area(first, second);
  };
  // Panels first, so that a change of the sections' kind cannot hide between the three points of
  // the first rule.
  constexpr int kPanels = 16;
  double sum = 0.0;
  for (int n = 0; n < kPanels; ++n) {
    const double from = low + (high - low) * n / kPanels;
    const double to = low + (high - low) * (n + 1) / kPanels;
    const double middle = 0.5 * (from + to);
    const double fa = area(from);
    const double fm = area(middle);
    const double fb = area(to);
    sum += adaptive_simpson(area, from, fa, middle, fm, to, fb,
                            (to - from) / 6.0 * (fa + 4.0 * fm + fb), 1e-5, 24);
  }
  return sum * 1e-3;
}

void check_anatomy(const Anatomy& anatomy) {
  for (const auto& [lv, when] : {std::pair{&anatomy.lv_end_diastole, "lv_end_diastole"},
                                 std::pair{&anatomy.lv_end_systole, "lv_end_systole"}}) {
    if (std::abs(lv->base_mm) >= 0.95 * lv->length_mm) {
      throw_invalid(std::string("anatomy/") + when +
                    "/base_mm must cut the cavity: less than 0.95 of its length_mm");
    }
  }
  for (const auto& [rv, when] : {std::pair{&anatomy.rv_end_diastole, "rv_end_diastole"},
                                 std::pair{&anatomy.rv_end_systole, "rv_end_systole"}}) {
    if (std::abs(rv->cut_mm - rv->centre_z_mm) >= 0.95 * rv->semi_axes_mm.z()) {
      throw_invalid(std::string("anatomy/") + when +
                    "/cut_mm must cut the cavity: within 0.95 of its z semi-axis of its centre");
    }
  }
  const Vec3 z = anatomy.apex_direction_lps;
  if (!(z.norm() > 1e-3) || !(anatomy.rv_direction_lps.cross(z).norm() > 1e-3)) {
    throw_invalid("anatomy/apex_direction_lps and rv_direction_lps must be two directions");
  }
  for (int n = 0; n <= 10; ++n) {
    const HeartShape shape = heart_shape(anatomy, 0.1 * n);
    if (!(shape.lv_epicardium.semi_axes_mm.x() > shape.lv_cavity.semi_axes_mm.x() + 0.5)) {
      throw_invalid(
          "anatomy: the LV's muscle is too little for a wall of 0.5 mm in every phase; "
          "raise lv_wall_mm");
    }
    if (common_ml(shape.lv_epicardium, shape.rv_cavity, shape.rv_cut_z_mm) >
        0.95 * cut_ellipsoid_ml(shape.rv_cavity, shape.rv_cut_z_mm)) {
      throw_invalid("anatomy: the RV lies inside the LV; move its centre_x_mm away");
    }
  }
}

nlohmann::json anatomy_to_json(const Anatomy& a) {
  return {{"lv_end_diastole", lv_to_json(a.lv_end_diastole)},
          {"lv_end_systole", lv_to_json(a.lv_end_systole)},
          {"lv_wall_mm", a.lv_wall_mm},
          {"apex_mm", a.apex_mm},
          {"rv_end_diastole", rv_to_json(a.rv_end_diastole)},
          {"rv_end_systole", rv_to_json(a.rv_end_systole)},
          {"rv_wall_mm", a.rv_wall_mm},
          {"origin_lps_mm", to_json(a.origin_lps_mm)},
          {"apex_direction_lps", to_json(a.apex_direction_lps)},
          {"rv_direction_lps", to_json(a.rv_direction_lps)},
          {"scale", a.scale}};
}

Anatomy anatomy_from_json(const nlohmann::json& json, const std::string& path) {
  Anatomy a;
  JsonObject object(json, path);
  read_lv(object, "lv_end_diastole", a.lv_end_diastole);
  read_lv(object, "lv_end_systole", a.lv_end_systole);
  object.read("lv_wall_mm", a.lv_wall_mm, 1.0, 40.0);
  object.read("apex_mm", a.apex_mm, -150.0, 0.0);
  read_rv(object, "rv_end_diastole", a.rv_end_diastole);
  read_rv(object, "rv_end_systole", a.rv_end_systole);
  object.read("rv_wall_mm", a.rv_wall_mm, 0.5, 20.0);
  read_vector(object, "origin_lps_mm", a.origin_lps_mm, -2000.0, 2000.0);
  read_vector(object, "apex_direction_lps", a.apex_direction_lps, -1.0, 1.0);
  read_vector(object, "rv_direction_lps", a.rv_direction_lps, -1.0, 1.0);
  object.read("scale", a.scale, 0.3, 1.6);
  object.finish();
  return a;
}

}  // namespace beatlas::phantom
