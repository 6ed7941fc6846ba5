#include "pipeline/ingest/view_choice.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "pipeline/ingest/heart_axis.h"
#include "pipeline/ingest/phase_resampling.h"
#include "pipeline/ingest/series_list.h"
#include "pipeline/ingest/stack_candidates.h"

namespace beatlas::ingest {
namespace {

/// What becomes neither part of the stack nor a view, and views that the given times do not fit.
struct LeftOut {
  std::set<int> of_frames;     ///< series of other frames of reference than the stack's
  std::size_t parallel = 0;    ///< cines of them that are parallel to the stack
  std::set<int> cines;         ///< their series
  std::size_t own_times = 0;   ///< views of another number of frames than times were given
  std::size_t incomplete = 0;  ///< slices parallel to the stack that are no cine
  std::size_t stills = 0;      ///< images of other slices that are none
};

/// Notes a place without a cine, and cines that the best one of their place outdoes.
/// @param used images of the stack
void note_left(const Place& place, bool parallel_to_stack, const std::set<int>& used,
               LeftOut& left) {
  if (place.cines.empty()) {
    if (parallel_to_stack) {
      ++left.incomplete;
    } else {
      left.stills += static_cast<std::size_t>(place.images);
    }
    return;
  }
  for (std::size_t n = 1; n < place.cines.size(); ++n) {
    const ImageSet& other = place.cines[n];
    if (used.count(other.images.front()) == 0) left.cines.insert(other.series_number);
  }
}

/// @param good of the stack: it has trigger times, and frames enough to blend
bool usable_as_view(const ImageSet& set, bool all_many_beats, bool good) {
  // Trigger times of a clock that runs on make every cine look like perfusion.
  return !set.timing.beat_unknown && (set.ordinary() || (all_many_beats && !set.flow)) &&
         (!good || (set.timing.by_trigger && set.frames() >= kLeastFramesToBlend));
}

/// Notes cines of another frame of reference than the stack's.
void note_other_frame(const Place& place, const Plane& plane, const Plane& stack_plane,
                      LeftOut& left) {
  for (const ImageSet& set : place.cines) left.of_frames.insert(set.series_number);
  left.parallel += !place.cines.empty() && nearly_parallel(plane, stack_plane) ? 1 : 0;
}

/// Secondary copies and cines of another contrast than the exam's are views only where no better
/// cine was planned in their direction.
bool outdone(const Plane& plane, const std::vector<Plane>& planes) {
  const auto worth = [](const Plane& one) {
    std::pair<bool, bool> most{false, false};
    for (const Place& place : one.places) {
      if (place.cines.empty() || !place.cines.front().ordinary()) continue;
      const ImageSet& set = place.cines.front();
      most = std::max(most, {!set.secondary(), set.usual});
    }
    return most;
  };
  return std::any_of(planes.begin(), planes.end(), [&](const Plane& other) {
    return same_frame(plane.frame, other.frame) && one_direction(plane, other) &&
           worth(other) > worth(plane);
  });
}

/// The best cine of a place, timed as the stack is.
/// @param own_times counts views of another number of frames than times were given
ChosenCine view_of(const Plane& plane, const Place& place, const IngestOptions& options,
                   const ChosenCine& stack, std::size_t& own_times) {
  const ImageSet& set = place.cines.front();
  ChosenCine view;
  const double depth = plane.thickness_mm > 0 ? plane.thickness_mm : plane.column_step_mm;
  view.grid = lattice_of(plane, place.position_lps, depth, 1);
  view.slices.push_back(set);
  view.numbers.push_back(0);
  SliceTiming& timing = view.slices.front().timing;
  if (options.frame_times_s.size() == set.images.size()) {
    timing = with_times(timing, options.frame_times_s, options.rr_interval_s);
  } else {
    timing = with_rr(timing, timing.rr_s * stack.rr_share).value_or(timing);
    own_times += options.frame_times_s.empty() ? 0 : 1;
  }
  view.rr_s = timing.rr_s > 0 ? timing.rr_s : stack.rr_s;
  return view;
}

void tell_other_frames(const LeftOut& left, Choice& choice) {
  if (left.of_frames.empty()) return;
  const bool one = left.of_frames.size() == 1;
  std::string out = "Warning: " + series_list(left.of_frames) + (one ? " names" : " name");
  out += " another frame of reference than the stack, as if the patient had been moved, and ";
  out += one ? "was left" : "were left";
  if (left.parallel > 0) {
    out += ", with " + counted(left.parallel, "slice that is", "slices that are");
    out += " parallel to it: see whether the stack is whole, or choose with --series";
  }
  choice.decisions.push_back(out + '.');
}

void tell_views(const LeftOut& left, Choice& choice) {
  if (!choice.views.empty()) {
    std::set<int> numbers;
    for (const ChosenCine& view : choice.views) numbers.insert(view.slices.front().series_number);
    choice.decisions.push_back(
        counted(choice.views.size(), "other cine view is", "other cine views are") +
        " kept beside the stack (" + series_list(numbers) + ").");
  }
  if (!left.cines.empty()) {
    choice.decisions.push_back(
        "Left: cines that are neither part of the stack nor a view of one or "
        "two slices, or that another cine of the same place outdoes (" +
        series_list(left.cines) + ").");
  }
  tell_other_frames(left, choice);
  if (left.own_times > 0) {
    choice.decisions.push_back(counted(left.own_times, "view has", "views have") +
                               " another number of frames than times were given and " +
                               (left.own_times == 1 ? "keeps its own." : "keep their own."));
  }
  if (left.incomplete > 0) {
    choice.decisions.push_back("Warning: " +
                               counted(left.incomplete, "slice parallel to the stack has",
                                       "slices parallel to the stack have") +
                               " one phase only or no order in time and " +
                               (left.incomplete == 1 ? "was" : "were") + " left.");
  }
  if (left.stills > 0) {
    choice.decisions.push_back("Left: " + counted(left.stills, "image", "images") +
                               " of slices that have one phase only or no order in time.");
  }
}

/// What was taken though it is no original.
void tell_provenance(Choice& choice) {
  std::map<Provenance, std::set<int>> series;
  const auto add = [&](const ChosenCine& cine) {
    for (const ImageSet& set : cine.slices) series[set.provenance].insert(set.series_number);
  };
  add(choice.stack);
  for (const ChosenCine& view : choice.views) add(view);
  const auto tell = [&](Provenance provenance, const std::string& what) {
    const auto found = series.find(provenance);
    if (found == series.end()) return;
    choice.decisions.push_back("Warning: there are no originals of " + series_list(found->second) +
                               ", which " + what +
                               "; export the original images too, if there are any.");
  };
  tell(Provenance::Secondary,
       "are secondary copies and may have been drawn on (ImageType, BurnedInAnnotation)");
  tell(Provenance::Derived, "were calculated from other images (ImageType DERIVED)");
}

}  // namespace

void choose_views(const std::vector<Plane>& planes, const Plane& stack_plane, bool good,
                  const IngestOptions& options, Choice& choice) {
  const std::vector<ImageSet>& slices = choice.stack.slices;
  std::set<int> used;
  for (const ImageSet& set : slices) used.insert(set.images.begin(), set.images.end());
  LeftOut left;
  const bool all_many_beats = std::all_of(slices.begin(), slices.end(), [](const ImageSet& set) {
    return set.timing.many_beats && !set.flow;
  });
  for (const Plane& plane : planes) {
    int cines = 0;
    for (const Place& place : plane.places) cines += place.cines.empty() ? 0 : 1;
    if (!same_frame(plane.frame, stack_plane.frame)) {
      for (const Place& place : plane.places) note_other_frame(place, plane, stack_plane, left);
      continue;
    }
    for (const Place& place : plane.places) {
      note_left(place, same_pixels(plane, stack_plane), used, left);
      if (place.cines.empty()) continue;
      const ImageSet& set = place.cines.front();
      if (used.count(set.images.front()) > 0) continue;
      if (nearly_parallel(plane, stack_plane) || cines > kMostSlicesOfView ||
          !usable_as_view(set, all_many_beats, good) || outdone(plane, planes)) {
        left.cines.insert(set.series_number);
        continue;
      }
      choice.views.push_back(view_of(plane, place, options, choice.stack, left.own_times));
    }
  }
  std::stable_sort(choice.views.begin(), choice.views.end(),
                   [](const ChosenCine& a, const ChosenCine& b) {
                     return a.slices.front().series_number < b.slices.front().series_number;
                   });
  tell_views(left, choice);
  tell_provenance(choice);
}

}  // namespace beatlas::ingest
