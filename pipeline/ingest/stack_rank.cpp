#include "pipeline/ingest/stack_rank.h"

#include <algorithm>
#include <cstdio>
#include <tuple>

#include "pipeline/ingest/heart_axis.h"

namespace beatlas::ingest {
namespace {

constexpr double kObliqueEvidence =
    0.25;                           // as a quarter of the views: where no view tells it tells
constexpr double kPlausible = 0.5;  // of the best one's evidence: pairs of views are few, and rough

/// Slices that share no field of view may be repeats as well as a stack: of three two count.
std::size_t weighed_slices(const Candidate& candidate) {
  return candidate.one_field ? candidate.slices.size() : candidate.slices.size() * 2 / 3;
}

auto rank(const Candidate& candidate) {
  return std::make_tuple(candidate.ordinary, !candidate.secondary, candidate.good,
                         candidate.short_axis, candidate.usual, weighed_slices(candidate),
                         candidate.one_field, candidate.uniform, candidate.originals,
                         candidate.views_met > 0, !candidate.mixed, candidate.one_series,
                         candidate.phases);
}

/// Whether the second of two stacks is the first one, taken again in another field of view.
bool is_repeat(const Candidate& first, const Candidate& second) {
  return first.plane != second.plane && nearly_parallel(*first.plane, *second.plane) &&
         same_contrast(*first.slices.front().second, *second.slices.front().second) &&
         latest_series(first) < latest_series(second);
}

void find_axis(std::vector<Candidate>& candidates, const std::vector<Plane>& planes) {
  for (Candidate& one : candidates) one.views_met = axis_evidence(*one.plane, planes);
  // A heart that was imaged in two frames of reference lies about the same in both.
  std::vector<double> evidence;
  double best = 0;
  for (const Candidate& one : candidates) {
    double met = 0;
    for (const Candidate& other : candidates) {
      if (one_direction(*one.plane, *other.plane)) met = std::max(met, other.views_met);
    }
    evidence.push_back(met + (is_oblique(*one.plane) ? kObliqueEvidence : 0));
    if (one.ordinary) best = std::max(best, evidence.back());
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    candidates[i].short_axis = evidence[i] >= kPlausible * best;
  }
}

}  // namespace

void rank_candidates(std::vector<Candidate>& candidates, const std::vector<Plane>& planes) {
  find_axis(candidates, planes);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return rank(a) > rank(b); });
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    for (std::size_t j = i + 1; j < candidates.size() && rank(candidates[i]) == rank(candidates[j]);
         ++j) {
      if (is_repeat(candidates[i], candidates[j])) std::swap(candidates[i], candidates[j]);
    }
  }
}

std::string why_before(const Candidate& first, const Candidate& second) {
  if (first.ordinary != second.ordinary)
    return "it is a cine, the next is flow, perfusion or several beats of unknown length";
  if (first.secondary != second.secondary) {
    return "the next holds secondary copies, as screenshots and drawn-on images are";
  }
  if (first.good != second.good) return "it has trigger times and 8 phases or more";
  if (first.short_axis != second.short_axis) {
    return first.views_met > second.views_met
               ? "it lies across the axis along which the long-axis views meet"
               : "no view tells the heart's axis, and it is oblique as a short axis is";
  }
  if (first.usual != second.usual) return "it has the contrast that most cines of the exam have";
  if (first.one_field != second.one_field) {
    return first.one_field ? "its slices have one field of view"
                           : "it has far more parallel slices, though in several fields of view";
  }
  if (first.slices.size() != second.slices.size()) return "it has most parallel slices";
  if (first.uniform != second.uniform) return "its slices have one contrast";
  if (first.originals != second.originals) return "it has more original images, not derived ones";
  if ((first.views_met > 0) != (second.views_met > 0)) {
    return "views of its frame of reference lie beside it";
  }
  if (first.mixed != second.mixed) return "its slices have one heart rate";
  if (first.one_series != second.one_series) return "its slices are one series";
  if (first.phases != second.phases) return "it has as many slices and most phases";
  if (first.plane > second.plane) return "it repeats an equal stack in another field of view";
  if (first.plane != second.plane) {
    return "it is equal to the next and its plane comes first in the order of series";
  }
  if (latest_series(first) != latest_series(second)) {
    return "it is equal to the next and of a later series";
  }
  return "it is equal to the next and comes first in the order of images";
}

std::string other_axis_told(const std::vector<Candidate>& candidates, std::size_t chosen) {
  if (chosen >= candidates.size()) return {};
  const Candidate& taken = candidates[chosen];
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Candidate& other = candidates[i];
    const bool rivals = i != chosen && other.ordinary && other.good == taken.good &&
                        2 * weighed_slices(other) >= weighed_slices(taken) &&
                        turned(*other.plane, *taken.plane);
    // Where no view tells the axis, a stack along the patient's axes may be it for all its slices.
    const bool untold = taken.views_met == 0 && weighed_slices(other) >= weighed_slices(taken);
    if (!rivals || !(other.short_axis || untold)) continue;
    return "Warning: the views do not tell for certain which of possible stacks " +
           std::to_string(chosen + 1) + " and " + std::to_string(i + 1) +
           " lies across the heart's axis; look at the images, and take the other with --stack " +
           std::to_string(i + 1) + " if it is the short axis.";
  }
  return {};
}

std::string other_rate_told(const std::vector<Candidate>& candidates, std::size_t chosen) {
  if (chosen >= candidates.size()) return {};
  const Candidate& taken = candidates[chosen];
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Candidate& other = candidates[i];
    if (other.ordinary != taken.ordinary || other.secondary != taken.secondary ||
        other.good != taken.good || other.usual != taken.usual || other.mixed ||
        weighed_slices(other) < weighed_slices(taken) || turned(*other.plane, *taken.plane) ||
        same_rate(other.rr_s, taken.rr_s)) {
      continue;
    }
    char intervals[64];
    std::snprintf(intervals, sizeof(intervals), "R-R %.0f instead of %.0f ms", 1e3 * other.rr_s,
                  1e3 * taken.rr_s);
    return "Warning: possible stack " + std::to_string(i + 1) +
           " is as large and of another heart rate (" + intervals +
           "), as rest and stress are; take it with --stack " + std::to_string(i + 1) +
           " if it is the one that is meant.";
  }
  return {};
}

}  // namespace beatlas::ingest
