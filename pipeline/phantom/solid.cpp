#include "pipeline/phantom/solid.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>

#include "pipeline/phantom/crossings.h"
#include "pipeline/phantom/curve.h"

namespace beatlas::phantom {
namespace {

constexpr double kOnMm = 1e-7;          // a point this close to a primitive counts as on it
constexpr double kNormalMm = 1e-6;      // closer than this, x - nearest is no direction
constexpr double kBesideMm = 1e-5;      // a step that leaves a surface for good
constexpr std::size_t kMostFaces = 16;  // primitives of one solid
constexpr std::size_t kRun = 16;        // points of a curve that share a ball
constexpr double kInfinity = std::numeric_limits<double>::infinity();

const Ellipsoid* as_ellipsoid(const Primitive& primitive) {
  return std::get_if<Ellipsoid>(&primitive);
}

/// The point of a curve nearest to x between two neighbours of its point `middle`: the distance
/// falls from `before` and rises to `after`, and its slope is halved on.
Vec3 foot_on_curve(const Ellipsoid& a, const Ellipsoid& b, const Vec3& before, const Vec3& middle,
                   const Vec3& after, const Vec3& x) {
  const auto on_curve = [&](double u) -> Vec3 {
    Vec3 q = u < 0.0 ? Vec3(middle + (middle - before) * u) : Vec3(middle + (after - middle) * u);
    return settle_on_curve(a, b, q) ? q : middle;
  };
  const auto slope = [&](const Vec3& q) {
    const Vec3 along = curve_direction(a, b, q);
    const double sense = along.dot(after - before) < 0.0 ? -1.0 : 1.0;
    return sense * along.dot(q - x);
  };
  double low = -1.0;
  double high = 1.0;
  double low_slope = slope(before);
  double high_slope = slope(after);
  Vec3 q = middle;
  for (int iteration = 0; iteration < 40 && high - low > 1e-9; ++iteration) {
    // Regula falsi in turn with halving: fast where the slope is straight, never slow.
    double u = 0.5 * (low + high);
    if (iteration % 3 != 2 && low_slope < 0.0 && high_slope > 0.0) {
      u = low - low_slope * (high - low) / (high_slope - low_slope);
    }
    q = on_curve(u);
    const double s = slope(q);
    if (std::abs(s) < 1e-10) break;
    if (s < 0.0) {
      low = u;
      low_slope = s;
    } else {
      high = u;
      high_slope = s;
    }
  }
  return q;
}

}  // namespace

Solid::Solid(std::vector<Primitive> primitives, std::vector<Cell> cells, double curve_step_mm)
    : primitives_(std::move(primitives)), cells_(std::move(cells)) {
  assert(primitives_.size() <= kMostFaces);
  find_creases(curve_step_mm);
}

Solid::Balls::Balls(const std::vector<Vec3>& points, double margin_mm) {
  for (std::size_t first = 0; first < points.size(); first += kRun) {
    const std::size_t end = std::min(points.size(), first + kRun);
    const Vec3& centre = points[(first + end) / 2];
    double radius = 0.0;
    for (std::size_t n = first; n < end; ++n) {
      radius = std::max(radius, (points[n] - centre).norm());
    }
    centres.push_back(centre);
    radii.push_back(radius + margin_mm);
  }
}

double Solid::value_mm(int primitive, const Vec3& x) const {
  if (const auto* ellipsoid = as_ellipsoid(primitives_[primitive])) {
    return ellipsoid->level(x) / ellipsoid->gradient(x).norm();
  }
  return x.z() - std::get<Below>(primitives_[primitive]).z_mm;
}

bool Solid::contains(const Vec3& x) const {
  for (const Cell& cell : cells_) {
    bool in = true;
    for (const Literal& literal : cell) {
      const auto* ellipsoid = as_ellipsoid(primitives_[literal.index]);
      const double value = ellipsoid != nullptr
                               ? ellipsoid->level(x)
                               : x.z() - std::get<Below>(primitives_[literal.index]).z_mm;
      if ((value < 0.0) != literal.inside) {
        in = false;
        break;
      }
    }
    if (in) return true;
  }
  return false;
}

bool Solid::on_boundary(const Vec3& x) const {
  // Kleene's logic: in, on, out; `on` survives an intersection with in and a union with out.
  bool on_any = false;
  for (const Cell& cell : cells_) {
    bool on = false;
    bool out = false;
    for (const Literal& literal : cell) {
      const double outward = (literal.inside ? 1.0 : -1.0) * value_mm(literal.index, x);
      if (outward > kOnMm) {
        out = true;
        break;
      }
      on = on || outward >= -kOnMm;
    }
    if (out) continue;
    if (!on) return false;
    on_any = true;
  }
  return on_any;
}

Vec3 Solid::outward_normal(int primitive, const Vec3& x) const {
  const auto* ellipsoid = as_ellipsoid(primitives_[primitive]);
  const Vec3 gradient =
      ellipsoid != nullptr ? Vec3(ellipsoid->gradient(x).normalized()) : Vec3(Vec3::UnitZ());
  return contains(x + kBesideMm * gradient) ? Vec3(-gradient) : gradient;
}

void Solid::find_creases(double step_mm) {
  const int count = static_cast<int>(primitives_.size());
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      if (j != i) find_creases_between(i, j, step_mm);
    }
  }
  for (const FlatCrease& crease : flat_creases_) look_along(crease, step_mm);
  for (CurvedCrease& crease : curved_creases_) look_along(crease);
  for (const Corner& corner : corners_) crease_points_.push_back(corner.point);
  crease_balls_ = Balls(crease_points_, 0.0);
}

