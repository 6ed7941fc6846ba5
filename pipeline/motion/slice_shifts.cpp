#include "pipeline/motion/slice_shifts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/motion/narrow_field.h"
#include "pipeline/motion/patch_shift.h"
#include "runtime/base/error.h"

namespace beatlas::motion {
namespace {

constexpr int kFewestSlices = 5;
constexpr double kBlockMm = 40;
constexpr double kFewestBlockPixels = 12;  ///< along a side: coarser ones hold no structure
constexpr double kLargestStepMm = 20;      ///< between neighbours: breath-holds do not differ more
constexpr double kLargestSizeMm = 8;
constexpr double kBlockBlurMm = 2;       ///< Gaussian, before blocks are followed
constexpr double kSmallestSizeMm = 0.3;  ///< what is less is not worth resampling
constexpr double kBlockErrorPx = 0.02;   ///< of a block at best: interpolation
constexpr double kBendErrorMm = 0.03;    ///< of a bend at best

cv::Mat frame_of(const ImageCycle<float>& images, std::size_t phase, int k) {
  const Grid& grid = images.grid;
  return {grid.size[1], grid.size[0], CV_32F,
          const_cast<float*>(images.phases[phase].data() + grid.offset(0, 0, k))};
}

cv::Mat mean_slice(const ImageCycle<float>& images, int k) {
  cv::Mat mean = cv::Mat::zeros(images.grid.size[1], images.grid.size[0], CV_32F);
  for (std::size_t p = 0; p < images.phases.size(); ++p) mean += frame_of(images, p, k);
  return mean / images.phase_count();
}

double variance_of(const cv::Mat& image) {
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(image, mean, deviation);
  return deviation[0] * deviation[0];
}

/// Whether most of what a slice's frames hold is common to them: of n frames of noise the mean has
/// an n-th of their variance, of blank ones none. Nothing can be followed into such a slice.
bool shows_something(const ImageCycle<float>& images, int k, const cv::Mat& mean) {
  constexpr double kLeastCommon = 0.5;
  const auto n = static_cast<double>(images.phases.size());
  double each = 0;
  for (std::size_t p = 0; p < images.phases.size(); ++p) {
    each += variance_of(frame_of(images, p, k)) / n;
  }
  const double common = variance_of(mean);
  return n > 1 ? n * common - each > kLeastCommon * (n - 1) * each : common > 0;
}

cv::Mat blurred(const cv::Mat& image, double sigma_mm, const Vec3& spacing) {
  cv::Mat out;
  cv::GaussianBlur(image, out, {}, sigma_mm / spacing[0], sigma_mm / spacing[1],
                   cv::BORDER_REPLICATE);
  return out;
}

std::vector<cv::Rect> blocks_of(const cv::Size& size, const Vec3& spacing) {
  const auto parts = [](int pixels, double mm) {
    return std::max(1, static_cast<int>(std::lround(pixels * mm / kBlockMm)));
  };
  const int across = parts(size.width, spacing[0]);
  const int down = parts(size.height, spacing[1]);
  std::vector<cv::Rect> out;
  for (int b = 0; b < down; ++b) {
    for (int a = 0; a < across; ++a) {
      const cv::Point first(size.width * a / across, size.height * b / down);
      const cv::Point last(size.width * (a + 1) / across, size.height * (b + 1) / down);
      out.emplace_back(first, last);
    }
  }
  return out;
}

/// A bend and its covariance [pixels].
struct Bend {
  Vec2 value = Vec2::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
};

/// The bend that most blocks share: iteratively reweighted least squares with Cauchy's weights,
/// its covariance from the blocks' own scatter.
Bend shared_bend(const std::vector<PatchShift>& to_here, const std::vector<PatchShift>& from_here) {
  std::vector<Vec2> bends;
  std::vector<Eigen::Matrix2d> weights;
  for (std::size_t b = 0; b < to_here.size(); ++b) {
    const auto covariance = [](const PatchShift& shift) {
      return Eigen::Matrix2d((shift.information + 1e-9 * Eigen::Matrix2d::Identity()).inverse());
    };
    const Eigen::Matrix2d sum = covariance(to_here[b]) + covariance(from_here[b]) +
                                kBlockErrorPx * kBlockErrorPx * Eigen::Matrix2d::Identity();
    bends.emplace_back(from_here[b].shift_px - to_here[b].shift_px);
    weights.emplace_back(sum.inverse());
  }
  const auto median = [](std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  Bend out;
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> values;
    values.reserve(bends.size());
    for (const Vec2& bend : bends) values.push_back(bend[axis]);
    out.value[axis] = median(std::move(values));
  }
  for (int round = 0; round < 20; ++round) {
    std::vector<double> misfit;
    for (std::size_t b = 0; b < bends.size(); ++b) {
      const Vec2 off = bends[b] - out.value;
      misfit.push_back(off.dot(weights[b] * off));
    }
    const double scale = std::max(1e-9, median(misfit));
    Eigen::Matrix2d whole = Eigen::Matrix2d::Zero();
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    Vec2 sum = Vec2::Zero();
    for (std::size_t b = 0; b < bends.size(); ++b) {
      const Eigen::Matrix2d weight = weights[b] / (1 + misfit[b] / scale);
      const Vec2 pull = weight * (bends[b] - out.value);
      whole += weight;
      sum += weight * bends[b];
      scatter += pull * pull.transpose();
    }
    const Eigen::Matrix2d inverse = whole.inverse();
    out.value = inverse * sum;
    out.covariance = inverse * scatter * inverse;
  }
  return out;
}

/// Likeliest shifts along one axis [mm] of bends with their variances, infinite where a bend is not
/// known, each N(0, size_mm^2).
Eigen::VectorXd shifts_of(const std::vector<double>& bend, const std::vector<double>& variance,
                          double size_mm) {
  const auto n = static_cast<Eigen::Index>(bend.size()) + 2;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(n, n) / (size_mm * size_mm);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  const Vec3 second(1, -2, 1);
  for (Eigen::Index k = 0; k + 2 < n; ++k) {
    const auto at = static_cast<std::size_t>(k);
    normal.block<3, 3>(k, k) += second * second.transpose() / variance[at];
    right.segment<3>(k) += second * bend[at] / variance[at];
  }
  return normal.ldlt().solve(right);
}

/// Taps of the windowed sinc that reads a row at `shift_px` beyond each pixel.
struct SincTaps {
  int first = 0;  ///< of six, relative to the pixel
  std::array<float, 6> weight{};

