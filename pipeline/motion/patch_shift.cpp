#include "pipeline/motion/patch_shift.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

namespace beatlas::motion {
namespace {

struct Sample {
  float value = 0;
  float slope_i = 0;  ///< half the difference of the neighbours, as if a pixel apart
  float slope_j = 0;
};

/// Bilinear; none where the four pixels and their neighbours are not inside.
class Sampler {
 public:
  explicit Sampler(const cv::Mat& image) : image_(image) {}

  [[nodiscard]] bool at(double x, double y, Sample& out) const {
    const double fx = std::floor(x);
    const double fy = std::floor(y);
    const int i = static_cast<int>(fx);
    const int j = static_cast<int>(fy);
    if (i < 1 || j < 1 || i + 2 >= image_.cols || j + 2 >= image_.rows) return false;
    const auto a = static_cast<float>(x - fx);
    const auto b = static_cast<float>(y - fy);
    const float* row0 = image_.ptr<float>(j - 1);
    const float* row1 = image_.ptr<float>(j);
    const float* row2 = image_.ptr<float>(j + 1);
    const float* row3 = image_.ptr<float>(j + 2);
    const auto along = [&](const float* row) { return (1 - a) * row[i] + a * row[i + 1]; };
    const auto slope = [&](const float* row) {
      return 0.5F * ((1 - a) * (row[i + 1] - row[i - 1]) + a * (row[i + 2] - row[i]));
    };
    const float here = along(row1);
    const float below = along(row2);
    out.value = (1 - b) * here + b * below;
    out.slope_i = (1 - b) * slope(row1) + b * slope(row2);
    out.slope_j = 0.5F * ((1 - b) * (below - along(row0)) + b * (along(row3) - here));
    return true;
  }

 private:
  const cv::Mat& image_;
};

struct Step {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Vec2 right = Vec2::Zero();
  double squares = 0;  ///< of the misfit, unweighted
  int pixels = 0;
};

/// Normal equations of one step. `scale` of Cauchy's weights; 0: all pixels weigh the same.
Step equations(const cv::Mat& first, const cv::Mat& second, const cv::Rect& where,
               const Vec2& shift, double scale) {
  const Sampler from(first);
  const Sampler to(second);
  Step out;
  for (int j = where.y; j < where.y + where.height; ++j) {
    for (int i = where.x; i < where.x + where.width; ++i) {
      Sample a;
      Sample b;
      if (!from.at(i, j, a) || !to.at(i + shift[0], j + shift[1], b)) continue;
      const Vec2 slope(0.5 * (a.slope_i + b.slope_i), 0.5 * (a.slope_j + b.slope_j));
      const double misfit = b.value - a.value;
      const double weight = scale > 0 ? 1 / (1 + misfit * misfit / (scale * scale)) : 1;
      out.normal += weight * slope * slope.transpose();
      out.right -= weight * misfit * slope;
      out.squares += misfit * misfit;
      ++out.pixels;
    }
  }
  return out;
}

/// Median misfit of the fifth of the pixels with the steepest slopes, as a standard deviation.
double misfit_scale(const cv::Mat& first, const cv::Mat& second, const Vec2& shift) {
  const Sampler from(first);
  const Sampler to(second);
  std::vector<std::pair<float, float>> steep;  // slope squared, misfit
  for (int j = 0; j < first.rows; ++j) {
    for (int i = 0; i < first.cols; ++i) {
      Sample a;
      Sample b;
      if (!from.at(i, j, a) || !to.at(i + shift[0], j + shift[1], b)) continue;
      steep.emplace_back(a.slope_i * a.slope_i + a.slope_j * a.slope_j,
                         std::abs(b.value - a.value));
    }
  }
  if (steep.size() < 5) return 0;
  const auto fifth = steep.begin() + static_cast<std::ptrdiff_t>(steep.size() * 4 / 5);
  std::nth_element(steep.begin(), fifth, steep.end());
  const auto middle = fifth + (steep.end() - fifth) / 2;
  std::nth_element(fifth, middle, steep.end(),
                   [](const auto& a, const auto& b) { return a.second < b.second; });
  return std::max(1e-6, 1.4826 * middle->second);
}

/// Damped, so that a patch without structure stays; at most a pixel at once.
Vec2 step_of(const Step& step, double damping) {
  const double bulk = step.normal.trace();
  if (!(bulk > 0)) return Vec2::Zero();
  const Eigen::Matrix2d normal = step.normal + damping * bulk * Eigen::Matrix2d::Identity();
  Vec2 out = normal.ldlt().solve(step.right);
  const double length = out.norm();
  if (length > 1) out /= length;
  return out;
}

}  // namespace

Vec2 whole_shift_px(const cv::Mat& first, const cv::Mat& second) {
  Vec2 shift = Vec2::Zero();
  for (const int level : {4, 2, 1}) {
    const auto coarse = [&](const cv::Mat& image) {
      cv::Mat smooth;
      cv::GaussianBlur(image, smooth, {}, level, level, cv::BORDER_REPLICATE);
      cv::Mat out((image.rows + level - 1) / level, (image.cols + level - 1) / level, CV_32F);
      for (int j = 0; j < out.rows; ++j) {
        for (int i = 0; i < out.cols; ++i) {
          out.at<float>(j, i) = smooth.at<float>(j * level, i * level);
        }
      }
      return out;
    };
    const cv::Mat a = coarse(first);
    const cv::Mat b = coarse(second);
    shift /= level;
    for (int round = 0; round < 15; ++round) {
      const double scale = misfit_scale(a, b, shift);
      if (scale <= 0) break;
      const Vec2 step = step_of(equations(a, b, {0, 0, a.cols, a.rows}, shift, scale), 1e-6);
      shift += step;
      if (step.norm() < 1e-3) break;
    }
    shift *= level;
  }
  return shift;
}

PatchShift follow_patch(const cv::Mat& first, const cv::Mat& second, const cv::Rect& where,
                        const Vec2& start_px) {
  PatchShift out;
  out.shift_px = start_px;
  Step step;
  for (int round = 0; round < 10; ++round) {
    step = equations(first, second, where, out.shift_px, 0);
    const Vec2 by = step_of(step, 1e-2);
    out.shift_px += by;
    if (by.norm() < 1e-2) break;
  }
  const double variance = step.pixels > 0 ? step.squares / step.pixels : 1;
  out.information = step.normal / std::max(variance, 1e-6);
  return out;
}

}  // namespace beatlas::motion
