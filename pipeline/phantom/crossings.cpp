#include "pipeline/phantom/crossings.h"

#include <algorithm>
#include <array>
#include <numbers>

namespace beatlas::phantom {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kSteps = 64;

struct Direction {
  double cosine;
  double sine;
};

const std::array<Direction, kSteps>& directions() {
  static const std::array<Direction, kSteps> table = [] {
    std::array<Direction, kSteps> out{};
    for (int n = 0; n < kSteps; ++n) {
      out[n] = {std::cos(kTurn * n / kSteps), std::sin(kTurn * n / kSteps)};
    }
    return out;
  }();
  return table;
}

/// Level of the ellipsoid along the ellipse: a trigonometric polynomial of degree 2, so it has at
/// most four zeros and four extremes.
struct LevelAlong {
  double p0, p1, q0, q1, rest;

  LevelAlong(const AxisEllipse& ellipse, const Ellipsoid& other) {
    const Vec3 from = (ellipse.centre_mm - other.centre_mm).cwiseQuotient(other.semi_axes_mm);
    p0 = from[ellipse.p];
    q0 = from[ellipse.q];
    p1 = ellipse.semi_p_mm / other.semi_axes_mm[ellipse.p];
    q1 = ellipse.semi_q_mm / other.semi_axes_mm[ellipse.q];
    const double across = from[3 - ellipse.p - ellipse.q];
    rest = across * across - 1.0;
  }
  double at(const Direction& d) const {
    const double u = p0 + p1 * d.cosine;
    const double v = q0 + q1 * d.sine;
    return u * u + v * v + rest;
  }
  double at(double angle) const { return at(Direction{std::cos(angle), std::sin(angle)}); }
};

/// Regula falsi in turn with halving, to the last bits.
double root_between(const LevelAlong& level, double low, double high, bool low_inside) {
  double at_low = level.at(low);
  double at_high = level.at(high);
  double angle = 0.5 * (low + high);
  for (int iteration = 0; iteration < 80 && high - low > 1e-15; ++iteration) {
    angle = low - at_low * (high - low) / (at_high - at_low);
    if (iteration % 3 == 2 || !(angle > low && angle < high)) angle = 0.5 * (low + high);
    const double value = level.at(angle);
    if (std::abs(value) < 1e-16) break;
    if ((value < 0.0) == low_inside) {
      low = angle;
      at_low = value;
    } else {
      high = angle;
      at_high = value;
    }
  }
  return angle;
}

/// Where the level comes nearest to zero from one side, within two steps around `angle`.
double extreme_near(const LevelAlong& level, double low, double high, double sign) {
  constexpr double kGolden = 0.6180339887498949;
  double a = high - kGolden * (high - low);
  double b = low + kGolden * (high - low);
  double at_a = sign * level.at(a);
  double at_b = sign * level.at(b);
  for (int iteration = 0; iteration < 40 && at_a > 0.0 && at_b > 0.0; ++iteration) {
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - kGolden * (high - low);
      at_a = sign * level.at(a);
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + kGolden * (high - low);
      at_b = sign * level.at(b);
    }
  }
  return at_a < at_b ? a : b;
}

}  // namespace

bool section(const Ellipsoid& ellipsoid, int axis, double at_mm, AxisEllipse& ellipse) {
  const double u = (at_mm - ellipsoid.centre_mm[axis]) / ellipsoid.semi_axes_mm[axis];
  if (!(u * u < 1.0)) return false;
  if (axis != 2 && ellipsoid.is_cylinder()) return false;
  const double shrink = std::sqrt((1.0 - u) * (1.0 + u));
  ellipse.centre_mm = ellipsoid.centre_mm;
  ellipse.centre_mm[axis] = at_mm;
  ellipse.p = axis == 0 ? 1 : 0;
  ellipse.q = axis == 2 ? 1 : 2;
  ellipse.semi_p_mm = ellipsoid.semi_axes_mm[ellipse.p] * shrink;
  ellipse.semi_q_mm = ellipsoid.semi_axes_mm[ellipse.q] * shrink;
  return true;
}

std::vector<double> crossing_angles(const AxisEllipse& ellipse, const Ellipsoid& ellipsoid) {
  const LevelAlong level(ellipse, ellipsoid);
  std::array<double, kSteps> values{};
  for (int n = 0; n < kSteps; ++n) values[n] = level.at(directions()[n]);
  const auto value = [&](int n) { return values[static_cast<std::size_t>((n + kSteps) % kSteps)]; };
  constexpr double kStep = kTurn / kSteps;
  std::vector<double> angles;
  for (int n = 0; n < kSteps; ++n) {
    const bool inside = value(n) < 0.0;
    if ((value(n + 1) < 0.0) != inside) {
      angles.push_back(root_between(level, kStep * n, kStep * (n + 1), inside));
    }
    // A dip through zero and back between two steps.
    const double sign = inside ? -1.0 : 1.0;
    if ((value(n - 1) < 0.0) != inside || (value(n + 1) < 0.0) != inside) continue;
    if (sign * value(n) > sign * value(n - 1) || sign * value(n) >= sign * value(n + 1)) continue;
    const double dip = extreme_near(level, kStep * (n - 1), kStep * (n + 1), sign);
    if ((level.at(dip) < 0.0) == inside) continue;
    angles.push_back(root_between(level, kStep * (n - 1), dip, inside));
    angles.push_back(root_between(level, dip, kStep * (n + 1), !inside));
  }
  for (double& angle : angles) angle -= kTurn * std::floor(angle / kTurn);
  std::sort(angles.begin(), angles.end());
  return angles;
}

}  // namespace beatlas::phantom
