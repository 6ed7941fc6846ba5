#include "pipeline/mesh/nested.h"

#include <algorithm>
#include <array>

#include "pipeline/core/parallel.h"
#include "pipeline/field/interpolant.h"
#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {
namespace {

constexpr double kGapMm = 0.01;   // of either surface from the middle
constexpr double kFarMm = 1.0;    // from the middle: no triangle of a vertex there reaches it
constexpr double kMostMm = 0.25;  // that a vertex goes at a time
constexpr int kRounds = 5;

/// All of them lie beside each other, and in the heart.
constexpr std::array kInHeart{Structure::LvBlood, Structure::LvMyocardium, Structure::RvBlood,
                              Structure::LaBlood, Structure::RaBlood,      Structure::Aorta};

template <class Cycle>
Cycle* of(std::vector<Cycle>& cycles, Structure structure) {
  for (Cycle& cycle : cycles) {
    if (cycle.structure == structure) return &cycle;
  }
  return nullptr;
}

/// A function of two distances that is positive where a place of the first structure has to go
/// back.
struct Bound {
  double own = 0;
  double other = 0;
};
constexpr Bound kBeside{0.5, -0.5};     // the middle between two
constexpr Bound kWithin{0.5, 0.5};      // the same, of a cavity in the heart
constexpr Bound kAround{-0.5, -0.5};    // and of the heart around it
constexpr Bound kOutsideOf{0.0, -1.0};  // the other's own surface

/// How far a place is beyond what bounds it.
class Middle {
 public:
  Middle(const field::Interpolant& own, const field::Interpolant& other, const Bound& bound)
      : own_(own), other_(other), bound_(bound) {}

  [[nodiscard]] double beyond(const Vec3& x) const {
    return bound_.own * own_.value(x) + bound_.other * other_.value(x) + kGapMm;
  }
  /// Unit vector the way back; zero where there is none.
  [[nodiscard]] Vec3 back(const Vec3& x) const {
    const Vec3 slope =
        bound_.own * own_.sample(x).gradient + bound_.other * other_.sample(x).gradient;
    const double steep = slope.norm();
    return steep > 0.3 ? Vec3(-slope / steep) : Vec3(Vec3::Zero());
  }

 private:
  const field::Interpolant& own_;
  const field::Interpolant& other_;
  Bound bound_;
};

/// A place of a triangle's that has to go back: the mean of some vertices.
struct Place {
  std::array<std::uint32_t, 3> vertex{};
  int count = 0;      ///< of vertices
  double need = 0;    ///< [mm] back, of the place
  double pushed = 0;  ///< multiplier of this demand
};

/// The shortest ways back d (least sum of squares) that take every place as far as it needs: the
/// dual of the quadratic programme, one demand after the other (Hildreth 1957).
void shortest_ways(std::vector<Place>& places, std::vector<double>& way) {
  constexpr int kSweeps = 25;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (Place& place : places) {
      double gone = 0;
      for (int n = 0; n < place.count; ++n) gone += way[place.vertex[static_cast<std::size_t>(n)]];
      // a . d >= need, a = 1 / count at each of its vertices: |a|^2 = 1 / count.
      const double pushed = std::max(0.0, place.pushed + place.count * place.need - gone);
      for (int n = 0; n < place.count; ++n) {
        way[place.vertex[static_cast<std::size_t>(n)]] += (pushed - place.pushed) / place.count;
      }
      place.pushed = pushed;
    }
  }
}

