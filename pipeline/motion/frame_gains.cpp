#include "pipeline/motion/frame_gains.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "pipeline/core/parallel.h"
#include "pipeline/core/statistics.h"
#include "pipeline/motion/narrow_field.h"

namespace beatlas::motion {
namespace {

constexpr std::size_t kMostPixels =
    8192;                            ///< of a slice that are looked at; a median needs no more
constexpr double kLeastShown = 0.5;  ///< of the mean: air and lung are darker, tissue is not
constexpr std::size_t kFewestPixels =
    64;                     ///< of tissue, for a median known to a tenth of their spread
constexpr int kRounds = 3;  ///< in which what is still and the gains settle
constexpr double kLeastAlike =
    0.7;  ///< correlation of a frame with its slice's middle image, half of its contrast
constexpr double kLeastGain =
    0.1;  ///< more than the 7 % by which it is wrong where little but the heart is seen

/// Pixels of a slice, and what those of tissue, which no phase shows as nothing, do.
struct Pixels {
  std::vector<double> middle;              ///< [pixel] median over the phases
  std::vector<std::vector<double>> frame;  ///< [phase][pixel]
  std::vector<std::vector<double>>
      ratio;  ///< [phase][pixel of tissue] logarithm of what it shows over its median
};

Pixels pixels_of(const ImageCycle<float>& images, int k) {
  const std::size_t count = images.grid.slice_count();
  const std::size_t begin = images.grid.offset(0, 0, k);
  const std::size_t step = std::max<std::size_t>(1, count / kMostPixels);
  const std::size_t phases = images.phases.size();
  Pixels out;
  out.frame.resize(phases);
  out.ratio.resize(phases);
  for (std::size_t v = begin; v < begin + count; v += step) {
    std::vector<double> course;
    course.reserve(phases);
    for (std::size_t p = 0; p < phases; ++p) {
      course.push_back(static_cast<double>(images.phases[p][v]));
      out.frame[p].push_back(course.back());
    }
    out.middle.push_back(median(std::move(course)));
  }
  const double mean = std::accumulate(out.middle.begin(), out.middle.end(), 0.0) /
                      static_cast<double>(out.middle.size());
  for (std::size_t n = 0; n < out.middle.size(); ++n) {
    const bool shown = std::all_of(out.frame.begin(), out.frame.end(),
                                   [&](const std::vector<double>& frame) { return frame[n] > 0; });
    if (!shown || out.middle[n] <= kLeastShown * mean) continue;
    for (std::size_t p = 0; p < phases; ++p) {
      out.ratio[p].push_back(std::log(out.frame[p][n] / out.middle[n]));
    }
  }
  return out;
}

/// [pixel] those that change least, once the gains are off.
std::vector<bool> still_half(const std::vector<std::vector<double>>& ratio,
                             const std::vector<double>& gain) {
  std::vector<double> swing(ratio.front().size(), 0);
  for (std::size_t p = 0; p < ratio.size(); ++p) {
    for (std::size_t n = 0; n < swing.size(); ++n) swing[n] += std::abs(ratio[p][n] - gain[p]);
  }
  const double most = median(swing);
  std::vector<bool> out;
  out.reserve(swing.size());
  for (const double value : swing) out.push_back(value <= most);
  return out;
}

bool is_uneven(double gain) { return std::abs(std::log(gain)) > std::log1p(kLeastGain); }

/// [phase] logarithms of the gains.
std::vector<double> gains_of_slice(const ImageCycle<float>& images, int k) {
  const Pixels pixels = pixels_of(images, k);
  std::vector<double> gain(images.phases.size(), 0);
  if (pixels.ratio.front().size() < kFewestPixels) return gain;
  for (std::size_t p = 0; p < gain.size(); ++p) gain[p] = median(pixels.ratio[p]);
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<bool> still = still_half(pixels.ratio, gain);
    for (std::size_t p = 0; p < gain.size(); ++p) {
      std::vector<double> values;
      for (std::size_t n = 0; n < still.size(); ++n) {
        if (still[n]) values.push_back(pixels.ratio[p][n]);
      }
      gain[p] = median(std::move(values));
    }
  }
  std::vector<double> believed;
  std::vector<std::size_t> of;
  for (std::size_t p = 0; p < gain.size(); ++p) {
    if (correlation(pixels.frame[p], pixels.middle) < kLeastAlike) continue;
    believed.push_back(gain[p]);
    of.push_back(p);
  }
  const double middle = median(believed);
  std::fill(gain.begin(), gain.end(), 0);
  for (std::size_t n = 0; n < of.size(); ++n) gain[of[n]] = believed[n] - middle;
  return gain;
}

/// Whether brightness counts from nothing, so that a gain is a factor of it. Images with an offset,
/// or standardised ones, go far below 0; what interpolation leaves there is a few per cent of what
/// is bright.
bool counts_from_nothing(const ImageCycle<float>& images) {
  constexpr double kEnd = 0.01;  // of the pixels, at either end
  constexpr float kLeastBelow = 0.05F;
  constexpr std::size_t kPixels = 65536;
  std::vector<float> values;
  const std::size_t all = images.grid.count() * images.phases.size();
  const std::size_t step = std::max<std::size_t>(1, all / kPixels);
  for (std::size_t n = 0; n < all; n += step) {
    values.push_back(images.phases[n / images.grid.count()][n % images.grid.count()]);
  }
  std::sort(values.begin(), values.end());
  const auto last = static_cast<double>(values.size() - 1);
  const float low = values[static_cast<std::size_t>(kEnd * last)];
  const float high = values[static_cast<std::size_t>((1 - kEnd) * last)];
  return high > 0 && low > -kLeastBelow * high;
}

/// Takes the gains off the slices that have uneven ones. @return the gains, 1 where none was taken
/// off
std::vector<std::vector<double>> take_off(ImageCycle<float>& images) {
  std::vector<std::vector<double>> gains = frame_gains(images);
  parallel_for(gains.size(), [&](std::size_t k) {
    std::vector<double>& of_slice = gains[k];
    if (std::none_of(of_slice.begin(), of_slice.end(), is_uneven)) {
      std::fill(of_slice.begin(), of_slice.end(), 1.0);
      return;
    }
    const std::size_t begin = images.grid.offset(0, 0, static_cast<int>(k));
    for (std::size_t p = 0; p < of_slice.size(); ++p) {
      const auto by = static_cast<float>(1 / of_slice[p]);
      for (std::size_t v = begin; v < begin + images.grid.slice_count(); ++v) {
        images.phases[p][v] *= by;
      }
    }
  });
  return gains;
}

}  // namespace

