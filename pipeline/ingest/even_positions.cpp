#include "pipeline/ingest/even_positions.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

/// The run that starts with positions a and b and goes on in steps of their distance.
std::vector<int> run_from(const std::vector<double>& positions, int a, int b) {
  std::vector<int> out{a, b};
  const auto at = [&](int index) { return positions[static_cast<std::size_t>(index)]; };
  const double step = at(b) - at(a);
  int next = b + 1;
  while (next < static_cast<int>(positions.size())) {
    const double aim = at(out.back()) + step;
    int best = -1;
    for (int i = next; i < static_cast<int>(positions.size()) && at(i) <= aim + step; ++i) {
      if (best < 0 || std::abs(at(i) - aim) < std::abs(at(best) - aim)) best = i;
    }
    if (best < 0 || std::abs(at(best) - aim) > kMostUneven * step) break;
    out.push_back(best);
    next = best + 1;
  }
  return out;
}

/// The longest of all, the narrower of two as long.
std::vector<int> longest_run(const std::vector<double>& positions_mm) {
  const int count = static_cast<int>(positions_mm.size());
  std::vector<int> best;
  double best_step = 0;
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      const auto run = run_from(positions_mm, a, b);
      const double step =
          positions_mm[static_cast<std::size_t>(b)] - positions_mm[static_cast<std::size_t>(a)];
      if (run.size() > best.size() || (run.size() == best.size() && step < best_step)) {
        best = run;
        best_step = step;
      }
    }
  }
  return best;
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

EvenStack find_even_stack(const std::vector<double>& positions_mm) {
  const auto count = static_cast<double>(positions_mm.size());
  const std::vector<int> best = longest_run(positions_mm);
  if (best.size() < 3 || static_cast<double>(best.size()) <= kLeastKept * count) {
    throw_invalid("the slices of the stack are unevenly spaced, with gaps of " +
                  listed(positions_mm) + " mm: a slice is missing or its series is incomplete");
  }

  EvenStack out;
  out.members = best;
  std::vector<double> gaps;
  const auto at = [&](std::size_t member) {
    return positions_mm[static_cast<std::size_t>(best[member])];
  };
  for (std::size_t m = 1; m < best.size(); ++m) gaps.push_back(at(m) - at(m - 1));
  std::vector<double> sorted = gaps;
  std::sort(sorted.begin(), sorted.end());
  const double median = sorted.size() % 2 == 1
                            ? sorted[sorted.size() / 2]
                            : 0.5 * (sorted[sorted.size() / 2 - 1] + sorted[sorted.size() / 2]);
  for (const double gap : gaps) {
    out.worst_gap = std::max(out.worst_gap, std::abs(gap - median) / median);
  }
  const auto last = best.size() - 1;
  if (out.worst_gap <= kNotedUneven) {
    out.spacing_mm = (at(last) - at(0)) / static_cast<double>(last);
    out.first_mm = at(0);
    return out;
  }
  out.spacing_mm = median;
  double sum = 0;  // the even stack lies so that its slices are off by nothing on average
  for (std::size_t m = 0; m < best.size(); ++m) sum += at(m) - median * static_cast<double>(m);
  out.first_mm = sum / static_cast<double>(best.size());
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
    for (const int i : left) positions.push_back(at(i));
    std::vector<int> part;
    for (const int i : longest_run(positions)) part.push_back(left[static_cast<std::size_t>(i)]);
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
