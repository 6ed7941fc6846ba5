#include "pipeline/mesh/nested.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "pipeline/core/parallel.h"
#include "pipeline/field/interpolant.h"
#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {
namespace {

constexpr double kGapMm = 0.01;   // of either surface from the middle
constexpr double kFarMm = 1.0;    // from the middle: no triangle of a vertex there reaches it
constexpr double kMostMm = 0.25;  // that a vertex goes at a time
constexpr int kRounds = 5;
constexpr double kFarFromOwnMm = 4;  // of what goes back alone
constexpr double kMostOffMm = 1.25;  // from its own surface: farther it would be another shape
constexpr int kMoreRounds = 12;      // for what crosses all the same
constexpr double kMoreMm = 0.05;     // that its vertices go beyond the middle, a round
constexpr double kClearMm = 0.03;    // and once more when nothing crosses
constexpr double kThinDeg = 11;      // a triangle that would become thinner stays
constexpr double kMoreThinDeg = 20;  // the same of what crosses all the same

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

void sort_unique(std::vector<std::uint32_t>& all) {
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
}

/// Where a vertex's triangles are.
class Fans {
 public:
  Fans(std::size_t vertices, std::span<const Triangle> triangles)
      : triangles_(triangles), first_(vertices + 1, 0), at_(3 * triangles.size()) {
    for (const Triangle& t : triangles) {
      for (const std::uint32_t v : t) ++first_[v + 1];
    }
    for (std::size_t v = 0; v < vertices; ++v) first_[v + 1] += first_[v];
    std::vector<std::uint32_t> filled(first_.begin(), first_.end() - 1);
    for (std::uint32_t n = 0; n < triangles.size(); ++n) {
      for (const std::uint32_t v : triangles[n]) at_[filled[v]++] = n;
    }
  }

  /// The triangles of some vertices, ascending.
  [[nodiscard]] std::vector<std::uint32_t> around(
      const std::vector<std::uint32_t>& vertices) const {
    std::vector<std::uint32_t> out;
    for (const std::uint32_t v : vertices) {
      out.insert(out.end(), at_.begin() + first_[v], at_.begin() + first_[v + 1]);
    }
    sort_unique(out);
    return out;
  }

  /// Moves a vertex as far of the way, all, half or a quarter, as turns no triangle far from where
  /// it was at the start and makes none thin.
  void move(std::vector<Vec3>& points, const std::vector<Vec3>& start, std::uint32_t v,
            const Vec3& way, double thin_deg) const {
    const Vec3 from = points[v];
    for (const double share : {1.0, 0.5, 0.25}) {
      points[v] = from + share * way;
      const bool sound = std::all_of(
          at_.begin() + first_[v], at_.begin() + first_[v + 1],
          [&](std::uint32_t n) { return is_sound(triangles_[n], points, start, thin_deg); });
      if (sound) return;
    }
    points[v] = from;
  }

 private:
  static bool is_sound(const Triangle& t, const std::vector<Vec3>& points,
                       const std::vector<Vec3>& start, double thin_deg) {
    constexpr double kTurned = 0.7;  // cosine
    const auto area = [&](const std::vector<Vec3>& of) -> Vec3 {
      return (of[t[1]] - of[t[0]]).cross(of[t[2]] - of[t[0]]);
    };
    const auto least_deg = [&](const std::vector<Vec3>& of) {
      return least_angle_deg(of[t[0]], of[t[1]], of[t[2]]);
    };
    const Vec3 before = area(start);
    const Vec3 after = area(points);
    if (before.dot(after) < kTurned * before.norm() * after.norm()) return false;
    const double now_deg = least_deg(points);
    return now_deg > thin_deg || now_deg >= least_deg(start);
  }

  std::span<const Triangle> triangles_;
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> at_;
};

/// Of one of two structures: what comes near the other.
struct Side {
  std::vector<std::uint32_t> vertices;
  std::vector<std::uint32_t> triangles;
  bool known = false;
  /// What was found of them last, how far beyond the middle [mm]: of those that moved since, and of
  /// their triangles, it is asked again.
  std::vector<double> vertex_beyond;
  std::vector<std::array<double, 4>> triangle_beyond;  ///< its middle, its edges' from corner 0 on
  std::vector<bool> asked;                             ///< [triangle]
  int seen = -1;                                       ///< moves of the body then
};

void look_around(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles,
                 const Middle& middle, Side& side) {
  if (side.known) return;
  side.known = true;
  std::vector<bool> near(points.size());
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    near[v] = middle.beyond(points[v]) > -kFarMm - kRounds * kMostMm;
    if (near[v]) side.vertices.push_back(v);
  }
  for (std::uint32_t n = 0; n < triangles.size(); ++n) {
    const Triangle& t = triangles[n];
    if (near[t[0]] && near[t[1]] && near[t[2]]) side.triangles.push_back(n);
  }
}

