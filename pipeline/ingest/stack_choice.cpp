#include "pipeline/ingest/stack_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "pipeline/ingest/even_positions.h"
#include "pipeline/ingest/phase_resampling.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

constexpr int kLeastSlices = 3;
constexpr double kAlikeCount = 0.9;  // share of the common number of frames that still counts as it

/// A possible stack: one image set a place, before its geometry is looked at.
struct Candidate {
  const Plane* plane = nullptr;
  std::vector<std::pair<const Place*, const ImageSet*>> slices;
  bool one_series = false;
  bool good = false;  ///< trigger times, and frames enough to blend
  int phases = 0;

  [[nodiscard]] auto rank() const {
    return std::make_tuple(good, slices.size(), one_series, phases);
  }
};

std::string with_digits(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

std::string counted(std::size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + ' ' + (count == 1 ? one : many);
}

std::string series_list(const std::set<int>& numbers) {
  std::string out = "series ";
  for (auto it = numbers.begin(); it != numbers.end(); ++it) {
    out += (it == numbers.begin() ? "" : ", ") + std::to_string(*it);
  }
  return out;
}

/// The number of frames that most slices have, weighed by how much of the cycle it shows.
int common_count(const Candidate& candidate) {
  int best = 0;
  double most = 0;
  for (const auto& [place, set] : candidate.slices) {
    const int count = set->frames();
    double alike = 0;
    for (const auto& [other_place, other] : candidate.slices) {
      alike += other->frames() >= kAlikeCount * count ? 1 : 0;
    }
    if (alike * count > most || (alike * count == most && count > best)) {
      most = alike * count;
      best = count;
    }
  }
  return best;
}

void finish(Candidate& candidate) {
  candidate.phases = common_count(candidate);
  std::size_t by_trigger = 0;
  for (const auto& [place, set] : candidate.slices) by_trigger += set->timing.by_trigger ? 1 : 0;
  candidate.good =
      2 * by_trigger > candidate.slices.size() && candidate.phases >= kLeastFramesToBlend;
}

std::vector<Candidate> candidates_of(const Plane& plane) {
  Candidate all;
  all.plane = &plane;
  std::map<std::string, Candidate> by_series;
  for (const Place& place : plane.places) {
    if (!place.cines.empty()) all.slices.emplace_back(&place, &place.cines.front());
    for (const ImageSet& set : place.cines) {
      if (set.merged) continue;
      Candidate& single = by_series[set.series_uid];
      // The sets of a place are best first: of two contrasts of one series keep the first.
      if (single.slices.empty() || single.slices.back().first != &place) {
        single.slices.emplace_back(&place, &set);
      }
    }
  }
  std::vector<Candidate> out;
  if (all.slices.size() >= kLeastSlices) out.push_back(all);
  for (auto& [uid, single] : by_series) {
    if (single.slices.size() < kLeastSlices) continue;
    single.plane = &plane;
    single.one_series = true;
    out.push_back(single);
  }
  for (Candidate& candidate : out) finish(candidate);
  std::stable_sort(out.begin(), out.end(),
                   [](const Candidate& a, const Candidate& b) { return a.rank() > b.rank(); });
  return out;
}

double mean_rr_s(const Candidate& candidate, const IngestOptions& options) {
  double sum = 0;
  int known = 0;
  for (const auto& [place, set] : candidate.slices) {
    if (set->timing.rr_s <= 0) continue;
    sum += set->timing.rr_s;
    ++known;
  }
  if (known > 0) return sum / known;
  if (options.rr_interval_s > 0) return options.rr_interval_s;
  throw_invalid("the images name no R-R interval and no trigger times: give the R-R interval");
}

/// Drops slices that lack a part of the cycle.
void drop_incomplete(Candidate& candidate, double rr_s, std::vector<std::string>& decisions) {
  std::vector<double> gaps;
  gaps.reserve(candidate.slices.size());
  for (const auto& [place, set] : candidate.slices) {
    gaps.push_back(largest_gap(phases_of(set->timing, rr_s)));
  }
  std::vector<double> sorted = gaps;
  std::sort(sorted.begin(), sorted.end());
  // One missing frame among enough of them is bridged.
  const double one_missing = candidate.phases >= kLeastFramesToBlend ? 2.05 / candidate.phases : 0;
  const double most = std::max({kGapOfComplete, 1.5 * sorted[sorted.size() / 2], one_missing});
  std::vector<std::pair<const Place*, const ImageSet*>> kept;
  std::set<int> dropped;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    const bool complete =
        gaps[i] <= most && 2 * candidate.slices[i].second->frames() >= candidate.phases;
    if (complete) {
      kept.push_back(candidate.slices[i]);
    } else {
      dropped.insert(candidate.slices[i].second->series_number);
    }
  }
  const std::size_t left = candidate.slices.size() - kept.size();
  if (kept.size() < kLeastSlices) {
    throw_invalid("only " + std::to_string(kept.size()) + " of " +
                  std::to_string(candidate.slices.size()) +
                  " parallel slices show the whole cycle, at least 3 are needed");
  }
  if (left > 0) {
    decisions.push_back("Warning: " + counted(left, "slice lacks", "slices lack") +
                        " a part of the cycle and " + (left == 1 ? "was" : "were") + " left (" +
                        series_list(dropped) + ").");
  }
  candidate.slices = std::move(kept);
}

