#include "pipeline/segment/ring.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace beatlas::segment {
namespace {

constexpr double kStepMm = 0.5;
constexpr double kReachMm = 70;
constexpr double kThinWallMm = 3.5;
constexpr double kThickWallMm = 25;   ///< beyond any wall but the most hypertrophic
constexpr double kUnseenWallMm = 20;  ///< dark this far: a wall with other tissue behind it
constexpr double kTrabeculaMm = 2.5;

/// Cosine and sine of every ray's angle.
const std::array<cv::Point2d, Ring::kRays>& directions() {
  static const std::array<cv::Point2d, Ring::kRays> kDirections = [] {
    std::array<cv::Point2d, Ring::kRays> out;
    for (int a = 0; a < Ring::kRays; ++a) {
      const double angle = 2 * std::numbers::pi * a / Ring::kRays;
      out[static_cast<std::size_t>(a)] = {std::cos(angle), std::sin(angle)};
    }
    return out;
  }();
  return kDirections;
}

/// Bilinear; not a number outside the image.
float sample(const cv::Mat& image, const cv::Point2d& at) {
  if (!(at.x >= 0 && at.y >= 0 && at.x < image.cols - 1 && at.y < image.rows - 1)) {
    return std::numeric_limits<float>::quiet_NaN();
  }
  const int x = static_cast<int>(at.x);
  const int y = static_cast<int>(at.y);
  const double u = at.x - x;
  const double v = at.y - y;
  const auto* row0 = image.ptr<float>(y);
  const auto* row1 = image.ptr<float>(y + 1);
  return static_cast<float>((1 - v) * ((1 - u) * row0[x] + u * row0[x + 1]) +
                            v * ((1 - u) * row1[x] + u * row1[x + 1]));
}

}  // namespace

double Ring::median_wall_mm() const {
  std::vector<float> walls;
  for (std::size_t a = 0; a < walled.size(); ++a) {
    if (walled[a]) walls.push_back(outer_mm[a] - endo_mm[a]);
  }
  if (walls.empty()) return 0;
  const auto middle = walls.begin() + static_cast<std::ptrdiff_t>(walls.size() / 2);
  std::nth_element(walls.begin(), middle, walls.end());
  return *middle;
}

double Ring::muscle_share() const {
  int count = 0;
  for (std::size_t a = 0; a < walled.size(); ++a) {
    count += walled[a] || outer_mm[a] - endo_mm[a] > kUnseenWallMm ? 1 : 0;
  }
  return static_cast<double>(count) / kRays;
}

cv::Point2d ray_point(const cv::Point2d& centre_px, const cv::Point2d& pixel_mm, int a,
                      double radius_mm) {
  const cv::Point2d& direction = directions()[static_cast<std::size_t>(a)];
  return {centre_px.x + radius_mm * direction.x / pixel_mm.x,
          centre_px.y + radius_mm * direction.y / pixel_mm.y};
}

Ring trace_ring(const cv::Mat& image, const cv::Point2d& pixel_mm, const cv::Point2d& centre_px,
                const TissueLevels& levels) {
  Ring ring;
  ring.endo_mm.assign(Ring::kRays, 0);
  ring.outer_mm.assign(Ring::kRays, 0);
  ring.walled.assign(Ring::kRays, 0);
  int walled = 0;
  const auto& along = directions();
  for (int a = 0; a < Ring::kRays; ++a) {
    const cv::Point2d& direction = along[static_cast<std::size_t>(a)];
    const cv::Point2d per_mm(direction.x / pixel_mm.x, direction.y / pixel_mm.y);
    double endo = -1;
    double outer = -1;
    double run_start = -1;
    for (double r = 0; r < kReachMm; r += kStepMm) {
      const float value = sample(image, centre_px + r * per_mm);
      if (std::isnan(value)) {
        // The border of the image is no end of a wall: behind blood there is none, and that of
        // muscle lies unseen beyond.
        if (endo < 0) {
          endo = run_start >= 0 ? run_start : r;
          outer = endo;
        }
        break;
      }
      const bool bright = value > levels.threshold;
      if (endo < 0) {
        // The end of the blood: a dark run longer than a trabecula.
        if (bright) {
          run_start = -1;
        } else if (run_start < 0) {
          run_start = r;
        } else if (r - run_start >= kTrabeculaMm) {
          endo = run_start;
        }
      }
      if (endo >= 0 && (bright || value < levels.dark)) {
        outer = r;
        break;
      }
      if (endo >= 0 && r - endo > kThickWallMm) break;
    }
    if (endo < 0) {
      endo = run_start >= 0 ? run_start : kReachMm;
      outer = endo;
    } else if (outer < 0) {
      outer = endo + kThickWallMm + kStepMm;
    }
    const auto index = static_cast<std::size_t>(a);
    ring.endo_mm[index] = static_cast<float>(endo);
    ring.outer_mm[index] = static_cast<float>(outer);
    const double wall = outer - endo;
    ring.walled[index] = wall >= kThinWallMm && wall <= kThickWallMm && endo > 0;
    walled += ring.walled[index];
  }
  ring.walled_share = static_cast<double>(walled) / Ring::kRays;
  double mean = 0;
  for (float r : ring.endo_mm) mean += r / Ring::kRays;
  double square = 0;
  for (float r : ring.endo_mm) square += (r - mean) * (r - mean) / Ring::kRays;
  ring.roundness = mean > 0 ? std::max(0.0, 1 - std::sqrt(square) / mean) : 0;
  for (int a = 0; a < Ring::kRays; ++a) {
    const auto here = static_cast<std::size_t>(a);
    const auto next = static_cast<std::size_t>((a + 1) % Ring::kRays);
    ring.area_mm2 += 0.5 * ring.endo_mm[here] * ring.endo_mm[next] *
                     std::sin(2 * std::numbers::pi / Ring::kRays);
  }
  return ring;
}

}  // namespace beatlas::segment
