#pragma once
/// The phantom's heart written a second time, from the table of reference numbers, and its distance
/// by exhaustive search. Shares no code with the room it checks but
/// the names of the parts.

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <vector>

#include "pipeline/phantom/part.h"
#include "runtime/base/geometry.h"

namespace beatlas::test {

using phantom::Part;

struct ReferenceHeart {
  double a, c, base, apex_wall;  // LV cavity
  double centre, radius_epi, half_epi;
  double rx, rz, px, py, pz, cut;  // RV cavity
  Vec3 la, ra;                     // centres of the atria
  double la_radius, ra_radius;
  double foot, top;  // of the aorta's wall and lumen
  Vec3 muscle[2];    // papillary
  double muscle_radius, muscle_half;
  static constexpr double kAortaX = 4, kAortaY = 22, kLumen = 14, kAortaWall = 2, kAtrialWall = 2,
                          kHalfFat = 3, kFat = 3.1;

  /// s by adding up the three pulses on a fine grid (midpoint rule).
  static double loss(double t_s) {
    const auto pulse = [](double t, double t0, double d, double k) {
      const double x = (t - t0) / d;
      return x <= 0 || x >= 1 ? 0.0 : 1.0 - std::cos(2.0 * M_PI * std::pow(x, k));
    };
    const auto area = [](const auto& f, double to) {
      constexpr int kSteps = 100000;
      double sum = 0.0;
      for (int n = 0; n < kSteps; ++n) sum += f(to * (n + 0.5) / kSteps);
      return sum * to / kSteps;
    };
    const auto share = [&](double t0, double d, double k) {
      const auto f = [&](double t) { return pulse(t, t0, d, k); };
      return area(f, t_s) / area(f, 0.75);
    };
    return share(0.05, 0.28, 0.8) - 0.75 * share(0.4, 0.16, 0.85) - 0.25 * share(0.615, 0.115, 1.0);
  }

  static ReferenceHeart at(double s) {
    const auto mix = [s](double x, double y) { return x * (1 - s) + y * s; };
    const auto cup = [](double r, double c, double b) {
      return r * r * (b - b * b * b / (3 * c * c) + 2 * c / 3);
    };
    ReferenceHeart h{};
    h.a = mix(27.0, 17.37);
    h.c = mix(62.0, 51.22);
    const double b = mix(30.0, 24.78);
    h.apex_wall = mix(6.0, 8.0);
    h.centre = -68.0 + h.apex_wall + h.c;
    h.base = h.centre + b;
    h.half_epi = h.c + h.apex_wall;
    const double muscle = cup(35.5, 68.0, 30.0) - cup(27.0, 62.0, 30.0);
    h.radius_epi = std::sqrt((muscle + cup(h.a, h.c, b)) / cup(1.0, h.half_epi, b));
    h.rx = mix(28, 22);
    h.rz = mix(-2, -8);
    h.px = mix(32.5, 26.2);
    h.py = mix(44, 36);
    h.pz = mix(62, 52);
    h.cut = mix(32, 10);
    h.la_radius = mix(22, 29);
    h.ra_radius = mix(23, 29);
    // The valve planes cut discs of 10 mm radius from the atria.
    h.la = Vec3(-6, -16, h.base + std::sqrt(h.la_radius * h.la_radius - 100));
    h.ra = Vec3(h.rx + 14, 0, h.cut + std::sqrt(h.ra_radius * h.ra_radius - 100));
    h.foot = h.base - 1;
    h.top = h.base + 35;
    h.muscle_radius = mix(4, 6);
    h.muscle_half = mix(15, 12);
    for (int n = 0; n < 2; ++n) {
      const double angle = (n == 0 ? 130.0 : 235.0) * M_PI / 180.0;
      h.muscle[n] = Vec3(0.6 * h.a * std::cos(angle), 0.6 * h.a * std::sin(angle),
                         h.centre - 0.4 * h.muscle_half);
    }
    return h;
  }