/// Keeps the slices whose origins lie on one line along the normal; returns a point of that line.
Vec3 drop_offset(Candidate& candidate, std::vector<std::string>& decisions) {
  const Plane& plane = *candidate.plane;
  const double most = kMostShearPixels * std::min(plane.column_step_mm, plane.row_step_mm);
  const Vec3 normal = plane.normal_lps();
  const auto off_axis = [&](const Vec3& a, const Vec3& b) {
    const Vec3 difference = a - b;
    return (difference - normal * normal.dot(difference)).norm();
  };
  std::vector<std::size_t> best;  // indices into the slices
  Vec3 anchor = Vec3::Zero();
  double worst = 0;
  for (const auto& [place, set] : candidate.slices) {
    std::vector<std::size_t> near;
    for (std::size_t i = 0; i < candidate.slices.size(); ++i) {
      const double off = off_axis(candidate.slices[i].first->position_lps, place->position_lps);
      if (off <= most) near.push_back(i);
      worst = std::max(worst, off);
    }
    if (near.size() > best.size()) {
      best = near;
      anchor = place->position_lps;
    }
  }
  const std::size_t count = candidate.slices.size();
  if (best.size() == count) return anchor;
  if (best.size() < kLeastSlices ||
      static_cast<double>(best.size()) <= kLeastKept * static_cast<double>(count)) {
    throw_invalid(
        "the slices of the stack are shifted against each other within their plane by up "
        "to " +
        with_digits("%.2f", worst) +
        " mm (a sheared stack): export the slices with one common field of view");
  }
  decisions.push_back("Warning: " + counted(count - best.size(), "slice lies", "slices lie") +
                      " beside the axis of the stack and " +
                      (count - best.size() == 1 ? "was" : "were") + " left.");
  std::vector<std::pair<const Place*, const ImageSet*>> kept;
  kept.reserve(best.size());
  for (const std::size_t i : best) kept.push_back(candidate.slices[i]);
  candidate.slices = std::move(kept);
  return anchor;
}

Grid grid_of(const Plane& plane, const Vec3& first_lps, double spacing_mm, int slices) {
  Grid out;
  out.size = {plane.columns, plane.rows, slices};
  out.mm_from_index.linear().col(0) = plane.row_lps * plane.column_step_mm;
  out.mm_from_index.linear().col(1) = plane.column_lps * plane.row_step_mm;
  out.mm_from_index.linear().col(2) = plane.normal_lps() * spacing_mm;
  out.mm_from_index.translation() = first_lps;
  return out;
}

