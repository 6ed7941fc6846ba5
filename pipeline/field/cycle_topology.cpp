#include "pipeline/field/cycle_topology.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>

#include "pipeline/core/parallel.h"
#include "pipeline/field/simple_points.h"

namespace beatlas::field {
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

/// Gives triangles room along threads that no phase's samples have: a neck that another phase left
/// there, or a way to a piece apart that ends beside one.
void thicken(const Lattice& lattice, const std::vector<float>& samples, Mask& body) {
  constexpr int kSweeps = 2;  // what is not simple at first may be when others are in
  std::vector<std::size_t> threads;
  for (std::size_t n = 0; n < body.size(); ++n) {
    if (!(samples[n] < 0) && lattice.is_thread(body, n)) threads.push_back(n);
  }
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (const std::size_t thread : threads) {
      lattice.around(thread, [&](std::size_t, std::size_t n) {
        const bool may = body[n] == 0 && !lattice.on_border(lattice.at(n));
        if (may && lattice.is_simple(body, n, false)) body[n] = 1;
      });
    }
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

/// A body through space and time: pieces of neighbouring phases are one where the smaller lies in
/// the other by more than half.
class PiecesOfCycle {
 public:
  PiecesOfCycle(const Lattice& lattice, const std::vector<Wanted>& wanted)
      : pieces_(wanted.size()), first_(wanted.size() + 1) {
    const std::size_t phases = wanted.size();
    parallel_for(phases,
                 [&](std::size_t p) { pieces_[p] = pieces_of(lattice, wanted[p].body, 1); });
    for (std::size_t p = 0; p < phases; ++p) first_[p + 1] = first_[p] + pieces_[p].size();
    root_.resize(first_.back());
    std::iota(root_.begin(), root_.end(), std::size_t{0});
    for (std::size_t p = 0; p < phases; ++p) unite(p, (p + 1) % phases, wanted[p].body.size());
    for (std::size_t p = 1; p < phases; ++p) join(largest(p), largest(0));
  }

  /// [piece] 1 if it is linked, from phase to phase, to the largest piece of any phase.
  [[nodiscard]] std::vector<std::uint8_t> belongs(std::size_t phase) {
    std::vector<std::uint8_t> out;
    for (std::size_t n = first_[phase]; n < first_[phase + 1]; ++n) {
      out.push_back(root(n) == root(largest(phase)) ? 1 : 0);
    }
    return out;
  }

 private:
  [[nodiscard]] std::size_t largest(std::size_t phase) const {
    const auto at = std::max_element(
        pieces_[phase].begin(), pieces_[phase].end(),
        [](const Piece& a, const Piece& b) { return a.samples.size() < b.samples.size(); });
    return first_[phase] + static_cast<std::size_t>(at - pieces_[phase].begin());
  }

  std::size_t root(std::size_t n) {
    while (root_[n] != n) n = root_[n] = root_[root_[n]];
    return n;
  }
  void join(std::size_t a, std::size_t b) {
    root_[std::max(root(a), root(b))] = std::min(root(a), root(b));
  }

  void unite(std::size_t from, std::size_t to, std::size_t samples) {
    if (pieces_[from].size() == 1 && pieces_[to].size() == 1) return;
    std::vector<std::uint32_t> piece_at(samples, 0);  // 0: none
    for (std::uint32_t n = 0; n < pieces_[to].size(); ++n) {
      for (const std::size_t s : pieces_[to][n].samples) piece_at[s] = n + 1;
    }
    for (std::size_t n = 0; n < pieces_[from].size(); ++n) {
      std::vector<std::size_t> shared(pieces_[to].size() + 1);
      for (const std::size_t s : pieces_[from][n].samples) ++shared[piece_at[s]];
      for (std::size_t m = 0; m < pieces_[to].size(); ++m) {
        const std::size_t smaller =
            std::min(pieces_[from][n].samples.size(), pieces_[to][m].samples.size());
        if (2 * shared[m + 1] > smaller) join(first_[from] + n, first_[to] + m);
      }
    }
  }

  std::vector<std::vector<Piece>> pieces_;  ///< [phase]
  std::vector<std::size_t> first_;          ///< [phase] of all phases' pieces
  std::vector<std::size_t> root_;
};

/// Makes every phase's body one piece.
void make_bodies(const Grid& grid, std::vector<Wanted>& wanted) {
  PiecesOfCycle pieces(Lattice(grid), wanted);
  std::vector<float> least = *wanted.front().samples;
  for (const Wanted& phase : wanted) {
    for (std::size_t n = 0; n < least.size(); ++n)
      least[n] = std::min(least[n], (*phase.samples)[n]);
  }
  std::vector<PiecesInCycle> cycle(wanted.size());
  for (std::size_t p = 0; p < wanted.size(); ++p) cycle[p] = {pieces.belongs(p), &least};
  parallel_for(wanted.size(), [&](std::size_t p) {
    make_one_body(grid, *wanted[p].samples, wanted[p].body, cycle[p]);
  });
}

}  // namespace

std::vector<Repair> make_balls(const Grid& grid, std::vector<std::vector<float>>& phases,
                               const StageContext& context) {
  const Lattice lattice(grid);
  const std::size_t count = phases.size();
  std::vector<Repair> out(count);
  std::vector<Wanted> wanted(count);
  parallel_for(count, context.part(0, 0.3), "handles of phase", [&](std::size_t p) {
    out[p].before = topology_of(grid, phases[p]);
    wanted[p].samples = &phases[p];
    wanted[p].body = inside_of(phases[p]);
  });
  if (std::all_of(out.begin(), out.end(), [](const Repair& r) { return r.before.is_ball(); })) {
    return out;
  }
  make_bodies(grid, wanted);
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
    std::vector<float> samples = phases[p];
    (void)change_sides(grid, wanted[p].body, samples);
    out[p].left_handles = make_ball(grid, samples).left_handles;
    balls[p] = inside_of(samples);
    cost[p] = cost_of(lattice, wanted, p, bodies_from(lattice, wanted, p, balls[p]));
  });
  const auto start =
      static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  std::vector<Mask> bodies = bodies_from(lattice, wanted, start, balls[start]);
  const int left_handles = out[start].left_handles;
  parallel_for(count, [&](std::size_t p) {
    thicken(lattice, phases[p], bodies[p]);
    out[p].left_handles = left_handles;
    out[p].changed = change_sides(grid, bodies[p], phases[p]);
  });
  return out;
}

}  // namespace beatlas::field
