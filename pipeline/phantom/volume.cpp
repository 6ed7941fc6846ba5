#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "pipeline/phantom/crossings.h"
#include "pipeline/phantom/solid.h"

namespace beatlas::phantom {
namespace {

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

/// Half of the integral of x dy - y dx along an arc of an ellipse.
double swept_mm2(const Ellipse& e, double from, double to) {
  return 0.5 * (e.semi_x_mm * e.semi_y_mm * (to - from) +
                e.centre_mm.x() * e.semi_y_mm * (std::sin(to) - std::sin(from)) -
                e.centre_mm.y() * e.semi_x_mm * (std::cos(to) - std::cos(from)));
}

/// [primitive] Its section by a plane z = z_mm; none where it has no ellipse there.
using Sections = std::vector<std::optional<Ellipse>>;

Sections sections_at(const std::vector<Primitive>& primitives, double z_mm) {
  Sections out(primitives.size());
  for (std::size_t n = 0; n < primitives.size(); ++n) {
    const auto* ellipsoid = std::get_if<Ellipsoid>(&primitives[n]);
    Ellipse ellipse;
    if (ellipsoid != nullptr && section(*ellipsoid, z_mm, ellipse)) out[n] = ellipse;
  }
  return out;
}

/// Whether a point of the plane z = z_mm is in a primitive.
bool primitive_holds(const Primitive& primitive, const Vec3& x, double z_mm) {
  const auto* ellipsoid = std::get_if<Ellipsoid>(&primitive);
  return ellipsoid != nullptr ? ellipsoid->level(x) < 0.0 : z_mm < std::get<Below>(primitive).z_mm;
}

/// Angles at which the other sections cut that of primitive n into arcs: ascending, once around.
std::vector<double> arc_ends(const std::vector<Primitive>& primitives, const Sections& sections,
                             std::size_t n) {
  std::vector<double> out;
  for (std::size_t m = 0; m < primitives.size(); ++m) {
    if (m == n || !sections[m]) continue;
    const Vec3 apart = (sections[m]->centre_mm - sections[n]->centre_mm).cwiseAbs();
    if (apart.x() > sections[m]->semi_x_mm + sections[n]->semi_x_mm ||
        apart.y() > sections[m]->semi_y_mm + sections[n]->semi_y_mm) {
      continue;
    }
    const auto angles = crossing_angles(*sections[n], std::get<Ellipsoid>(primitives[m]));
    out.insert(out.end(), angles.begin(), angles.end());
  }
  std::sort(out.begin(), out.end());
  if (out.empty()) out.push_back(0.0);
  out.push_back(out.front() + 2.0 * std::numbers::pi);
  return out;
}

}  // namespace

double Solid::section_mm2(double z_mm) const {
  const Sections ellipses = sections_at(primitives_, z_mm);
  // Whether x, a point on the ellipse `on`, is in the solid when it counts as inside of that one.
  const auto contains_if = [&](const Vec3& x, std::size_t on, bool inside_on) {
    return std::any_of(cells_.begin(), cells_.end(), [&](const Cell& cell) {
      return std::all_of(cell.begin(), cell.end(), [&](const Literal& literal) {
        const auto n = static_cast<std::size_t>(literal.index);
        const bool inside = n == on ? inside_on : primitive_holds(primitives_[n], x, z_mm);
        return inside == literal.inside;
      });
    });
  };
  double area = 0.0;
  for (std::size_t n = 0; n < ellipses.size(); ++n) {
    if (!ellipses[n]) continue;
    const std::vector<double> cuts = arc_ends(primitives_, ellipses, n);
    for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
      const Vec3 x = ellipses[n]->point(0.5 * (cuts[k] + cuts[k + 1]));
      const bool within = contains_if(x, n, true);
      if (within == contains_if(x, n, false)) continue;
      area += (within ? 1.0 : -1.0) * swept_mm2(*ellipses[n], cuts[k], cuts[k + 1]);
    }
  }
  return area;
}

double Solid::volume_ml() const {
  std::vector<double> cuts;
  for (const Primitive& primitive : primitives_) {
    if (const auto* ellipsoid = std::get_if<Ellipsoid>(&primitive)) {
      if (ellipsoid->is_cylinder()) continue;
      cuts.push_back(ellipsoid->centre_mm.z() - ellipsoid->semi_axes_mm.z());
      cuts.push_back(ellipsoid->centre_mm.z() + ellipsoid->semi_axes_mm.z());
    } else {
      cuts.push_back(std::get<Below>(primitive).z_mm);
    }
  }
  std::sort(cuts.begin(), cuts.end());
  // Panels, so that a change of the sections' kind cannot hide between the three points of the
  // first rule.
  constexpr double kPanelMm = 8.0;
  constexpr double kToleranceMm3 = 5e-4;
  // Sections jump at planes, so the ends of a panel are looked at from within.
  constexpr double kInsideMm = 1e-9;
  double sum = 0.0;
  for (std::size_t n = 0; n + 1 < cuts.size(); ++n) {
    const double from = cuts[n] + kInsideMm;
    const double length = cuts[n + 1] - kInsideMm - from;
    if (!(length > 0.0)) continue;
    const int panels = static_cast<int>(std::ceil(length / kPanelMm));
    const auto area = [&](double z) { return section_mm2(z); };
    double low = from;
    double at_low = area(low);
    for (int panel = 0; panel < panels; ++panel) {
      const double high = from + length * (panel + 1) / panels;
      const double middle = 0.5 * (low + high);
      const double at_middle = area(middle);
      const double at_high = area(high);
      sum += adaptive_simpson(area, low, at_low, middle, at_middle, high, at_high,
                              (high - low) / 6.0 * (at_low + 4.0 * at_middle + at_high),
                              kToleranceMm3, 20);
      low = high;
      at_low = at_high;
    }
  }
  return sum * 1e-3;
}

}  // namespace beatlas::phantom