double mean_rr_s(const std::vector<ImageSet>& slices, double otherwise_s) {
  double sum = 0;
  for (const ImageSet& set : slices) sum += set.timing.rr_s > 0 ? set.timing.rr_s : otherwise_s;
  return sum / static_cast<double>(slices.size());
}

/// @throws Error{InvalidInput} if the candidate's geometry makes no stack.
ChosenCine build(Candidate candidate, const IngestOptions& options,
                 std::vector<std::string>& decisions) {
  const std::size_t found = candidate.slices.size();
  const double rr_s = mean_rr_s(candidate, options);
  drop_incomplete(candidate, rr_s, decisions);
  const Vec3 anchor = drop_offset(candidate, decisions);
  std::vector<double> positions;
  positions.reserve(candidate.slices.size());
  for (const auto& [place, set] : candidate.slices) positions.push_back(place->along_mm);
  EvenStack even;
  try {
    even = find_even_stack(positions);
  } catch (const Error& error) {
    const std::size_t left = found - positions.size();
    if (left == 0) throw;
    throw error.with_context("without the " + counted(left, "slice that is", "slices that are") +
                             " incomplete or beside the axis");
  }

  ChosenCine out;
  std::set<int> series;
  for (const int member : even.members) {
    out.slices.push_back(*candidate.slices[static_cast<std::size_t>(member)].second);
    series.insert(out.slices.back().series_number);
  }
  const Plane& plane = *candidate.plane;
  const Vec3 normal = plane.normal_lps();
  const Vec3 first = anchor + normal * (even.first_mm - normal.dot(anchor));
  const auto slices = static_cast<int>(out.slices.size());
  out.grid = grid_of(plane, first, even.spacing_mm, slices);
  out.rr_s = mean_rr_s(out.slices, rr_s);

  decisions.push_back("The stack is made of " + std::to_string(slices) + " parallel slices of " +
                      std::to_string(candidate.phases) + " phases, " +
                      with_digits("%.2f", even.spacing_mm) + " mm apart, " +
                      std::to_string(plane.columns) + " x " + std::to_string(plane.rows) +
                      " pixels of " + with_digits("%.3f", plane.column_step_mm) + " x " +
                      with_digits("%.3f", plane.row_step_mm) + " mm (" + series_list(series) +
                      "): most parallel slices, then most phases.");
  if (even.worst_gap > kNotedUneven) {
    decisions.push_back("Warning: the gaps between slices differ from their median of " +
                        with_digits("%.2f", even.spacing_mm) + " mm by up to " +
                        with_digits("%.1f", 100 * even.worst_gap) +
                        " %; the slices were placed evenly at the median.");
  }
  const std::size_t left = positions.size() - even.members.size();
  if (left > 0) {
    decisions.push_back("Warning: " + counted(left, "parallel slice does", "parallel slices do") +
                        " not continue the even spacing of the stack and " +
                        (left == 1 ? "was" : "were") + " left.");
  }
  return out;
}

[[noreturn]] void no_stack(const std::vector<Plane>& planes) {
  std::size_t most = 0;
  bool any_cine = false;
  for (const Plane& plane : planes) {
    std::size_t cines = 0;
    for (const Place& place : plane.places) cines += place.cines.empty() ? 0 : 1;
    any_cine = any_cine || cines > 0;
    most = std::max(most, cines);
  }
  if (!any_cine) {
    throw_invalid("there is only one phase of each slice: a cine with several phases is needed");
  }
  throw_invalid("there is no stack: at most " +
                counted(most, "parallel slice has", "parallel slices have") +
                " several phases, at least 3 are needed");
}

