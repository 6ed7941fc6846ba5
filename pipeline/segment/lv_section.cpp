#include "pipeline/segment/lv_section.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/distance_map.h"
#include "pipeline/core/parallel.h"
#include "runtime/atlas/structures.h"

namespace beatlas::segment {
namespace {

/// At its thinnest, the apex, 1 to 2 mm (Ho 2009, doi:10.1093/ejechocard/jep159; 60 hearts:
/// Bradfield, Beck and Vecht, Br Heart J 39:806, 1977).
constexpr double kThinnestWallMm = 2;

/// A slice of one phase as a matrix that shares the voxels.
cv::Mat slice_of(const Grid& grid, const std::vector<std::uint8_t>& labels, int k) {
  return {grid.size[1], grid.size[0], CV_8U,
          const_cast<std::uint8_t*>(labels.data() + grid.offset(0, 0, k))};
}

/// What lies beside the cavity of a slice and is no muscle.
cv::Mat open_beside_cavity(const cv::Mat& slice) {
  const cv::Mat blood = slice == kLabelLvBlood;
  cv::Mat beside;
  cv::dilate(blood, beside, cv::Mat());
  return beside & ~blood & (slice != kLabelLvMyocardium);
}

}  // namespace

void fill_cavity(const LabelImages& sure, ImageCycle<std::uint8_t>& labels) {
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    for (int k = 0; k < labels.grid.size[2]; ++k) {
      cv::Mat slice = slice_of(labels.grid, labels.phases[p], k);
      std::vector<cv::Point> blood;
      cv::findNonZero(slice == kLabelLvBlood, blood);
      if (blood.size() < 3) continue;
      std::vector<cv::Point> hull;
      cv::convexHull(blood, hull);
      cv::Mat filled = cv::Mat::zeros(slice.size(), CV_8U);
      cv::fillConvexPoly(filled, hull, cv::Scalar(255));
      if (hull.size() >= 5) {
        cv::ellipse(filled, cv::fitEllipse(hull), cv::Scalar(255), cv::FILLED);
        filled &= slice_of(labels.grid, sure[p], k) != kLabelLvMyocardium;
      }
      slice.setTo(cv::Scalar(kLabelLvBlood), filled & (slice == kLabelLvMyocardium));
    }
  });
}

bool is_closed(const ImageCycle<std::uint8_t>& labels, std::size_t phase, int k) {
  return cv::countNonZero(open_beside_cavity(slice_of(labels.grid, labels.phases[phase], k))) == 0;
}

void close_wall(int base_step, ImageCycle<std::uint8_t>& labels) {
  const int reach =
      static_cast<int>(std::ceil(kThinnestWallMm / labels.grid.spacing_mm().head<2>().minCoeff()));
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1});
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    bool closed = false;  // in a slice on the way from the base
    for (int n = 0; n < labels.grid.size[2]; ++n) {
      const int k = base_step > 0 ? labels.grid.size[2] - 1 - n : n;
      cv::Mat slice = slice_of(labels.grid, labels.phases[p], k);
      const cv::Mat blood = slice == kLabelLvBlood;
      if (cv::countNonZero(blood) == 0) continue;
      const cv::Mat open = open_beside_cavity(slice);
      if (closed) {
        cv::Mat wall;
        cv::dilate(open, wall, disc);
        cv::Mat about;
        cv::dilate(blood, about, disc);
        slice.setTo(cv::Scalar(kLabelLvMyocardium), wall & about & (slice != kLabelLvBlood));
      } else {
        closed = cv::countNonZero(open) == 0;
      }
    }
  });
}

void trim_wall(ImageCycle<std::uint8_t>& labels) {
  const std::size_t slice = labels.grid.slice_count();
  const auto slices = static_cast<std::size_t>(labels.grid.size[2]);
  // Distances are those of voxels' centres, so a disc's own edge is up to a pixel farther off.
  const auto pixel = static_cast<float>(labels.grid.spacing_mm().head<2>().maxCoeff());
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    std::vector<std::uint8_t>& phase = labels.phases[p];
    std::vector<std::uint8_t> section(phase.size());
    std::transform(phase.begin(), phase.end(), section.begin(), [](std::uint8_t label) {
      return static_cast<std::uint8_t>(label == kLabelLvBlood || label == kLabelLvMyocardium);
    });
    // An opening by a disc: what is deeper than its radius, and what lies within it of that.
    const std::vector<float> depth = depth_within(labels.grid, section, false);
    std::vector<float> radius(slices);
    for (std::size_t v = 0; v < depth.size(); ++v) {
      float& most = radius[v / slice];
      most = std::max(most, depth[v] / 2);
    }
    for (std::size_t v = 0; v < depth.size(); ++v) {
      section[v] = static_cast<std::uint8_t>(depth[v] > radius[v / slice]);
    }
    const std::vector<float> away = distance_map(labels.grid, section, false);
    for (std::size_t v = 0; v < away.size(); ++v) {
      if (phase[v] == kLabelLvMyocardium && away[v] > radius[v / slice] + pixel) {
        phase[v] = kLabelBackground;
      }
    }
  });
}

std::vector<float> distance_from_cavity(const Grid& grid, std::vector<std::uint8_t> labels) {
  for (int k = 0; k < grid.size[2]; ++k) {
    cv::Mat slice = slice_of(grid, labels, k);
    cv::Mat blood = slice == kLabelLvBlood;
    std::vector<std::vector<cv::Point>> outlines;
    cv::findContours(blood, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    slice.setTo(0);
    cv::drawContours(slice, outlines, -1, cv::Scalar(255), cv::FILLED);
  }
  std::vector<float> out = distance_map(grid, labels, false);
  const std::vector<float> depth = depth_within(grid, labels, false);
  // Outlines run between voxels' centres.
  const auto half = static_cast<float>(0.5 * grid.spacing_mm()[0]);
  for (std::size_t v = 0; v < out.size(); ++v) {
    if (out[v] < kNoDistance) out[v] = labels[v] != 0 ? half - depth[v] : out[v] - half;
  }
  return out;
}

}  // namespace beatlas::segment
