#include "pipeline/prior/orientations.h"

#include <algorithm>
#include <cmath>

namespace beatlas::prior {
namespace {

constexpr int kFewPhases = 4;  ///< cost little, and have fewer neighbours

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
        use(v, row * width_ + column);
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

}  // namespace

Turns turns_of(int orientations, int phases, int slice, int phase) {
  if (phases <= kFewPhases) return {0, orientations};
  const int half = (orientations + 1) / 2;
  return {(slice + phase) % 2 == 0 ? 0 : orientations - half, half};
}

void run_turned(Network& network, const ModelCard& card, const std::vector<float>& input, int width,
                int height, const Turns& turns, std::vector<float>& probabilities) {
  const std::size_t plane = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const std::size_t outputs = card.outputs.size();
  probabilities.assign(outputs * plane, 0.0F);
  std::vector<float> turned(input.size());
  std::vector<float> likely(outputs);
  for (int n = turns.first; n < turns.first + turns.count; ++n) {
    const Orientation& how = kOrientations.at(static_cast<std::size_t>(n));
    const Turn turn(how, width, height);
    for (std::size_t c = 0; c < card.channels.size(); ++c) {
      const float* from = input.data() + c * plane;
      float* to = turned.data() + (how.swapped ? shown_as(card.channels, c) : c) * plane;
      turn.each([&](std::size_t v, std::size_t there) { to[there] = from[v]; });
    }
    const float* logits = network.run(turned, width, height).data();
    turn.each([&](std::size_t v, std::size_t there) {
      float most = logits[there];
      for (std::size_t o = 1; o < outputs; ++o) most = std::max(most, logits[o * plane + there]);
      float sum = 0;
      for (std::size_t o = 0; o < outputs; ++o) {
        likely[o] = std::exp(logits[o * plane + there] - most);
        sum += likely[o];
      }
      const float share = 1 / (sum * static_cast<float>(turns.count));
      for (std::size_t o = 0; o < outputs; ++o) probabilities[o * plane + v] += likely[o] * share;
    });
  }
}

}  // namespace beatlas::prior
