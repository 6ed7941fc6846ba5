#include "pipeline/segment/tissue.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "runtime/atlas/structures.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

double median_of(std::vector<float>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double quantile_of(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto index = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[static_cast<std::size_t>(index)];
}

/// A Gaussian of sigma 0.7 pixel keeps 1 / (4 pi 0.49) of white noise's variance.
constexpr double kSmoothedVariance = 0.1624;

/// The swing [in standard deviations of the noise] that noise alone exceeds in two voxels of a
/// thousand: a quantile of chi-squared (Wilson and Hilferty 1931). The fewer the phases, the wider.
double swing_of_noise(int phases) {
  const double freedom = std::max(1, phases - 1);
  const double part = 2 / (9 * freedom);
  const double quantile = freedom * std::pow(1 - part + 2.878 * std::sqrt(part), 3);
  return std::sqrt(kSmoothedVariance * std::max(0.0, quantile / (freedom + 1) - 1));
}

/// Ascending, by the digits of their bits: millions of intensities, no comparisons.
void sort_floats(std::vector<float>& values) {
  constexpr int kDigitBits = 11;
  constexpr std::uint32_t kDigits = 1U << kDigitBits;
  constexpr std::uint32_t kSign = 0x80000000U;
  // Bits that sort as the numbers do: negative ones turned round.
  std::vector<std::uint32_t> keys(values.size());
  std::transform(values.begin(), values.end(), keys.begin(), [](float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return (bits & kSign) != 0 ? ~bits : bits | kSign;
  });
  std::vector<std::uint32_t> sorted(keys.size());
  for (int shift = 0; shift < 32; shift += kDigitBits) {
    std::vector<std::size_t> first(kDigits + 1, 0);
    for (const std::uint32_t key : keys) ++first[(key >> shift) % kDigits + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    for (const std::uint32_t key : keys) sorted[first[(key >> shift) % kDigits]++] = key;
    keys.swap(sorted);
  }
  std::transform(keys.begin(), keys.end(), values.begin(), [](std::uint32_t key) {
    return std::bit_cast<float>((key & kSign) != 0 ? key & ~kSign : ~key);
  });
}

}  // namespace

/// Noise from temporal second differences of voxels that hold signal: what is left after motion
/// slower than two phases; the median ignores the few voxels that move faster. Air is left out:
/// where there is no signal, magnitude images show only two thirds of the noise.
double noise_level(const ImageCycle<float>& images) {
  const int n = images.phase_count();
  const std::size_t count = images.grid.count();
  const std::size_t stride = std::max<std::size_t>(1, count / 200000);
  std::vector<float> sampled;
  for (std::size_t v = 0; v < count; v += stride) sampled.push_back(images.phases[0][v]);
  const double dark = quantile_of(sampled, 0.02);
  const double signal = dark + 0.2 * (quantile_of(sampled, 0.98) - dark);
  std::vector<float> residuals;
  for (std::size_t v = 0; v < count; v += stride) {
    const int p = static_cast<int>(v / stride) % n;
    const double before = images.phases[static_cast<std::size_t>((p + n - 1) % n)][v];
    const double here = images.phases[static_cast<std::size_t>(p)][v];
    const double after = images.phases[static_cast<std::size_t>((p + 1) % n)][v];
    // Of two phases each is the other's neighbour on both sides. The means choose voxels without
    // favour: they are uncorrelated with the differences.
    const double mean = n == 2 ? (here + after) / 2 : (before + here + after) / 3;
    if (mean < signal) continue;
    residuals.push_back(static_cast<float>(std::abs(here - 0.5 * (before + after)) /
                                           std::sqrt(n == 2 ? 2.0 : 1.5)));
  }
  return median_of(residuals) / 0.6745;
}

std::vector<float> smooth_in_plane(const Grid& grid, const std::vector<float>& image,
                                   double sigma_mm) {
  if (sigma_mm <= 0) return image;
  std::vector<float> out(image.size());
  const Vec3 spacing = grid.spacing_mm();
  for (int k = 0; k < grid.size[2]; ++k) {
    const std::size_t begin = grid.offset(0, 0, k);
    const cv::Mat source(grid.size[1], grid.size[0], CV_32F,
                         const_cast<float*>(image.data() + begin));
    cv::Mat target(grid.size[1], grid.size[0], CV_32F, out.data() + begin);
    cv::GaussianBlur(source, target, cv::Size(0, 0), sigma_mm / spacing[0], sigma_mm / spacing[1],
                     cv::BORDER_REPLICATE);
  }
  return out;
}

TemporalStats temporal_stats(const ImageCycle<float>& images) {
  const auto n = static_cast<std::size_t>(images.phase_count());
  const std::size_t count = images.grid.count();
  TemporalStats stats;
  stats.noise = noise_level(images);
  stats.phases = images.phase_count();
  stats.low.assign(count, 0);
  stats.high.assign(count, 0);
  stats.mean.assign(count, 0);
  stats.swing.assign(count, 0);

  // One slice a task, so that only a slice's smoothed phases are alive at once.
  const std::size_t slice = images.grid.slice_count();
  const Grid slice_grid =
      images.grid.part({0, 0, 0}, {images.grid.size[0], images.grid.size[1], 1});
  const double pixel_mm = slice_grid.spacing_mm().head<2>().maxCoeff();
  parallel_for(static_cast<std::size_t>(images.grid.size[2]), [&](std::size_t k) {
    std::vector<double> sum(slice, 0);
    std::vector<double> sum_squares(slice, 0);
    std::vector<float> low(slice, std::numeric_limits<float>::max());
    std::vector<float> high(slice, std::numeric_limits<float>::lowest());
    std::vector<float> plane(slice);
    for (std::size_t p = 0; p < n; ++p) {
      const float* source = images.phases[p].data() + k * slice;
      plane.assign(source, source + slice);
      const std::vector<float> smooth = smooth_in_plane(slice_grid, plane, 0.7 * pixel_mm);
      for (std::size_t v = 0; v < slice; ++v) {
        sum[v] += smooth[v];
        sum_squares[v] += static_cast<double>(smooth[v]) * smooth[v];
        low[v] = std::min(low[v], smooth[v]);
        high[v] = std::max(high[v], smooth[v]);
      }
    }
    const double noise_variance = stats.noise * stats.noise * kSmoothedVariance;
    for (std::size_t v = 0; v < slice; ++v) {
      const double mean = sum[v] / static_cast<double>(n);
      const double variance = sum_squares[v] / static_cast<double>(n) - mean * mean;
      stats.low[k * slice + v] = low[v];
      stats.high[k * slice + v] = high[v];
      stats.mean[k * slice + v] = static_cast<float>(mean);
      stats.swing[k * slice + v] =
          static_cast<float>(std::sqrt(std::max(0.0, variance - noise_variance)));
    }
  });
  return stats;
}

Box find_moving_box(const Grid& grid, const TemporalStats& stats) {
  const Vec3 spacing = grid.spacing_mm();
  const double top = quantile_of(stats.swing, 0.998);
  const double signal = quantile_of(stats.mean, 0.98);
  const double of_noise = std::max(0.6, 1.33 * swing_of_noise(stats.phases)) * stats.noise;
  if (!(top > of_noise) || !(top > 0.02 * signal)) {
    throw_invalid(
        "no heart found: nothing in the images changes through the cycle by more than their noise");
  }
  const double threshold = 0.3 * top;

  // Motion energy, spread over 10 mm in plane, so that a heart outweighs vessels and ghosts.
  std::vector<float> energy(stats.swing.size());
  for (std::size_t v = 0; v < energy.size(); ++v) {
    energy[v] = std::max(0.0F, stats.swing[v] - static_cast<float>(threshold));
  }
  const std::vector<float> spread = smooth_in_plane(grid, energy, 10.0);

  // Centre: mean shift from the largest spread energy with a ball of 70 mm.
  const auto start =
      static_cast<std::size_t>(std::max_element(spread.begin(), spread.end()) - spread.begin());
  const Index3 first = index_of(grid, start);
  Vec3 centre(first[0], first[1], first[2]);
  const auto for_each_near = [&](double radius_mm, const auto& visit) {
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const float e = energy[grid.offset(i, j, k)];
          if (e <= 0) continue;
          const Vec3 d = (Vec3(i, j, k) - centre).cwiseProduct(spacing);
          if (d.squaredNorm() < radius_mm * radius_mm) visit(Vec3(i, j, k), e);
        }
      }
    }
  };
  for (int round = 0; round < 30; ++round) {
    Vec3 sum = Vec3::Zero();
    double weight = 0;
    for_each_near(70, [&](const Vec3& at, double e) {
      sum += e * at;
      weight += e;
    });
    const Vec3 next = sum / weight;
    const double step_mm = (next - centre).cwiseProduct(spacing).norm();
    centre = next;
    if (step_mm < 0.1) break;
  }

  // Extent: weighted 1..99 % along each axis, within 110 mm of the centre.
  std::array<std::vector<double>, 3> profile;
  for (std::size_t a = 0; a < 3; ++a) profile[a].assign(static_cast<std::size_t>(grid.size[a]), 0);
  for_each_near(110, [&](const Vec3& at, double e) {
    for (int a = 0; a < 3; ++a) {
      profile[static_cast<std::size_t>(a)][static_cast<std::size_t>(at[a])] += e;
    }
  });
  Box box;
  for (std::size_t a = 0; a < 3; ++a) {
    const double total = std::accumulate(profile[a].begin(), profile[a].end(), 0.0);
    int low = 0;
    int high = grid.size[a] - 1;
    for (double sum = 0;
         low < high && (sum += profile[a][static_cast<std::size_t>(low)]) < 0.01 * total;)
      ++low;
    for (double sum = 0;
         high > low && (sum += profile[a][static_cast<std::size_t>(high)]) < 0.01 * total;)
      --high;
    const int margin = static_cast<int>(std::ceil(20.0 / spacing[static_cast<int>(a)]));
    low = std::max(0, low - margin);
    high = std::min(grid.size[a] - 1, high + margin);
    box.first[a] = low;
    box.size[a] = high - low + 1;
  }
  return box;
}

