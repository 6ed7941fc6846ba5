#include "pipeline/ingest/stack_candidates.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <map>
#include <set>

#include "pipeline/ingest/even_positions.h"
#include "pipeline/ingest/guest_slices.h"
#include "pipeline/ingest/heart_axis.h"
#include "pipeline/ingest/image_runs.h"
#include "pipeline/ingest/phase_resampling.h"
#include "pipeline/ingest/series_list.h"
#include "pipeline/ingest/stack_rank.h"

namespace beatlas::ingest {
namespace {

constexpr double kAlikeCount = 0.9;  // share of the common number of frames that still counts as it
constexpr int kNextSteps = 3;        // scouts and repeats may lie between two series of one stack

/// The number of frames that most slices have, weighed by how much of the cycle it shows. Where
/// they are too few to blend, that which more than half of the slices have: of others some are
/// left.
int common_count(const Candidate& candidate) {
  int best = 0;
  double most = 0;
  std::map<int, std::size_t> counts;
  for (const auto& [place, set] : candidate.slices) {
    const bool most_have = 2 * ++counts[set->frames()] > candidate.slices.size();
    if (most_have && set->frames() < kLeastFramesToBlend) return set->frames();
  }
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

/// Adds a place's set unless the place has one: the sets of a place come best first.
void add(Candidate& candidate, const Place& place, const ImageSet& set) {
  if (candidate.slices.empty() || candidate.slices.back().first != &place) {
    candidate.slices.emplace_back(&place, &set);
  }
}

int first_series(const Candidate& candidate) {
  int out = candidate.slices.front().second->series_number;
  for (const auto& [place, set] : candidate.slices) out = std::min(out, set->series_number);
  return out;
}

/// Sets of a plane that tell a heart rate, in the order of their series.
Slices in_order_of_series(const Plane& plane) {
  Slices out;
  for (const Place& place : plane.places) {
    for (const ImageSet& set : place.cines) {
      if (!set.merged && set.timing.rr_s > 0) out.emplace_back(&place, &set);
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) {
    return a.second->series_number < b.second->series_number;
  });
  return out;
}

/// By how much the number grows from one series to the next: scanners count by one or by the
/// thousand.
int usual_step(const Slices& in_order) {
  std::vector<int> steps;
  for (std::size_t i = 1; i < in_order.size(); ++i) {
    const int step = in_order[i].second->series_number - in_order[i - 1].second->series_number;
    if (step > 0) steps.push_back(step);
  }
  if (steps.empty()) return 1;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// Series that follow each other at one heart rate. Of a place that they imaged twice the later set
/// counts, unless it has fewer frames or is less of a cine; or, `once`, another acquisition begins.
std::vector<Candidate> acquisitions(const Plane& plane, bool once) {
  std::vector<Candidate> out;
  double mean_s = 0;
  int count = 0;
  int last = 0;
  const Slices all = in_order_of_series(plane);
  const int far = kNextSteps * usual_step(all);
  for (const auto& [place, set] : all) {
    const auto place_of = [place = place](const auto& one) { return one.first == place; };
    const bool again =
        !out.empty() && std::any_of(out.back().slices.begin(), out.back().slices.end(), place_of);
    const bool next = !out.empty() && set->series_number - last <= far &&
                      same_rate(set->timing.rr_s, mean_s) && !(once && again);
    if (!next) {
      out.emplace_back();
      count = 0;
      mean_s = 0;
    }
    mean_s = (mean_s * count + set->timing.rr_s) / (count + 1);
    ++count;
    last = set->series_number;
    Slices& slices = out.back().slices;
    const auto had = std::find_if(slices.begin(), slices.end(), place_of);
    if (had == slices.end()) {
      slices.emplace_back(place, set);
    } else if (set->frames() >= had->second->frames() && set->usual >= had->second->usual &&
               set->secondary() <= had->second->secondary() &&
               set->series_number > had->second->series_number) {
      had->second = set;
    }
  }
  for (Candidate& candidate : out) {
    std::sort(candidate.slices.begin(), candidate.slices.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
  }
  return out;
}

/// All slices of one heart rate, the best of each place, wherever they lie in the order of series:
/// in the order of R-R intervals rates part where one is far from the next. Nothing where all are
/// of one.
std::vector<Candidate> heart_rates(const Plane& plane) {
  Slices all = in_order_of_series(plane);
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.second->timing.rr_s < b.second->timing.rr_s;
  });
  std::vector<std::set<const ImageSet*>> rates;
  double last_s = 0;
  for (const auto& [place, set] : all) {
    if (rates.empty() || !same_rate(set->timing.rr_s, last_s)) rates.emplace_back();
    last_s = set->timing.rr_s;
    rates.back().insert(set);
  }
  std::vector<Candidate> out(rates.size() > 1 ? rates.size() : 0);
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (const Place& place : plane.places) {
      for (const ImageSet& set : place.cines) {
        if (rates[i].count(&set) > 0) add(out[i], place, set);
      }
    }
  }
  return out;
}

/// The even stacks that interleave in a candidate.
std::vector<Candidate> interleaved(const Candidate& candidate) {
  std::vector<double> positions;
  positions.reserve(candidate.slices.size());
  for (const auto& [place, set] : candidate.slices) positions.push_back(place->along_mm);
  std::vector<Candidate> out;
  for (const std::vector<int>& part : even_parts(positions)) {
    Candidate one;
    for (const int i : part) one.slices.push_back(candidate.slices[static_cast<std::size_t>(i)]);
    out.push_back(std::move(one));
  }
  // One after the other: slices of one series are one stack.
  std::vector<std::pair<int, int>> series;
  series.reserve(out.size());
  for (const Candidate& one : out) {
    series.emplace_back(first_series(one), latest_series(one));
  }
  std::sort(series.begin(), series.end());
  for (std::size_t i = 1; i < series.size(); ++i) {
    if (series[i].first <= series[i - 1].second) return {};
  }
  return out;
}

/// The kinds of image in series that hold several at one place, by the series' UIDs.
using SeriesKinds = std::map<std::string, std::set<std::string>>;
/// By the UIDs of series and, of those that hold several, by kind.
using BySeries = std::map<std::pair<std::string, std::string>, Candidate>;

SeriesKinds kinds_of_series(const Plane& plane) {
  SeriesKinds out;
  for (const Place& place : plane.places) {
    for (const ImageSet& set : place.cines) {
      if (set.kinds > 1) out[set.series_uid].insert(set.kind);
    }
  }
  return out;
}

/// Adds a set to the stack of its series; one of a series whose other places hold several kinds to
/// the stacks of all these.
void add_to_series(const Place& place, const ImageSet& set, const SeriesKinds& kinds,
                   BySeries& by_series) {
  if (set.merged) return;
  const auto several = kinds.find(set.series_uid);
  if (set.kinds > 1) {
    add(by_series[{set.series_uid, set.kind}], place, set);
  } else if (several != kinds.end()) {
    for (const std::string& kind : several->second) {
      add(by_series[{set.series_uid, kind}], place, set);
    }
  } else {
    add(by_series[{set.series_uid, ""}], place, set);
  }
}

/// Adds a set to the stack of its contrast, which is begun if there is none.
void add_to_contrast(const Place& place, const ImageSet& set, std::vector<Candidate>& by_contrast) {
  auto alike = std::find_if(by_contrast.begin(), by_contrast.end(), [&](const Candidate& one) {
    return same_contrast(*one.slices.front().second, set);
  });
  if (alike == by_contrast.end()) alike = by_contrast.insert(alike, Candidate());
  add(*alike, place, set);
}

/// The candidates of a plane that have slices enough and differ, the latest series first.
std::vector<Candidate> finished(std::vector<Candidate> all, const Plane& plane) {
  std::vector<Candidate> out;
  for (Candidate& candidate : all) {
    if (candidate.slices.size() < kLeastSlices) continue;
    if (std::any_of(out.begin(), out.end(),
                    [&](const Candidate& other) { return other.slices == candidate.slices; })) {
      continue;
    }
    candidate.plane = &plane;
    finish(candidate);
    out.push_back(std::move(candidate));
  }
  std::stable_sort(out.begin(), out.end(), [](const Candidate& a, const Candidate& b) {
    return latest_series(a) > latest_series(b);
  });
  return out;
}

std::vector<Candidate> candidates_of(const Plane& plane) {
  Candidate all;
  std::vector<Candidate> by_contrast;
  const SeriesKinds kinds = kinds_of_series(plane);
  BySeries by_series;
  for (const Place& place : plane.places) {
    for (const ImageSet& set : place.cines) {
      add(all, place, set);
      add_to_series(place, set, kinds, by_series);
      add_to_contrast(place, set, by_contrast);
    }
  }
  std::vector<Candidate> out{all};
  out.insert(out.end(), by_contrast.begin(), by_contrast.end());
  std::vector<Candidate> singles;
  singles.reserve(by_series.size());
  for (const auto& [uid, single] : by_series) singles.push_back(single);
  std::stable_sort(singles.begin(), singles.end(), [](const Candidate& a, const Candidate& b) {
    const auto first = [](const Candidate& one) {
      const ImageSet& set = *one.slices.front().second;
      return std::make_pair(set.series_number, set.images.front());
    };
    return first(a) < first(b);
  });
  out.insert(out.end(), singles.begin(), singles.end());
  for (std::size_t i = 0, wholes = 1 + by_contrast.size(); i < wholes; ++i) {
    for (Candidate& part : interleaved(out[i])) out.push_back(std::move(part));
  }
  for (Candidate& one : acquisitions(plane, false)) out.push_back(std::move(one));
  // Of a stack in which one slice came twice the halves are none.
  for (Candidate& one : acquisitions(plane, true)) {
    if (one.slices.size() == all.slices.size()) out.push_back(std::move(one));
  }
  for (Candidate& one : heart_rates(plane)) out.push_back(std::move(one));
  return finished(std::move(out), plane);
}

}  // namespace

std::string counted(std::size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + ' ' + (count == 1 ? one : many);
}

std::string Candidate::shape_told() const {
  bool flow = false;
  bool many_beats = false;
  for (const auto& [place, set] : slices) {
    flow = flow || set->flow;
    many_beats = many_beats || set->timing.many_beats;
  }
  char apart[32];
  std::snprintf(apart, sizeof(apart), "%.2f mm apart", spacing_mm);
  std::string out = std::to_string(slices.size()) + " slices x " + std::to_string(phases) +
                    " phases, " + apart + ", " + orientation_told(*plane);
  if (!ordinary && flow) out += ", flow";
  if (!ordinary && many_beats) out += ", one image a beat";
  return out;
}

std::string Candidate::told() const {
  std::set<int> series;
  for (const auto& [place, set] : slices) series.insert(set->series_number);
  return shape_told() + " (" + series_list(series) + ")";
}

void finish(Candidate& candidate) {
  candidate.phases = common_count(candidate);
  std::size_t by_trigger = 0;
  std::size_t ordinary = 0;
  std::size_t usual = 0;
  std::set<std::string> series;
  candidate.uniform = true;
  candidate.secondary = false;
  candidate.originals = 0;
  for (const auto& [place, set] : candidate.slices) {
    by_trigger += set->timing.by_trigger ? 1 : 0;
    ordinary += set->ordinary() ? 1 : 0;
    usual += set->usual ? 1 : 0;
    candidate.secondary = candidate.secondary || set->secondary();
    candidate.originals += set->provenance == Provenance::Original ? 1 : 0;
    if (!set->merged) series.insert(set->series_uid);
    candidate.uniform = candidate.uniform && same_contrast(*candidate.slices.front().second, *set);
  }
  candidate.ordinary = 2 * ordinary > candidate.slices.size();
  candidate.usual = 2 * usual > candidate.slices.size();
  candidate.one_series = series.size() == 1;
  candidate.good =
      2 * by_trigger > candidate.slices.size() && candidate.phases >= kLeastFramesToBlend;
  double shortest = 0;
  double longest = 0;
  double sum = 0;
  int told = 0;
  bool choice = false;
  for (const auto& [place, set] : candidate.slices) {
    choice = choice || place->cines.size() > 1;
    const double rr_s = set->timing.rr_s;
    if (rr_s <= 0) continue;
    shortest = shortest > 0 ? std::min(shortest, rr_s) : rr_s;
    longest = std::max(longest, rr_s);
    sum += rr_s;
    ++told;
  }
  candidate.rr_s = told > 0 ? sum / told : 0;
  candidate.mixed = choice && !candidate.one_series && !same_rate(shortest, longest);
  std::vector<double> gaps;
  for (std::size_t i = 1; i < candidate.slices.size(); ++i) {
    gaps.push_back(candidate.slices[i].first->along_mm - candidate.slices[i - 1].first->along_mm);
  }
  std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2),
                   gaps.end());
  candidate.spacing_mm = gaps[gaps.size() / 2];
}

