#include "pipeline/tissue/shading.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>

#include "pipeline/core/parallel.h"

namespace beatlas::tissue {
namespace {

constexpr int kTerms = 9;              ///< of degree 1 and 2 in three variables
constexpr double kStepMm = 4;          ///< between voxels that are looked at
constexpr double kSmoothMm = 1;        ///< Gaussian in plane, before
constexpr double kSignalShare = 0.15;  ///< of the bright: less is air, lung or bone
constexpr double kRidge = 1e-3;        ///< of the mean diagonal: what nothing tells of stays flat
constexpr double kStillShare = 0.03;   ///< of the mean, beside the noise: changes less
constexpr std::size_t kFewestSamples = 2000;  ///< less may be one body, whose form feigns a field
constexpr int kShadeRounds = 60;
constexpr double kWidest = 0.25;       ///< of the histogram's smoothing, in the first round
constexpr double kNarrowest = 0.06;    ///< in the last ones
constexpr double kNarrowing = 0.93;    ///< a round
constexpr double kLeastSpread = 0.15;  ///< of the field's logarithm: less is what anatomy feigns

using Terms = Eigen::Matrix<double, kTerms, 1>;

/// Products of Legendre polynomials of the place in the box, -1..1 along each axis.
Terms terms_at(const Vec3& place) {
  const auto second = [](double x) { return (3 * x * x - 1) / 2; };
  const double x = place[0];
  const double y = place[1];
  const double z = place[2];
  Terms out;
  out << x, y, z, x * y, y * z, z * x, second(x), second(y), second(z);
  return out;
}

/// A voxel that is looked at.
struct Sample {
  Terms terms;
  double logarithm = 0;
};

class Logarithms {
 public:
  Logarithms(const Grid& grid, const TemporalStats& stats)
      : grid_(grid), stats_(stats), smooth_(smooth_in_plane(grid, stats.mean, kSmoothMm)) {
    std::vector<float> sorted = smooth_;
    const auto bright = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 95 / 100);
    std::nth_element(sorted.begin(), bright, sorted.end());
    least_ = std::max(kSignalShare * *bright, 3 * stats.noise);
    for (int a = 0; a < 3; ++a) {
      const int step = static_cast<int>(std::lround(kStepMm / grid.spacing_mm()[a]));
      step_[static_cast<std::size_t>(a)] = std::max(1, step);
    }
  }

  /// Values have an offset: no gain multiplies them.
  [[nodiscard]] bool below_zero() const {
    return *std::min_element(smooth_.begin(), smooth_.end()) < -0.05 * least_ / kSignalShare;
  }
  [[nodiscard]] bool still(int i, int j, int k) const {
    const std::size_t v = grid_.offset(i, j, k);
    return stats_.swing[v] < stats_.noise + kStillShare * stats_.mean[v];
  }
  [[nodiscard]] bool has(int i, int j, int k) const {
    return smooth_[grid_.offset(i, j, k)] > least_;
  }
  [[nodiscard]] Vec3 place(int i, int j, int k) const {
    const auto along = [](int at, int size) { return size > 1 ? 2.0 * at / (size - 1) - 1 : 0.0; };
    return {along(i, grid_.size[0]), along(j, grid_.size[1]), along(k, grid_.size[2])};
  }
  [[nodiscard]] double value(int i, int j, int k) const {
    return std::log(static_cast<double>(smooth_[grid_.offset(i, j, k)]));
  }
  [[nodiscard]] const std::array<int, 3>& step() const { return step_; }

  [[nodiscard]] std::vector<Sample> samples() const {
    std::vector<Sample> out;
    for (int k = 0; k < grid_.size[2]; k += step_[2]) {
      for (int j = 0; j < grid_.size[1]; j += step_[1]) {
        for (int i = 0; i < grid_.size[0]; i += step_[0]) {
          if (has(i, j, k) && still(i, j, k))
            out.push_back({terms_at(place(i, j, k)), value(i, j, k)});
        }
      }
    }
    return out;
  }

 private:
  const Grid& grid_;
  const TemporalStats& stats_;
  std::vector<float> smooth_;
  double least_ = 0;
  std::array<int, 3> step_{};
};

/// Where the mean of the histogram lies, seen from each of its bins through a Gaussian.
class Modes {
 public:
  Modes(const std::vector<double>& values, double width) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    low_ = *low - 4 * width;
    const auto bins = static_cast<std::size_t>((*high - *low + 8 * width) / kBin) + 2;
    std::vector<double> count(bins, 0);
    for (const double value : values) count[bin(value)] += 1;
    const auto reach = static_cast<int>(std::ceil(3 * width / kBin));
    mean_.assign(bins, 0);
    for (std::size_t b = 0; b < bins; ++b) {
      double sum = 0;
      double moment = 0;
      for (int d = -reach; d <= reach; ++d) {
        const auto at = static_cast<std::ptrdiff_t>(b) + d;
        if (at < 0 || at >= static_cast<std::ptrdiff_t>(bins)) continue;
        const double x = d * kBin / width;
        const double weight = std::exp(-0.5 * x * x) * count[static_cast<std::size_t>(at)];
        sum += weight;
        moment += weight * d * kBin;
      }
      mean_[b] = sum > 0 ? moment / sum : 0;
    }
  }

  /// What parts a value from the mean of those around it.
  [[nodiscard]] double above(double value) const { return -mean_[bin(value)]; }