std::vector<std::vector<double>> frame_gains(const ImageCycle<float>& images) {
  std::vector<std::vector<double>> out(static_cast<std::size_t>(images.grid.size[2]),
                                       std::vector<double>(images.phases.size(), 1.0));
  if (is_narrow_field(images.grid) || !counts_from_nothing(images)) return out;
  parallel_for(out.size(), [&](std::size_t k) {
    out[k] = gains_of_slice(images, static_cast<int>(k));
    for (double& gain : out[k]) gain = std::exp(gain);
  });
  return out;
}

Exam with_even_frames(Exam exam) {
  for (Cine& view : exam.views) (void)take_off(view.images);
  const std::vector<std::vector<double>> gains = take_off(exam.stack.images);
  int uneven = 0;
  double most = 0;
  std::string where;
  for (std::size_t k = 0; k < gains.size(); ++k) {
    for (std::size_t p = 0; p < gains[k].size(); ++p) {
      if (!is_uneven(gains[k][p])) continue;
      ++uneven;
      if (std::abs(std::log(gains[k][p])) <= most) continue;
      most = std::abs(std::log(gains[k][p]));
      where = std::to_string(static_cast<int>(std::lround(100 * std::abs(gains[k][p] - 1)))) +
              " % " + (gains[k][p] > 1 ? "brighter" : "darker") + ", phase " + std::to_string(p) +
              " of slice " + std::to_string(k);
    }
  }
  if (uneven > 0) {
    exam.decisions.push_back(
        "Warning: the brightness of whole images changes from phase to phase (" +
        std::to_string(uneven) + " of " +
        std::to_string(gains.size() * exam.stack.images.phases.size()) + " images; most " + where +
        " than the slice's middle one); it was made even.");
  }
  return exam;
}

}  // namespace beatlas::motion
