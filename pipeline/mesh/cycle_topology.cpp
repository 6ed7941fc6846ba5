#include "pipeline/mesh/cycle_topology.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "pipeline/core/parallel.h"
#include "pipeline/mesh/simple_points.h"

namespace beatlas::mesh {
namespace {

/// Each costs a way around the cycle, so that all would cost the square of its phases.
constexpr std::size_t kMostTried = 32;

/// A phase's samples and what its body would be, handles and all.
struct Wanted {
  const std::vector<float>* samples = nullptr;
  Mask body;
};

/// Sum of |samples| where two bodies differ.
double difference(const Mask& one, const Mask& other, const std::vector<float>& samples) {
  double sum = 0;
  for (std::size_t n = 0; n < one.size(); ++n) {
    if (one[n] != other[n]) sum += std::abs(static_cast<double>(samples[n]));
  }
  return sum;
}

/// Makes a body another phase's as far as that does not change its topology.
void deform(const Lattice& lattice, const Wanted& to, Mask& body) {
  std::priority_queue<Waiting<float>> queue;  // the surest first
  Mask waits(body.size());
  std::uint64_t turn = 0;
  const auto push = [&](std::size_t index) {
    if (body[index] == to.body[index] || waits[index] != 0) return;
    waits[index] = 1;
    queue.push({-std::abs((*to.samples)[index]), turn++, index});
  };
  for (std::size_t n = 0; n < body.size(); ++n) push(n);
  while (!queue.empty()) {
    const std::size_t index = queue.top().index;
    queue.pop();
    waits[index] = 0;
    if (!lattice.is_simple(body, index, false)) continue;
    body[index] ^= 1U;
    lattice.around(index, [&](std::size_t, std::size_t n) { push(n); });
  }
}

/// Bodies of all phases [phase] that come from a ball of phase `start`.
std::vector<Mask> bodies_from(const Lattice& lattice, const std::vector<Wanted>& wanted,
                              std::size_t start, const Mask& ball) {
  const std::size_t phases = wanted.size();
  std::vector<Mask> out(phases);
  out[start] = ball;
  const auto go = [&](std::size_t from, std::size_t to) {
    out[to] = out[from];
    deform(lattice, wanted[to], out[to]);
  };
  for (std::size_t n = 1; n <= phases / 2; ++n) {
    go((start + n - 1) % phases, (start + n) % phases);
  }
  for (std::size_t n = 1; n <= (phases - 1) / 2; ++n) {
    go((start + phases + 1 - n) % phases, (start + phases - n) % phases);
  }
  return out;
}

/// What is changed, and where both ways from `start` meet and disagree, that once a phase.
double cost_of(const Lattice& lattice, const std::vector<Wanted>& wanted, std::size_t start,
               const std::vector<Mask>& bodies) {
  const std::size_t phases = wanted.size();
  double out = 0;
  for (std::size_t p = 0; p < phases; ++p) {
    out += difference(bodies[p], wanted[p].body, *wanted[p].samples);
  }
  const auto disagreement = [&](std::size_t from, std::size_t to) {
    Mask body = bodies[from];
    deform(lattice, wanted[to], body);
    return difference(body, bodies[to], *wanted[to].samples);
  };
  const std::size_t last = (start + phases / 2) % phases;
  const std::size_t next = (last + 1) % phases;
  return out +
         static_cast<double>(phases) / 2 * (disagreement(last, next) + disagreement(next, last));
}

}  // namespace

std::vector<Repair> make_balls(const Grid& grid, std::vector<std::vector<float>>& phases,
                               const StageContext& context) {
  const Lattice lattice(grid);
  const std::size_t count = phases.size();
  std::vector<Repair> out(count);
  std::vector<Wanted> wanted(count);
  parallel_for(count, context.part(0, 0.4), "handles of phase", [&](std::size_t p) {
    out[p].before = topology_of(grid, phases[p]);
    wanted[p].samples = &phases[p];
    wanted[p].body = inside_of(phases[p]);
    if (!out[p].before.is_ball()) make_one_body(grid, phases[p], wanted[p].body);
  });
  if (std::all_of(out.begin(), out.end(), [](const Repair& r) { return r.before.is_ball(); })) {
    return out;
  }
  int fewest = std::numeric_limits<int>::max();
  for (const Repair& repair : out) fewest = std::min(fewest, repair.before.handles);
  std::vector<Mask> balls(count);
  std::vector<double> cost(count, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> candidates;
  for (std::size_t p = 0; p < count; ++p) {
    if (out[p].before.handles == fewest) candidates.push_back(p);
  }
  const std::size_t tried = std::min(candidates.size(), kMostTried);
  parallel_for(tried, context.part(0.4, 1), "from phase", [&](std::size_t n) {
    const std::size_t p = candidates[n * candidates.size() / tried];
    balls[p] = wanted[p].body;
    if (fewest > 0) {
      std::vector<float> samples = phases[p];
      out[p].left_handles = make_ball(grid, samples).left_handles;
      balls[p] = inside_of(samples);
    }
    cost[p] = cost_of(lattice, wanted, p, bodies_from(lattice, wanted, p, balls[p]));
  });
  const auto start =
      static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  const std::vector<Mask> bodies = bodies_from(lattice, wanted, start, balls[start]);
  const int left_handles = out[start].left_handles;
  parallel_for(count, [&](std::size_t p) {
    out[p].left_handles = left_handles;
    out[p].changed = change_sides(grid, bodies[p], phases[p]);
  });
  return out;
}

}  // namespace beatlas::mesh