void Solid::find_creases_between(int i, int j, double step_mm) {
  const auto* first = as_ellipsoid(primitives_[i]);
  const auto* second = as_ellipsoid(primitives_[j]);
  if (second == nullptr) return;
  if (first == nullptr) {
    FlatCrease crease{i, j, {}};
    if (section(*second, std::get<Below>(primitives_[i]).z_mm, crease.ellipse)) {
      flat_creases_.push_back(crease);
    }
  } else if (i < j) {
    for (Curve& curve : intersection_curves(*first, *second, step_mm)) {
      curved_creases_.push_back({i, j, std::move(curve), {}});
    }
  }
}

void Solid::look_along(const FlatCrease& crease, double step_mm) {
  const int count = static_cast<int>(primitives_.size());
  for (int j = 0; j < count; ++j) {
    const auto* other = as_ellipsoid(primitives_[j]);
    if (other == nullptr || j == crease.ellipsoid) continue;
    for (double angle : crossing_angles(crease.ellipse, *other)) {
      const Vec3 corner = crease.ellipse.point(angle);
      if (on_boundary(corner)) corners_.push_back({corner, {crease.plane, crease.ellipsoid, j}});
    }
  }
  const double length =
      2.0 * std::numbers::pi * std::max(crease.ellipse.semi_x_mm, crease.ellipse.semi_y_mm);
  const int steps = std::max(16, static_cast<int>(std::ceil(length / step_mm)));
  for (int n = 0; n < steps; ++n) {
    const Vec3 x = crease.ellipse.point(2.0 * std::numbers::pi * n / steps);
    if (on_boundary(x)) crease_points_.push_back(x);
  }
}

void Solid::look_along(CurvedCrease& crease) {
  const int count = static_cast<int>(primitives_.size());
  const std::vector<Vec3>& points = crease.curve.points;
  for (const Vec3& x : points) {
    if (on_boundary(x)) crease_points_.push_back(x);
  }
  // Three pairs make the same corner; it is taken from the pair of lowest numbers.
  for (int j = crease.second + 1; j < count; ++j) {
    if (const auto* third = as_ellipsoid(primitives_[j])) find_corners(crease, *third, j);
  }
  crease.balls = Balls(points, 2.0 * crease.curve.step_mm);
}

