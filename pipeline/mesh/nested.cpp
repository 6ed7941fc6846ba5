#include "pipeline/mesh/nested.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/mesh/draw_back.h"
#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {
namespace {

constexpr double kOffMm = 0.25;    // from its own surface: farther off, no field tells what crosses
constexpr int kMoreRounds = 24;    // for what crosses all the same
constexpr double kMoreMm = 0.05;   // that its vertices go on, a round
constexpr double kClearMm = 0.03;  // and once more when nothing crosses
constexpr double kThinDeg = 11;    // a triangle that would become thinner stays
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

constexpr Bound kBeside{0.5, -0.5};     // the middle between two
constexpr Bound kWithin{0.5, 0.5};      // the same, of a cavity in the heart
constexpr Bound kAround{-0.5, -0.5};    // and of the heart around it
constexpr Bound kOutsideOf{0.0, -1.0};  // the other's own surface

/// All structures of one phase.
class Phase {
 public:
  Phase(std::vector<Body> bodies, const std::vector<Structure>& held)
      : bodies_(std::move(bodies)), held_(held) {
    for (std::size_t n = 0; n < kInHeart.size(); ++n) {
      for (std::size_t m = n + 1; m < kInHeart.size(); ++m) add_pair(kInHeart[n], kInHeart[m]);
    }
    for (const Structure structure : kInHeart) add_pair(structure, Structure::Heart);
  }

  void part() {
    // Ventricles are the same whether atria are known or not.
    for (std::vector<Pair>* pairs : {&ventricles_, &beyond_base_}) {
      for (int round = 0; round < kPartRounds; ++round) {
        bool moved = false;
        for (Pair& pair : *pairs) {
          for (Half& half : pair.halves) moved |= part(half);
        }
        if (!moved) break;
      }
      for (Body& body : bodies_) {
        stay_apart(body);
        body.changed = body.box;
        body.off = off_surface(body);
      }
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
    bool stays;  ///< the other, if any, goes back alone
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
    const bool beyond_alone = !inside && is_beyond_base(second) && !is_beyond_base(first);
    const Bound& bound = inside ? kAround : beyond_alone ? kOutsideOf : kBeside;
    const bool apart = is_beyond_base(first) || is_beyond_base(second);
    const Middle middle(one->field, other->field, inside ? kWithin : kBeside);
    (apart ? beyond_base_ : ventricles_)
        .push_back(
            {{Half{one, middle, beyond_alone || is_held(first), {}, {}},
              Half{other, Middle(other->field, one->field, bound), is_held(second), {}, {}}}});
  }

  [[nodiscard]] bool is_held(Structure structure) const {
    return std::find(held_.begin(), held_.end(), structure) != held_.end();
  }

  static bool part(Half& half) {
    look_around(half.body->points, half.body->triangles(), half.middle, half.side);
    if (half.more.empty()) half.more.assign(half.body->points.size(), 0);
    return !half.stays && draw_back(*half.body, half.middle, half.side, half.more, kThinDeg);
  }

  /// Triangles that are off their surface, on a membrane across a slit that other phases have open.
  static std::vector<std::uint32_t> off_surface(const Body& body) {
    std::vector<bool> off(body.points.size());
    for (std::size_t v = 0; v < off.size(); ++v) {
      off[v] = std::abs(body.field.value(body.points[v])) > kOffMm;
    }
    std::vector<std::uint32_t> out;
    for (std::uint32_t n = 0; n < body.triangles().size(); ++n) {
      const Triangle& t = body.triangles()[n];
      if (off[t[0]] || off[t[1]] || off[t[2]]) out.push_back(n);
    }
    return out;
  }

  /// What of a half may cross the other: what is near the middle, and what either has off its
  /// surface with what of the other is around that. Only where something changed.
  static std::vector<Triangle> may_cross(const Half& half, const Half& other) {
    const Body& body = *half.body;
    if (body.changed.isEmpty() && other.body->changed.isEmpty()) return {};
    Eigen::AlignedBox3d around;
    for (const std::uint32_t n : other.body->off) {
      around.extend(other.body->box_of(other.body->triangles()[n]));
    }
    const auto is_new = [&](const Eigen::AlignedBox3d& box) {
      return box.intersects(body.changed) || box.intersects(other.body->changed);
    };
    std::vector<std::uint32_t> all;
    for (const auto* some : {&half.side.triangles, &body.off}) {
      for (const std::uint32_t n : *some) {
        if (is_new(body.box_of(body.triangles()[n]))) all.push_back(n);
      }
    }
    if (!around.isEmpty()) {
      for (std::uint32_t n = 0; n < body.triangles().size(); ++n) {
        const Eigen::AlignedBox3d box = body.box_of(body.triangles()[n]);
        if (around.intersects(box) && is_new(box)) all.push_back(n);
      }
    }
    sort_unique(all);
    std::vector<Triangle> out;
    for (const std::uint32_t n : all) out.push_back(body.triangles()[n]);
    return out;
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
      Found own{&one, {}};
      Found its{&other, {}};
      for (const auto& [a, b] : crossings(one.body->points, may_cross(one, other),
                                          other.body->points, may_cross(other, one))) {
        own.vertices.insert(own.vertices.end(), a.begin(), a.end());
        its.vertices.insert(its.vertices.end(), b.begin(), b.end());
      }
      if (own.vertices.empty()) continue;
      if (!one.stays) found.push_back(std::move(own));
      if (!other.stays) found.push_back(std::move(its));
    }
    for (Body& body : bodies_) body.changed.setEmpty();
    for (Found& each : found) {
      sort_unique(each.vertices);
      push(*each.half, each.vertices, kMoreMm);
    }
    return !found.empty();
  }

