#include "pipeline/ingest/stack_candidates.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <map>
#include <set>
#include <tuple>

#include "pipeline/ingest/phase_resampling.h"
#include "pipeline/ingest/series_list.h"

namespace beatlas::ingest {
namespace {

constexpr double kAlikeCount = 0.9;  // share of the common number of frames that still counts as it
constexpr double kAlikeEcho = 0.1;   // scanners trim echo times slice by slice
constexpr double kAlongAxis = 0.966;  // cosine of 15 degrees

auto rank(const Candidate& candidate) {
  return std::make_tuple(candidate.ordinary, candidate.good, candidate.slices.size(),
                         candidate.uniform, candidate.one_series, candidate.phases);
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

bool same_contrast(const ImageSet& a, const ImageSet& b) {
  return a.sequence == b.sequence &&
         std::abs(a.echo_ms - b.echo_ms) <= kAlikeEcho * std::max(a.echo_ms, b.echo_ms);
}

void finish(Candidate& candidate) {
  candidate.phases = common_count(candidate);
  std::size_t by_trigger = 0;
  std::size_t ordinary = 0;
  std::set<std::string> series;
  candidate.uniform = true;
  for (const auto& [place, set] : candidate.slices) {
    by_trigger += set->timing.by_trigger ? 1 : 0;
    ordinary += set->ordinary() ? 1 : 0;
    if (!set->merged) series.insert(set->series_uid);
    candidate.uniform = candidate.uniform && same_contrast(*candidate.slices.front().second, *set);
  }
  candidate.ordinary = 2 * ordinary > candidate.slices.size();
  candidate.one_series = series.size() == 1;
  candidate.good =
      2 * by_trigger > candidate.slices.size() && candidate.phases >= kLeastFramesToBlend;
  std::vector<double> gaps;
  for (std::size_t i = 1; i < candidate.slices.size(); ++i) {
    gaps.push_back(candidate.slices[i].first->along_mm - candidate.slices[i - 1].first->along_mm);
  }
  std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2),
                   gaps.end());
  candidate.spacing_mm = gaps[gaps.size() / 2];
}

/// Adds a place's set unless the place has one: the sets of a place come best first.
void add(Candidate& candidate, const Place& place, const ImageSet& set) {
  if (candidate.slices.empty() || candidate.slices.back().first != &place) {
    candidate.slices.emplace_back(&place, &set);
  }
}

std::vector<Candidate> candidates_of(const Plane& plane) {
  Candidate all;
  std::vector<Candidate> by_contrast;
  std::map<std::string, Candidate> by_series;
  for (const Place& place : plane.places) {
    for (const ImageSet& set : place.cines) {
      add(all, place, set);
      if (!set.merged) add(by_series[set.series_uid], place, set);
      auto alike = std::find_if(by_contrast.begin(), by_contrast.end(), [&](const Candidate& one) {
        return same_contrast(*one.slices.front().second, set);
      });
      if (alike == by_contrast.end()) alike = by_contrast.insert(alike, Candidate());
      add(*alike, place, set);
    }
  }
  std::vector<Candidate> out{all};
  out.insert(out.end(), by_contrast.begin(), by_contrast.end());
  std::vector<Candidate> singles;
  singles.reserve(by_series.size());
  for (const auto& [uid, single] : by_series) singles.push_back(single);
  std::stable_sort(singles.begin(), singles.end(), [](const Candidate& a, const Candidate& b) {
    return a.slices.front().second->series_number < b.slices.front().second->series_number;
  });
  out.insert(out.end(), singles.begin(), singles.end());
  std::vector<Candidate> different;
  for (Candidate& candidate : out) {
    if (candidate.slices.size() < kLeastSlices) continue;
    if (std::any_of(different.begin(), different.end(),
                    [&](const Candidate& other) { return other.slices == candidate.slices; })) {
      continue;
    }
    candidate.plane = &plane;
    finish(candidate);
    different.push_back(std::move(candidate));
  }
  return different;
}

const char* orientation(const Plane& plane) {
  const Vec3 normal = plane.normal_lps().cwiseAbs();
  if (normal.z() > kAlongAxis) return "axial";
  if (normal.y() > kAlongAxis) return "coronal";
  if (normal.x() > kAlongAxis) return "sagittal";
  return "oblique";
}

}  // namespace

std::string counted(std::size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + ' ' + (count == 1 ? one : many);
}

std::string Candidate::told() const {
  std::set<int> series;
  bool flow = false;
  bool many_beats = false;
  for (const auto& [place, set] : slices) {
    series.insert(set->series_number);
    flow = flow || set->flow;
    many_beats = many_beats || set->timing.many_beats;
  }
  char apart[32];
  std::snprintf(apart, sizeof(apart), "%.2f mm apart", spacing_mm);
  std::string out = std::to_string(slices.size()) + " slices x " + std::to_string(phases) +
                    " phases, " + apart + ", " + orientation(*plane);
  if (!ordinary && flow) out += ", flow";
  if (!ordinary && many_beats) out += ", one image a beat";
  return out + " (" + series_list(series) + ")";
}

std::vector<Candidate> find_candidates(const std::vector<Plane>& planes) {
  std::vector<Candidate> out;
  for (const Plane& plane : planes) {
    auto of_plane = candidates_of(plane);
    std::move(of_plane.begin(), of_plane.end(), std::back_inserter(out));
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Candidate& a, const Candidate& b) { return rank(a) > rank(b); });
  return out;
}

std::string why_before(const Candidate& first, const Candidate& second) {
  if (first.ordinary != second.ordinary) return "it is a cine, the next is flow or perfusion";
  if (first.good != second.good) return "it has trigger times and 8 phases or more";
  if (first.slices.size() != second.slices.size()) return "it has most parallel slices";
  if (first.uniform != second.uniform) return "its slices have one contrast";
  if (first.one_series != second.one_series) return "its slices are one series";
  if (first.phases != second.phases) return "it has as many slices and most phases";
  return "it is equal to the next and comes first in the order of series";
}

}  // namespace beatlas::ingest
