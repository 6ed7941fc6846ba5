#include "pipeline/ingest/stack_choice.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <set>

#include "pipeline/core/words.h"
#include "pipeline/ingest/even_positions.h"
#include "pipeline/ingest/guest_slices.h"
#include "pipeline/ingest/phase_resampling.h"
#include "pipeline/ingest/series_list.h"
#include "pipeline/ingest/slice_resampling.h"
#include "pipeline/ingest/stack_candidates.h"
#include "pipeline/ingest/stack_rank.h"
#include "pipeline/ingest/stack_telling.h"
#include "pipeline/ingest/view_choice.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

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
  throw_invalid(
      "the images name no R-R interval and no trigger times: give the R-R interval (--rr)");
}

/// Drops slices that lack more of the cycle than can be bridged, and more than the others do, or
/// that have too few frames: a heart that ends a slice early, or an exam with a hole, is worse than
/// a diastole that is drawn smoothly.
void drop_incomplete(Candidate& candidate, double rr_s, std::vector<std::string>& decisions) {
  std::vector<double> gaps;
  gaps.reserve(candidate.slices.size());
  for (const auto& [place, set] : candidate.slices) {
    gaps.push_back(largest_gap(phases_of(set->timing, rr_s)));
  }
  std::vector<double> sorted = gaps;
  std::sort(sorted.begin(), sorted.end());
  const double most = std::max(kMostUnseen, 1.5 * sorted[sorted.size() / 2]);
  const int fewest = std::min((candidate.phases + 1) / 2, kLeastFramesToBlend);
  std::vector<std::pair<const Place*, const ImageSet*>> kept;
  std::set<int> dropped;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (gaps[i] <= most && candidate.slices[i].second->frames() >= fewest) {
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

/// Drops guests that do not show the middle of the stack's field of view.
void drop_elsewhere(Candidate& candidate, const std::vector<DicomImage>& images,
                    std::vector<std::string>& decisions) {
  const Grid field = lattice_of(*candidate.plane, candidate.plane->first_lps, 1, 1);
  const auto left = std::erase_if(candidate.slices, [&](const auto& slice) {
    const DicomImage& image = images[static_cast<std::size_t>(slice.second->images.front())];
    return slice.first->guest && !SliceResampling(image, field, 0).shows_middle();
  });
  if (candidate.slices.size() < kLeastSlices) {
    throw_invalid("the slices of the stack have no field of view in common");
  }
  if (left > 0) {
    decisions.push_back("Warning: " + counted(left, "parallel slice does", "parallel slices do") +
                        " not show the middle of the others' field of view and " +
                        (left == 1 ? "was" : "were") + " left.");
  }
}

/// Tells of slices that are to be shown on pixels that are not theirs.
void tell_resampled(const ChosenCine& stack, const std::vector<DicomImage>& images,
                    std::vector<std::string>& decisions) {
  std::set<int> series;
  std::size_t count = 0;
  double shift_mm = 0;
  double turn_deg = 0;
  for (std::size_t n = 0; n < stack.slices.size(); ++n) {
    const ImageSet& set = stack.slices[n];
    const SliceResampling onto(images[static_cast<std::size_t>(set.images.front())], stack.grid,
                               stack.numbers[n]);
    if (onto.same()) continue;
    ++count;
    series.insert(set.series_number);
    shift_mm = std::max(shift_mm, onto.shift_mm());
    turn_deg = std::max(turn_deg, onto.turn_deg());
  }
  if (count == 0) return;
  decisions.push_back("Warning: " + counted(count, "slice has", "slices have") +
                      " a field of view of " + (count == 1 ? "its" : "their") +
                      " own, whose middle lies " + (count == 1 ? "" : "up to ") +
                      with_digits("%.1f", shift_mm) + " mm beside the others'" +
                      (turn_deg > kSameTurnDeg
                           ? " and which is tilted by " + with_digits("%.1f", turn_deg) + " degrees"
                           : "") +
                      ", and " + (count == 1 ? "was" : "were") +
                      " resampled to the pixels of the stack (" + series_list(series) + ").");
}

double mean_rr_s(const std::vector<ImageSet>& slices, double otherwise_s) {
  double sum = 0;
  for (const ImageSet& set : slices) sum += set.timing.rr_s > 0 ? set.timing.rr_s : otherwise_s;
  return sum / static_cast<double>(slices.size());
}

/// The R-R interval that was given is the stack's mean: slices differ as they did before.
/// @return what every slice's own is to be multiplied with
double give_rr(Candidate& candidate, double given_s, std::deque<ImageSet>& store) {
  const double share = given_s / mean_rr_s(candidate, {.rr_interval_s = given_s});
  for (auto& [place, set] : candidate.slices) {
    if (set->timing.rr_s <= 0) continue;
    const auto timing = with_rr(set->timing, set->timing.rr_s * share);
    if (!timing) {
      throw_invalid("the frames of a slice span " +
                    with_digits("%.3f", set->timing.time_s.back() - set->timing.time_s.front()) +
                    " s, more than the R-R interval given, " + with_digits("%.3f", given_s) +
                    " s: give the interval in seconds, or the frame times too (--times)");
    }
    store.push_back(*set);
    store.back().timing = *timing;
    set = &store.back();
  }
  return share;
}

/// Puts the frame times that were given in place of the candidate's own; the sets that takes live
/// in `store`.
void give_times(Candidate& candidate, const IngestOptions& options, std::deque<ImageSet>& store) {
  const std::vector<double>& times = options.frame_times_s;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || (i > 0 && times[i] <= times[i - 1])) {
      throw_invalid("the frame times given must be numbers that ascend");
    }
  }
  for (auto& [place, set] : candidate.slices) {
    if (set->images.size() != times.size()) {
      throw_invalid(std::to_string(times.size()) +
                    " frame times are given, but a slice of series " +
                    std::to_string(set->series_number) + " has " +
                    counted(set->images.size(), "frame", "frames") +
                    ": give one a frame, or choose the series that have as many (--series)");
    }
    store.push_back(*set);
    store.back().timing = with_times(set->timing, times, options.rr_interval_s);
    const double rr_s = store.back().timing.rr_s;
    if (times.back() - times.front() >= rr_s) {
      throw_invalid("the frame times given span " +
                    with_digits("%.3f", times.back() - times.front()) +
                    " s, but the R-R interval is " + with_digits("%.3f", rr_s) +
                    " s: give both in seconds, of one beat");
    }
    set = &store.back();
  }
}

