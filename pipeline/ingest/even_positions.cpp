#include "pipeline/ingest/even_positions.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>

#include "pipeline/core/statistics.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

/// Positions in even steps.
struct Run {
  std::vector<int> members;  ///< indices into the positions
  std::vector<int> numbers;  ///< [member] steps from the first

  [[nodiscard]] int slices() const { return numbers.empty() ? 0 : numbers.back() + 1; }
  [[nodiscard]] int holes() const { return slices() - static_cast<int>(members.size()); }
  [[nodiscard]] int worth() const { return static_cast<int>(members.size()) - holes(); }
};

/// The position nearest to `aim`, of those from `next` on; -1 if none lies within kMostUneven
/// steps.
int position_at(const std::vector<double>& positions, int next, double aim, double step) {
  const auto off = [&](int i) { return std::abs(positions[static_cast<std::size_t>(i)] - aim); };
  int best = -1;
  for (int i = next; i < static_cast<int>(positions.size()) &&
                     positions[static_cast<std::size_t>(i)] <= aim + step;
       ++i) {
    if (best < 0 || off(i) < off(best)) best = i;
  }
  return best < 0 || off(best) > kMostUneven * step ? -1 : best;
}

/// How many steps may lie between two members of a run.
int most_apart(Spacing spacing) { return spacing == Spacing::WithHoles ? 2 : 1; }

/// The run that starts with positions a and b, `apart` steps from each other, and goes on so.
Run run_from(const std::vector<double>& positions, int a, int b, int apart, Spacing spacing) {
  Run out{{a, b}, {0, apart}};
  const auto at = [&](int index) { return positions[static_cast<std::size_t>(index)]; };
  const double step = (at(b) - at(a)) / apart;
  for (bool found = true; found;) {
    found = false;
    const int last = out.members.back();
    for (int steps = 1; steps <= most_apart(spacing) && !found; ++steps) {
      const int next = position_at(positions, last + 1, at(last) + steps * step, step);
      if (next < 0) continue;
      out.members.push_back(next);
      out.numbers.push_back(out.numbers.back() + steps);
      found = true;
    }
  }
  return out;
}

/// The one with most members, less its holes, the narrower of two as good.
Run longest_run(const std::vector<double>& positions_mm, Spacing spacing) {
  const int count = static_cast<int>(positions_mm.size());
  Run best;
  double best_step = 0;
  const auto is_better = [&](const Run& run, double step) {
    if (best.members.empty() || run.worth() != best.worth()) {
      return best.members.empty() || run.worth() > best.worth();
    }
    const bool narrower = step < best_step;
    return run.members.size() == best.members.size() ? narrower
                                                     : run.members.size() > best.members.size();
  };
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      for (int apart = 1; apart <= most_apart(spacing); ++apart) {
        Run run = run_from(positions_mm, a, b, apart, spacing);
        const double step = (positions_mm[static_cast<std::size_t>(b)] -
                             positions_mm[static_cast<std::size_t>(a)]) /
                            apart;
        if (!is_better(run, step)) continue;
        best = std::move(run);
        best_step = step;
      }
    }
  }
  return best;
}

/// All positions, with a hole where a gap is nearer to two median ones than to one.
/// @return empty where one is neither, or there are fewer than 2 positions
Run all_of(const std::vector<double>& positions_mm) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < positions_mm.size(); ++i) {
    gaps.push_back(positions_mm[i] - positions_mm[i - 1]);
  }
  if (gaps.empty()) return {};
  const double middle = median(gaps);
  Run out{{0}, {0}};
  for (const double gap : gaps) {
    const auto steps = std::max(1, static_cast<int>(std::lround(gap / middle)));
    if (steps > 2 || std::abs(gap / middle - steps) > kLooseGap) return {};
    out.members.push_back(out.members.back() + 1);
    out.numbers.push_back(out.numbers.back() + steps);
  }
  return out;
}

std::string listed(const std::vector<double>& positions) {
  std::string out;
  for (std::size_t i = 1; i < positions.size(); ++i) {
    char text[32];
    std::snprintf(text, sizeof(text), "%s%.2f", i > 1 ? ", " : "", positions[i] - positions[i - 1]);
    out += text;
  }
  return out;
}

}  // namespace

