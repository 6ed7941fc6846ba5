#include "pipeline/assess/palpation_set.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "runtime/base/error.h"

namespace beatlas::assess {
namespace {

constexpr double kTicksPerSecond = 1000;
constexpr double kSpacingMm = 4;  // between points among which places are chosen
constexpr double kClearMm = 1e-3;
constexpr double kSlideMm = 10;
constexpr double kGoldenAngle = 2.399963229728653;  // turns directions of slides evenly

struct Place {
  Vec3 at;
  Vec3 outward;
};

void check(const PalpationOptions& options) {
  const auto demand = [](bool good, const char* name, const char* range) {
    if (!good) throw_invalid(std::string(name) + " must be " + range);
  };
  demand(options.places >= 1 && options.places <= 1000, "places", "from 1 to 1000");
  demand(options.depth_mm >= 0 && options.depth_mm <= 15, "depth_mm", "from 0 to 15 mm");
  demand(options.finger_mm > 0 && options.finger_mm <= 50, "finger_mm", "above 0, to 50 mm");
  demand(options.crease_mm >= 0, "crease_mm", "0 or more");
  demand(options.cycles >= 1 && options.cycles <= 20, "cycles", "from 1 to 20");
}

std::vector<Place> reachable_places(const phantom::Frame& frame, const PalpationOptions& options) {
  std::vector<Place> out;
  for (const Vec3& at : frame.sample_surface(options.structure, kSpacingMm)) {
    if (frame.crease_distance_mm(options.structure, at) < options.crease_mm) continue;
    const Vec3 outward = frame.nearest(options.structure, at).outward;
    const double clear = frame.distance_mm(options.structure, at + options.finger_mm * outward);
    if (clear >= options.finger_mm - kClearMm) out.push_back({at, outward});
  }
  return out;
}

/// Farthest first, from the one farthest from the centroid.
std::vector<Place> spread(const std::vector<Place>& places, int count) {
  Vec3 centroid = Vec3::Zero();
  for (const Place& place : places) centroid += place.at / static_cast<double>(places.size());
  std::vector<double> gap(places.size());
  std::transform(places.begin(), places.end(), gap.begin(),
                 [&](const Place& place) { return (place.at - centroid).norm(); });
  std::vector<Place> out;
  while (static_cast<int>(out.size()) < count) {
    const auto farthest = std::max_element(gap.begin(), gap.end());
    if (!(*farthest > 0.0)) break;
    const Place next = places[static_cast<std::size_t>(farthest - gap.begin())];
    if (out.empty()) std::fill(gap.begin(), gap.end(), std::numeric_limits<double>::infinity());
    out.push_back(next);
    for (std::size_t n = 0; n < places.size(); ++n) {
      gap[n] = std::min(gap[n], (places[n].at - next.at).norm());
    }
  }
  return out;
}

/// A unit vector across `outward`, turned by `angle` about it.
Vec3 across(const Vec3& outward, double angle) {
  const Vec3 u = outward.unitOrthogonal();
  return std::cos(angle) * u + std::sin(angle) * outward.cross(u);
}

Vec3 position(const Place& place, std::size_t index, Touch touch, double t_s, double depth_mm) {
  const auto third = static_cast<double>(index % 3);
  switch (touch) {
    case Touch::Press: {
      const double turn = 2.0 * std::numbers::pi * (1.0 + third) * t_s;
      return place.at - 0.5 * depth_mm * (1.0 - std::cos(turn)) * place.outward;
    }
    case Touch::Hold:
      return place.at - 0.25 * (1.0 + third) * depth_mm * place.outward;
    case Touch::Slide: {
      const double along = kSlideMm * std::sin(2.0 * std::numbers::pi * t_s);
      return place.at - 0.375 * depth_mm * place.outward +
             along * across(place.outward, kGoldenAngle * static_cast<double>(index));
    }
  }
  return place.at;
}

}  // namespace

PalpationSet palpation_set(const phantom::Phantom& phantom, const PalpationOptions& options) {
  check(options);
  const double rr_s = phantom.spec().rr_interval_s;
  const std::vector<Place> places =
      spread(reachable_places(*phantom.frame(0.0), options), options.places);
  if (places.empty()) {
    throw_invalid("no place on " + std::string(structure_name(options.structure)) +
                  " can be reached by a finger of " + std::to_string(options.finger_mm) +
                  " mm; choose a thinner one or another structure");
  }
  PalpationSet out;
  out.structure = options.structure;
  out.ticks_per_beat = static_cast<int>(std::lround(rr_s * kTicksPerSecond));
  out.tick_s = rr_s / out.ticks_per_beat;
  for (std::size_t n = 0; n < places.size(); ++n) {
    for (const Touch touch : {Touch::Press, Touch::Hold, Touch::Slide}) {
      Trajectory path{touch, {}};
      for (int tick = 0; tick < options.cycles * out.ticks_per_beat; ++tick) {
        path.at_lps.push_back(position(places[n], n, touch, tick * out.tick_s, options.depth_mm));
      }
      out.trajectories.push_back(std::move(path));
    }
  }
  return out;
}

}  // namespace beatlas::assess