  explicit SincTaps(double shift_px) {
    const double whole = std::floor(shift_px);
    const double part = shift_px - whole;
    first = static_cast<int>(whole) - 2;
    const auto sinc = [](double x) {
      return std::abs(x) < 1e-9 ? 1.0 : std::sin(M_PI * x) / (M_PI * x);
    };
    double sum = 0;
    std::array<double, 6> raw{};
    for (int t = 0; t < 6; ++t) {
      const double x = t - 2 - part;
      raw[static_cast<std::size_t>(t)] = std::abs(x) < 3 ? sinc(x) * sinc(x / 3) : 0;
      sum += raw[static_cast<std::size_t>(t)];
    }
    for (std::size_t t = 0; t < 6; ++t) weight[t] = static_cast<float>(raw[t] / sum);
  }
};

/// How an image's rows, or its columns, lie in memory.
struct Lines {
  int count = 0;
  int pixels = 0;
  int lines_apart = 0;
  int pixels_apart = 0;
};

/// Reads an image anew along its lines as the taps say.
void read_along(const SincTaps& taps, const Lines& lines, const float* from, float* to) {
  for (int line = 0; line < lines.count; ++line) {
    for (int n = 0; n < lines.pixels; ++n) {
      float sum = 0;
      for (int t = 0; t < 6; ++t) {
        const int at = std::clamp(n + taps.first + t, 0, lines.pixels - 1);
        sum += taps.weight[static_cast<std::size_t>(t)] *
               from[line * lines.lines_apart + at * lines.pixels_apart];
      }
      to[line * lines.lines_apart + n * lines.pixels_apart] = sum;
    }
  }
}

/// Reads a slice, row-major, anew as the taps along its rows and columns say.
/// @param rows room for a slice
void read_shifted(const SincTaps& along_i, const SincTaps& along_j, int ni, int nj, float* slice,
                  float* rows) {
  read_along(along_i, {nj, ni, ni, 1}, slice, rows);
  read_along(along_j, {ni, nj, 1, ni}, rows, slice);
}

std::string mm_text(double mm) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f", mm);
  return text.data();
}

}  // namespace

bool SliceShifts::certain() const {
  return size_mm > kSmallestSizeMm && size_mm < kLargestSizeMm && size_mm > 3 * error_mm;
}