  /// So much farther from the middle than before, or than they are. @param crossing vertices,
  /// ascending
  static void push(Half& half, const std::vector<std::uint32_t>& crossing, double mm) {
    for (const std::uint32_t v : crossing) {
      half.more[v] = std::max(half.more[v], -half.middle.beyond(half.body->points[v])) + mm;
    }
    Side side;
    side.triangles = half.body->fans->around(crossing);
    for (const std::uint32_t n : side.triangles) {
      for (const std::uint32_t v : half.body->triangles()[n]) side.vertices.push_back(v);
    }
    sort_unique(side.vertices);
    const std::vector<std::uint32_t> around = half.body->fans->around(side.vertices);
    std::vector<Vec3> before;
    for (const std::uint32_t v : side.vertices) before.push_back(half.body->points[v]);
    (void)draw_back(*half.body, half.middle, side, half.more, kMoreThinDeg);
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

  /// Both sides of a thin wall may have gone back from what lies beside them, and into each other.
  static void stay_apart(Body& body) {
    std::vector<std::uint32_t> vertices;
    std::vector<Vec3> before;
    for (std::uint32_t v = 0; v < body.points.size(); ++v) {
      if (body.points[v] == body.start[v]) continue;
      vertices.push_back(v);
      before.push_back(body.start[v]);
    }
    if (!vertices.empty()) keep_apart(body, body.fans->around(vertices), vertices, before);
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
  const std::vector<Structure>& held_;
  std::vector<Pair> ventricles_;   ///< among them, and with the heart
  std::vector<Pair> beyond_base_;  ///< with atria and vessels
};

}  // namespace

void part_structures(std::vector<SurfaceCycle>& surfaces, const std::vector<FieldCycle>& given,
                     const std::vector<Structure>& held) {
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
    Phase phase(std::move(bodies), held);
    phase.part();
    for (const Body& body : phase.bodies()) {
      for (std::size_t v = 0; v < body.points.size(); ++v) {
        body.surface->positions[p][v] = body.points[v].cast<float>();
      }
    }
  });
}

}  // namespace beatlas::mesh