/// Frames of several beats need to know how long one is.
void check_beats(const Candidate& candidate) {
  for (const auto& [place, set] : candidate.slices) {
    const SliceTiming& timing = set->timing;
    if (!timing.beat_unknown) continue;
    const double span_s = timing.time_s.empty() ? 0 : timing.time_s.back() - timing.time_s.front();
    throw_invalid("the frames of a slice of series " + std::to_string(set->series_number) +
                  " go on for " + (span_s > 0 ? with_digits("%.1f", span_s) + " s, " : "") +
                  "several heart beats, and name no R-R interval: give it (--rr)");
  }
}

/// Tells which slices of the stack are not there.
void tell_holes(const ChosenCine& stack, std::vector<std::string>& decisions) {
  std::vector<std::string> missing;
  for (int k = 0; k < stack.grid.size[2]; ++k) {
    if (!std::binary_search(stack.numbers.begin(), stack.numbers.end(), k)) {
      missing.push_back(std::to_string(k));
    }
  }
  if (missing.empty()) return;
  const bool one = missing.size() == 1;
  decisions.push_back(std::string("Warning: ") + (one ? "slice " : "slices ") +
                      beatlas::listed(missing) + (one ? " is" : " are") +
                      " missing within the stack and " + (one ? "was" : "were") +
                      " left blank; if " + (one ? "it was" : "they were") + " acquired, export " +
                      (one ? "it" : "them") + " too.");
}

