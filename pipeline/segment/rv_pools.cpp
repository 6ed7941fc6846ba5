#include "pipeline/segment/rv_pools.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <opencv2/imgproc.hpp>

#include "pipeline/segment/tissue.h"

namespace beatlas::segment {
namespace {

constexpr double kWidestDipMm =
    3.5;                            ///< radius: a wall between bright tissues is narrower than that
constexpr double kLeastDip = 0.18;  ///< of blood above muscle
constexpr double kBrightest = 1.1;  ///< of blood: fat is brighter, and its brightness no dip's rim
constexpr double kFatOverBlood = 0.45;  ///< of blood above muscle: so much brighter is no blood
constexpr double kAlike = 0.2;          ///< the same, by which the two ventricles' blood may differ
constexpr double kOpenMm = 2.0;         ///< radius of the opening that cuts what hangs by a thread
constexpr double kMendMm = 4.0;         ///< radius of the closing over trabeculae and the band
constexpr double kLeastContact = 0.08;  ///< of the rays: about 30 degrees of septum
constexpr double kFullContact = 0.25;   ///< more counts no more
constexpr double kLeastLeaning = 0.03;  ///< the same in slices beside one that has it
constexpr double kSeptumReachMm = 5;
constexpr double kApexwardMm = 2;       ///< beyond the continuation: walls are not quite convex
constexpr double kMostNarrowing = 0.7;  ///< mm for each mm between slices
constexpr double kBasewardMm = 4;  ///< and than the slice nearer the apex, where a pool goes on,
constexpr double kBasewardLean = 0.5;  ///< and so much for each mm between them
constexpr double kGoesOn = 0.5;        ///< of a part, within those
constexpr double kBeyondDiastoleMm = 3;
constexpr double kFastestMm = 60;  ///< a wall's way through a cycle, in the phases' shares,
constexpr double kFastestLoss =
    6;  ///< of its area, in the phases' shares: more is lost, not ejected
constexpr double kMostLoss = 0.8;
constexpr int kNearDiastole = 12;  ///< there a pool is followed in one part of so many of the cycle
constexpr double kCalmPx = 0.7;    ///< Gaussian in plane, before
constexpr double kSlackMm = 1.5;   ///< and this much

cv::Mat widened(const cv::Mat& mask, double by_mm, const cv::Point2d& pixel_mm) {
  cv::Mat out;
  cv::dilate(mask, out, disc(by_mm, pixel_mm));
  return out;
}

/// From the LV's centre to the middle of its wall.
cv::Mat inside_wall(const LvSlice& lv, std::size_t phase, const cv::Size& size,
                    const cv::Point2d& pixel_mm) {
  const Ring& ring = lv.rings[phase];
  std::vector<cv::Point> points;
  for (int a = 0; a < Ring::kRays; ++a) {
    const auto i = static_cast<std::size_t>(a);
    const double wall = ring.walled[i] ? 0.5 * (ring.outer_mm[i] - ring.endo_mm[i]) : 2.0;
    const cv::Point2d at = ray_point(lv.centre_px, pixel_mm, a, ring.endo_mm[i] + wall);
    points.emplace_back(static_cast<int>(std::lround(at.x)), static_cast<int>(std::lround(at.y)));
  }
  cv::Mat mask = cv::Mat::zeros(size, CV_8U);
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{points}, cv::Scalar(255));
  return mask;
}

/// Bright voxels beyond the LV, without dips.
cv::Mat pools(const cv::Mat& image, const LvSlice& lv, std::size_t phase,
              const TissueLevels& levels, const cv::Point2d& pixel_mm) {
  const cv::Mat clipped = cv::min(image, kBrightest * levels.blood);
  cv::Mat closed;
  cv::morphologyEx(clipped, closed, cv::MORPH_CLOSE, disc(kWidestDipMm, pixel_mm));
  const cv::Mat dip = closed - clipped > kLeastDip * (levels.blood - levels.muscle);
  const double fat = levels.blood + kFatOverBlood * (levels.blood - levels.muscle);
  return (image > levels.threshold) & (image < fat) & ~dip &
         ~inside_wall(lv, phase, image.size(), pixel_mm);
}

/// Parts of a mask after an opening.
std::vector<cv::Mat> parts_of(const cv::Mat& mask, const cv::Point2d& pixel_mm) {
  cv::Mat opened;
  cv::morphologyEx(mask, opened, cv::MORPH_OPEN, disc(kOpenMm, pixel_mm), {-1, -1}, 1,
                   cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::Mat ids;
  const int count = cv::connectedComponents(opened, ids, 4);
  std::vector<cv::Mat> parts;
  for (int id = 1; id < count; ++id) parts.emplace_back(ids == id);
  return parts;
}

/// Share of the rays that meet the part right behind the ring of muscle.
double contact(const cv::Mat& part, const LvSlice& lv, std::size_t phase,
               const cv::Point2d& pixel_mm) {
  const Ring& ring = lv.rings[phase];
  int hits = 0;
  for (int a = 0; a < Ring::kRays; ++a) {
    const auto i = static_cast<std::size_t>(a);
    if (!ring.walled[i]) continue;
    for (double beyond = 1.0; beyond <= kSeptumReachMm; beyond += 1.0) {
      const cv::Point2d at = ray_point(lv.centre_px, pixel_mm, a, ring.outer_mm[i] + beyond);
      const cv::Point px(static_cast<int>(std::lround(at.x)), static_cast<int>(std::lround(at.y)));
      if (px.x < 0 || px.y < 0 || px.x >= part.cols || px.y >= part.rows) break;
      if (part.at<std::uint8_t>(px) == 0) continue;
      ++hits;
      break;
    }
  }
  return static_cast<double>(hits) / Ring::kRays;
}

/// Trabeculae and the moderator band are of the cavity; nothing of the ring of muscle is.
cv::Mat mended(const cv::Mat& mask, const cv::Mat& bright, const cv::Point2d& pixel_mm) {
  cv::Mat closed;
  cv::morphologyEx(mask, closed, cv::MORPH_CLOSE, disc(kMendMm, pixel_mm), {-1, -1}, 1,
                   cv::BORDER_CONSTANT, cv::Scalar(0));
  return (closed & bright) | mask;
}

cv::Mat moved(const cv::Mat& mask, const cv::Point2d& by_px) {
  cv::Mat out;
  const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, by_px.x, 0, 1, by_px.y);
  cv::warpAffine(mask, out, shift, mask.size(), cv::INTER_NEAREST);
  return out;
}

/// Signed distance to the mask's outline [mm], negative inside.
cv::Mat distance_mm(const cv::Mat& mask, const cv::Point2d& pixel_mm) {
  cv::Mat outward;
  cv::Mat inward;
  cv::distanceTransform(~mask, outward, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::distanceTransform(mask, inward, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return (outward - inward) * std::sqrt(pixel_mm.x * pixel_mm.y);
}

/// Ventricles narrow toward the apex ever more: their outline lies within the straight continuation
/// of those of the next two slices toward the base, the LV's centres on one another.
cv::Mat within_continuation(const std::vector<LvSlice>& lv, const std::vector<cv::Mat>& rv,
                            std::size_t phase, int n, int toward_base, const cv::Point2d& pixel_mm,
                            double slice_mm) {
  const auto slice = [&](int at) -> const LvSlice& { return lv[static_cast<std::size_t>(at)]; };
  const auto outline = [&](int at) {
    const cv::Mat& pool = rv[static_cast<std::size_t>(slice(at).k)];
    const cv::Mat both = pool | inside_wall(slice(at), phase, pool.size(), pixel_mm);
    return distance_mm(moved(both, slice(n).centre_px - slice(at).centre_px), pixel_mm);
  };
  const auto has = [&](int at) {
    return at >= 0 && at < static_cast<int>(lv.size()) &&
           !rv[static_cast<std::size_t>(slice(at).k)].empty();
  };
  const int next = n + toward_base;
  const int second = next + toward_base;
  cv::Mat distance = outline(next);
  if (has(second)) {
    const double apart_mm = slice_mm * std::abs(slice(n).k - slice(next).k);
    const double share = static_cast<double>(std::abs(slice(n).k - slice(next).k)) /
                         std::abs(slice(next).k - slice(second).k);
    const cv::Mat narrows = (distance - outline(second)) * share;
    distance += cv::min(cv::max(narrows, 0.0), kMostNarrowing * apart_mm);
  }
  return distance <= kApexwardMm;
}

double inscribed_mm(const cv::Mat& part, const cv::Point2d& pixel_mm) {
  cv::Mat distance;
  cv::distanceTransform(part, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  double most = 0;
  cv::minMaxLoc(distance, nullptr, &most);
  return most * std::sqrt(pixel_mm.x * pixel_mm.y);
}

}  // namespace

std::vector<cv::Mat> rv_at_end_diastole(const Setting& s, const Chambers& chambers) {
  std::vector<cv::Mat> out(static_cast<std::size_t>(s.images.grid.size[2]));
  const auto ed = static_cast<std::size_t>(chambers.end_diastole);
  const auto count = static_cast<int>(chambers.lv.size());
  const auto slice = [&](int n) -> const LvSlice& {
    return chambers.lv[static_cast<std::size_t>(n)];
  };
  const auto image = [&](int n) { return s.slice(chambers.end_diastole, slice(n).k); };
  std::vector<cv::Mat> bright;
  bright.reserve(chambers.lv.size());
  for (int n = 0; n < count; ++n) {
    bright.push_back(pools(image(n), slice(n), ed, chambers.levels, s.pixel_mm));
  }
  // The slice that shows it best: the widest pool that leans on the ring. Fat and effusion lean on
  // more of it, but are layers.
  int first = -1;
  double most = 0;
  cv::Mat found;
  for (int n = 0; n < count; ++n) {
    for (const cv::Mat& part : parts_of(bright[static_cast<std::size_t>(n)], s.pixel_mm)) {
      const double leans = contact(part, slice(n), ed, s.pixel_mm);
      if (leans < kLeastContact) continue;
      const double radius_mm = inscribed_mm(part, s.pixel_mm);
      const double unlike = (cv::mean(image(n), part)[0] - chambers.levels.blood) /
                            (kAlike * (chambers.levels.blood - chambers.levels.muscle));
      const double rating =
          std::min(leans, kFullContact) * radius_mm * radius_mm / (1 + unlike * unlike);
      if (rating <= most) continue;
      most = rating;
      first = n;
      found = part;
    }
  }
  if (first < 0) return out;
  const auto keep = [&](int n, const cv::Mat& mask, const cv::Mat& reach) {
    out[static_cast<std::size_t>(slice(n).k)] =
        mended(mask,
               (image(n) > chambers.levels.threshold) & reach &
                   ~inside_wall(slice(n), ed, mask.size(), s.pixel_mm),
               s.pixel_mm);
  };
  keep(first, found, cv::Mat(found.size(), CV_8U, cv::Scalar(255)));
  for (const int step : {-chambers.base_step, chambers.base_step}) {
    cv::Mat before = found;
    for (int n = first + step; n >= 0 && n < count; n += step) {
      const bool baseward = step == chambers.base_step;
      const double apart_mm = s.slice_mm * std::abs(slice(n).k - slice(n - step).k);
      const cv::Mat there = moved(before, slice(n).centre_px - slice(n - step).centre_px);
      const cv::Mat close = widened(there, kBasewardMm, s.pixel_mm);
      const cv::Mat reach =
          baseward ? widened(there, kBasewardMm + kBasewardLean * apart_mm, s.pixel_mm)
                   : within_continuation(chambers.lv, out, ed, n, -step, s.pixel_mm, s.slice_mm);
      const cv::Mat within = bright[static_cast<std::size_t>(n)] & reach;
      cv::Mat rv = cv::Mat::zeros(within.size(), CV_8U);
      for (const cv::Mat& part : parts_of(within, s.pixel_mm)) {
        if (contact(part, slice(n), ed, s.pixel_mm) < kLeastLeaning) continue;
        if (cv::countNonZero(part & close) < kGoesOn * cv::countNonZero(part)) continue;
        rv |= part;
      }
      if (cv::countNonZero(rv) == 0) break;
      keep(n, rv, reach);
      before = out[static_cast<std::size_t>(slice(n).k)];
    }
  }
  return out;
}

std::vector<std::vector<cv::Mat>> rv_through_the_beat(const ImageCycle<float>& images,
                                                      const Chambers& chambers) {
  const Grid& grid = images.grid;
  const Vec3 spacing = grid.spacing_mm();
  const cv::Point2d pixel_mm(spacing[0], spacing[1]);
  const int n = images.phase_count();
  std::vector<std::vector<cv::Mat>> out(
      static_cast<std::size_t>(n), std::vector<cv::Mat>(static_cast<std::size_t>(grid.size[2])));
  const double reach_mm = kFastestMm / n + kSlackMm;
  const double least = 1 - std::min(kMostLoss, kFastestLoss / n);
  const int base_k = chambers.base_step > 0 ? chambers.lv.back().k : chambers.lv.front().k;
  const auto follow_slice = [&](int at) {
    const LvSlice& lv = chambers.lv[static_cast<std::size_t>(at)];
    const auto k = static_cast<std::size_t>(lv.k);
    const cv::Mat& diastole = chambers.rv[k];
    if (diastole.empty()) return;
    const cv::Mat limit = widened(diastole, kBeyondDiastoleMm, pixel_mm);
    const int basal = at + chambers.base_step;
    const double below_mm = std::abs(base_k - lv.k) * spacing[2];
    const bool narrows = below_mm >= kBaseDescendsMm + spacing[2];
    const auto phase = [&](int p) { return static_cast<std::size_t>(((p % n) + n) % n); };
    out[phase(chambers.end_diastole)][k] = diastole;
    const auto follow = [&](int step, int phases) {
      cv::Mat before = diastole;
      for (int apart = 1; apart <= phases; ++apart) {
        const std::size_t p = phase(chambers.end_diastole + step * apart);
        cv::Mat image;
        cv::GaussianBlur(slice_of(grid, images.phases[p], lv.k), image, {0, 0}, kCalmPx);
        cv::Mat reach = limit & widened(before, reach_mm, pixel_mm);
        if (narrows &&
            !out[p][static_cast<std::size_t>(chambers.lv[static_cast<std::size_t>(basal)].k)]
                 .empty()) {
          reach &= within_continuation(chambers.lv, out[p], p, at, chambers.base_step, pixel_mm,
                                       spacing[2]);
        }
        const cv::Mat within = pools(image, lv, p, chambers.levels, pixel_mm) & reach;
        cv::Mat rv = cv::Mat::zeros(within.size(), CV_8U);
        for (const cv::Mat& part : parts_of(within, pixel_mm)) {
          if (cv::countNonZero(part & before) >= kGoesOn * cv::countNonZero(part)) rv |= part;
        }
        rv = mended(
            rv,
            (image > chambers.levels.threshold) & reach & ~inside_wall(lv, p, rv.size(), pixel_mm),
            pixel_mm);
        if (cv::countNonZero(rv) <= least * cv::countNonZero(before)) return;
        out[p][k] = rv;
        before = rv;
      }
    };
    const int most = below_mm >= kBaseDescendsMm ? n : n / kNearDiastole;
    follow(1, std::min(most, n / 2));
    follow(-1, std::min(most, (n - 1) / 2));
  };
  // Each slice after the one next to it toward the base.
  const auto last = static_cast<int>(chambers.lv.size()) - 1;
  for (int at = 0; at <= last; ++at) follow_slice(chambers.base_step > 0 ? last - at : at);
  return out;
}

}  // namespace beatlas::segment
