#include "pipeline/prior/orientations.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "pipeline/prior/slices.h"

namespace beatlas::prior {
namespace {

/// Runs of the network over an exam, where its images may have more than two each: as many as 25
/// phases of 12 slices take with two.
constexpr std::size_t kRuns = 600;
constexpr int kFewest = 2;  ///< an image has

/// Where pixels of a slice lie in the turned one.
class Turn {
 public:
  Turn(const Orientation& how, int width, int height)
      : how_(how),
        width_(static_cast<std::size_t>(width)),
        height_(static_cast<std::size_t>(height)) {}

  /// Calls with the offsets of each pixel in both.
  template <class Use>
  void each(const Use& use) const {
    std::size_t v = 0;
    for (std::size_t j = 0; j < height_; ++j) {
      const std::size_t row = how_.mirrored_rows ? height_ - 1 - j : j;
      for (std::size_t i = 0; i < width_; ++i, ++v) {
        const std::size_t column = how_.mirrored_columns ? width_ - 1 - i : i;
        use(v, how_.transposed ? column * height_ + row : row * width_ + column);
      }
    }
  }

 private:
  Orientation how_;
  std::size_t width_, height_;
};

/// The channel whose place a channel takes.
std::size_t shown_as(const std::vector<Channel>& channels, std::size_t channel) {
  Channel other = channels[channel];
  if (other == Channel::Below) {
    other = Channel::Above;
  } else if (other == Channel::Above) {
    other = Channel::Below;
  }
  const auto at = std::find(channels.begin(), channels.end(), other);
  return at == channels.end() ? channel : static_cast<std::size_t>(at - channels.begin());
}

/// A slice at one size, and what has been said of it.
struct Shown {
  int width = 0;
  int height = 0;
  std::vector<float> input;  ///< [channel][row][column]
  std::vector<float> sum;    ///< [output][row][column], probabilities of all views; empty: of none

  [[nodiscard]] std::size_t plane() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

/// About the same middle, as wide and high as the multiple makes it.
Shown enlarge(const Shown& plain, std::size_t channels, int multiple) {
  const auto size = [&](int pixels) {
    const int least = static_cast<int>(std::ceil(pixels * kEnlarged));
    return least + (multiple - least % multiple) % multiple;
  };
  Shown out{size(plain.width), size(plain.height), {}, {}};
  const AxisWeights along = axis_weights(plain.width, out.width, 1 / kEnlarged);
  const AxisWeights across = axis_weights(plain.height, out.height, 1 / kEnlarged);
  for (std::size_t c = 0; c < channels; ++c) {
    const std::vector<float> channel =
        resampled(std::span(plain.input).subspan(c * plain.plane(), plain.plane()), plain.width,
                  plain.height, along, across);
    out.input.insert(out.input.end(), channel.begin(), channel.end());
  }
  return out;
}

/// Adds what the network says of a slice that is shown so.
void add_view(Network& network, const ModelCard& card, const Orientation& how, Shown& shown) {
  const std::size_t plane = shown.plane();
  const std::size_t outputs = card.outputs.size();
  const Turn turn(how, shown.width, shown.height);
  std::vector<float> turned(shown.input.size());
  for (std::size_t c = 0; c < card.channels.size(); ++c) {
    const float* from = shown.input.data() + c * plane;
    float* to = turned.data() + (how.swapped ? shown_as(card.channels, c) : c) * plane;
    turn.each([&](std::size_t v, std::size_t there) { to[there] = from[v]; });
  }
  const float* logits = how.transposed ? network.run(turned, shown.height, shown.width).data()
                                       : network.run(turned, shown.width, shown.height).data();
  shown.sum.resize(outputs * plane, 0.0F);
  std::vector<float> likely(outputs);
  turn.each([&](std::size_t v, std::size_t there) {
    float most = logits[there];
    for (std::size_t o = 1; o < outputs; ++o) most = std::max(most, logits[o * plane + there]);
    float all = 0;
    for (std::size_t o = 0; o < outputs; ++o) {
      likely[o] = std::exp(logits[o * plane + there] - most);
      all += likely[o];
    }
    for (std::size_t o = 0; o < outputs; ++o) shown.sum[o * plane + v] += likely[o] / all;
  });
}

}  // namespace

TurnsOfImages::TurnsOfImages(int orientations, std::size_t images)
    : orientations_(orientations), count_(orientations), parts_(1) {
  while (count_ > kFewest && static_cast<std::size_t>(count_) * images > kRuns) {
    count_ = (count_ + 1) / 2;
    parts_ *= 2;
  }
}

Turns TurnsOfImages::of(int slice, int phase) const {
  // A step in time is the next part; a step in space is half of them, so that two slices of two
  // phases have four parts.
  const int part = (phase + slice * std::max(1, parts_ / 2)) % parts_;
  return {std::min(part * count_, orientations_ - count_), count_};
}

void run_turned(Network& network, const ModelCard& card, const std::vector<float>& input, int width,
                int height, const Turns& turns, std::vector<float>& probabilities) {
  Shown plain{width, height, {input.begin(), input.end()}, {}};
  Shown enlarged;
  for (int n = turns.first; n < turns.first + turns.count; ++n) {
    const Orientation& how = kOrientations.at(static_cast<std::size_t>(n));
    if (how.enlarged && enlarged.input.empty()) {
      enlarged = enlarge(plain, card.channels.size(), card.multiple);
    }
    add_view(network, card, how, how.enlarged ? enlarged : plain);
  }
  const std::size_t plane = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  probabilities = std::move(plain.sum);
  probabilities.resize(card.outputs.size() * plane, 0.0F);
  if (!enlarged.sum.empty()) {
    const AxisWeights along = axis_weights(enlarged.width, width, kEnlarged);
    const AxisWeights across = axis_weights(enlarged.height, height, kEnlarged);
    const std::size_t large = enlarged.sum.size() / card.outputs.size();
    for (std::size_t o = 0; o < card.outputs.size(); ++o) {
      const std::vector<float> part = resampled(std::span(enlarged.sum).subspan(o * large, large),
                                                enlarged.width, enlarged.height, along, across);
      for (std::size_t v = 0; v < plane; ++v) probabilities[o * plane + v] += part[v];
    }
  }
  const float share = 1 / static_cast<float>(turns.count);
  for (float& probability : probabilities) probability *= share;
}

}  // namespace beatlas::prior