void Solid::find_corners(const CurvedCrease& crease, const Ellipsoid& third, int index) {
  const Ellipsoid& a = *as_ellipsoid(primitives_[crease.first]);
  const Ellipsoid& b = *as_ellipsoid(primitives_[crease.second]);
  const std::vector<Vec3>& points = crease.curve.points;
  for (std::size_t n = 0; n < points.size(); ++n) {
    const Vec3& from = points[n];
    const Vec3& to = points[(n + 1) % points.size()];
    const double at_from = third.level(from);
    const double at_to = third.level(to);
    if ((at_from < 0.0) == (at_to < 0.0)) continue;
    Vec3 corner = from + (to - from) * (at_from / (at_from - at_to));
    if (!settle_on_corner(a, b, third, corner)) continue;
    if ((corner - from).norm() > 4.0 * crease.curve.step_mm || !on_boundary(corner)) continue;
    corners_.push_back({corner, {crease.first, crease.second, index}});
  }
}

void Solid::nearest_on_curve(const CurvedCrease& crease, const Vec3& x, double& best,
                             Vec3& point) const {
  const std::vector<Vec3>& points = crease.curve.points;
  const Ellipsoid& a = *as_ellipsoid(primitives_[crease.first]);
  const Ellipsoid& b = *as_ellipsoid(primitives_[crease.second]);
  const std::size_t count = points.size();
  const auto at = [&](std::size_t n) -> const Vec3& { return points[n % count]; };
  for (std::size_t run = 0; run < crease.balls.centres.size(); ++run) {
    if ((crease.balls.centres[run] - x).norm() - crease.balls.radii[run] >= best) continue;
    const std::size_t end = std::min(count, (run + 1) * kRun);
    for (std::size_t n = run * kRun; n < end; ++n) {
      const Vec3& before = at(n + count - 1);
      const Vec3& after = at(n + 1);
      const double here = (points[n] - x).squaredNorm();
      if (here > (before - x).squaredNorm() || here > (after - x).squaredNorm()) continue;
      if (std::sqrt(here) - 2.0 * crease.curve.step_mm >= best) continue;
      const Vec3 q = foot_on_curve(a, b, before, points[n], after, x);
      const double distance = (q - x).norm();
      if (distance < best && on_boundary(q)) {
        best = distance;
        point = q;
      }
    }
  }
}

struct Solid::Search {
  struct Face {
    bool open = false;  // its nearest point is cut off, so its crease or another point may count
    double at_least = 0;
  };
  const Solid& solid;
  const Vec3& x;
  double best = kInfinity;
  Nearest out{};
  std::array<Face, kMostFaces> faces{};

  /// Takes a point where it is nearer and on the boundary; whether it did.
  bool take(const Vec3& q, const std::array<int, 3>& through) {
    const double distance = (q - x).norm();
    if (!(distance < best) || !solid.on_boundary(q)) return false;
    best = distance;
    out.point = q;
    out.faces = through;
    return true;
  }
  [[nodiscard]] bool open(int face) const {
    return faces[face].open && faces[face].at_least < best;
  }
};

void Solid::search_faces(Search& search) const {
  const Vec3& x = search.x;
  const int count = static_cast<int>(primitives_.size());
  for (int i = 0; i < count; ++i) {
    const auto* ellipsoid = as_ellipsoid(primitives_[i]);
    const Vec3 q = ellipsoid != nullptr ? nearest_point(*ellipsoid, x)
                                        : Vec3(x.x(), x.y(), std::get<Below>(primitives_[i]).z_mm);
    Search::Face& face = search.faces[i];
    face.at_least = (q - x).norm();
    face.open = face.at_least < search.best && !search.take(q, {i, -1, -1});
  }
  for (int i = 0; i < count; ++i) {
    const auto* ellipsoid = as_ellipsoid(primitives_[i]);
    if (ellipsoid == nullptr || !search.open(i)) continue;
    const NearPoints others = near_points(*ellipsoid, x);
    for (int n = 1; n < others.count; ++n) search.take(others.points[n], {i, -1, -1});
  }
}

