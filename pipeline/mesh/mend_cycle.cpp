// What a fit could not do on the surfaces, done off them.
#include <algorithm>

#include "pipeline/core/parallel.h"
#include "pipeline/mesh/cycle_fit.h"

namespace beatlas::mesh {

int CycleFit::mend(Cycle& cycle) {
  constexpr int kRounds = 60;
  constexpr int kFlipEvery = 4;
  constexpr int kPatience = 10;   // rounds without getting better
  constexpr int kWiderEvery = 3;  // such rounds: more rings around what is wrong
  constexpr int kFewestRings = 2;
  constexpr int kMostRings = 12;
  const std::size_t phases = cycle.size();
  std::vector<Flaws> flaws(phases);
  for (Flaws& of : flaws) of.changed.assign(triangles_.size(), true);
  Cycle best = cycle;
  std::vector<Triangle> best_triangles = triangles_;
  int best_crossings = 0;
  std::size_t fewest = 0;
  int best_round = 0;
  int rings = kFewestRings;
  for (int round = 0; round <= kRounds; ++round) {
    parallel_for(phases, [&](std::size_t p) { look_for_flaws(cycle[p], flaws[p]); });
    std::size_t count = 0;
    int crossings_now = 0;
    for (const Flaws& of : flaws) {
      count += of.count;
      crossings_now += static_cast<int>(of.crossings.size());
    }
    if (round == 0 || count < fewest) {
      fewest = count;
      best = cycle;
      best_triangles = triangles_;
      best_crossings = crossings_now;
      best_round = round;
    }
    if (count == 0 || round == kRounds || round > best_round + kPatience) break;
    if (round > best_round && (round - best_round) % kWiderEvery == 0) {
      rings = std::min(rings + 2, kMostRings);
    }
    if (round % kFlipEvery == kFlipEvery - 1) flip_thin(cycle, flaws);
    parallel_for(phases, [&](std::size_t p) {
      if (flaws[p].count > 0) smooth_flaws(cycle[p], rings, rings > kFewestRings, flaws[p]);
    });
  }
  cycle = std::move(best);
  triangles_ = std::move(best_triangles);
  find_neighbours();
  return best_crossings;
}

void CycleFit::flip_thin(const Cycle& cycle, std::vector<Flaws>& flaws) {
  std::vector<bool> any(triangles_.size(), false);
  for (const Flaws& of : flaws) {
    for (std::size_t n = 0; n < any.size(); ++n) any[n] = any[n] || of.thin[n];
  }
  const std::vector<Triangle> before = triangles_;
  (void)flip_edges(cycle, any);
  for (std::size_t n = 0; n < before.size(); ++n) {
    if (before[n] == triangles_[n]) continue;
    for (Flaws& of : flaws) of.changed[n] = true;
  }
}

void CycleFit::look_for_flaws(const std::vector<Vec3>& points, Flaws& flaws) const {
  if (std::none_of(flaws.changed.begin(), flaws.changed.end(), [](bool v) { return v; })) return;
  flaws.thin = too_thin_triangles(points);
  std::erase_if(flaws.crossings, [&](const auto& pair) {
    return flaws.changed[pair.first] || flaws.changed[pair.second];
  });
  const auto found = self_intersections(points, triangles_, flaws.changed);
  flaws.crossings.insert(flaws.crossings.end(), found.begin(), found.end());
  flaws.count = flaws.crossings.size() +
                static_cast<std::size_t>(std::count(flaws.thin.begin(), flaws.thin.end(), true));
  flaws.changed.assign(triangles_.size(), false);
}

void CycleFit::smooth_flaws(std::vector<Vec3>& points, int rings, bool stalled,
                            Flaws& flaws) const {
  constexpr int kThinRings = 2;
  std::vector<bool> crossing(triangles_.size(), false);
  for (const auto& [one, other] : flaws.crossings) crossing[one] = crossing[other] = true;
  const std::vector<bool> around_thin = loosened(flaws.thin, stalled ? kThinRings : 1);
  const std::vector<bool> around_crossing = loosened(crossing, rings);
  // As often as there are rings, so that it reaches across them.
  for (int n = 0; n < rings; ++n) {
    std::vector<Vec3> moved = points;
    const std::vector<double> area = stalled ? area_around(points) : std::vector<double>();
    for (std::size_t v = 0; v < moved.size(); ++v) {
      if (!around_crossing[v] && !(around_thin[v] && n < (stalled ? kThinRings : 1))) continue;
      // Where evening out does not help, large triangles draw those of a lump apart.
      const Vec3 middle = stalled ? drawn_middle(points, area, v) : middle_of_ring(points, v);
      moved[v] = 0.5 * (points[v] + middle);
    }
    points = std::move(moved);
  }
  for (std::size_t n = 0; n < triangles_.size(); ++n) {
    for (const std::uint32_t v : triangles_[n]) {
      if (around_thin[v] || around_crossing[v]) flaws.changed[n] = true;
    }
  }
}

}  // namespace beatlas::mesh
