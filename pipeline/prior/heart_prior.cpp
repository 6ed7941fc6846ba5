#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/prior/network.h"
#include "pipeline/prior/prior.h"
#include "pipeline/prior/slices.h"
#include "runtime/base/error.h"

namespace beatlas::prior {
namespace {

constexpr double kSeen = 0.1;  // share of the time before the network runs

/// Logits of one pixel -> its log-probabilities as they are stored.
class Softmax {
 public:
  explicit Softmax(std::size_t outputs) : logits_(outputs) {}

  /// @param from, to first output of the pixel; the others follow at these distances
  void store(const float* from, std::size_t from_step, std::int8_t* to, std::size_t to_step) {
    for (std::size_t o = 0; o < logits_.size(); ++o) logits_[o] = from[o * from_step];
    const float most = *std::max_element(logits_.begin(), logits_.end());
    float sum = 0;
    for (const float logit : logits_) sum += std::exp(logit - most);
    const float log_sum = most + std::log(sum);
    for (std::size_t o = 0; o < logits_.size(); ++o) {
      const float log = logits_[o] - log_sum;
      // What is no number is as unlikely as can be.
      const bool likely = log > static_cast<float>(PriorCycle::kLeast);
      const float kept = likely ? std::min(log, 0.0F) : static_cast<float>(PriorCycle::kLeast);
      to[o * to_step] = static_cast<std::int8_t>(std::lround(kept * PriorCycle::kUnits));
    }
  }

 private:
  std::vector<float> logits_;
};

}  // namespace

PriorCycle heart_prior(const Exam& exam, const Model& model, StageContext& context) {
  const Cine& stack = exam.stack;
  if (stack.grid().count() == 0 || stack.phase_count() == 0) {
    throw_invalid("the stack has no images, so nothing in it can be told");
  }
  const ModelCard& card = model.card();
  const SeenSlices seen = see(stack, card, context.part(0, kSeen));
  const PaddedSize padded = padded_size(seen.grid, card.multiple);
  const std::size_t plane =
      static_cast<std::size_t>(padded.width) * static_cast<std::size_t>(padded.height);
  const std::size_t outputs = card.outputs.size();
  const std::size_t voxels = seen.grid.count();
  PriorCycle out;
  out.grid = seen.grid;
  out.labels = card.outputs;
  out.phases.resize(stack.images.phases.size());
  for (std::vector<std::int8_t>& phase : out.phases) phase.resize(outputs * voxels);

  const auto slices = static_cast<std::size_t>(seen.grid.size[2]);
  const StageContext running = context.part(kSeen, 1);
  NetworkPool networks(model);
  with_quiet_opencv([&] {
    parallel_for(out.phases.size() * slices, running, "image", [&](std::size_t at) {
      const std::size_t p = at / slices;
      const std::size_t k = at % slices;
      std::vector<float> input;
      fill_input(seen, card, static_cast<int>(k), static_cast<int>(p), input);
      Softmax softmax(outputs);
      networks.with([&](Network& network) {
        const float* logits = network.run(input, padded.width, padded.height).data();
        for (int j = 0; j < seen.grid.size[1]; ++j) {
          const float* from = logits + static_cast<std::ptrdiff_t>(j) * padded.width;
          std::int8_t* to = out.phases[p].data() + seen.grid.offset(0, j, static_cast<int>(k));
          for (int i = 0; i < seen.grid.size[0]; ++i)
            softmax.store(from + i, plane, to + i, voxels);
        }
      });
    });
  });
  return out;
}

}  // namespace beatlas::prior
