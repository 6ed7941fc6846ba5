#include "pipeline/mesh/draw_back.h"

#include <algorithm>
#include <cmath>

namespace beatlas::mesh {
namespace {

constexpr double kMostMm = 0.25;  // that a vertex goes at a time

/// A place of a triangle's that has to go back: the mean of some vertices.
struct Place {
  std::array<std::uint32_t, 3> vertex{};
  int count = 0;      ///< of vertices
  double need = 0;    ///< [mm] back, of the place
  double pushed = 0;  ///< multiplier of this demand
};

/// Places that have to go back, and those that nearly have to.
struct Demands {
  std::vector<Place> places;
  bool any = false;  ///< has to

  /// @param beyond [mm] the middle, of the mean of the corners
  void add(double beyond, std::initializer_list<std::uint32_t> corners) {
    if (beyond < -kFarMm / 4) return;
    any |= beyond > 0;
    Place& place = places.emplace_back();
    for (const std::uint32_t v : corners) {
      place.vertex[static_cast<std::size_t>(place.count++)] = v;
    }
    place.need = std::min(beyond, kMostMm);
  }
};

/// Whether a vertex moved since a side was asked.
bool is_stale(const Body& body, const Side& side, std::uint32_t v) {
  return body.moved[v] > side.seen;
}

/// @return [vertex] whether it is near the middle
std::vector<bool> ask_vertices(const Body& body, const Middle& middle,
                               const std::vector<double>& more, Side& side, Demands& demands) {
  std::vector<bool> near(body.points.size());
  side.vertex_beyond.resize(side.vertices.size());
  for (std::size_t k = 0; k < side.vertices.size(); ++k) {
    const std::uint32_t v = side.vertices[k];
    if (is_stale(body, side, v)) side.vertex_beyond[k] = middle.beyond(body.points[v]);
    const double beyond = side.vertex_beyond[k] + more[v];
    near[v] = beyond > -kFarMm;
    demands.add(beyond, {v});
  }
  return near;
}

/// The middles of triangles and of their edges, where all corners are near.
void ask_triangles(const Body& body, const Middle& middle, const std::vector<double>& more,
                   const std::vector<bool>& near, Side& side, Demands& demands) {
  const std::vector<Vec3>& points = body.points;
  const auto stale = [&](std::uint32_t v) { return is_stale(body, side, v); };
  side.triangle_beyond.resize(side.triangles.size());
  side.asked.resize(side.triangles.size(), false);
  for (std::size_t k = 0; k < side.triangles.size(); ++k) {
    const Triangle& t = body.triangles()[side.triangles[k]];
    const bool fresh = side.asked[k] && !stale(t[0]) && !stale(t[1]) && !stale(t[2]);
    side.asked[k] = near[t[0]] && near[t[1]] && near[t[2]];
    if (!side.asked[k]) continue;
    std::array<double, 4>& beyond = side.triangle_beyond[k];
    if (!fresh) beyond[0] = middle.beyond((points[t[0]] + points[t[1]] + points[t[2]]) / 3);
    demands.add(beyond[0] + std::max({more[t[0]], more[t[1]], more[t[2]]}), {t[0], t[1], t[2]});
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t a = t[e];
      const std::uint32_t b = t[(e + 1) % 3];
      if (a > b) continue;
      if (!fresh) beyond[e + 1] = middle.beyond((points[a] + points[b]) / 2);
      demands.add(beyond[e + 1] + std::max(more[a], more[b]), {a, b});
    }
  }
}

/// The shortest ways back d (least sum of squares) that take every place as far as it needs: the
/// dual of the quadratic programme, one demand after the other (Hildreth 1957).
void shortest_ways(std::vector<Place>& places, std::vector<double>& way) {
  constexpr int kSweeps = 25;
  constexpr double kDoneMm = 1e-4;
  double most = 1;
  for (int sweep = 0; sweep < kSweeps && most > kDoneMm; ++sweep) {
    most = 0;
    for (Place& place : places) {
      double gone = 0;
      for (int n = 0; n < place.count; ++n) gone += way[place.vertex[static_cast<std::size_t>(n)]];
      // a . d >= need, a = 1 / count at each of its vertices: |a|^2 = 1 / count.
      const double pushed = std::max(0.0, place.pushed + place.count * place.need - gone);
      for (int n = 0; n < place.count; ++n) {
        way[place.vertex[static_cast<std::size_t>(n)]] += (pushed - place.pushed) / place.count;
      }
      most = std::max(most, std::abs(pushed - place.pushed) / place.count);
      place.pushed = pushed;
    }
  }
}

}  // namespace

void look_around(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles,
                 const Middle& middle, Side& side) {
  if (side.known) return;
  side.known = true;
  std::vector<bool> near(points.size());
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    near[v] = middle.beyond(points[v]) > -kFarMm - kPartRounds * kMostMm;
    if (near[v]) side.vertices.push_back(v);
  }
  for (std::uint32_t n = 0; n < triangles.size(); ++n) {
    const Triangle& t = triangles[n];
    if (near[t[0]] && near[t[1]] && near[t[2]]) side.triangles.push_back(n);
  }
}

bool draw_back(Body& body, const Middle& middle, Side& side, const std::vector<double>& more,
               double thin_deg) {
  Demands demands;
  const std::vector<bool> near = ask_vertices(body, middle, more, side, demands);
  ask_triangles(body, middle, more, near, side, demands);
  side.seen = body.moves;
  if (!demands.any) return false;
  std::vector<double> way(body.points.size(), 0);
  shortest_ways(demands.places, way);
  ++body.moves;
  for (const std::uint32_t v : side.vertices) {
    if (!(way[v] > 0)) continue;
    const Vec3 from = body.points[v];
    body.moved[v] = body.moves;
    body.fans->move(body.points, body.start, v, std::min(way[v], kMostMm) * middle.back(from),
                    thin_deg);
  }
  return true;
}

}  // namespace beatlas::mesh
