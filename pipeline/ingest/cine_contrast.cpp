#include "pipeline/ingest/cine_contrast.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <tuple>

#include "pipeline/ingest/heart_axis.h"

namespace beatlas::ingest {
namespace {

/// A contrast and at how many places of each direction there are cines of its protocol.
struct Tally {
  Contrast contrast;
  std::map<std::size_t, std::size_t> places;  ///< by direction
};

bool counts(const ImageSet& set, bool secondary) {
  return set.ordinary() && (set.provenance == Provenance::Secondary) == secondary;
}

/// Of each plane the first that has its direction.
std::vector<std::size_t> directions_of(const std::vector<Plane>& planes) {
  std::vector<std::size_t> out;
  for (const Plane& plane : planes) {
    const auto first = std::find_if(planes.begin(), planes.end(), [&](const Plane& other) {
      return one_direction(other, plane);
    });
    out.push_back(static_cast<std::size_t>(first - planes.begin()));
  }
  return out;
}

std::vector<Tally> tallies_of(const std::vector<Plane>& planes, bool secondary) {
  std::vector<Tally> out;
  for (const Plane& plane : planes) {
    for (const Place& place : plane.places) {
      for (const ImageSet& set : place.cines) {
        const bool known = std::any_of(out.begin(), out.end(), [&](const Tally& tally) {
          return same_contrast(tally.contrast, set.contrast);
        });
        if (counts(set, secondary) && !known) out.push_back({set.contrast, {}});
      }
    }
  }
  const std::vector<std::size_t> directions = directions_of(planes);
  for (Tally& tally : out) {
    for (std::size_t p = 0; p < planes.size(); ++p) {
      for (const Place& place : planes[p].places) {
        const bool has =
            std::any_of(place.cines.begin(), place.cines.end(), [&](const ImageSet& set) {
              return counts(set, secondary) && one_protocol(tally.contrast, set.contrast);
            });
        if (has) ++tally.places[directions[p]];
      }
    }
  }
  return out;
}

/// Whether a contrast has a stack that is no addition to a larger one of another.
bool has_stack(const Tally& tally, const std::vector<Tally>& all) {
  const auto [direction, own] =
      *std::max_element(tally.places.begin(), tally.places.end(),
                        [](const auto& a, const auto& b) { return a.second < b.second; });
  std::size_t most = own;
  for (const Tally& other : all) {
    const auto found = other.places.find(direction);
    if (found != other.places.end()) most = std::max(most, found->second);
  }
  return own > kMostSlicesOfView && 3 * own >= 2 * most;
}

auto worth(const Tally& tally) {
  std::size_t sum = 0;
  for (const auto& [direction, count] : tally.places) sum += count;
  return std::make_tuple(tally.places.size(), sum, !is_spoiled(tally.contrast));
}

}  // namespace

std::optional<Contrast> contrast_of_cines(const std::vector<Plane>& planes) {
  std::vector<Tally> all = tallies_of(planes, false);
  if (all.empty()) all = tallies_of(planes, true);
  std::vector<Tally> able;
  std::copy_if(all.begin(), all.end(), std::back_inserter(able),
               [&](const Tally& tally) { return has_stack(tally, all); });
  if (able.empty()) return {};
  const auto best = std::max_element(
      able.begin(), able.end(), [](const Tally& a, const Tally& b) { return worth(a) < worth(b); });
  const bool equal = std::any_of(able.begin(), able.end(), [&](const Tally& other) {
    return worth(other) == worth(*best) && !one_protocol(other.contrast, best->contrast);
  });
  if (equal) return {};
  return best->contrast;
}

}  // namespace beatlas::ingest
