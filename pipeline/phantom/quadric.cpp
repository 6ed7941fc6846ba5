#include "pipeline/phantom/quadric.h"

#include <algorithm>
#include <cmath>

namespace beatlas::phantom {
namespace {

/// The problem in as many dimensions as there are different semi-axes, shortest first: within a
/// group of equal axes only the distance from the group's origin matters.
struct Reduced {
  int dimension = 0;
  std::array<double, 3> semi{};
  std::array<double, 3> query{};    // >= 0
  std::array<int, 3> group{};       // axis -> group
  std::array<double, 3> unit{};     // axis -> component of its group's direction
  std::array<int, 3> group_size{};  // axes in a group
};

Reduced reduce(const std::array<double, 3>& semi, const std::array<double, 3>& query,
               int dimension) {
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.begin() + dimension,
            [&](int a, int b) { return semi[a] < semi[b]; });
  Reduced out;
  const double longest = semi[order[dimension - 1]];
  std::array<double, 3> squared{};
  for (int n = 0; n < dimension; ++n) {
    const int axis = order[n];
    const bool fresh = n == 0 || semi[axis] - out.semi[out.dimension - 1] > 1e-12 * longest;
    if (fresh) out.semi[out.dimension++] = semi[axis];
    const int group = out.dimension - 1;
    out.group[axis] = group;
    ++out.group_size[group];
    squared[group] += query[axis] * query[axis];
  }
  // Off the planes of symmetry no root falls on a pole; the distance is 1-Lipschitz, so this
  // costs no more accuracy than the size of the step.
  const double least = 5e-10 * longest;
  for (int g = 0; g < out.dimension; ++g) out.query[g] = std::max(std::sqrt(squared[g]), least);
  std::array<bool, 3> started{};
  for (int axis = 0; axis < dimension; ++axis) {
    const int g = out.group[axis];
    const double length = std::sqrt(squared[g]);
    if (length >= least) {
      out.unit[axis] = query[axis] / length;
    } else {
      out.unit[axis] = started[g] ? 0.0 : std::copysign(1.0, query[axis]);
    }
    started[g] = true;
  }
  return out;
}

/// sum (a p / (a^2 - a_pole^2 + s))^2 - 1 and its derivative: the multiplier is counted from a pole
/// so that no digits are lost close to it.
struct Secular {
  const Reduced& r;
  int pole;

  double denominator(int i, double s) const {
    return (r.semi[i] - r.semi[pole]) * (r.semi[i] + r.semi[pole]) + s;
  }
  double value(double s, double& slope) const {
    double sum = -1.0;
    slope = 0.0;
    for (int i = 0; i < r.dimension; ++i) {
      const double d = denominator(i, s);
      const double w = r.semi[i] * r.query[i] / d;
      sum += w * w;
      slope -= 2.0 * w * w / d;
    }
    return sum;
  }
};

/// Foot point of the multiplier s, put on the surface exactly to rounding.
std::array<double, 3> foot(const Secular& f, double s) {
  std::array<double, 3> x{};
  double norm2 = 0.0;
  for (int i = 0; i < f.r.dimension; ++i) {
    const double w = f.r.semi[i] * f.r.query[i] / f.denominator(i, s);
    x[i] = f.r.semi[i] * w;
    norm2 += w * w;
  }
  const double norm = std::sqrt(norm2);
  for (double& value : x) value /= norm;
  return x;
}

/// The root on the convex, falling branch right of every pole: Newton from its left never
/// overshoots.
double nearest_root(const Secular& f) {
  double s = 0.0;
  for (int i = 0; i < f.r.dimension; ++i) {
    const double reach =
        f.r.semi[i] * f.r.query[i] - (f.r.semi[i] - f.r.semi[0]) * (f.r.semi[i] + f.r.semi[0]);
    s = i == 0 ? reach : std::max(s, reach);
  }
  for (int iteration = 0; iteration < 100; ++iteration) {
    double slope = 0.0;
    const double value = f.value(s, slope);
    const double step = -value / slope;
    if (!(step > 1e-16 * s)) break;
    s += step;
  }
  return s;
}

/// A root in (low, high), where the function falls (or rises) through zero once.
double bracketed_root(const Secular& f, double low, double high, bool falling) {
  double s = 0.5 * (low + high);
  for (int iteration = 0; iteration < 200; ++iteration) {
    double slope = 0.0;
    const double value = f.value(s, slope);
    if ((value > 0.0) == falling) {
      low = s;
    } else {
      high = s;
    }
    double next = s - value / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - s) <= 1e-15 * std::abs(s)) return next;
    s = next;
  }
  return s;
}

