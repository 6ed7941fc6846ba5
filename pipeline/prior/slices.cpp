#include "pipeline/prior/slices.h"

#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"

namespace beatlas::prior {
namespace {

constexpr double kLowShare = 0.01;
constexpr double kHighShare = 0.995;
constexpr float kBrightest = 1.2F;
constexpr double kNearestMm = 4;    // a slice that is closer shows the same again
constexpr double kFarthestMm = 20;  // one that is farther shows other things
constexpr double kRimMm = 8;        // of the images' edges together, which may go unseen
constexpr double kTruncate = 4;     // standard deviations of a Gaussian that are summed
constexpr float kDeviationGain = 4;

float number(float value) { return std::isfinite(value) ? value : 0.0F; }

/// Linear between the two values beside the place. Reorders.
float percentile(std::vector<float>& values, double share) {
  const double place = share * static_cast<double>(values.size() - 1);
  const auto at = static_cast<std::size_t>(place);
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(at);
  std::nth_element(values.begin(), nth, values.end());
  const float below = *nth;
  if (at + 1 == values.size()) return below;
  const float above = *std::min_element(nth + 1, values.end());
  return static_cast<float>(below + (place - static_cast<double>(at)) *
                                        (static_cast<double>(above) - below));
}

/// Weights of pixels -radius..radius, 1 in sum.
std::vector<double> gaussian(double sigma) {
  const int radius = sigma > 0 ? static_cast<int>(kTruncate * sigma + 0.5) : 0;
  std::vector<double> out;
  double sum = 0;
  for (int n = -radius; n <= radius; ++n) {
    out.push_back(sigma > 0 ? std::exp(-0.5 * n * n / (sigma * sigma)) : 1.0);
    sum += out.back();
  }
  for (double& weight : out) weight /= sum;
  return out;
}

int pixels(int source, double spacing_mm, double pixel_mm, int multiple) {
  const int all = std::max(1, static_cast<int>(std::lround(source * spacing_mm / pixel_mm)));
  const int beyond = all % multiple;
  const bool few = all > multiple && 4 * beyond <= multiple && beyond * pixel_mm <= kRimMm;
  return few ? all - beyond : all;
}

/// Where the first pixel of a lattice lies in the source, if both have the same middle.
double first_place(int source, int result, double factor) {
  return 0.5 * (source - 1) - 0.5 * (result - 1) * factor;
}

}  // namespace

std::vector<float> resampled(std::span<const float> image, int width, int height,
                             const AxisWeights& along, const AxisWeights& across) {
  const std::size_t columns = along.first.size();
  std::vector<float> rows(columns * static_cast<std::size_t>(height));
  for (int j = 0; j < height; ++j) {
    const float* from = image.data() + static_cast<std::ptrdiff_t>(j) * width;
    for (std::size_t a = 0; a < columns; ++a) {
      float sum = 0;
      int i = along.first[a];
      for (const float weight : along.weights[a]) {
        sum += weight * from[std::clamp(i++, 0, width - 1)];
      }
      rows[static_cast<std::size_t>(j) * columns + a] = sum;
    }
  }
  std::vector<float> out(columns * across.first.size(), 0.0F);
  for (std::size_t b = 0; b < across.first.size(); ++b) {
    float* to = out.data() + b * columns;
    int j = across.first[b];
    for (const float weight : across.weights[b]) {
      const float* from =
          rows.data() + static_cast<std::size_t>(std::clamp(j++, 0, height - 1)) * columns;
      for (std::size_t a = 0; a < columns; ++a) to[a] += weight * from[a];
    }
  }
  return out;
}

Grid network_grid(const Grid& stack, double pixel_mm, int multiple) {
  const Vec3 spacing = stack.spacing_mm();
  Grid out;
  out.size = {pixels(stack.size[0], spacing[0], pixel_mm, multiple),
              pixels(stack.size[1], spacing[1], pixel_mm, multiple), stack.size[2]};
  const double fi = pixel_mm / spacing[0];
  const double fj = pixel_mm / spacing[1];
  out.mm_from_index = stack.mm_from_index;
  out.mm_from_index.linear().col(0) *= fi;
  out.mm_from_index.linear().col(1) *= fj;
  out.mm_from_index.translation() = stack.mm(first_place(stack.size[0], out.size[0], fi),
                                             first_place(stack.size[1], out.size[1], fj), 0);
  return out;
}

float Brightness::of(float value, float tone) const {
  if (high <= low) return 0;
  const float shown = std::clamp((number(value) - low) / (high - low), 0.0F, kBrightest);
  return tone == kUsualTone ? std::sqrt(shown) : std::pow(shown, tone);
}

Brightness brightness_of(const ImageCycle<float>& images, int slice) {
  const std::size_t pixels_of_slice = images.grid.slice_count();
  const std::size_t first = pixels_of_slice * static_cast<std::size_t>(slice);
  std::vector<float> values;
  values.reserve(pixels_of_slice * images.phases.size());
  for (const std::vector<float>& phase : images.phases) {
    for (std::size_t v = first; v < first + pixels_of_slice; ++v) {
      values.push_back(number(phase[v]));
    }
  }
  Brightness out;
  out.low = percentile(values, kLowShare);
  out.high = percentile(values, kHighShare);
  return out;
}

AxisWeights axis_weights(int source, int result, double factor) {
  const std::vector<double> smooth = gaussian(std::max(0.0, 0.5 * (factor - 1)));
  const int radius = static_cast<int>(smooth.size() / 2);
  AxisWeights out;
  for (int o = 0; o < result; ++o) {
    const double place =
        std::clamp(first_place(source, result, factor) + o * factor, 0.0, source - 1.0);
    const int below = static_cast<int>(place);
    const double share = place - below;
    std::vector<float> weights;
    for (int n = 0; n <= 2 * radius + 1; ++n) {
      const double here = n <= 2 * radius ? smooth[static_cast<std::size_t>(n)] : 0;
      const double before = n > 0 ? smooth[static_cast<std::size_t>(n) - 1] : 0;
      weights.push_back(static_cast<float>((1 - share) * here + share * before));
    }
    out.first.push_back(below - radius);
    out.weights.push_back(std::move(weights));
  }
  return out;
}

std::optional<int> neighbour_of(int slice, int step, int slices, double spacing_mm,
                                double neighbour_mm) {
  const int away = std::max(1, static_cast<int>(std::lround(neighbour_mm / spacing_mm)));
  const int found = std::clamp(slice + step * away, 0, slices - 1);
  const double distance_mm = std::abs(found - slice) * spacing_mm;
  const bool cut_short = found != slice + step * away;
  if (found == slice || distance_mm > kFarthestMm) return std::nullopt;
  if (cut_short && distance_mm < kNearestMm) return std::nullopt;
  return found;
}

SeenSlices see(const Cine& stack, const ModelCard& card, const StageContext& context, float tone) {
  const Grid& grid = stack.grid();
  const Vec3 spacing = grid.spacing_mm();
  SeenSlices out;
  out.grid = network_grid(grid, card.pixel_mm, card.multiple);
  const AxisWeights along =
      axis_weights(grid.size[0], out.grid.size[0], card.pixel_mm / spacing[0]);
  const AxisWeights across =
      axis_weights(grid.size[1], out.grid.size[1], card.pixel_mm / spacing[1]);
  const auto slices = static_cast<std::size_t>(grid.size[2]);
  const std::size_t phases = stack.images.phases.size();
  out.frames.resize(slices);
  out.means.resize(slices);
  out.deviations.resize(slices);
  parallel_for(slices, context, "slice", [&](std::size_t k) {
    const Brightness brightness = brightness_of(stack.images, static_cast<int>(k));
    const std::size_t source = grid.slice_count();
    const std::size_t seen = out.grid.slice_count();
    std::vector<float> image(source);
    std::vector<double> sums(seen, 0.0);
    for (const std::vector<float>& phase : stack.images.phases) {
      const auto from = phase.begin() + static_cast<std::ptrdiff_t>(source * k);
      std::transform(from, from + static_cast<std::ptrdiff_t>(source), image.begin(),
                     [&](float value) { return brightness.of(value, tone); });
      out.frames[k].push_back(resampled(image, grid.size[0], grid.size[1], along, across));
      for (std::size_t v = 0; v < seen; ++v) sums[v] += out.frames[k].back()[v];
    }
    std::vector<double> squares(seen, 0.0);
    for (const std::vector<float>& frame : out.frames[k]) {
      for (std::size_t v = 0; v < seen; ++v) {
        const double off = frame[v] - sums[v] / static_cast<double>(phases);
        squares[v] += off * off;
      }
    }
    out.means[k].resize(seen);
    out.deviations[k].resize(seen);
    for (std::size_t v = 0; v < seen; ++v) {
      out.means[k][v] = static_cast<float>(sums[v] / static_cast<double>(phases));
      out.deviations[k][v] =
          kDeviationGain * static_cast<float>(std::sqrt(squares[v] / static_cast<double>(phases)));
    }
  });
  return out;
}

PaddedSize padded_size(const Window& window, int multiple) {
  const auto up = [&](int size) { return (size + multiple - 1) / multiple * multiple; };
  return {up(window.size[0]), up(window.size[1])};
}

void fill_input(const SeenSlices& seen, const ModelCard& card, int slice, int phase,
                const Window& window, std::vector<float>& input) {
  const PaddedSize padded = padded_size(window, card.multiple);
  const std::size_t plane =
      static_cast<std::size_t>(padded.width) * static_cast<std::size_t>(padded.height);
  input.assign(plane * card.channels.size(), 0.0F);
  const auto k = static_cast<std::size_t>(slice);
  const auto p = static_cast<std::size_t>(phase);
  // Of hearts that the network has seen rows, columns and slices were right-handed.
  const int up = seen.grid.mm_from_index.linear().determinant() < 0 ? -1 : 1;
  const auto beside = [&](int step) -> const std::vector<float>* {
    const std::optional<int> at = neighbour_of(slice, up * step, seen.grid.size[2],
                                               seen.grid.spacing_mm()[2], card.neighbour_mm);
    return at ? &seen.frames[static_cast<std::size_t>(*at)][p] : nullptr;
  };
  const auto shown = [&](Channel channel) -> const std::vector<float>* {
    switch (channel) {
      case Channel::Frame:
        return &seen.frames[k][p];
      case Channel::Below:
        return beside(-1);
      case Channel::Above:
        return beside(+1);
      case Channel::Mean:
        return &seen.means[k];
      case Channel::Deviation:
        break;
    }
    return &seen.deviations[k];
  };
  for (std::size_t c = 0; c < card.channels.size(); ++c) {
    const std::vector<float>* image = shown(card.channels[c]);
    if (image == nullptr) continue;
    for (int j = 0; j < window.size[1]; ++j) {
      const auto from = image->begin() + static_cast<std::ptrdiff_t>(seen.grid.offset(
                                             window.first[0], window.first[1] + j, 0));
      std::copy(from, from + window.size[0],
                input.begin() + static_cast<std::ptrdiff_t>(c * plane) +
                    static_cast<std::ptrdiff_t>(j) * padded.width);
    }
  }
}

}  // namespace beatlas::prior