/// @return whether anything moved
bool draw_back(std::vector<Vec3>& points, const std::vector<Triangle>& triangles,
               const Middle& middle) {
  std::vector<bool> near(points.size());
  std::vector<Place> places;
  bool any = false;
  const auto demand = [&](double beyond, std::initializer_list<std::uint32_t> corners) {
    if (beyond < -kFarMm / 4) return;
    any |= beyond > 0;
    Place& place = places.emplace_back();
    for (const std::uint32_t v : corners) {
      place.vertex[static_cast<std::size_t>(place.count++)] = v;
    }
    place.need = std::min(beyond, kMostMm);
  };
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    const double beyond = middle.beyond(points[v]);
    near[v] = beyond > -kFarMm;
    demand(beyond, {v});
  }
  for (const Triangle& t : triangles) {
    if (!near[t[0]] || !near[t[1]] || !near[t[2]]) continue;
    demand(middle.beyond((points[t[0]] + points[t[1]] + points[t[2]]) / 3), {t[0], t[1], t[2]});
    for (std::size_t n = 0; n < 3; ++n) {
      const std::uint32_t a = t[n];
      const std::uint32_t b = t[(n + 1) % 3];
      if (a < b) demand(middle.beyond((points[a] + points[b]) / 2), {a, b});
    }
  }
  if (!any) return false;
  std::vector<double> way(points.size(), 0);
  shortest_ways(places, way);
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (way[v] > 0) points[v] += std::min(way[v], kMostMm) * middle.back(points[v]);
  }
  return true;
}

}  // namespace

void part_structures(std::vector<SurfaceCycle>& surfaces, const std::vector<FieldCycle>& given) {
  if (surfaces.empty()) return;
  std::vector<const FieldCycle*> fields;
  for (const SurfaceCycle& surface : surfaces) {
    const auto field = std::find_if(given.begin(), given.end(), [&](const FieldCycle& each) {
      return each.structure == surface.structure;
    });
    if (field != given.end()) fields.push_back(&*field);
  }
  const std::size_t phases = surfaces.front().positions.size();
  parallel_for(phases, [&](std::size_t p) {
    struct Body {
      SurfaceCycle* surface;
      field::Interpolant field;
      std::vector<Vec3> points;
      Eigen::AlignedBox3d box;
    };
    std::vector<Body> bodies;
    for (const FieldCycle* field : fields) {
      SurfaceCycle* surface = of(surfaces, field->structure);
      Body& body = bodies.emplace_back(
          Body{surface, {field->distance_mm.grid, field->distance_mm.phases[p]}, {}, {}});
      for (const Vec3f& x : surface->positions[p]) {
        body.points.emplace_back(x.cast<double>());
        body.box.extend(body.points.back());
      }
      body.box.min().array() -= kFarMm;
      body.box.max().array() += kFarMm;
    }
    const auto body_of = [&](Structure structure) -> Body* {
      for (Body& body : bodies) {
        if (body.surface->structure == structure) return &body;
      }
      return nullptr;
    };
    for (int round = 0; round < kRounds; ++round) {
      bool moved = false;
      const auto part = [&](Structure first, Structure second) {
        Body* one = body_of(first);
        Body* other = body_of(second);
        if (one == nullptr || other == nullptr || !one->box.intersects(other->box)) return;
        const bool inside = second == Structure::Heart;
        // Ventricles are the same whether atria are known or not.
        const bool first_stays = !inside && is_beyond_base(second) && !is_beyond_base(first);
        if (!first_stays) {
          moved |= draw_back(one->points, one->surface->triangles,
                             Middle(one->field, other->field, inside ? kWithin : kBeside));
        }
        moved |= draw_back(other->points, other->surface->triangles,
                           Middle(other->field, one->field,
                                  inside        ? kAround
                                  : first_stays ? kOutsideOf
                                                : kBeside));
      };
      for (std::size_t n = 0; n < kInHeart.size(); ++n) {
        for (std::size_t m = n + 1; m < kInHeart.size(); ++m) part(kInHeart[n], kInHeart[m]);
      }
      for (const Structure structure : kInHeart) part(structure, Structure::Heart);
      if (!moved) break;
    }
    for (Body& body : bodies) {
      for (std::size_t v = 0; v < body.points.size(); ++v) {
        body.surface->positions[p][v] = body.points[v].cast<float>();
      }
    }
  });
}

}  // namespace beatlas::mesh