/// Cines of one or two parallel slices become views; whatever else was not used is told.
void choose_views(const std::vector<Plane>& planes, const Plane& stack_plane, bool good,
                  Choice& choice) {
  std::set<int> used;
  for (const ImageSet& set : choice.stack.slices) used.insert(set.images.begin(), set.images.end());
  std::set<int> left_cines;
  std::size_t stills = 0;
  for (const Plane& plane : planes) {
    std::size_t cines = 0;
    for (const Place& place : plane.places) cines += place.cines.empty() ? 0 : 1;
    for (const Place& place : plane.places) {
      if (place.cines.empty()) {
        stills += static_cast<std::size_t>(place.images);
        continue;
      }
      const ImageSet& set = place.cines.front();
      for (const ImageSet& other : place.cines) {
        if (&other != &set && used.count(other.images.front()) == 0) {
          left_cines.insert(other.series_number);
        }
      }
      if (used.count(set.images.front()) > 0) continue;
      const bool usable = !good || (set.timing.by_trigger && set.frames() >= kLeastFramesToBlend);
      if (&plane == &stack_plane || cines > 2 || !usable) {
        left_cines.insert(set.series_number);
        continue;
      }
      ChosenCine view;
      const double depth = plane.thickness_mm > 0 ? plane.thickness_mm : plane.column_step_mm;
      view.grid = grid_of(plane, place.position_lps, depth, 1);
      view.slices.push_back(set);
      view.rr_s = mean_rr_s(view.slices, choice.stack.rr_s);
      choice.views.push_back(std::move(view));
    }
  }
  std::stable_sort(choice.views.begin(), choice.views.end(),
                   [](const ChosenCine& a, const ChosenCine& b) {
                     return a.slices.front().series_number < b.slices.front().series_number;
                   });
  if (!choice.views.empty()) {
    std::set<int> numbers;
    for (const ChosenCine& view : choice.views) numbers.insert(view.slices.front().series_number);
    choice.decisions.push_back(
        counted(choice.views.size(), "other cine view is", "other cine views are") +
        " kept beside the stack (" + series_list(numbers) + ").");
  }
  if (!left_cines.empty()) {
    choice.decisions.push_back(
        "Left: cines that are neither part of the stack nor a view of one or "
        "two slices, or that another cine of the same place outdoes (" +
        series_list(left_cines) + ").");
  }
  if (stills > 0) {
    choice.decisions.push_back("Left: " + counted(stills, "image", "images") +
                               " of slices that have one phase only or no order in time.");
  }
}

void tell_timing(const ChosenCine& stack, int frames, std::vector<std::string>& decisions) {
  std::map<std::string, std::set<int>> notes;
  for (const ImageSet& set : stack.slices) {
    if (set.frames() < frames) {
      notes["fewer frames than other slices have"].insert(set.series_number);
    }
    if (!set.timing.note.empty()) notes[set.timing.note].insert(set.series_number);
    if (set.merged) notes["the phases came from a series each"].insert(set.series_number);
  }
  for (const auto& [note, series] : notes) {
    decisions.push_back("Warning: timing of the stack (" + series_list(series) + "): " + note +
                        ".");
  }
}

}  // namespace

Choice choose_stack(const std::vector<DicomImage>& images, const IngestOptions& options) {
  const std::vector<Plane> planes = group_planes(images);
  std::vector<Candidate> best;
  for (const Plane& plane : planes) {
    auto candidates = candidates_of(plane);
    if (candidates.empty()) continue;
    if (best.empty() || candidates.front().rank() > best.front().rank()) {
      best = std::move(candidates);
    }
  }
  if (best.empty()) no_stack(planes);

  std::optional<Error> first_error;
  for (const Candidate& candidate : best) {
    // Within one orientation a single series may do where the union of all does not.
    Choice choice;
    try {
      choice.stack = build(candidate, options, choice.decisions);
    } catch (const Error& error) {
      if (!first_error) first_error = error;
      continue;
    }
    choice.phases = options.phases > 0 ? options.phases : candidate.phases;
    tell_timing(choice.stack, candidate.phases, choice.decisions);
    choose_views(planes, *candidate.plane, candidate.good, choice);
    return choice;
  }
  throw Error(*first_error);
}

}  // namespace beatlas::ingest
