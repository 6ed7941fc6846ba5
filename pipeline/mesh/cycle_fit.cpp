#include "pipeline/mesh/cycle_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>

#include "pipeline/core/parallel.h"

namespace beatlas::mesh {
namespace {

constexpr double kMaxStepMm = 1.0;    // of a projection
constexpr double kThinDeg = 20;       // triangles below it are evened out on the surface
constexpr double kTooThinDeg = 11;    // and off it
constexpr double kLeastDeg = 10;      // of any, when a package has rounded its vertices, too
constexpr double kRoundingMm = 0.01;  // of a vertex in a package
constexpr double kRad = std::numbers::pi / 180.0;

/// Cosine of a triangle's smallest angle: that opposite its shortest side. 1 if degenerate.
double least_angle_cosine(const Vec3& a, const Vec3& b, const Vec3& c) {
  std::array<double, 3> side{(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()};
  std::swap(side[0], *std::min_element(side.begin(), side.end()));
  return side[0] > 0 ? (side[1] + side[2] - side[0]) / (2 * std::sqrt(side[1] * side[2])) : 1.0;
}

Vec3 doubled_area(const std::vector<Vec3>& points, const Triangle& t) {
  return (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
}

/// 1 for an even triangle, 0 for a thin one, below 0 for one that is turned over.
double goodness(const std::vector<Vec3>& points, const Triangle& t, const Vec3& outward) {
  const double share = 1.0 - least_angle_cosine(points[t[0]], points[t[1]], points[t[2]]);
  return doubled_area(points, t).dot(outward) > 0 ? share : share - 1.0;
}

/// The corner of a triangle that is neither a nor b.
std::uint32_t third_corner(const Triangle& t, std::uint32_t a, std::uint32_t b) {
  return t[0] != a && t[0] != b ? t[0] : (t[1] != a && t[1] != b ? t[1] : t[2]);
}

/// Two triangles on either side of an edge.
using TwoTriangles = std::array<Triangle, 2>;

/// Whether a flip makes the worst triangle of all phases better and moves the surface far in none.
/// @param made {a, d, c} and {d, b, c} where an edge from a to b is to run from c to d
/// @param most_off_mm between the two edges
bool is_flip_better(const Cycle& cycle, const TwoTriangles& old, const TwoTriangles& made,
                    double most_off_mm) {
  constexpr double kBetter = 0.002;  // of goodness
  const std::uint32_t a = made[0][0];
  const std::uint32_t b = made[1][1];
  const std::uint32_t c = made[0][2];
  const std::uint32_t d = made[0][1];
  double before = 1;
  double after = 1;
  for (const std::vector<Vec3>& points : cycle) {
    const Vec3 outward =
        doubled_area(points, old[0]).normalized() + doubled_area(points, old[1]).normalized();
    before =
        std::min({before, goodness(points, old[0], outward), goodness(points, old[1], outward)});
    after =
        std::min({after, goodness(points, made[0], outward), goodness(points, made[1], outward)});
    const Vec3 apart = 0.5 * (points[a] + points[b] - points[c] - points[d]);
    const double area = outward.norm() > 0 ? std::abs(apart.dot(outward.normalized())) : 1e9;
    if (area > most_off_mm) after = -1;
  }
  return !(after < before + kBetter);
}

/// Marks triangles that are bad in any phase. @return how many are, in all phases
std::size_t gather_bad(const std::vector<std::vector<bool>>& bad_at, std::vector<bool>& bad) {
  std::size_t count = 0;
  for (const std::vector<bool>& at : bad_at) {
    for (std::size_t n = 0; n < bad.size(); ++n) {
      if (!at[n]) continue;
      bad[n] = true;
      ++count;
    }
  }
  return count;
}

}  // namespace

double kept_of_harmonic(int k, int phases) {
  const double ratio = k / (0.42 * phases);
  return 1.0 / (1.0 + std::pow(ratio, 8));
}

CycleFit::CycleFit(std::vector<Triangle> triangles, std::vector<field::Interpolant> phases,
                   double edge_mm)
    : triangles_(std::move(triangles)), phases_(std::move(phases)), edge_mm_(edge_mm) {
  find_neighbours();
}

void CycleFit::find_neighbours() {
  std::size_t count = 0;
  for (const Triangle& t : triangles_) {
    for (const std::uint32_t v : t) count = std::max<std::size_t>(count, v + std::size_t{1});
  }
  ring_.assign(count, {});
  // Each edge runs once either way in a closed mesh.
  for (const Triangle& t : triangles_) {
    for (std::size_t n = 0; n < 3; ++n) ring_[t[n]].push_back(t[(n + 1) % 3]);
  }
  for (auto& ring : ring_) std::sort(ring.begin(), ring.end());
}

Vec3 CycleFit::middle_of_ring(const std::vector<Vec3>& points, std::size_t v) const {
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t n : ring_[v]) sum += points[n];
  return sum / static_cast<double>(ring_[v].size());
}

std::vector<double> CycleFit::area_around(const std::vector<Vec3>& points) const {
  std::vector<double> area(points.size(), 0);
  for (const Triangle& t : triangles_) {
    const double own = doubled_area(points, t).norm();
    for (const std::uint32_t v : t) area[v] += own;
  }
  return area;
}

Vec3 CycleFit::drawn_middle(const std::vector<Vec3>& points, const std::vector<double>& area,
                            std::size_t v) const {
  Vec3 sum = Vec3::Zero();
  double drawn = 0;
  for (const std::uint32_t n : ring_[v]) {
    sum += area[n] * points[n];
    drawn += area[n];
  }
  return drawn > 0 ? Vec3(sum / drawn) : points[v];
}

Vec3 CycleFit::on_surface(const Vec3& mm, const Vec3& outward, std::size_t phase) const {
  const field::Interpolant& surface = phases_[phase];
  const Vec3 there = surface.project_to_zero(mm, kMaxStepMm);
  // Not to the far side of a thin wall, nor off along a crease.
  const bool near = (there - mm).squaredNorm() <= edge_mm_ * edge_mm_;
  return near && surface.sample(there).gradient.dot(outward) > 0 ? there : mm;
}

void CycleFit::put_on_surface(std::vector<Vec3>& points, std::size_t phase) const {
  const std::vector<Vec3> normals = vertex_normals(points, triangles_);
  for (std::size_t v = 0; v < points.size(); ++v) {
    points[v] = on_surface(points[v], normals[v], phase);
  }
}

void CycleFit::even_out(std::vector<Vec3>& points, const std::vector<bool>& loose,
                        const std::vector<Vec3>& normals, std::size_t phase) const {
  std::vector<Vec3> moved = points;
  for (std::size_t v = 0; v < moved.size(); ++v) {
    if (!loose[v]) continue;
    moved[v] = on_surface(0.5 * (points[v] + middle_of_ring(points, v)), normals[v], phase);
  }
  points = std::move(moved);
}

void CycleFit::calm(Cycle& cycle) const {
  constexpr std::size_t kFewestPhases = 8;
  constexpr int kRounds = 2;
  const std::size_t phases = cycle.size();
  if (phases < kFewestPhases) return;
  // The filter as weights of the phases around.
  std::vector<double> weight(phases);
  for (std::size_t d = 0; d < phases; ++d) {
    for (std::size_t k = 0; k < phases; ++k) {
      const auto harmonic = static_cast<int>(std::min(k, phases - k));
      weight[d] += kept_of_harmonic(harmonic, static_cast<int>(phases)) *
                   std::cos(2 * std::numbers::pi * static_cast<double>(k * d % phases) /
                            static_cast<double>(phases)) /
                   static_cast<double>(phases);
    }
  }
  for (int round = 0; round < kRounds; ++round) {
    Cycle out(phases);
    parallel_for(phases, [&](std::size_t p) {
      const std::vector<Vec3> normals = vertex_normals(cycle[p], triangles_);
      out[p].resize(cycle[p].size());
      for (std::size_t v = 0; v < out[p].size(); ++v) {
        Vec3 way = -cycle[p][v];
        for (std::size_t q = 0; q < phases; ++q) {
          way += weight[(p + phases - q) % phases] * cycle[q][v];
        }
        way -= normals[v].dot(way) * normals[v];
        out[p][v] = on_surface(cycle[p][v] + way, normals[v], p);
      }
    });
    cycle = std::move(out);
  }
}

std::vector<bool> CycleFit::too_thin_triangles(const std::vector<Vec3>& points) const {
  std::vector<bool> bad = flipped_triangles(points, triangles_);
  for (std::size_t n = 0; n < triangles_.size(); ++n) {
    const Vec3& a = points[triangles_[n][0]];
    const Vec3& b = points[triangles_[n][1]];
    const Vec3& c = points[triangles_[n][2]];
    // The long sides of a thin triangle are alike; both their ends may go across.
    const double longest =
        std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    const double turned = 2 * kRoundingMm / std::max(longest, kRoundingMm);
    const double thin = std::max(kTooThinDeg * kRad, kLeastDeg * kRad + turned);
    if (least_angle_cosine(a, b, c) > std::cos(thin)) bad[n] = true;
  }
  return bad;
}

CycleFit::Patch CycleFit::patch_around(const std::vector<bool>& moved) const {
  // A triangle is turned over by the normals at its corners, and those hang on all around them.
  std::vector<bool> turned = moved;
  grow(turned, 1);
  std::vector<bool> seen = turned;
  grow(seen, 1);
  Patch out;
  for (std::uint32_t v = 0; v < seen.size(); ++v) {
    if (seen[v]) out.vertices.push_back(v);
  }
  for (std::uint32_t n = 0; n < triangles_.size(); ++n) {
    const auto has = [&](const std::vector<bool>& vertices) {
      return std::any_of(triangles_[n].begin(), triangles_[n].end(),
                         [&](std::uint32_t v) { return vertices[v]; });
    };
    if (!has(seen)) continue;
    out.around.push_back(n);
    if (has(turned)) out.triangles.push_back(n);
  }
  return out;
}

std::vector<Vec3> CycleFit::normals_in(const Patch& patch, const std::vector<Vec3>& points) const {
  std::vector<Vec3> out(points.size(), Vec3::Zero());
  for (const std::uint32_t n : patch.around) {
    const Vec3 normal = doubled_area(points, triangles_[n]);
    for (const std::uint32_t v : triangles_[n]) out[v] += normal;
  }
  for (const std::uint32_t v : patch.vertices) out[v].normalize();
  return out;
}

void CycleFit::look_for_bad(const std::vector<Vec3>& points, const Patch& patch,
                            std::vector<bool>& bad) const {
  const double thin = std::cos(kThinDeg * kRad);
  const std::vector<Vec3> normals = normals_in(patch, points);
  for (const std::uint32_t n : patch.triangles) {
    const Triangle& t = triangles_[n];
    const Vec3 mean = normals[t[0]] + normals[t[1]] + normals[t[2]];
    bad[n] = doubled_area(points, t).dot(mean) <= 0 ||
             least_angle_cosine(points[t[0]], points[t[1]], points[t[2]]) > thin;
  }
}

std::vector<bool> CycleFit::loosened(const std::vector<bool>& bad, int rings) const {
  std::vector<bool> loose(ring_.size(), false);
  for (std::size_t n = 0; n < triangles_.size(); ++n) {
    if (!bad[n]) continue;
    for (const std::uint32_t v : triangles_[n]) loose[v] = true;
  }
  grow(loose, rings);
  return loose;
}

void CycleFit::grow(std::vector<bool>& vertices, int rings) const {
  for (int ring = 0; ring < rings; ++ring) {
    const std::vector<bool> inner = vertices;
    for (std::size_t v = 0; v < ring_.size(); ++v) {
      if (!inner[v]) continue;
      for (const std::uint32_t n : ring_[v]) vertices[n] = true;
    }
  }
}

int CycleFit::flip_edges(const Cycle& cycle, const std::vector<bool>& bad) {
  constexpr std::size_t kFewest = 4;     // neighbours of a vertex that loses one
  constexpr double kMostOffEdges = 0.2;  // between the two diagonals, in edges
  // Directed edges with their triangles, ascending. Those of flipped triangles stay as they were:
  // whoever comes upon one passes by, for it was changed.
  std::vector<std::pair<std::uint64_t, std::uint32_t>> sides;
  const auto edge = [](std::uint32_t from, std::uint32_t to) {
    return (std::uint64_t{from} << 32U) | to;
  };
  for (std::uint32_t n = 0; n < triangles_.size(); ++n) {
    const Triangle& t = triangles_[n];
    for (std::size_t e = 0; e < 3; ++e) sides.emplace_back(edge(t[e], t[(e + 1) % 3]), n);
  }
  std::sort(sides.begin(), sides.end());
  std::vector<bool> changed(triangles_.size(), false);
  int flips = 0;
  for (std::size_t n = 0; n < triangles_.size(); ++n) {
    if (!bad[n]) continue;
    for (std::size_t e = 0; e < 3 && !changed[n]; ++e) {
      const std::uint32_t a = triangles_[n][e];
      const std::uint32_t b = triangles_[n][(e + 1) % 3];
      const std::uint32_t c = triangles_[n][(e + 2) % 3];
      const std::size_t other =
          std::lower_bound(sides.begin(), sides.end(), std::pair{edge(b, a), std::uint32_t{0}})
              ->second;
      if (changed[other]) continue;
      const std::uint32_t d = third_corner(triangles_[other], a, b);
      if (c == d || ring_[a].size() <= kFewest || ring_[b].size() <= kFewest ||
          std::binary_search(ring_[c].begin(), ring_[c].end(), d)) {
        continue;
      }
      const TwoTriangles old{triangles_[n], triangles_[other]};
      const TwoTriangles made{Triangle{a, d, c}, Triangle{d, b, c}};
      if (!is_flip_better(cycle, old, made, kMostOffEdges * edge_mm_)) continue;
      triangles_[n] = made[0];
      triangles_[other] = made[1];
      changed[n] = changed[other] = true;
      flip_in_rings(a, b, c, d);
      ++flips;
    }
  }
  return flips;
}

void CycleFit::flip_in_rings(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  const auto drop = [&](std::uint32_t v, std::uint32_t from) {
    auto& ring = ring_[from];
    ring.erase(std::lower_bound(ring.begin(), ring.end(), v));
  };
  const auto join = [&](std::uint32_t v, std::uint32_t to) {
    auto& ring = ring_[to];
    ring.insert(std::lower_bound(ring.begin(), ring.end(), v), v);
  };
  drop(a, b);
  drop(b, a);
  join(c, d);
  join(d, c);
}

void CycleFit::leave_slits(Cycle& cycle) const {
  parallel_for(cycle.size(), [&](std::size_t p) {
    put_on_surface(cycle[p], p);
    leave_slits(cycle[p], p);
  });
}

void CycleFit::leave_slits(std::vector<Vec3>& points, std::size_t phase) const {
  constexpr double kOffEdges = 0.5;   // from the surface: left behind
  constexpr double kMostShare = 0.1;  // of the mesh; more is no slit
  constexpr int kRings = 5;
  constexpr int kTimes = 40;
  constexpr int kPatience = 4;  // times without getting better
  constexpr int kSweeps = 10;
  std::size_t fewest = points.size();
  int best = 0;
  for (int time = 0; time < kTimes && time <= best + kPatience; ++time) {
    std::vector<bool> off(points.size());
    for (std::size_t v = 0; v < points.size(); ++v) {
      off[v] = std::abs(phases_[phase].value(points[v])) > kOffEdges * edge_mm_;
    }
    const auto count = static_cast<std::size_t>(std::count(off.begin(), off.end(), true));
    if (count == 0 ||
        static_cast<double>(count) > kMostShare * static_cast<double>(points.size())) {
      return;
    }
    if (count < fewest) {
      fewest = count;
      best = time;
    }
    std::vector<bool> loose = off;
    grow(loose, kRings);
    // Large triangles draw: else those of a deep slit would shrink to a point.
    const std::vector<double> area = area_around(points);
    const std::vector<Vec3> normals = vertex_normals(points, triangles_);
    for (int sweep = 1; sweep <= kSweeps; ++sweep) {
      for (std::size_t v = 0; v < points.size(); ++v) {
        if (!loose[v]) continue;
        points[v] = drawn_middle(points, area, v);
        if (!off[v] || sweep == kSweeps) points[v] = on_surface(points[v], normals[v], phase);
      }
    }
  }
}

void CycleFit::settle(Cycle& cycle) {
  constexpr int kRounds = 40;
  constexpr int kFlipEvery = 4;
  constexpr int kPatience = 8;  // rounds without getting better
  int best_round = 0;
  const std::size_t phases = cycle.size();
  parallel_for(phases, [&](std::size_t p) { put_on_surface(cycle[p], p); });
  Cycle best = cycle;
  std::vector<Triangle> best_triangles = triangles_;
  std::size_t fewest = phases * triangles_.size() + 1;
  std::vector<std::vector<bool>> bad_at(phases, std::vector<bool>(triangles_.size()));
  Patch patch = patch_around(std::vector<bool>(ring_.size(), true));
  for (int round = 0; round <= kRounds; ++round) {
    parallel_for(phases, [&](std::size_t p) { look_for_bad(cycle[p], patch, bad_at[p]); });
    std::vector<bool> bad(triangles_.size(), false);
    const std::size_t count = gather_bad(bad_at, bad);
    if (count < fewest) {
      fewest = count;
      best = cycle;
      best_triangles = triangles_;
      best_round = round;
    }
    if (count == 0 || round == kRounds || round > best_round + kPatience) break;
    std::vector<bool> changed(ring_.size(), false);
    if (round % kFlipEvery == kFlipEvery - 1) {
      const std::vector<Triangle> before = triangles_;
      (void)flip_edges(cycle, bad);
      for (std::size_t n = 0; n < before.size(); ++n) {
        if (before[n] == triangles_[n]) continue;
        for (const std::uint32_t v : triangles_[n]) changed[v] = true;
      }
    }
    const std::vector<bool> loose = loosened(bad, 1);
    for (std::size_t v = 0; v < loose.size(); ++v) changed[v] = changed[v] || loose[v];
    patch = patch_around(changed);
    parallel_for(phases,
                 [&](std::size_t p) { even_out(cycle[p], loose, normals_in(patch, cycle[p]), p); });
  }
  cycle = std::move(best);
  triangles_ = std::move(best_triangles);
  find_neighbours();
}

double CycleFit::flawed_share(const Cycle& cycle) const {
  constexpr double kLostMm = 1;
  const Patch all = patch_around(std::vector<bool>(ring_.size(), true));
  std::vector<double> count(cycle.size());
  parallel_for(cycle.size(), [&](std::size_t p) {
    std::vector<bool> bad(triangles_.size());
    look_for_bad(cycle[p], all, bad);
    count[p] = static_cast<double>(std::count(bad.begin(), bad.end(), true));
    for (const Triangle& t : triangles_) {
      const Vec3 middle = (cycle[p][t[0]] + cycle[p][t[1]] + cycle[p][t[2]]) / 3;
      if (std::abs(phases_[p].value(middle)) > kLostMm) count[p] += kLostWeighs;
    }
  });
  return std::accumulate(count.begin(), count.end(), 0.0) /
         static_cast<double>(cycle.size() * triangles_.size());
}

}  // namespace beatlas::mesh