bool same_contrast(const ImageSet& a, const ImageSet& b) {
  const bool same_kind = a.kinds == 1 || b.kinds == 1 || a.kind == b.kind;
  return same_kind && a.secondary() == b.secondary() && same_contrast(a.contrast, b.contrast);
}

int latest_series(const Candidate& candidate) {
  int out = candidate.slices.front().second->series_number;
  for (const auto& [place, set] : candidate.slices) out = std::max(out, set->series_number);
  return out;
}

std::vector<Candidate> find_candidates(const std::vector<Plane>& planes) {
  std::vector<Candidate> out = gathered(planes, true);
  for (const Plane& plane : planes) {
    auto of_plane = candidates_of(plane);
    std::move(of_plane.begin(), of_plane.end(), std::back_inserter(out));
  }
  rank_candidates(out, planes);
  return out;
}

Stacks find_stacks(const std::vector<DicomImage>& images, const ImageFiles& files) {
  Stacks out;
  out.planes = group_planes(images, files);
  out.candidates = find_candidates(out.planes);
  if (frames_of_reference(images).one_a_series) {
    out.frames_told =
        "Warning: every series names a frame of reference of its own, which tells nothing; their "
        "places were taken as of one.";
  }
  if (!out.candidates.empty()) return out;
  ImageFiles joining = files;
  joining.join_frames = true;
  Stacks joined;
  joined.planes = group_planes(images, joining);
  joined.candidates = find_candidates(joined.planes);
  if (joined.candidates.empty()) return out;
  joined.frames_told =
      "Warning: the slices name several frames of reference, none of which holds a stack; they "
      "were "
      "taken together, though the patient may have been moved between them: look at their "
      "outlines.";
  return joined;
}

}  // namespace beatlas::ingest