template <class T>
ImageCycle<T> crop(const ImageCycle<T>& images, const Box& box) {
  ImageCycle<T> out;
  out.grid = images.grid.part(box.first, box.size);
  out.phases.resize(images.phases.size());
  parallel_for(images.phases.size(), [&](std::size_t p) {
    out.phases[p].reserve(out.grid.count());
    for (int k = 0; k < box.size[2]; ++k) {
      for (int j = 0; j < box.size[1]; ++j) {
        const auto from =
            images.phases[p].begin() + static_cast<std::ptrdiff_t>(images.grid.offset(
                                           box.first[0], box.first[1] + j, box.first[2] + k));
        out.phases[p].insert(out.phases[p].end(), from, from + box.size[0]);
      }
    }
  });
  return out;
}

template ImageCycle<float> crop(const ImageCycle<float>&, const Box&);
template ImageCycle<std::uint8_t> crop(const ImageCycle<std::uint8_t>&, const Box&);

void put_back(const ImageCycle<std::uint8_t>& labels, const Box& box,
              ImageCycle<std::uint8_t>& whole) {
  whole.phases.resize(labels.phases.size());
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    whole.phases[p].assign(whole.grid.count(), kLabelBackground);
    for (int k = 0; k < box.size[2]; ++k) {
      for (int j = 0; j < box.size[1]; ++j) {
        const auto from =
            labels.phases[p].begin() + static_cast<std::ptrdiff_t>(labels.grid.offset(0, j, k));
        std::copy(from, from + box.size[0],
                  whole.phases[p].begin() + static_cast<std::ptrdiff_t>(whole.grid.offset(
                                                box.first[0], box.first[1] + j, box.first[2] + k)));
      }
    }
  });
}

double otsu_threshold(std::vector<float> values) {
  if (values.empty()) return 0;
  sort_floats(values);
  // Ends are clipped so that a few bright pixels do not stretch the classes.
  const float floor = values[values.size() / 200];
  const float ceiling = values[values.size() - 1 - values.size() / 200];
  const double total = std::accumulate(values.begin(), values.end(), 0.0, [&](double s, float v) {
    return s + std::clamp(v, floor, ceiling);
  });
  const auto n = static_cast<double>(values.size());
  double below = 0;
  double best = -1;
  double threshold = values.front();
  for (std::size_t i = 0; i + 1 < values.size(); ++i) {
    below += std::clamp(values[i], floor, ceiling);
    if (values[i + 1] == values[i]) continue;
    const double share = static_cast<double>(i + 1) / n;
    const double gap =
        below / static_cast<double>(i + 1) - (total - below) / (n - static_cast<double>(i + 1));
    const double between = share * (1 - share) * gap * gap;
    if (between > best) {
      best = between;
      threshold = 0.5 * (values[i] + values[i + 1]);
    }
  }
  return threshold;
}

}  // namespace beatlas::segment
