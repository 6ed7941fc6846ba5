#include "pipeline/ingest/guest_slices.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include "pipeline/ingest/even_positions.h"
#include "pipeline/ingest/slice_resampling.h"

namespace beatlas::ingest {
namespace {

using Slice = std::pair<const Place*, const ImageSet*>;

bool less_along(const Slice& a, const Slice& b) { return a.first->along_mm < b.first->along_mm; }

/// Originals first, then most frames, then the later series.
bool better(const Slice& a, const Slice& b) {
  const auto rank = [](const Slice& slice) {
    return std::make_tuple(slice.second->provenance, slice.second->frames(),
                           slice.second->series_number);
  };
  return rank(a) > rank(b);
}

double nearest_mm(const std::vector<Slice>& slices, double along_mm) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [place, set] : slices) {
    nearest = std::min(nearest, std::abs(place->along_mm - along_mm));
  }
  return nearest;
}

/// The set of a place that could be a slice of a candidate; null if none.
const ImageSet* like_those_of(const Place& guest, const Candidate& own) {
  const ImageSet& first = *own.slices.front().second;
  for (const ImageSet& set : guest.cines) {
    if (set.ordinary() && set.timing.by_trigger == first.timing.by_trigger &&
        same_rate(set.timing.rr_s, own.rr_s) && 2 * set.frames() >= own.phases &&
        same_contrast(first, set)) {
      return &set;
    }
  }
  return nullptr;
}

/// Guests that could be slices of a candidate, best first.
std::vector<Slice> fitting(const Candidate& own, const std::vector<DicomImage>& images) {
  std::vector<Slice> out;
  const Grid field = lattice_of(*own.plane, own.plane->first_lps, 1, 1);
  for (const Place& guest : own.plane->guests) {
    const ImageSet* set = like_those_of(guest, own);
    if (set == nullptr) continue;
    const DicomImage& image = images[static_cast<std::size_t>(set->images.front())];
    if (SliceResampling(image, field, 0).shows_middle()) out.emplace_back(&guest, set);
  }
  std::stable_sort(out.begin(), out.end(), better);
  return out;
}

int most_frames(const std::vector<Slice>& some, const std::vector<Slice>& others) {
  int most = 0;
  for (const std::vector<Slice>* slices : {&some, &others}) {
    for (const auto& [place, set] : *slices) most = std::max(most, set->frames());
  }
  return most;
}

/// The contrasts of the ordinary cines of a plane, one set for each.
std::vector<const ImageSet*> contrasts_of(const Plane& plane) {
  std::vector<const ImageSet*> out;
  for (const Place& place : plane.places) {
    for (const ImageSet& set : place.cines) {
      const bool known = std::any_of(out.begin(), out.end(),
                                     [&](const ImageSet* one) { return same_contrast(*one, set); });
      if (set.ordinary() && !known) out.push_back(&set);
    }
  }
  return out;
}

/// Slices of a contrast at some places, the best of each.
std::vector<Slice> slices_of(const std::vector<Place>& places, const ImageSet& contrast) {
  std::vector<Slice> out;
  for (const Place& place : places) {
    const auto found = std::find_if(
        place.cines.begin(), place.cines.end(),
        [&](const ImageSet& set) { return set.ordinary() && same_contrast(contrast, set); });
    if (found != place.cines.end()) out.emplace_back(&place, &*found);
  }
  return out;
}

/// Whether of the planes that are nearly parallel this one has most slices of a contrast, of as
/// many it is the first.
bool leads(const Plane& plane, const std::vector<Plane>& planes, const ImageSet& contrast) {
  const std::size_t own = slices_of(plane.places, contrast).size();
  return std::all_of(planes.begin(), planes.end(), [&](const Plane& other) {
    if (&other == &plane || !could_be_one_stack(plane, other)) return true;
    const std::size_t count = slices_of(other.places, contrast).size();
    return count < own || (count == own && &plane < &other);
  });
}

}  // namespace

