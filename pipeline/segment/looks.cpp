#include "pipeline/segment/looks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace beatlas::segment {
namespace {

constexpr double kUnseen = 0.02;    ///< least density of a bin, over that of all bins alike
constexpr double kPricePerNat = 2;  ///< of improbability, over the price of a sure millimetre

}  // namespace

Bins::Bins(const ImageCycle<float>& images) {
  std::vector<float> some;
  for (const std::vector<float>& phase : images.phases) {
    for (std::size_t v = 0; v < phase.size(); v += 7) some.push_back(phase[v]);
  }
  const auto at =
      some.begin() + static_cast<std::ptrdiff_t>(0.995 * (static_cast<double>(some.size()) - 1.0));
  std::nth_element(some.begin(), at, some.end());
  top_ = std::max(*at, 1e-6F);
}

std::size_t Bins::of(float value) const {
  return static_cast<std::size_t>(
      std::clamp(static_cast<int>(value / top_ * kLookBins), 0, kLookBins - 1));
}

Look density_of(const Look& counts, double sigma) {
  std::vector<double> weights{6, 4, 1};
  if (sigma > 1) {
    weights.clear();
    for (int d = 0; d <= 3 * sigma; ++d) weights.push_back(std::exp(-0.5 * d * d / sigma / sigma));
  }
  Look smooth{};
  for (int b = 0; b < kLookBins; ++b) {
    for (int d = 1 - static_cast<int>(weights.size()); d < static_cast<int>(weights.size()); ++d) {
      const auto from = static_cast<std::size_t>(std::clamp(b + d, 0, kLookBins - 1));
      smooth[static_cast<std::size_t>(b)] +=
          weights[static_cast<std::size_t>(std::abs(d))] * counts[from];
    }
  }
  const double sum = std::accumulate(smooth.begin(), smooth.end(), 0.0);
  for (double& bin : smooth) {
    const double share = sum > 0 ? bin / sum : 1.0 / kLookBins;
    bin = (1 - kUnseen) * share * kLookBins + kUnseen;
  }
  return smooth;
}

Looks densities_of(const Looks& counts) {
  Looks out;
  std::transform(counts.begin(), counts.end(), out.begin(),
                 [](const Look& label) { return density_of(label); });
  return out;
}

void set_prices(const std::array<double, VoxelPrices::kLabels>& weights, std::uint8_t* price) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (std::size_t l = 0; l < weights.size(); ++l) {
    const double nats = -std::log(std::max(weights[l] / sum, 1e-4));
    const double units = VoxelPrices::kUnits * (1 + kPricePerNat * nats);
    price[l] = static_cast<std::uint8_t>(std::clamp(units, 1.0, 255.0));
  }
}

}  // namespace beatlas::segment
