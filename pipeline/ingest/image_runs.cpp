#include "pipeline/ingest/image_runs.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace beatlas::ingest {
namespace {

constexpr std::size_t kLeastOfRun = 4;  // images of the largest run before runs are told apart
constexpr double kPauseS = 3;           // between two images: another breath-hold

constexpr std::size_t kSeriesToTell = 3;  // a stack and its repeat may each have a frame

using Runs = std::vector<std::vector<int>>;

/// First and last trigger time [ms]; nothing if an image has none.
std::optional<std::pair<double, double>> range_of(const std::vector<int>& run,
                                                  const std::vector<DicomImage>& images) {
  std::optional<std::pair<double, double>> out;
  for (const int index : run) {
    const auto& ms = images[static_cast<std::size_t>(index)].stamp.trigger_ms;
    if (!ms) return std::nullopt;
    if (!out) out = {*ms, *ms};
    out->first = std::min(out->first, *ms);
    out->second = std::max(out->second, *ms);
  }
  return out;
}

const std::vector<int>& largest(const Runs& runs) {
  return *std::max_element(runs.begin(), runs.end(),
                           [](const auto& a, const auto& b) { return a.size() < b.size(); });
}

/// Whether every run shows what the largest shows, or a part of it: half of its images lie between
/// the first and the last of the largest. Without trigger times they are taken to.
bool repeat(const Runs& runs, const std::vector<DicomImage>& images) {
  if (runs.size() < 2 || largest(runs).size() < kLeastOfRun) return false;
  const auto most = range_of(largest(runs), images);
  return std::all_of(runs.begin(), runs.end(), [&](const std::vector<int>& run) {
    if (!most || !range_of(run, images)) return true;
    const auto within = std::count_if(run.begin(), run.end(), [&](int index) {
      const double ms = *images[static_cast<std::size_t>(index)].stamp.trigger_ms;
      return ms >= most->first && ms <= most->second;
    });
    return 2 * static_cast<std::size_t>(within) >= run.size();
  });
}

template <class Key>
Runs runs_by(const std::map<Key, std::vector<int>>& groups) {
  Runs out;
  for (const auto& [key, members] : groups) out.push_back(members);
  return out;
}

double earliest_s(const std::vector<int>& run, const std::vector<DicomImage>& images) {
  double out = 0;
  bool any = false;
  for (const int index : run) {
    const auto& at = images[static_cast<std::size_t>(index)].stamp.acquisition_s;
    if (!at) return 0;
    out = any ? std::min(out, *at) : *at;
    any = true;
  }
  return out;
}

/// Cut where the clock pauses; all in one if an image has no time.
Runs by_clock(const std::vector<int>& indices, const std::vector<DicomImage>& images) {
  const auto at = [&](int i) { return images[static_cast<std::size_t>(i)].stamp.acquisition_s; };
  if (!std::all_of(indices.begin(), indices.end(), [&](int i) { return at(i).has_value(); })) {
    return {indices};
  }
  std::vector<int> order = indices;
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return *at(a) < *at(b); });
  Runs out{{}};
  for (const int index : order) {
    if (!out.back().empty() && *at(index) - *at(out.back().back()) > kPauseS) out.emplace_back();
    out.back().push_back(index);
  }
  for (std::vector<int>& run : out) std::sort(run.begin(), run.end());
  return out;
}

}  // namespace

std::vector<std::vector<int>> kinds_of(const std::vector<int>& indices,
                                       const std::vector<DicomImage>& images) {
  std::map<std::string, std::vector<int>> kinds;
  for (const int index : indices) {
    kinds[images[static_cast<std::size_t>(index)].kind].push_back(index);
  }
  Runs runs = runs_by(kinds);
  if (runs.size() < 2) return {indices};
  std::sort(runs.begin(), runs.end(),
            [](const auto& a, const auto& b) { return a.front() < b.front(); });
  const std::vector<int> most = largest(runs);
  const auto all = range_of(indices, images);
  Runs out;
  std::vector<int> others;
  for (const std::vector<int>& run : runs) {
    bool whole = 2 * run.size() >= most.size() && run.size() > 1;
    if (all && whole) {
      const auto own = *range_of(run, images);
      whole = 2 * (own.second - own.first) >= all->second - all->first;
    }
    if (whole) {
      out.push_back(run);
    } else {
      others.insert(others.end(), run.begin(), run.end());
    }
  }
  if (out.size() < 2) return {indices};
  for (std::vector<int>& run : out) {
    if (run.front() != largest(out).front()) continue;
    run.insert(run.end(), others.begin(), others.end());
    std::sort(run.begin(), run.end());
    break;
  }
  return out;
}

std::vector<std::vector<int>> acquisitions_of(const std::vector<int>& indices,
                                              const std::vector<DicomImage>& images) {
  std::map<double, std::vector<int>> numbers;
  for (const int index : indices) {
    const auto& number = images[static_cast<std::size_t>(index)].stamp.acquisition_number;
    numbers[number.value_or(-1)].push_back(index);
  }
  Runs runs = runs_by(numbers);
  if (repeat(runs, images)) {
    std::stable_sort(runs.begin(), runs.end(), [&](const auto& a, const auto& b) {
      return earliest_s(a, images) < earliest_s(b, images);
    });
    return runs;
  }
  runs = by_clock(indices, images);
  return repeat(runs, images) ? runs : Runs{indices};
}

std::size_t most_complete(const std::vector<std::vector<int>>& acquisitions) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < acquisitions.size(); ++i) {
    if (acquisitions[i].size() >= acquisitions[best].size()) best = i;
  }
  return best;
}

Frames frames_of_reference(const std::vector<DicomImage>& images) {
  std::map<std::string, std::set<std::string>> by_series;
  for (const DicomImage& image : images) {
    by_series[image.series_uid].insert(image.frame_of_reference_uid);
  }
  std::set<std::string> all;
  std::size_t told = 0;
  for (const auto& [series, uids] : by_series) {
    if (uids.size() > 1 || uids.begin()->empty()) continue;
    all.insert(*uids.begin());
    ++told;
  }
  Frames out;
  out.one_a_series = told >= kSeriesToTell && told == by_series.size() && all.size() == told;
  for (const DicomImage& image : images) {
    const bool tells = !out.one_a_series && by_series[image.series_uid].size() == 1;
    out.uids.push_back(tells ? image.frame_of_reference_uid : std::string());
  }
  return out;
}

}  // namespace beatlas::ingest