/// A structure in one phase.
struct Body {
  SurfaceCycle* surface;
  const Fans* fans;
  field::Interpolant field;
  std::vector<Vec3> points;
  std::vector<Vec3> start;
  Eigen::AlignedBox3d box;      ///< and what lies near it
  Eigen::AlignedBox3d changed;  ///< triangles that moved since crossings were looked for
  std::vector<int> moved;       ///< [vertex] at which of the body's moves last
  int moves = 0;

  [[nodiscard]] Structure structure() const { return surface->structure; }
  [[nodiscard]] const std::vector<Triangle>& triangles() const { return surface->triangles; }
  [[nodiscard]] Eigen::AlignedBox3d box_of(const Triangle& t) const {
    return Eigen::AlignedBox3d(points[t[0]]).extend(points[t[1]]).extend(points[t[2]]);
  }
};

/// @param side what of the body may demand and move
/// @param more [vertex] [mm] that it has to go beyond the middle
/// @param most_off_mm that a vertex may get off its own surface
/// @return whether anything moved
bool draw_back(Body& body, const Middle& middle, Side& side, const std::vector<double>& more,
               double thin_deg, double most_off_mm) {
  const std::vector<Vec3>& points = body.points;
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
  const auto stale = [&](std::uint32_t v) { return body.moved[v] > side.seen; };
  std::vector<bool> near(points.size());
  side.vertex_beyond.resize(side.vertices.size());
  for (std::size_t k = 0; k < side.vertices.size(); ++k) {
    const std::uint32_t v = side.vertices[k];
    if (stale(v)) side.vertex_beyond[k] = middle.beyond(points[v]);
    const double beyond = side.vertex_beyond[k] + more[v];
    near[v] = beyond > -kFarMm;
    demand(beyond, {v});
  }
  side.triangle_beyond.resize(side.triangles.size());
  side.asked.resize(side.triangles.size(), false);
  for (std::size_t k = 0; k < side.triangles.size(); ++k) {
    const Triangle& t = body.triangles()[side.triangles[k]];
    const bool fresh = side.asked[k] && !stale(t[0]) && !stale(t[1]) && !stale(t[2]);
    side.asked[k] = near[t[0]] && near[t[1]] && near[t[2]];
    if (!side.asked[k]) continue;
    std::array<double, 4>& beyond = side.triangle_beyond[k];
    if (!fresh) beyond[0] = middle.beyond((points[t[0]] + points[t[1]] + points[t[2]]) / 3);
    demand(beyond[0] + std::max({more[t[0]], more[t[1]], more[t[2]]}), {t[0], t[1], t[2]});
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t a = t[e];
      const std::uint32_t b = t[(e + 1) % 3];
      if (a > b) continue;
      if (!fresh) beyond[e + 1] = middle.beyond((points[a] + points[b]) / 2);
      demand(beyond[e + 1] + std::max(more[a], more[b]), {a, b});
    }
  }
  side.seen = body.moves;
  if (!any) return false;
  std::vector<double> way(points.size(), 0);
  shortest_ways(places, way);
  ++body.moves;
  for (const std::uint32_t v : side.vertices) {
    if (!(way[v] > 0)) continue;
    const Vec3 from = points[v];
    body.moved[v] = body.moves;
    body.fans->move(body.points, body.start, v, std::min(way[v], kMostMm) * middle.back(from),
                    thin_deg);
    const double off_mm = std::abs(body.field.value(points[v]));
    if (off_mm > most_off_mm && off_mm > std::abs(body.field.value(from))) body.points[v] = from;
  }
  return true;
}