 private:
  static constexpr double kBin = 0.01;
  [[nodiscard]] std::size_t bin(double value) const {
    return static_cast<std::size_t>(std::max(0.0, (value - low_) / kBin + 0.5));
  }
  double low_ = 0;
  std::vector<double> mean_;
};

Terms fit(const std::vector<Sample>& samples) {
  using Matrix = Eigen::Matrix<double, kTerms, kTerms>;
  Matrix normal = Matrix::Zero();
  for (const Sample& sample : samples) {
    normal.selfadjointView<Eigen::Lower>().rankUpdate(sample.terms);
  }
  normal.diagonal().array() += kRidge * normal.trace() / kTerms + 1e-12;
  const auto solver = normal.selfadjointView<Eigen::Lower>().ldlt();
  Terms found = Terms::Zero();
  std::vector<double> even(samples.size());
  double width = kWidest;
  for (int round = 0; round < kShadeRounds; ++round) {
    for (std::size_t n = 0; n < samples.size(); ++n) {
      even[n] = samples[n].logarithm - samples[n].terms.dot(found);
    }
    const Modes modes(even, width);
    Terms right = Terms::Zero();
    for (std::size_t n = 0; n < samples.size(); ++n) {
      right += modes.above(even[n]) * samples[n].terms;
    }
    found += solver.solve(right);
    width = std::max(kNarrowest, kNarrowing * width);
  }
  double sum = 0;
  double squares = 0;
  for (const Sample& sample : samples) {
    const double value = sample.terms.dot(found);
    sum += value;
    squares += value * value;
  }
  const auto count = static_cast<double>(samples.size());
  const double variance = squares / count - sum * sum / count / count;
  return variance > kLeastSpread * kLeastSpread ? found : Terms(Terms::Zero());
}

/// The step that most voxels share within 5 %; 0 unless more than half of all share it, and half as
/// many again as share none.
double shared_step(std::vector<double> steps) {
  constexpr double kWithin = 0.05;
  constexpr std::size_t kFewestSteps = 100;
  std::sort(steps.begin(), steps.end());
  const auto sharing = [&](double step) {
    return std::upper_bound(steps.begin(), steps.end(), step + kWithin) -
           std::lower_bound(steps.begin(), steps.end(), step - kWithin);
  };
  constexpr int kFarthest = 80;  // hundredths of the logarithm
  double best = 0;
  auto most = sharing(0);
  const auto none = most;
  for (int hundredths = -kFarthest; hundredths <= kFarthest; ++hundredths) {
    const auto count = sharing(0.01 * hundredths);
    if (count > most) {
      most = count;
      best = 0.01 * hundredths;
    }
  }
  const bool majority =
      steps.size() >= kFewestSteps && 2 * most > static_cast<std::ptrdiff_t>(steps.size());
  return majority && 2 * most > 3 * none ? best : 0;
}

/// [slice] logarithm of its gain beside the smooth field.
std::vector<double> slice_gains(const Grid& grid, const Logarithms& logs, const Terms& field) {
  std::vector<double> out(static_cast<std::size_t>(grid.size[2]), 0);
  for (int k = 0; k + 1 < grid.size[2]; ++k) {
    std::vector<double> steps;
    for (int j = 0; j < grid.size[1]; j += logs.step()[1]) {
      for (int i = 0; i < grid.size[0]; i += logs.step()[0]) {
        if (!logs.has(i, j, k) || !logs.has(i, j, k + 1)) continue;
        const double smooth =
            field.dot(terms_at(logs.place(i, j, k + 1)) - terms_at(logs.place(i, j, k)));
        steps.push_back(logs.value(i, j, k + 1) - logs.value(i, j, k) - smooth);
      }
    }
    const double step = shared_step(steps);
    out[static_cast<std::size_t>(k) + 1] = out[static_cast<std::size_t>(k)] + step;
  }
  return out;
}

}  // namespace

std::vector<float> find_shading(const Grid& grid, const TemporalStats& stats) {
  std::vector<float> out(grid.count(), 1.0F);
  const Logarithms logs(grid, stats);
  const auto slices = static_cast<std::size_t>(grid.size[2]);
  const std::vector<Sample> samples = logs.samples();
  if (samples.size() < kFewestSamples || logs.below_zero()) return out;
  const Terms field = fit(samples);
  const std::vector<double> gains = slice_gains(grid, logs, field);

  std::vector<double> sums(slices, 0);
  std::vector<double> counts(slices, 0);
  parallel_for(slices, [&](std::size_t slice) {
    const auto k = static_cast<int>(slice);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const double value = field.dot(terms_at(logs.place(i, j, k))) + gains[slice];
        out[grid.offset(i, j, k)] = static_cast<float>(value);
        if (!logs.has(i, j, k)) continue;
        sums[slice] += value;
        counts[slice] += 1;
      }
    }
  });
  double sum = 0;
  double all = 0;
  for (std::size_t k = 0; k < slices; ++k) {
    sum += sums[k];
    all += counts[k];
  }
  const double mean_log = all > 0 ? sum / all : 0;
  // A field fitted where there is signal may run away where there is none.
  for (float& value : out) {
    value = static_cast<float>(std::exp(std::clamp(value - mean_log, -1.2, 1.2)));
  }
  return out;
}

ImageCycle<float> without_shading(const ImageCycle<float>& images,
                                  const std::vector<float>& shading) {
  ImageCycle<float> out{images.grid, images.phases};
  parallel_for(images.phases.size(), [&](std::size_t p) {
    for (std::size_t v = 0; v < shading.size(); ++v) out.phases[p][v] /= shading[v];
  });
  return out;
}

}  // namespace beatlas::tissue