/// @throws Error{InvalidInput} if the candidate's geometry makes no stack.
ChosenCine build(Candidate candidate, const std::vector<DicomImage>& images,
                 const IngestOptions& options, Spacing spacing,
                 std::vector<std::string>& decisions) {
  if (options.frame_times_s.empty()) check_beats(candidate);
  std::deque<ImageSet> retimed;
  double rr_share = 1;
  if (!options.frame_times_s.empty()) {
    give_times(candidate, options, retimed);
  } else if (options.rr_interval_s > 0) {
    rr_share = give_rr(candidate, options.rr_interval_s, retimed);
  }
  const Slices found = candidate.slices;
  const double rr_s = mean_rr_s(candidate, options);
  drop_incomplete(candidate, rr_s, decisions);
  drop_elsewhere(candidate, images, decisions);
  std::vector<double> positions;
  positions.reserve(candidate.slices.size());
  for (const auto& [place, set] : candidate.slices) positions.push_back(place->along_mm);
  EvenStack even;
  try {
    even = find_even_stack(positions, spacing);
  } catch (const Error& uneven) {
    const Error error(uneven.code(), uneven.what() + hole_told(candidate.slices, found));
    const std::size_t left = found.size() - positions.size();
    if (left == 0) throw error;
    throw error.with_context("without the " + counted(left, "slice that is", "slices that are") +
                             " incomplete or of another region");
  }

  ChosenCine out;
  std::set<int> series;
  for (const int member : even.members) {
    out.slices.push_back(*candidate.slices[static_cast<std::size_t>(member)].second);
    series.insert(out.slices.back().series_number);
  }
  const Plane& plane = *candidate.plane;
  const Vec3 normal = plane.normal_lps();
  const auto own = std::find_if(candidate.slices.begin(), candidate.slices.end(),
                                [](const auto& slice) { return !slice.first->guest; });
  const Vec3 anchor = own == candidate.slices.end() ? plane.first_lps : own->first->position_lps;
  const Vec3 first = anchor + normal * (even.first_mm - normal.dot(anchor));
  const auto slices = static_cast<int>(out.slices.size());
  out.numbers = even.numbers;
  out.first_mm = even.first_mm;
  out.grid = lattice_of(plane, first, even.spacing_mm, even.numbers.back() + 1);
  out.rr_s = mean_rr_s(out.slices, rr_s);
  out.rr_share = rr_share;

  decisions.push_back(
      "The stack is made of " + std::to_string(slices) + " parallel slices of " +
      std::to_string(candidate.phases) + " phases, " + with_digits("%.2f", even.spacing_mm) +
      " mm apart, " + std::to_string(plane.columns) + " x " + std::to_string(plane.rows) +
      " pixels of " + with_digits("%.3f", plane.column_step_mm) + " x " +
      with_digits("%.3f", plane.row_step_mm) + " mm (" + series_list(series) + ").");
  if (even.worst_gap > kNotedUneven) {
    decisions.push_back("Warning: the gaps between slices differ from their median by up to " +
                        with_digits("%.1f", 100 * even.worst_gap) +
                        " %; the slices were placed evenly, " +
                        with_digits("%.2f", even.spacing_mm) + " mm apart, and lie up to " +
                        with_digits("%.1f", even.worst_off_mm) + " mm off.");
  }
  tell_holes(out, decisions);
  tell_resampled(out, images, decisions);
  const std::size_t left = positions.size() - even.members.size();
  if (left > 0) {
    decisions.push_back("Warning: " + counted(left, "parallel slice does", "parallel slices do") +
                        " not continue the even spacing of the stack and " +
                        (left == 1 ? "was" : "were") + " left.");
  }
  return out;
}

[[noreturn]] void no_stack(const std::vector<Plane>& planes,
                           const std::vector<DicomImage>& images) {
  if (std::none_of(images.begin(), images.end(), [](const auto& i) { return i.magnitude; })) {
    throw_invalid("there are phase (velocity) images only: export the magnitude images too");
  }
  std::size_t most = 0;
  bool any_cine = false;
  int images_of_place = 0;
  for (const Plane& plane : planes) {
    std::size_t cines = 0;
    for (const Place& place : plane.places) {
      cines += place.cines.empty() ? 0 : 1;
      images_of_place = std::max(images_of_place, place.images);
    }
    any_cine = any_cine || cines > 0;
    most = std::max(most, cines);
  }
  if (!any_cine && images_of_place >= kLeastFramesToBlend) {
    throw_invalid(
        "there are up to " + std::to_string(images_of_place) +
        " images of a slice, but nothing tells their order in time: export them with their trigger "
        "times, or at least with their InstanceNumber");
  }
  if (!any_cine) {
    throw_invalid("there is only one phase of each slice: a cine with several phases is needed");
  }
  throw_invalid("there is no stack: at most " +
                counted(most, "parallel slice has", "parallel slices have") +
                " several phases, at least " + std::to_string(kLeastSlices) + " are needed");
}