EvenStack find_even_stack(const std::vector<double>& positions_mm, Spacing spacing) {
  const auto count = static_cast<double>(positions_mm.size());
  const bool loose = spacing == Spacing::Loose;
  const Run best = loose ? all_of(positions_mm) : longest_run(positions_mm, spacing);
  const std::size_t members = best.members.size();
  const auto refuse = [&] {
    throw_invalid("the slices of the stack are unevenly spaced, with gaps of " +
                  listed(positions_mm) + " mm: a slice is missing or its series is incomplete");
  };
  if (members < 3 || static_cast<double>(members) <= kLeastKept * count ||
      kSlicesPerHole * best.holes() > best.slices()) {
    refuse();
  }

  for (std::size_t m = 1; m < members; ++m) {
    const double gap_mm = positions_mm[static_cast<std::size_t>(best.members[m])] -
                          positions_mm[static_cast<std::size_t>(best.members[m - 1])];
    if (best.numbers[m] - best.numbers[m - 1] > 1 && gap_mm > kWidestHoleMm) refuse();
  }

  EvenStack out;
  out.members = best.members;
  out.numbers = best.numbers;
  std::vector<double> gaps;
  const auto at = [&](std::size_t member) {
    return positions_mm[static_cast<std::size_t>(best.members[member])];
  };
  for (std::size_t m = 1; m < members; ++m) {
    gaps.push_back((at(m) - at(m - 1)) / (best.numbers[m] - best.numbers[m - 1]));
  }
  const double middle = median(gaps);
  for (const double gap : gaps) {
    out.worst_gap = std::max(out.worst_gap, std::abs(gap - middle) / middle);
  }
  if (out.worst_gap <= kNotedUneven) {
    out.spacing_mm = (at(members - 1) - at(0)) / best.numbers.back();
    out.first_mm = at(0);
    return out;
  }
  // The even stack lies so that its slices are off by nothing on average.
  const auto n = static_cast<double>(members);
  double mean_number = 0;
  double mean_mm = 0;
  for (std::size_t m = 0; m < members; ++m) {
    mean_number += best.numbers[m] / n;
    mean_mm += at(m) / n;
  }
  double square = 0;
  double product = 0;
  for (std::size_t m = 0; m < members; ++m) {
    const double number = best.numbers[m] - mean_number;
    square += number * number;
    product += number * (at(m) - mean_mm);
  }
  out.spacing_mm = loose ? product / square : middle;
  out.first_mm = mean_mm - out.spacing_mm * mean_number;
  for (std::size_t m = 0; m < members; ++m) {
    const double even_mm = out.first_mm + out.spacing_mm * best.numbers[m];
    out.worst_off_mm = std::max(out.worst_off_mm, std::abs(at(m) - even_mm));
  }
  if (loose && out.worst_off_mm > kMostOff * out.spacing_mm) refuse();
  return out;
}

std::vector<std::vector<int>> even_parts(const std::vector<double>& positions_mm) {
  std::vector<std::vector<int>> out;
  std::vector<int> left(positions_mm.size());
  std::iota(left.begin(), left.end(), 0);
  const auto at = [&](int i) { return positions_mm[static_cast<std::size_t>(i)]; };
  const auto step = [&](const std::vector<int>& part) {
    return (at(part.back()) - at(part.front())) / static_cast<double>(part.size() - 1);
  };
  while (!left.empty()) {
    std::vector<double> positions;
    positions.reserve(left.size());
    for (const int i : left) positions.push_back(at(i));
    std::vector<int> part;
    for (const int i : longest_run(positions, Spacing::Even).members) {
      part.push_back(left[static_cast<std::size_t>(i)]);
    }
    if (part.size() < 3) return {};
    std::erase_if(left, [&](int i) { return std::count(part.begin(), part.end(), i) > 0; });
    if (!out.empty()) {
      const std::vector<int>& main = out.front();
      const double spacing = step(main);
      const double over =
          std::min(at(main.back()), at(part.back())) - std::max(at(main.front()), at(part.front()));
      const double offset = (at(part.front()) - at(main.front())) / spacing;
      const bool between = std::abs(offset - std::round(offset)) > kMostUneven;
      if (std::abs(step(part) - spacing) > kMostUneven * spacing || !between ||
          2 * over < at(part.back()) - at(part.front())) {
        return {};
      }
    }
    out.push_back(std::move(part));
  }
  return out.size() > 1 ? out : std::vector<std::vector<int>>();
}

}  // namespace beatlas::ingest