/// All structures of one phase.
class Phase {
 public:
  explicit Phase(std::vector<Body> bodies) : bodies_(std::move(bodies)) {
    for (std::size_t n = 0; n < kInHeart.size(); ++n) {
      for (std::size_t m = n + 1; m < kInHeart.size(); ++m) add_pair(kInHeart[n], kInHeart[m]);
    }
    for (const Structure structure : kInHeart) add_pair(structure, Structure::Heart);
  }

  void part() {
    // Ventricles are the same whether atria are known or not.
    for (std::vector<Pair>* pairs : {&ventricles_, &beyond_base_}) {
      for (int round = 0; round < kRounds; ++round) {
        bool moved = false;
        for (Pair& pair : *pairs) {
          for (Half& half : pair.halves) moved |= part(half);
        }
        if (!moved) break;
      }
      for (Body& body : bodies_) body.changed = body.box;
      bool cleared = false;
      for (int round = 0; round < kMoreRounds; ++round) {
        if (part_crossings(*pairs)) continue;
        if (cleared) break;
        cleared = true;
        clear(*pairs);
      }
    }
  }

  [[nodiscard]] const std::vector<Body>& bodies() const { return bodies_; }

 private:
  /// What goes back from what.
  struct Half {
    Body* body;
    Middle middle;
    bool stays;          ///< the other goes back alone
    double most_off_mm;  ///< see draw_back
    Side side;
    std::vector<double> more;  ///< see draw_back
  };
  struct Pair {
    std::array<Half, 2> halves;
  };

  Body* body_of(Structure structure) {
    for (Body& body : bodies_) {
      if (body.structure() == structure) return &body;
    }
    return nullptr;
  }

  void add_pair(Structure first, Structure second) {
    Body* one = body_of(first);
    Body* other = body_of(second);
    if (one == nullptr || other == nullptr || !one->box.intersects(other->box)) return;
    const bool inside = second == Structure::Heart;
    const bool stays = !inside && is_beyond_base(second) && !is_beyond_base(first);
    const Bound& bound = inside ? kAround : stays ? kOutsideOf : kBeside;
    const bool apart = is_beyond_base(first) || is_beyond_base(second);
    (apart ? beyond_base_ : ventricles_)
        .push_back({{Half{one,
                          Middle(one->field, other->field, inside ? kWithin : kBeside),
                          stays,
                          kMostOffMm,
                          {},
                          {}},
                     Half{other,
                          Middle(other->field, one->field, bound),
                          false,
                          stays ? kFarFromOwnMm : kMostOffMm,
                          {},
                          {}}}});
  }

  static bool part(Half& half) {
    look_around(half.body->points, half.body->triangles(), half.middle, half.side);
    if (half.more.empty()) half.more.assign(half.body->points.size(), 0);
    return !half.stays &&
           draw_back(*half.body, half.middle, half.side, half.more, kThinDeg, half.most_off_mm);
  }

  /// What crosses all the same goes back farther, with the triangles around.
  /// @return whether anything crossed
  bool part_crossings(std::vector<Pair>& pairs) {
    struct Found {
      Half* half;
      std::vector<std::uint32_t> vertices;
    };
    std::vector<Found> found;
    for (Pair& pair : pairs) {
      Half& one = pair.halves[0];
      Half& other = pair.halves[1];
      const auto near = [&](const Half& half) {
        std::vector<Triangle> out;
        for (const std::uint32_t n : half.side.triangles) {
          const Triangle& t = half.body->triangles()[n];
          const Eigen::AlignedBox3d box = half.body->box_of(t);
          if (box.intersects(one.body->changed) || box.intersects(other.body->changed)) {
            out.push_back(t);
          }
        }
        return out;
      };
      Found own{&one, {}};
      Found its{&other, {}};
      for (const auto& [a, b] :
           crossings(one.body->points, near(one), other.body->points, near(other))) {
        own.vertices.insert(own.vertices.end(), a.begin(), a.end());
        its.vertices.insert(its.vertices.end(), b.begin(), b.end());
      }
      if (own.vertices.empty()) continue;
      if (!one.stays) found.push_back(std::move(own));
      found.push_back(std::move(its));
    }
    for (Body& body : bodies_) body.changed.setEmpty();
    for (Found& each : found) {
      sort_unique(each.vertices);
      push(*each.half, each.vertices, kMoreMm);
    }
    return !found.empty();
  }