/// The candidate that was asked for alone; else the best and others of its plane (one series may do
/// where the union of all does not).
std::vector<std::size_t> of_first_plane(const std::vector<Candidate>& candidates, std::size_t first,
                                        bool asked) {
  if (asked) return {first};
  std::vector<std::size_t> out;
  for (std::size_t i = first; i < candidates.size(); ++i) {
    if (candidates[i].plane == candidates[first].plane) out.push_back(i);
  }
  return out;
}

/// Candidates of other planes that are as good in kind; none where one was asked for.
std::vector<std::size_t> of_other_planes(const std::vector<Candidate>& candidates,
                                         std::size_t first, bool asked) {
  std::vector<std::size_t> out;
  if (asked) return out;
  const Candidate& best = candidates[first];
  for (std::size_t i = first; i < candidates.size(); ++i) {
    const Candidate& candidate = candidates[i];
    if (candidate.plane != best.plane && candidate.ordinary == best.ordinary &&
        candidate.good == best.good) {
      out.push_back(i);
    }
  }
  return out;
}

/// Possible stacks, of which one after the other is tried until one can be built.
struct Trials {
  const std::vector<DicomImage>& images;
  const IngestOptions& options;
  const Stacks& stacks;
  std::vector<Candidate> wholes;  ///< gathered of several fields of view
  std::size_t first = 0;          ///< the candidate that is tried first
  Spacing spacing = Spacing::Even;
  std::optional<Error> why_not = {};  ///< of the first candidate that failed

  /// Stacks that were left and could have been meant as well.
  void tell_rivals(std::size_t taken, std::vector<std::string>& decisions) const {
    for (const std::string& rival :
         {other_axis_told(stacks.candidates, taken), other_rate_told(stacks.candidates, taken)}) {
      if (!rival.empty()) decisions.push_back(rival);
    }
  }
  /// @param i the candidate's number for which it stands
  std::optional<Choice> one(const Candidate& candidate, std::size_t i,
                            std::optional<Error>& failed) const {
    Choice choice;
    if (!stacks.frames_told.empty()) choice.decisions.push_back(stacks.frames_told);
    choice.decisions.push_back(listed(stacks.candidates, i, options.stack > 0));
    std::vector<std::string> timing;
    try {
      choice.stack = build(candidate, images, options, spacing, choice.decisions);
      tell_timing(choice.stack, candidate.phases, timing);
    } catch (const Error& error) {
      if (!failed) failed = error;
      return {};
    }
    if (i != first) {
      choice.decisions.push_back(
          "Warning: possible stack " + std::to_string(first + 1) +
          " was passed over: " + (why_not ? why_not->what() : "more slices would be left") + '.');
    }
    choice.phases = options.phases > 0 ? options.phases : candidate.phases;
    choice.decisions.insert(choice.decisions.end(), timing.begin(), timing.end());
    if (options.stack == 0) tell_rivals(i, choice.decisions);
    if (candidate.mixed) choice.decisions.push_back(mixed_told());
    choose_views(stacks.planes, *candidate.plane, candidate.good, options, choice);
    return choice;
  }
  /// The i-th candidate with slices that other fields of view hold; else as it is.
  std::optional<Choice> one_completed(std::size_t i) {
    std::optional<Error> ignored;
    for (const Candidate& whole : wholes) {
      if (!acquired_among(stacks.candidates[i], whole)) continue;
      if (auto choice = one(whole, i, ignored)) return choice;
    }
    if (const auto whole = completed(stacks.candidates[i], images)) {
      if (auto choice = one(*whole, i, ignored)) return choice;
    }
    return one(stacks.candidates[i], i, why_not);
  }
};

/// Slices of a candidate that lie beyond the ends of a stack of its plane.
struct Beyond {
  std::size_t before = 0;  ///< the first slice
  std::size_t behind = 0;  ///< the last one