SliceShifts find_slice_shifts(const ImageCycle<float>& images) {
  const Grid& grid = images.grid;
  const auto slices = static_cast<std::size_t>(grid.size[2]);
  SliceShifts out;
  out.shift_mm.assign(slices, Vec2::Zero());
  if (grid.size[2] < kFewestSlices) return out;
  if (is_narrow_field(grid)) return out;
  const Vec3 spacing = grid.spacing_mm();
  if (std::max(spacing[0], spacing[1]) * kFewestBlockPixels > kBlockMm) return out;

  std::vector<cv::Mat> means(slices);
  std::vector<cv::Mat> smooth(slices);
  std::vector<std::uint8_t> shown(slices);
  parallel_for(slices, [&](std::size_t k) {
    means[k] = mean_slice(images, static_cast<int>(k));
    smooth[k] = blurred(means[k], kBlockBlurMm, spacing);
    shown[k] = shows_something(images, static_cast<int>(k), means[k]) ? 1 : 0;
  });
  const std::vector<cv::Rect> blocks = blocks_of(means.front().size(), spacing);
  std::vector<std::vector<PatchShift>> steps(slices - 1);
  parallel_for(slices - 1, [&](std::size_t k) {
    Vec2 whole = whole_shift_px(means[k], means[k + 1]);
    if (whole.cwiseProduct(spacing.head<2>()).norm() > kLargestStepMm) whole.setZero();
    for (const cv::Rect& block : blocks) {
      steps[k].push_back(follow_patch(smooth[k], smooth[k + 1], block, whole));
    }
  });

  std::array<std::vector<double>, 2> bends;
  std::array<std::vector<double>, 2> variances;
  double squares = 0;
  double feigned = 0;
  int known = 0;
  for (std::size_t k = 0; k + 2 < slices; ++k) {
    if (shown[k] == 0 || shown[k + 1] == 0 || shown[k + 2] == 0) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        bends[axis].push_back(0);
        variances[axis].push_back(std::numeric_limits<double>::infinity());
      }
      continue;
    }
    ++known;
    const Bend bend = shared_bend(steps[k], steps[k + 1]);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto a = static_cast<int>(axis);
      const double mm = spacing[a];
      bends[axis].push_back(bend.value[a] * mm);
      const double variance = bend.covariance(a, a) * mm * mm;
      // The scatter of blocks of one slice leaves out what they share: twice its error.
      variances[axis].push_back(4 * variance + kBendErrorMm * kBendErrorMm);
      squares += bends[axis].back() * bends[axis].back();
      feigned += variance;
    }
  }
  if (known < kFewestSlices - 2) return out;
  // A bend of independent shifts has 1 + 4 + 1 times their variance.
  const double of_bends = 12.0 * known;
  out.size_mm = std::sqrt(std::max(0.0, squares - feigned) / of_bends);
  out.error_mm = std::sqrt(feigned / of_bends);
  if (out.size_mm <= 0) return out;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const Eigen::VectorXd found = shifts_of(bends[axis], variances[axis], out.size_mm);
    for (std::size_t k = 0; k < slices; ++k) {
      out.shift_mm[k][static_cast<int>(axis)] = found[static_cast<Eigen::Index>(k)];
    }
  }
  return out;
}

ImageCycle<float> without_shifts(ImageCycle<float> images, const std::vector<Vec2>& shift_mm) {
  const Grid grid = images.grid;
  const auto slices = static_cast<std::size_t>(grid.size[2]);
  if (shift_mm.size() != slices) {
    throw_invalid("there are " + std::to_string(shift_mm.size()) + " shifts for " +
                  std::to_string(slices) + " slices; give one a slice");
  }
  const Vec3 spacing = grid.spacing_mm();
  parallel_for(slices, [&](std::size_t k) {
    if (shift_mm[k].isZero(0)) return;
    const SincTaps along_i(shift_mm[k][0] / spacing[0]);
    const SincTaps along_j(shift_mm[k][1] / spacing[1]);
    std::vector<float> rows(grid.slice_count());
    for (std::vector<float>& phase : images.phases) {
      float* slice = phase.data() + grid.offset(0, 0, static_cast<int>(k));
      read_shifted(along_i, along_j, grid.size[0], grid.size[1], slice, rows.data());
    }
  });
  return images;
}

Exam with_aligned_slices(Exam exam, const AlignOptions& options) {
  if (options.slices == AlignOptions::Slices::Off) return exam;
  SliceShifts found = find_slice_shifts(exam.stack.images);
  if (!found.certain()) return exam;
  exam.stack.images = without_shifts(std::move(exam.stack.images), found.shift_mm);
  const auto most = std::max_element(
      found.shift_mm.begin(), found.shift_mm.end(),
      [](const Vec2& a, const Vec2& b) { return a.squaredNorm() < b.squaredNorm(); });
  exam.decisions.push_back(
      "Slices lie shifted in their planes by breath-holds (" + mm_text(found.size_mm) +
      " mm along an axis, standard deviation; most slice " +
      std::to_string(most - found.shift_mm.begin()) + ", " + mm_text(most->norm()) +
      " mm) and were moved back; /import/align_slices off in a recipe leaves them.");
  exam.slice_shifts_mm = std::move(found.shift_mm);
  return exam;
}

}  // namespace beatlas::motion