  static double level(const Vec3& x, double cx, double cz, double a, double b, double c,
                      double cy = 0) {
    const double u = (x.x() - cx) / a;
    const double v = (x.y() - cy) / b;
    const double w = (x.z() - cz) / c;
    return u * u + v * v + w * w - 1;
  }
  bool in_cavity(const Vec3& x) const { return level(x, 0, centre, a, a, c) < 0; }
  bool in_epi(const Vec3& x) const {
    return level(x, 0, centre, radius_epi, radius_epi, half_epi) < 0;
  }
  bool in_rv(const Vec3& x) const { return level(x, rx, rz, px, py, pz) < 0; }
  bool in_outer(const Vec3& x) const { return level(x, rx, rz, px + 3.5, py + 3.5, pz + 3.5) < 0; }

  bool in_la_outer(const Vec3& x) const { return (x - la).norm() < la_radius + kAtrialWall; }
  static double off_aorta(const Vec3& x) { return std::hypot(x.x() - kAortaX, x.y() - kAortaY); }
  bool in_muscle(const Vec3& x, int n) const {
    return level(x, muscle[n].x(), muscle[n].z(), muscle_radius, muscle_radius, muscle_half,
                 muscle[n].y()) < 0;
  }

  bool contains(Part part, const Vec3& x) const {
    switch (part) {
      case Part::Heart:
        return (in_epi(x) && x.z() < base) || (in_outer(x) && x.z() < cut) || in_la_outer(x) ||
               (x - ra).norm() < ra_radius + kAtrialWall ||
               (off_aorta(x) < kLumen + kAortaWall && x.z() > foot && x.z() < top);
      case Part::LvBlood:
        return in_cavity(x) && x.z() < base;
      case Part::RvBlood:
        return in_rv(x) && !in_epi(x) && x.z() < cut;
      case Part::LvMyocardium:
        return in_epi(x) && !in_cavity(x) && x.z() < base;
      case Part::RvWall:
        return in_outer(x) && !in_rv(x) && !in_epi(x) && x.z() < cut;
      case Part::LaBlood:
        return (x - la).norm() < la_radius && x.z() > base && off_aorta(x) > kLumen + kAortaWall;
      case Part::RaBlood:
        return (x - ra).norm() < ra_radius && x.z() > cut && !(in_epi(x) && x.z() < base) &&
               !in_la_outer(x) && off_aorta(x) > kLumen + kAortaWall;
      case Part::Aorta:
        return off_aorta(x) < kLumen && x.z() > base && x.z() < top;
      case Part::PapillaryMuscles:
        return (in_muscle(x, 0) || in_muscle(x, 1)) && in_cavity(x) && x.z() < base;
      case Part::Pericardium:
        return contains(Part::Heart, x) ||
               (level(x, 0, centre, radius_epi + kFat, radius_epi + kFat, half_epi + kFat,
                      kHalfFat) < 0 &&
                x.z() < base + kHalfFat) ||
               (level(x, rx, rz, px + 3.5 + kFat, py + 3.5 + kFat, pz + 3.5 + kFat, kHalfFat) < 0 &&
                x.z() < cut + kHalfFat);
    }
    return false;
  }

  /// A parametrised surface; derivatives along u and v are at most `reach` long, and so are the
  /// second ones.
  struct Patch {
    std::function<Vec3(double, double)> point, along_u, along_v, normal;
    double u0, u1, v0, v1, reach;
    std::function<double(const Vec3&)> at_least;  // no more than the distance to the surface
    std::vector<Part> bounds;                     // what it may be a face of
    bool round = true;
    double shrink(double v, double dv) const {
      return round ? std::min(1.0, std::sin(v) + dv) : 1.0;
    }
  };