  /// So much farther from the middle than before. @param crossing vertices, ascending
  static void push(Half& half, const std::vector<std::uint32_t>& crossing, double mm) {
    for (const std::uint32_t v : crossing) half.more[v] += mm;
    Side side;
    side.triangles = half.body->fans->around(crossing);
    for (const std::uint32_t n : side.triangles) {
      for (const std::uint32_t v : half.body->triangles()[n]) side.vertices.push_back(v);
    }
    sort_unique(side.vertices);
    const std::vector<std::uint32_t> around = half.body->fans->around(side.vertices);
    std::vector<Vec3> before;
    for (const std::uint32_t v : side.vertices) before.push_back(half.body->points[v]);
    (void)draw_back(*half.body, half.middle, side, half.more, kMoreThinDeg, half.most_off_mm);
    keep_apart(*half.body, around, side.vertices, before);
    for (const std::uint32_t n : around) {
      half.body->changed.extend(half.body->box_of(half.body->triangles()[n]));
    }
  }

  /// What no longer crosses may still touch, and would cross again in a package's counts.
  static void clear(std::vector<Pair>& pairs) {
    for (Pair& pair : pairs) {
      for (Half& half : pair.halves) {
        if (half.stays) continue;
        std::vector<std::uint32_t> crossed;
        for (std::uint32_t v = 0; v < half.more.size(); ++v) {
          if (half.more[v] > 0) crossed.push_back(v);
        }
        if (!crossed.empty()) push(half, crossed, kClearMm);
      }
    }
  }

  /// Takes moves back that made a surface pass through itself.
  /// @param moved triangles @param vertices that moved, ascending @param before where they were
  static void keep_apart(Body& body, const std::vector<std::uint32_t>& moved,
                         const std::vector<std::uint32_t>& vertices,
                         const std::vector<Vec3>& before) {
    Eigen::AlignedBox3d box;
    for (const std::uint32_t n : moved) box.extend(body.box_of(body.triangles()[n]));
    std::vector<Triangle> near;
    std::vector<bool> among;
    for (std::uint32_t n = 0; n < body.triangles().size(); ++n) {
      const Triangle& t = body.triangles()[n];
      if (!box.intersects(body.box_of(t))) continue;
      near.push_back(t);
      among.push_back(std::binary_search(moved.begin(), moved.end(), n));
    }
    for (bool again = true; again;) {
      again = false;
      for (const auto& [a, b] : self_intersections(body.points, near, among)) {
        for (const std::uint32_t n : {a, b}) {
          for (const std::uint32_t v : near[n]) {
            const auto at = std::lower_bound(vertices.begin(), vertices.end(), v);
            if (at == vertices.end() || *at != v) continue;
            const Vec3& was = before[static_cast<std::size_t>(at - vertices.begin())];
            again = again || body.points[v] != was;
            body.points[v] = was;
          }
        }
      }
    }
  }

  std::vector<Body> bodies_;
  std::vector<Pair> ventricles_;   ///< among them, and with the heart
  std::vector<Pair> beyond_base_;  ///< with atria and vessels
};

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
  std::vector<Fans> fans;
  for (const FieldCycle* field : fields) {
    const SurfaceCycle* surface = of(surfaces, field->structure);
    fans.emplace_back(surface->positions.front().size(), surface->triangles);
  }
  const std::size_t phases = surfaces.front().positions.size();
  parallel_for(phases, [&](std::size_t p) {
    std::vector<Body> bodies;
    for (const FieldCycle* field : fields) {
      SurfaceCycle* surface = of(surfaces, field->structure);
      Body& body = bodies.emplace_back(Body{surface,
                                            &fans[bodies.size()],
                                            {field->distance_mm.grid, field->distance_mm.phases[p]},
                                            {},
                                            {},
                                            {},
                                            {},
                                            {}});
      for (const Vec3f& x : surface->positions[p]) {
        body.points.emplace_back(x.cast<double>());
        body.box.extend(body.points.back());
      }
      body.start = body.points;
      body.moved.assign(body.points.size(), 0);
      body.box.min().array() -= kFarMm;
      body.box.max().array() += kFarMm;
    }
    Phase phase(std::move(bodies));
    phase.part();
    for (const Body& body : phase.bodies()) {
      for (std::size_t v = 0; v < body.points.size(); ++v) {
        body.surface->positions[p][v] = body.points[v].cast<float>();
      }
    }
  });
}

}  // namespace beatlas::mesh
