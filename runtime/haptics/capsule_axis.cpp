#include "runtime/haptics/capsule_axis.h"

#include <algorithm>
#include <cmath>

namespace beatlas::haptics {
namespace {

constexpr int kRefinements = 8;
constexpr double kLevel = 2e-4;  // slope along the axis: how far off across it the normal may be
constexpr int kPanels = 16;

struct Place {
  double share = 0;
  FieldSample sample;
};

}  // namespace

NearestOnAxis nearest_on_axis(const ContactField& field, const CapsuleAxis& axis, double t,
                              double steepest) noexcept {
  const double half = axis.half_mm.norm();
  if (half == 0) return {field.sample(axis.middle_mm, t), 0};
  const Vec3 along = axis.half_mm / half;
  const double shortest = field.resolution_mm() / half;
  Place best{-1, field.sample(axis.at(-1), t)};
  Place before = best;  // neighbours of the best
  Place after = best;
  Place last = best;
  while (last.share < 1) {
    const double room = last.sample.distance_mm - best.sample.distance_mm;
    const double step = std::max(shortest, room / (steepest * half));
    double share = last.share + step;
    if (share > 1 - 0.01 * shortest) share = 1;  // a neighbour at the same place would be none
    const Place next{share, field.sample(axis.at(share), t)};
    if (next.sample.distance_mm < best.sample.distance_mm) {
      before = last;
      best = next;
      after = next;
    } else if (after.share == best.share) {
      after = next;
    }
    last = next;
  }
  // Between the best and the neighbour to which the distance falls: where the slope is zero, by
  // regula falsi with an end's slope halved when it stays (Illinois).
  const auto slope = [&](const Place& place) { return place.sample.gradient.dot(along); };
  double from = best.share;
  double from_slope = slope(best);
  const Place& beside = from_slope < 0 ? after : before;
  double to = beside.share;
  double to_slope = slope(beside);
  for (int n = 0; n < kRefinements && from != to && from_slope * to_slope < 0; ++n) {
    const double share = from + (to - from) * from_slope / (from_slope - to_slope);
    const Place next{share, field.sample(axis.at(share), t)};
    if (next.sample.distance_mm < best.sample.distance_mm) best = next;
    const double next_slope = slope(next);
    if (std::abs(next_slope) < kLevel) break;
    if (next_slope * to_slope < 0) {
      from = to;
      from_slope = to_slope;
    } else {
      from_slope *= 0.5;
    }
    to = share;
    to_slope = next_slope;
  }
  return {best.sample, best.share};
}

double pressed_share(const ContactField& field, const CapsuleAxis& axis, double radius_mm,
                     double depth_mm, double t) noexcept {
  double area = 0;
  double moment = 0;
  double from = 0;
  for (int n = 0; n <= kPanels; ++n) {
    const double share = -1 + 2.0 * n / kPanels;
    const double to = depth_mm + radius_mm - field.sample(axis.at(share), t).distance_mm;
    if (n > 0 && (from > 0 || to > 0)) {
      // Straight over the panel, cut where it leaves the bed.
      const double begin = share - 2.0 / kPanels;
      double width = 2.0 / kPanels;
      double a = std::max(from, 0.0);
      double b = std::max(to, 0.0);
      double left = begin;
      if (from < 0) {
        width *= to / (to - from);
        left = share - width;
      } else if (to < 0) {
        width *= from / (from - to);
      }
      area += 0.5 * (a + b) * width;
      moment += width * (0.5 * (a + b) * left + width * (a / 6 + b / 3));
    }
    from = to;
  }
  return area > 0 ? std::clamp(moment / area, -1.0, 1.0) : 0;
}

}  // namespace beatlas::haptics