  std::vector<Patch> patches() const {
    std::vector<Patch> out;
    const auto ellipsoid = [&out](const Vec3& at, double p, double q, double r,
                                  std::vector<Part> bounds) {
      const double cx = at.x();
      const double cy = at.y();
      const double cz = at.z();
      out.push_back({[=](double u, double v) {
                       return Vec3(cx + p * std::cos(u) * std::sin(v),
                                   cy + q * std::sin(u) * std::sin(v), cz + r * std::cos(v));
                     },
                     [=](double u, double v) {
                       return Vec3(-p * std::sin(u) * std::sin(v), q * std::cos(u) * std::sin(v),
                                   0);
                     },
                     [=](double u, double v) {
                       return Vec3(p * std::cos(u) * std::cos(v), q * std::sin(u) * std::cos(v),
                                   -r * std::sin(v));
                     },
                     [=](double u, double v) {
                       return Vec3(Vec3(std::cos(u) * std::sin(v) / p,
                                        std::sin(u) * std::sin(v) / q, std::cos(v) / r)
                                       .normalized());
                     },
                     0, 2 * M_PI, 0, M_PI, std::max({p, q, r}),
                     [=](const Vec3& x) {
                       return std::abs(std::sqrt(level(x, cx, cz, p, q, r, cy) + 1) - 1) *
                              std::min({p, q, r});
                     },
                     std::move(bounds)});
    };
    const Vec3 lv(0, 0, centre);
    const Vec3 rv(rx, 0, rz);
    const Vec3 forward(0, kHalfFat, 0);
    const double epi = radius_epi;
    ellipsoid(lv, a, a, c, {Part::LvBlood, Part::LvMyocardium, Part::PapillaryMuscles});
    ellipsoid(lv, epi, epi, half_epi,
              {Part::Heart, Part::LvMyocardium, Part::RvBlood, Part::RvWall, Part::RaBlood});
    ellipsoid(rv, px, py, pz, {Part::RvBlood, Part::RvWall});
    ellipsoid(rv, px + 3.5, py + 3.5, pz + 3.5, {Part::Heart, Part::RvWall});
    ellipsoid(lv + forward, epi + kFat, epi + kFat, half_epi + kFat, {Part::Pericardium});
    ellipsoid(rv + forward, px + 3.5 + kFat, py + 3.5 + kFat, pz + 3.5 + kFat, {Part::Pericardium});
    const auto sphere = [&](const Vec3& at, double radius, std::vector<Part> bounds) {
      ellipsoid(at, radius, radius, radius, std::move(bounds));
    };
    sphere(la, la_radius, {Part::LaBlood});
    sphere(la, la_radius + kAtrialWall, {Part::Heart, Part::RaBlood, Part::Pericardium});
    sphere(ra, ra_radius, {Part::RaBlood});
    sphere(ra, ra_radius + kAtrialWall, {Part::Heart, Part::Pericardium});
    for (const Vec3& at : muscle) {
      ellipsoid(at, muscle_radius, muscle_radius, muscle_half, {Part::PapillaryMuscles});
    }
    const auto cylinder = [&out](double radius, double low, double high, std::vector<Part> bounds) {
      out.push_back(
          {[=](double u, double v) {
             return Vec3(kAortaX + radius * std::cos(u), kAortaY + radius * std::sin(u), v);
           },
           [=](double u, double) { return Vec3(-radius * std::sin(u), radius * std::cos(u), 0); },
           [](double, double) { return Vec3(0, 0, 1); },
           [](double u, double) { return Vec3(std::cos(u), std::sin(u), 0); }, 0, 2 * M_PI, low,
           high, radius, [=](const Vec3& x) { return std::abs(off_aorta(x) - radius); },
           std::move(bounds), false});
    };
    cylinder(kLumen, base, top, {Part::Aorta});
    cylinder(kLumen + kAortaWall, foot, std::max(top, la.z() + 40),
             {Part::Heart, Part::LaBlood, Part::RaBlood, Part::Pericardium});
    const auto plane = [&out](double z, std::vector<Part> bounds) {
      out.push_back({[z](double u, double v) { return Vec3(u, v, z); },
                     [](double, double) { return Vec3(1, 0, 0); },
                     [](double, double) { return Vec3(0, 1, 0); },
                     [](double, double) { return Vec3(0, 0, 1); }, -80, 80, -80, 80, 1.0,
                     [z](const Vec3& x) { return std::abs(x.z() - z); }, std::move(bounds), false});
    };
    plane(base, {Part::Heart, Part::LvBlood, Part::LvMyocardium, Part::LaBlood, Part::RaBlood,
                 Part::Aorta, Part::PapillaryMuscles});
    plane(cut, {Part::Heart, Part::RvBlood, Part::RvWall, Part::RaBlood});
    plane(foot, {Part::Heart, Part::Pericardium});
    plane(top, {Part::Heart, Part::Aorta, Part::Pericardium});
    plane(base + kHalfFat, {Part::Pericardium});
    plane(cut + kHalfFat, {Part::Pericardium});
    return out;
  }