std::array<double, 3> unreduce(const Reduced& r, const std::array<double, 3>& x, int dimension) {
  std::array<double, 3> out{};
  for (int axis = 0; axis < dimension; ++axis) out[axis] = x[r.group[axis]] * r.unit[axis];
  return out;
}

/// Between the poles of the two shortest axes the function is convex and has no root or two.
int second_pair(const Reduced& r, std::array<std::array<double, 3>, 2>& feet) {
  if (r.dimension < 2 || r.group_size[0] > 1) return 0;
  const Secular f{r, 0};
  const double width = (r.semi[1] - r.semi[0]) * (r.semi[1] + r.semi[0]);
  double low = -width;
  double high = 0.0;
  double lowest = 0.5 * (low + high);
  for (int iteration = 0; iteration < 200; ++iteration) {
    double slope = 0.0;
    const double value = f.value(lowest, slope);
    if (value < 0.0) break;
    (slope < 0.0 ? low : high) = lowest;
    // A convex function stays above its tangent.
    if (value + slope * ((slope < 0.0 ? high : low) - lowest) > 0.0) return 0;
    const double next = 0.5 * (low + high);
    if (next == lowest || next <= low || next >= high) return 0;
    lowest = next;
  }
  double slope = 0.0;
  if (!(f.value(lowest, slope) < 0.0)) return 0;
  // Each root is counted from the pole it may lie close to.
  const Secular far{r, 1};
  feet[0] = foot(f, bracketed_root(f, lowest, 0.0, false));
  feet[1] = foot(far, bracketed_root(far, 0.0, lowest + width, true));
  return 2;
}

Vec3 to_vec(const std::array<double, 3>& x) { return {x[0], x[1], x[2]}; }

std::array<double, 3> to_array(const Vec3& x) { return {x[0], x[1], x[2]}; }

/// One equation for all: `dimension` 3 for a surface, 2 for a curve in its plane.
NearPoints near_points(const Reduced& r, int dimension, const Vec3& centre) {
  NearPoints out;
  const Secular f{r, 0};
  out.points[0] = centre + to_vec(unreduce(r, foot(f, nearest_root(f)), dimension));
  std::array<std::array<double, 3>, 2> feet{};
  const int others = second_pair(r, feet);
  for (int n = 0; n < others; ++n) {
    out.points[n + 1] = centre + to_vec(unreduce(r, feet[n], dimension));
  }
  out.count = 1 + others;
  return out;
}

/// The section of a cylinder at the height of the query.
Ellipse section_beside(const Ellipsoid& cylinder, const Vec3& query) {
  return {{cylinder.centre_mm.x(), cylinder.centre_mm.y(), query.z()},
          cylinder.semi_axes_mm.x(),
          cylinder.semi_axes_mm.y()};
}

}  // namespace

NearPoints near_points(const Ellipsoid& ellipsoid, const Vec3& query) {
  if (ellipsoid.is_cylinder()) return near_points(section_beside(ellipsoid, query), query);
  return near_points(
      reduce(to_array(ellipsoid.semi_axes_mm), to_array(query - ellipsoid.centre_mm), 3), 3,
      ellipsoid.centre_mm);
}

Vec3 nearest_point(const Ellipsoid& ellipsoid, const Vec3& query) {
  if (ellipsoid.is_cylinder()) {
    return near_points(section_beside(ellipsoid, query), query).points[0];
  }
  const Reduced r =
      reduce(to_array(ellipsoid.semi_axes_mm), to_array(query - ellipsoid.centre_mm), 3);
  const Secular f{r, 0};
  return ellipsoid.centre_mm + to_vec(unreduce(r, foot(f, nearest_root(f)), 3));
}

bool section(const Ellipsoid& ellipsoid, double z_mm, Ellipse& ellipse) {
  const double u = (z_mm - ellipsoid.centre_mm.z()) / ellipsoid.semi_axes_mm.z();  // cylinder: 0
  if (!(u * u < 1.0)) return false;
  const double shrink = std::sqrt((1.0 - u) * (1.0 + u));
  ellipse.centre_mm = {ellipsoid.centre_mm.x(), ellipsoid.centre_mm.y(), z_mm};
  ellipse.semi_x_mm = ellipsoid.semi_axes_mm.x() * shrink;
  ellipse.semi_y_mm = ellipsoid.semi_axes_mm.y() * shrink;
  return true;
}

NearPoints near_points(const Ellipse& ellipse, const Vec3& query) {
  return near_points(
      reduce({ellipse.semi_x_mm, ellipse.semi_y_mm, 0.0},
             {query.x() - ellipse.centre_mm.x(), query.y() - ellipse.centre_mm.y(), 0.0}, 2),
      2, ellipse.centre_mm);
}

}  // namespace beatlas::phantom
