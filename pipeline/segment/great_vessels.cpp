#include "pipeline/segment/great_vessels.h"

#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace beatlas::segment {
namespace {

constexpr double kPoolWallMm = 4;          ///< wall of an atrium or a great vessel, and motion
constexpr double kNeckMm = 4;              ///< half the width of what joins two pools that touch
constexpr double kWidestVesselMm2 = 1000;  ///< of the descending aorta, r 18 mm
constexpr double kLeastOutside = 0.3;      ///< most of it that may lie in a ventricle's zone
constexpr double kVesselLeans = 1.2;       ///< mm aside for each mm from slice to slice, at most
constexpr double kVesselWidens = 1.6;      ///< area from one slice to the next, at most
constexpr std::size_t kLeastOfWay = 3;     ///< slices that it is seen in

cv::Point2d middle_of(const cv::Mat& mask) {
  const cv::Moments m = cv::moments(mask, true);
  return m.m00 > 0 ? cv::Point2d(m.m10 / m.m00, m.m01 / m.m00) : cv::Point2d(0, 0);
}

/// Pools of one slice, each whole though it touches another: what hangs together by a neck is two.
std::vector<cv::Mat> pools_of(const cv::Mat& blood, const cv::Point2d& pixel_mm) {
  cv::Mat cores;
  cv::erode(blood, cores, disc(kNeckMm, pixel_mm));
  cv::Mat ids;
  const int count = cv::connectedComponents(cores, ids, 4);
  std::vector<cv::Mat> pools;
  for (int id = 1; id < count; ++id) {
    cv::Mat pool;
    cv::dilate(cv::Mat(ids == id), pool, disc(kNeckMm, pixel_mm));
    pools.push_back(pool);
  }
  return pools;
}

double share_within(const cv::Mat& pool, const cv::Mat& zone) {
  return static_cast<double>(cv::countNonZero(pool & zone)) / cv::countNonZero(pool);
}

/// The descending aorta runs past the heart: a pool outside the ventricles' zones that goes on,
/// about as wide, from slice to slice, on to beside the atria. [slice] mask of such pools.
std::vector<cv::Mat> passing_vessels(const Grid& grid, const Chambers& chambers,
                                     const std::vector<std::vector<cv::Mat>>& pools,
                                     const std::vector<cv::Mat>& zones) {
  const Vec3 spacing = grid.spacing_mm();
  std::vector<cv::Mat> passing(zones.size());
  for (std::size_t k = 0; k < zones.size(); ++k) {
    passing[k] = cv::Mat::zeros(zones[k].size(), CV_8U);
  }
  const auto has = [&](int k) { return k >= 0 && k < static_cast<int>(zones.size()); };
  for (const LvSlice& slice : chambers.lv) {
    for (const cv::Mat& first : pools[static_cast<std::size_t>(slice.k)]) {
      const double area_mm2 = cv::countNonZero(first) * spacing[0] * spacing[1];
      if (area_mm2 > kWidestVesselMm2) continue;
      if (share_within(first, zones[static_cast<std::size_t>(slice.k)]) > kLeastOutside) continue;
      std::vector<std::pair<std::size_t, cv::Mat>> way{{static_cast<std::size_t>(slice.k), first}};
      for (int k = slice.k + chambers.base_step; has(k); k += chambers.base_step) {
        const cv::Mat& last = way.back().second;
        const cv::Mat* nearest = nullptr;
        double least_mm = kVesselLeans * spacing[2];
        for (const cv::Mat& pool : pools[static_cast<std::size_t>(k)]) {
          const double wider = static_cast<double>(cv::countNonZero(pool)) / cv::countNonZero(last);
          const cv::Point2d move = middle_of(pool) - middle_of(last);
          const double away_mm = std::hypot(move.x * spacing[0], move.y * spacing[1]);
          if (wider > kVesselWidens || wider < 1 / kVesselWidens || away_mm > least_mm) continue;
          least_mm = away_mm;
          nearest = &pool;
        }
        if (nearest == nullptr) break;
        way.emplace_back(static_cast<std::size_t>(k), *nearest);
      }
      if (way.size() < kLeastOfWay) continue;
      for (const auto& [k, pool] : way) passing[k] |= pool;
    }
  }
  return passing;
}

}  // namespace

void take_pools_whole(const Grid& grid, const Chambers& chambers, std::vector<cv::Mat>& zones) {
  const Vec3 spacing = grid.spacing_mm();
  const cv::Point2d pixel_mm(spacing[0], spacing[1]);
  std::vector<std::vector<cv::Mat>> pools;
  for (const cv::Mat& blood : chambers.always_blood) pools.push_back(pools_of(blood, pixel_mm));
  const std::vector<cv::Mat> passing = passing_vessels(grid, chambers, pools, zones);
  const int base_k = chambers.base_step > 0 ? chambers.lv.back().k : chambers.lv.front().k;
  std::vector<cv::Mat> reach = zones;
  const int next = base_k + chambers.base_step;
  if (next >= 0 && next < grid.size[2]) {
    reach[static_cast<std::size_t>(base_k)] |= zones[static_cast<std::size_t>(next)];
  }
  for (std::size_t k = 0; k < zones.size(); ++k) {
    cv::Mat within = cv::Mat::zeros(zones[k].size(), CV_8U);
    for (const cv::Mat& pool : pools[k]) {
      if (share_within(pool, reach[k]) > 0.5) within |= pool;
    }
    cv::dilate(within, within, disc(kPoolWallMm, pixel_mm));
    zones[k] = (zones[k] | within) & ~passing[k];
  }
}

}  // namespace beatlas::segment