std::optional<Candidate> completed(const Candidate& candidate,
                                   const std::vector<DicomImage>& images) {
  if (!candidate.ordinary || !candidate.uniform) return {};
  const double step_mm = candidate.spacing_mm;
  if (step_mm <= kSamePlaceMm) return {};
  Candidate out = candidate;
  const auto is_poor = [&](const Slice& slice) {
    return 2 * slice.second->frames() < candidate.phases;
  };
  std::erase_if(out.slices, is_poor);
  std::vector<Slice> guests = fitting(candidate, images);
  bool more = false;
  for (auto next = guests.begin(); next != guests.end();) {
    const double off = std::abs(nearest_mm(out.slices, next->first->along_mm) - step_mm);
    if (off <= kMostUneven * step_mm) {
      out.slices.push_back(*next);
      more = true;
      guests.erase(next);
      next = guests.begin();  // one that lay too far may be next to it
    } else {
      ++next;
    }
  }
  if (!more) return {};
  for (const Slice& slice : candidate.slices) {
    if (is_poor(slice) && nearest_mm(out.slices, slice.first->along_mm) > 0.5 * step_mm) {
      out.slices.push_back(slice);
    }
  }
  std::stable_sort(out.slices.begin(), out.slices.end(), less_along);
  finish(out);
  return out;
}

std::vector<Candidate> gathered(const std::vector<Plane>& planes, bool without_stack) {
  std::vector<Candidate> out;
  for (const Plane& plane : planes) {
    if (plane.guests.empty()) continue;
    for (const ImageSet* contrast : contrasts_of(plane)) {
      Candidate candidate;
      candidate.plane = &plane;
      candidate.one_field = false;
      candidate.slices = slices_of(plane.places, *contrast);
      if (without_stack && candidate.slices.size() >= kLeastSlices) continue;
      if (!leads(plane, planes, *contrast)) continue;
      std::vector<Slice> guests = slices_of(plane.guests, *contrast);
      // A slice of its own that was broken off counts where no other is.
      const int most = most_frames(candidate.slices, guests);
      const auto poor = std::stable_partition(
          candidate.slices.begin(), candidate.slices.end(),
          [&](const Slice& slice) { return 2 * slice.second->frames() >= most; });
      guests.insert(guests.end(), poor, candidate.slices.end());
      candidate.slices.erase(poor, candidate.slices.end());
      std::stable_sort(guests.begin(), guests.end(), better);
      for (const Slice& guest : guests) {
        if (nearest_mm(candidate.slices, guest.first->along_mm) > kSamePlaceMm) {
          candidate.slices.push_back(guest);
        }
      }
      if (candidate.slices.size() < kLeastSlices) continue;
      std::stable_sort(candidate.slices.begin(), candidate.slices.end(), less_along);
      finish(candidate);
      out.push_back(std::move(candidate));
    }
  }
  return out;
}

bool acquired_among(const Candidate& part, const Candidate& whole) {
  std::set<std::vector<int>> own;  // Guests are copies of sets, of the same images.
  for (const auto& [place, set] : part.slices) own.insert(set->images);
  std::vector<std::pair<int, bool>> in_time;  // series, whether it is of the part
  for (const auto& [place, set] : whole.slices) {
    in_time.emplace_back(set->series_number, own.count(set->images) > 0);
  }
  std::sort(in_time.begin(), in_time.end());
  const auto held =
      std::count_if(in_time.begin(), in_time.end(), [](const auto& slice) { return slice.second; });
  const auto others = static_cast<std::ptrdiff_t>(in_time.size()) - held;
  std::ptrdiff_t changes = 0;
  for (std::size_t i = 1; i < in_time.size(); ++i) {
    changes += in_time[i].second != in_time[i - 1].second ? 1 : 0;
  }
  // One acquisition amid another or behind it changes once or twice.
  return held == static_cast<std::ptrdiff_t>(own.size()) && changes > 2 &&
         changes >= std::min(held, others);
}

}  // namespace beatlas::ingest