void Solid::search_creases(Search& search) const {
  // A crease is no nearer than the nearest point of either of its faces, so it can only win where
  // both of them are open.
  for (const FlatCrease& crease : flat_creases_) {
    if (!search.open(crease.plane) || !search.open(crease.ellipsoid)) continue;
    const NearPoints near = near_points(crease.ellipse, search.x);
    for (int n = 0; n < near.count; ++n) {
      search.take(near.points[n], {crease.ellipsoid, crease.plane, -1});
    }
  }
  for (const CurvedCrease& crease : curved_creases_) {
    if (!search.open(crease.first) || !search.open(crease.second)) continue;
    const double before = search.best;
    nearest_on_curve(crease, search.x, search.best, search.out.point);
    if (search.best < before) search.out.faces = {crease.first, crease.second, -1};
  }
}

Nearest Solid::nearest(const Vec3& x) const {
  Search search{*this, x};
  search_faces(search);
  search_creases(search);
  double& best = search.best;
  Nearest& out = search.out;
  for (const Corner& corner : corners_) {
    const double distance = (corner.point - x).norm();
    if (distance >= best) continue;
    best = distance;
    out.point = corner.point;
    out.faces = corner.faces;
  }
  out.distance_mm = contains(x) ? -best : best;
  if (best > kNormalMm) {
    out.outward = (x - out.point) / out.distance_mm;
  } else if (out.faces[0] >= 0) {
    out.outward = outward_normal(out.faces[0], out.point);
  }
  return out;
}

double Solid::outward_speed(const Nearest& nearest, const std::vector<Primitive>& rates) const {
  // The point stays on its faces: grad f . w = -df/dt for each of them, and w is shortest.
  Eigen::Matrix3d gradients = Eigen::Matrix3d::Zero();
  Vec3 change = Vec3::Zero();
  int count = 0;
  for (int face : nearest.faces) {
    if (face < 0) break;
    const auto* ellipsoid = as_ellipsoid(primitives_[face]);
    Vec3 gradient = Vec3::UnitZ();
    double rate = 0.0;
    if (ellipsoid != nullptr) {
      const auto& moving = std::get<Ellipsoid>(rates[face]);
      gradient = ellipsoid->gradient(nearest.point);
      rate = -gradient.dot(moving.centre_mm);
      for (int axis = 0; axis < (ellipsoid->is_cylinder() ? 2 : 3); ++axis) {
        rate -= gradient[axis] * (nearest.point[axis] - ellipsoid->centre_mm[axis]) *
                moving.semi_axes_mm[axis] / ellipsoid->semi_axes_mm[axis];
      }
    } else {
      rate = -std::get<Below>(rates[face]).z_mm;
    }
    const double length = gradient.norm();
    gradients.row(count) = gradient.transpose() / length;
    change[count] = -rate / length;
    ++count;
  }
  if (count == 0) return 0.0;
  const auto rows = gradients.topRows(count);
  const Eigen::MatrixXd gram = rows * rows.transpose();
  const Vec3 velocity = rows.transpose() * gram.fullPivLu().solve(change.head(count));
  return velocity.dot(nearest.outward);
}

double Solid::crease_distance_mm(const Vec3& x) const {
  double best = kInfinity;
  for (std::size_t run = 0; run < crease_balls_.centres.size(); ++run) {
    if ((crease_balls_.centres[run] - x).norm() - crease_balls_.radii[run] >= best) continue;
    const std::size_t end = std::min(crease_points_.size(), (run + 1) * kRun);
    for (std::size_t n = run * kRun; n < end; ++n) {
      best = std::min(best, (crease_points_[n] - x).norm());
    }
  }
  return best;
}

}  // namespace beatlas::phantom
