#pragma once
/// The phantom's heart written a second time, from the table of reference numbers, and its distance
/// by exhaustive search. Shares no code with the room it checks.

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <vector>

#include "runtime/atlas/structures.h"
#include "runtime/base/geometry.h"

namespace beatlas::test {

struct ReferenceHeart {
  double a, c, base, apex_wall;  // LV cavity
  double centre, radius_epi, half_epi;
  double rx, rz, px, py, pz, cut;  // RV cavity

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
    return h;
  }

  static double level(const Vec3& x, double cx, double cz, double a, double b, double c) {
    const double u = (x.x() - cx) / a;
    const double v = x.y() / b;
    const double w = (x.z() - cz) / c;
    return u * u + v * v + w * w - 1;
  }
  bool in_cavity(const Vec3& x) const { return level(x, 0, centre, a, a, c) < 0; }
  bool in_epi(const Vec3& x) const {
    return level(x, 0, centre, radius_epi, radius_epi, half_epi) < 0;
  }
  bool in_rv(const Vec3& x) const { return level(x, rx, rz, px, py, pz) < 0; }
  bool in_outer(const Vec3& x) const { return level(x, rx, rz, px + 3.5, py + 3.5, pz + 3.5) < 0; }

  bool contains(Structure structure, const Vec3& x) const {
    switch (structure) {
      case Structure::Heart:
        return (in_epi(x) && x.z() < base) || (in_outer(x) && x.z() < cut);
      case Structure::LvBlood:
        return in_cavity(x) && x.z() < base;
      case Structure::RvBlood:
        return in_rv(x) && !in_epi(x) && x.z() < cut;
      case Structure::LvMyocardium:
        return in_epi(x) && !in_cavity(x) && x.z() < base;
    }
    return false;
  }

  /// A parametrised surface; derivatives along u and v are at most `reach` long, and so are the
  /// second ones.
  struct Patch {
    std::function<Vec3(double, double)> point, along_u, along_v, normal;
    double u0, u1, v0, v1, reach;
    std::function<double(const Vec3&)> at_least;  // no more than the distance to the surface
    std::vector<Structure> bounds;                // what it may be a face of
    bool round = true;
    double shrink(double v, double dv) const {
      return round ? std::min(1.0, std::sin(v) + dv) : 1.0;
    }
  };

  std::vector<Patch> patches() const {
    std::vector<Patch> out;
    const auto ellipsoid = [&out](double cx, double cz, double p, double q, double r,
                                  std::vector<Structure> bounds) {
      out.push_back(
          {[=](double u, double v) {
             return Vec3(cx + p * std::cos(u) * std::sin(v), q * std::sin(u) * std::sin(v),
                         cz + r * std::cos(v));
           },
           [=](double u, double v) {
             return Vec3(-p * std::sin(u) * std::sin(v), q * std::cos(u) * std::sin(v), 0);
           },
           [=](double u, double v) {
             return Vec3(p * std::cos(u) * std::cos(v), q * std::sin(u) * std::cos(v),
                         -r * std::sin(v));
           },
           [=](double u, double v) {
             return Vec3(
                 Vec3(std::cos(u) * std::sin(v) / p, std::sin(u) * std::sin(v) / q, std::cos(v) / r)
                     .normalized());
           },
           0, 2 * M_PI, 0, M_PI, std::max({p, q, r}),
           [=](const Vec3& x) {
             return std::abs(std::sqrt(level(x, cx, cz, p, q, r) + 1) - 1) * std::min({p, q, r});
           },
           std::move(bounds)});
    };
    ellipsoid(0, centre, a, a, c, {Structure::LvBlood, Structure::LvMyocardium});
    ellipsoid(0, centre, radius_epi, radius_epi, half_epi,
              {Structure::Heart, Structure::LvMyocardium, Structure::RvBlood});
    ellipsoid(rx, rz, px, py, pz, {Structure::RvBlood});
    ellipsoid(rx, rz, px + 3.5, py + 3.5, pz + 3.5, {Structure::Heart});
    const auto plane = [&out](double z, std::vector<Structure> bounds) {
      out.push_back({[z](double u, double v) { return Vec3(u, v, z); },
                     [](double, double) { return Vec3(1, 0, 0); },
                     [](double, double) { return Vec3(0, 1, 0); },
                     [](double, double) { return Vec3(0, 0, 1); }, -80, 80, -80, 80, 1.0,
                     [z](const Vec3& x) { return std::abs(x.z() - z); }, std::move(bounds), false});
    };
    plane(base, {Structure::Heart, Structure::LvBlood, Structure::LvMyocardium});
    plane(cut, {Structure::Heart, Structure::RvBlood});
    return out;
  }

  /// Distance to the structure's boundary by branch and bound over all its surfaces: a cell is
  /// dropped only if no point of it can be nearer than the best boundary point found, or if none
  /// is on the boundary. A point of a surface is on the boundary if the structure is on one side of
  /// it only. Too large by at most kToleranceMm, on creases by `resolution_mm`.
  static constexpr double kToleranceMm = 1e-5;
  double brute_distance(Structure structure, const Vec3& x, double resolution_mm) const {
    struct Cell {
      int patch;
      double u, v, du, dv;  // centre and half sizes
      double at_least;
      bool operator<(const Cell& other) const { return at_least > other.at_least; }
    };
    std::vector<Patch> all;
    for (const Patch& patch : patches()) {
      for (Structure bounded : patch.bounds) {
        if (bounded == structure) all.push_back(patch);
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
      const bool boundary = contains(structure, q + step) != contains(structure, q - step);
      if (boundary) best = std::min(best, distance);
      bool clear = true;
      for (int m = 0; m < static_cast<int>(all.size()); ++m) {
        clear = clear && (m == n || all[m].at_least(q) > radius + 1e-5);
      }
      if ((boundary || !clear) && radius > resolution_mm) {
        queue.push({n, u, v, du, dv, at_least});
      }
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