  Beyond(const Candidate& candidate, const ChosenCine& stack) {
    const double spacing_mm = stack.grid.spacing_mm()[2];
    const double last_mm = stack.first_mm + spacing_mm * (stack.grid.size[2] - 1);
    const double seen_mm = (0.5 + kMostUneven) * spacing_mm;  // by the outermost slice
    for (const auto& [place, set] : candidate.slices) {
      before += place->along_mm < stack.first_mm - seen_mm ? 1 : 0;
      behind += place->along_mm > last_mm + seen_mm ? 1 : 0;
    }
  }
  [[nodiscard]] std::size_t count() const { return before + behind; }
  [[nodiscard]] std::string told(int last) const {
    std::string where = before > 0 ? std::to_string(before) + " before slice 0" : "";
    if (behind > 0) {
      where += (where.empty() ? "" : ", ") + std::to_string(behind) + " behind slice ";
      where += std::to_string(last);
    }
    return "Warning: " + counted(count(), "parallel slice lies", "parallel slices lie") +
           " beyond the ends of the stack and " + (count() == 1 ? "was" : "were") + " left (" +
           where + "): look whether the heart goes on there.";
  }
};

/// Of the stacks that can be built of some candidates of a plane the one beyond whose ends fewest
/// slices of the first of them lie, for a part of a heart looks like a whole one that is small; of
/// these an even one before a loose one, that before one with holes and strays.
/// @return none if a third of the slices and more would be lost, or nothing can be built
std::optional<Choice> best_of_plane(Trials& trials, const std::vector<std::size_t>& candidates) {
  const Candidate& whole = trials.stacks.candidates[candidates.front()];
  std::optional<Choice> best;
  std::size_t least = whole.slices.size();
  std::size_t number = 0;
  for (const Spacing spacing : {Spacing::Even, Spacing::Loose, Spacing::WithHoles}) {
    trials.spacing = spacing;
    for (const std::size_t i : candidates) {
      auto choice = trials.one_completed(i);
      if (!choice) continue;
      const std::size_t beyond = Beyond(whole, choice->stack).count();
      if (best && beyond >= least) continue;
      best = std::move(choice);
      least = beyond;
      number = i + 1;
      if (beyond == 0) return best;
    }
  }
  if (!best) return {};
  if (3 * least >= whole.slices.size()) {
    const std::string why = trials.why_not ? trials.why_not->what() : "it has no even spacing";
    trials.why_not =
        Error(ErrorCode::InvalidInput, why + "; a part of it can be taken with --stack " +
                                           std::to_string(number) + ", beyond which lie " +
                                           std::to_string(least) + " of its slices");
    return {};
  }
  best->decisions.push_back(Beyond(whole, best->stack).told(best->stack.grid.size[2] - 1));
  return best;
}

}  // namespace

Choice choose_stack(const std::vector<DicomImage>& images, const IngestOptions& options,
                    const ImageFiles& files) {
  ImageFiles asked = files;
  asked.given_rr_s = options.rr_interval_s;
  const Stacks stacks = find_stacks(images, asked);
  const std::vector<Plane>& planes = stacks.planes;
  const std::vector<Candidate>& candidates = stacks.candidates;
  if (candidates.empty()) no_stack(planes, images);
  if (options.stack > static_cast<int>(candidates.size())) {
    throw_invalid("there is no stack " + std::to_string(options.stack) +
                  " (--stack): " + listed(candidates, candidates.size(), false));
  }
  const std::size_t first = options.stack > 0 ? static_cast<std::size_t>(options.stack) - 1 : 0;
  const bool one_asked = options.stack > 0;
  Trials trials{images, options, stacks, gathered(planes, false), first};
  if (auto choice = best_of_plane(trials, of_first_plane(candidates, first, one_asked))) {
    return *std::move(choice);
  }
  trials.spacing = Spacing::Even;
  for (const std::size_t i : of_other_planes(candidates, first, one_asked)) {
    if (auto choice = trials.one_completed(i)) return *std::move(choice);
  }
  if (one_asked) throw Error(*trials.why_not);
  for (const Candidate& whole : trials.wholes) {
    std::optional<Error> ignored;
    if (auto choice = trials.one(whole, candidates.size(), ignored)) return *std::move(choice);
  }
  if (candidates.size() == 1) throw Error(*trials.why_not);
  throw_invalid(std::string(trials.why_not->what()) +
                "; choose another with --stack or --series. " +
                listed(candidates, candidates.size(), false, kListedInErrors));
}

}  // namespace beatlas::ingest
