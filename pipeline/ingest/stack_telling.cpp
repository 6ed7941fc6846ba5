#include "pipeline/ingest/stack_telling.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>

#include "pipeline/ingest/phase_resampling.h"
#include "pipeline/ingest/series_list.h"
#include "pipeline/ingest/stack_rank.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

constexpr double kToldUnseen = 0.05;  // a missing frame of 25 is 0.04 and told as such

/// What of a slice's frames is unusual; clauses. @param frames what most slices have
std::vector<std::string> oddities_of(const ImageSet& set, int frames) {
  std::vector<std::string> out;
  if (set.frames() < frames) out.emplace_back("fewer frames than other slices have");
  if (set.frames() > frames && set.frames() < kLeastFramesToBlend) {
    out.emplace_back("more frames than other slices have, of which some were left");
  }
  if (!set.timing.note.empty()) out.push_back(set.timing.note);
  if (set.timing.many_beats) {
    out.emplace_back("the images seem to be of one beat each, not the phases of one");
  }
  if (set.flow) out.emplace_back("these are magnitudes of a flow measurement");
  if (set.kinds > 1) {
    out.push_back("each image is there in " + std::to_string(set.kinds) +
                  " kinds (ImageType), of which one was taken");
  }
  if (set.merged) out.emplace_back("the phases came from a series each");
  return out;
}

}  // namespace

std::string with_digits(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

void tell_timing(const ChosenCine& stack, int frames, std::vector<std::string>& decisions) {
  std::map<std::string, std::set<int>> notes;
  std::set<std::string> sources;
  std::set<std::string> kinds;
  double shortest = stack.rr_s;
  double longest = stack.rr_s;
  double unseen = 0;
  for (const ImageSet& set : stack.slices) {
    const SliceTiming& timing = set.timing;
    sources.insert(timing.source);
    if (timing.rr_s > 0) {
      shortest = std::min(shortest, timing.rr_s);
      longest = std::max(longest, timing.rr_s);
    }
    if (set.frames() >= kLeastFramesToBlend) {
      unseen = std::max(unseen, unseen_share(phases_of(timing, stack.rr_s)));
    }
    if (set.kinds > 1) kinds.insert(set.kind);
    for (const std::string& note : oddities_of(set, frames)) notes[note].insert(set.series_number);
  }
  std::string from;
  for (const std::string& source : sources) from += (from.empty() ? "" : " and ") + source;
  const std::string low = with_digits("%.0f", 1e3 * shortest);
  const std::string high = with_digits("%.0f", 1e3 * longest);
  decisions.push_back("Timing of the stack is by " + from + "; the R-R interval is " + low +
                      (low == high ? "" : " to " + high) + " ms.");
  for (const auto& [note, series] : notes) {
    decisions.push_back("Warning: timing of the stack (" + series_list(series) + "): " + note +
                        ".");
  }
  if (kinds.size() > 1) {
    decisions.emplace_back(
        "Warning: no kind (ImageType) of the images is there in all slices; kinds are mixed.");
  }
  if (unseen > kMostUnseen) {
    throw_invalid(
        with_digits("%.0f", 100 * unseen) +
        " % of the cycle has no frames: the images stop long before the R-R interval of " + high +
        " ms ends; export all phases, or give the interval with --rr");
  }
  if (unseen >= kToldUnseen) {
    decisions.push_back("Warning: " + with_digits("%.0f", 100 * unseen) +
                        " % of the cycle was never imaged (in one gap, of the slice that lacks "
                        "most); it is bridged by a smooth curve from the frames around it.");
  }
}

std::string listed(const std::vector<Candidate>& candidates, std::size_t chosen, bool asked,
                   std::size_t most) {
  std::string out = "Possible stacks: ";
  for (std::size_t i = 0; i < candidates.size() && (i < most || i <= chosen); ++i) {
    if (i >= most && i != chosen) continue;
    out += (i == 0 ? "" : "; ") + std::to_string(i + 1) + ". " + candidates[i].told();
    if (i == chosen) out += ", chosen";
    if (i == chosen && asked) out += " as asked";
    if (i == chosen && !asked && i == 0 && candidates.size() > 1) {
      out += " because " + why_before(candidates[0], candidates[1]);
    }
  }
  if (candidates.size() > most) {
    out += "; " + std::to_string(candidates.size() - most) + " lesser ones";
  }
  return out + '.';
}

std::string hole_told(const Slices& kept, const Slices& found) {
  if (kept.size() < 2) return {};
  std::size_t at = 1;
  const auto gap_mm = [&](std::size_t i) {
    return kept[i].first->along_mm - kept[i - 1].first->along_mm;
  };
  for (std::size_t i = 2; i < kept.size(); ++i) at = gap_mm(i) > gap_mm(at) ? i : at;
  const auto& [before, before_set] = kept[at - 1];
  const auto& [behind, behind_set] = kept[at];
  std::string out = "; the widest, " + with_digits("%.1f", gap_mm(at)) +
                    " mm, lies between slices of " +
                    series_list({before_set->series_number, behind_set->series_number});
  std::string lies = ", where none was found";
  for (const auto& [place, set] : found) {
    if (place->along_mm <= before->along_mm || place->along_mm >= behind->along_mm) continue;
    lies = ", where a slice of series " + std::to_string(set->series_number);
    lies += " has " + counted(set->images.size(), "frame", "frames");
    lies += " of a part of the cycle only";
  }
  out += lies;
  return out + ": export that slice whole, or acquire it again";
}

std::string mixed_told() {
  return "Warning: the R-R intervals of the slices differ by more than 15 % and some places were "
         "imaged several times: the slices may be of two acquisitions (rest and stress, say); "
         "choose one with --series if they are.";
}

}  // namespace beatlas::ingest