  /// Distance to the part's boundary by branch and bound over all its surfaces: a cell is
  /// dropped only if no point of it can be nearer than the best boundary point found, or if none
  /// is on the boundary. A point of a surface is on the boundary if the part is on one side of
  /// it only. Too large by at most kToleranceMm, on creases by `resolution_mm`.
  static constexpr double kToleranceMm = 1e-5;
  double brute_distance(Part part, const Vec3& x, double resolution_mm) const {
    struct Cell {
      int patch;
      double u, v, du, dv;  // centre and half sizes
      double at_least;
      bool operator<(const Cell& other) const { return at_least > other.at_least; }
    };
    std::vector<Patch> all;
    for (const Patch& patch : patches()) {
      for (Part bounded : patch.bounds) {
        if (bounded == part) all.push_back(patch);
      }
    }
    double best = 1e300;
    std::priority_queue<Cell> queue;
    const auto push = [&](int n, double u, double v, double du, double dv) {
      const Patch& patch = all[n];
      const Vec3 q = patch.point(u, v);
      const double distance = (q - x).norm();
      // Toward the poles of an ellipsoid steps of u grow short.
      const double reach_u = patch.reach * patch.shrink(v, dv);
      const double radius = reach_u * du + patch.reach * dv;
      double at_least = distance - radius;
      if (at_least > 0) {
        // Taylor with the second derivatives of the distance bounded over the cell.
        const Vec3 toward = (q - x) / distance;
        const double second = reach_u * du * du + 2 * patch.reach * du * dv +
                              patch.reach * dv * dv + radius * radius / at_least;
        at_least =
            std::max(at_least, distance - std::abs(toward.dot(patch.along_u(u, v))) * du -
                                   std::abs(toward.dot(patch.along_v(u, v))) * dv - 0.5 * second);
      }
      if (at_least >= best - kToleranceMm) return;
      const Vec3 step = 1e-6 * patch.normal(u, v);
      const bool boundary = contains(part, q + step) != contains(part, q - step);
      if (boundary) best = std::min(best, distance);
      if (radius <= resolution_mm) return;
      bool open = boundary;  // or beside another surface, which may part it
      for (int m = 0; m < static_cast<int>(all.size()) && !open; ++m) {
        open = m != n && !(all[m].at_least(q) > radius + 1e-5);
      }
      if (open) queue.push({n, u, v, du, dv, at_least});
    };
    for (int n = 0; n < static_cast<int>(all.size()); ++n) {
      const Patch& p = all[n];
      constexpr int kStart = 24;
      const double du = 0.5 * (p.u1 - p.u0) / kStart;
      const double dv = 0.5 * (p.v1 - p.v0) / kStart;
      for (int i = 0; i < kStart; ++i) {
        for (int j = 0; j < kStart; ++j) {
          push(n, p.u0 + du * (2 * i + 1), p.v0 + dv * (2 * j + 1), du, dv);
        }
      }
    }
    while (!queue.empty()) {
      const Cell cell = queue.top();
      queue.pop();
      if (cell.at_least >= best - kToleranceMm) break;
      const Patch& patch = all[cell.patch];
      const bool halve_u =
          patch.reach * patch.shrink(cell.v, cell.dv) * cell.du > patch.reach * cell.dv;
      for (double side : {-0.5, 0.5}) {
        if (halve_u) {
          push(cell.patch, cell.u + side * cell.du, cell.v, 0.5 * cell.du, cell.dv);
        } else {
          push(cell.patch, cell.u, cell.v + side * cell.dv, cell.du, 0.5 * cell.dv);
        }
      }
    }
    return best;
  }
};

}  // namespace beatlas::test
