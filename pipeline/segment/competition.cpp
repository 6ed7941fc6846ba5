#include "pipeline/segment/competition.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>

#include "pipeline/core/parallel.h"

namespace beatlas::segment {
namespace {

constexpr double kUnitsPerMm = 16;
constexpr std::uint32_t kMaxArc = 4095;  ///< dearest step, in units: 256 mm worth
constexpr std::uint32_t kBuckets = kMaxArc + 1;

/// Cost and label of a voxel in one number, so that the lesser number is the winner: the cheaper
/// one, and of two as cheap the lower label. What a voxel gets depends on those that are strictly
/// cheaper and on nothing else, so no order of work, and no number of threads, can change it.
using State = std::uint32_t;
constexpr int kLabelBits = 3;
constexpr State kUnreached = std::numeric_limits<State>::max();
static_assert(VoxelPrices::kLabels <= 1 << kLabelBits);

constexpr State state_of(std::uint32_t cost, std::uint32_t label) {
  return cost << kLabelBits | label;
}
constexpr std::uint32_t cost_of(State state) { return state >> kLabelBits; }
constexpr std::uint32_t label_of(State state) { return state & ((1U << kLabelBits) - 1); }

using Node = std::uint32_t;  ///< phase * voxels + voxel

/// The fronts of all labels, which move outward together. A step costs kMaxArc at most and one
/// unit at least, so a ring of buckets is a full queue, and those of one bucket are done at once.
class Fronts {
 public:
  explicit Fronts(const CompetitionInput& input)
      : in_(input),
        count_(static_cast<Node>(input.images.grid.count())),
        phases_(static_cast<Node>(input.images.phase_count())),
        nodes_(std::size_t{count_} * phases_),
        state_(std::make_unique_for_overwrite<State[]>(nodes_)) {
    parallel_for(phases_, [&](std::size_t p) {
      for (std::size_t v = 0; v < count_; ++v) {
        const std::size_t node = p * count_ + v;
        const std::uint8_t seed = input.seeds[p][v];
        state_[node] = seed != kUnlabelled ? state_of(0, seed) : kUnreached;
      }
    });
  }

  void run(StageContext& context) {
    // Seeds, the first bucket, are found where they lie.
    parallel_for(kLanes, [&](std::size_t lane) {
      const auto end = static_cast<Node>(nodes_ * (lane + 1) / kLanes);
      for (auto node = static_cast<Node>(nodes_ * lane / kLanes); node < end; ++node) {
        if (cost_of(state_[node]) == 0) spread(node, 0, queues_[lane]);
      }
    });
    std::size_t visited = 0;
    std::uint32_t empty_run = 0;
    std::vector<Node> current;
    for (std::uint32_t cost = 1; empty_run <= kMaxArc; ++cost) {
      current.clear();
      for (Queue& queue : queues_) {
        std::vector<Node>& bucket = queue[cost % kBuckets];
        current.insert(current.end(), bucket.begin(), bucket.end());
        bucket.clear();
      }
      empty_run = current.empty() ? empty_run + 1 : 0;
      if (current.empty()) continue;
      const auto part = [&](std::size_t lane, std::size_t lanes) {
        const std::size_t end = current.size() * (lane + 1) / lanes;
        for (std::size_t at = current.size() * lane / lanes; at < end; ++at) {
          spread(current[at], cost, queues_[lane]);
        }
      };
      if (current.size() < kWorthSharing) {
        part(0, 1);
      } else {
        parallel_for(kLanes, [&](std::size_t lane) { part(lane, kLanes); });
      }
      if ((visited >> 17) != ((visited + current.size()) >> 17)) {
        context.check_cancelled();
        context.progress(std::min(1.0, static_cast<double>(visited) / static_cast<double>(nodes_)));
      }
      visited += current.size();
    }
  }

  [[nodiscard]] ImageCycle<std::uint8_t> labels() const {
    ImageCycle<std::uint8_t> out{in_.images.grid, {}};
    out.phases.resize(phases_);
    parallel_for(phases_, [&](std::size_t p) {
      out.phases[p].resize(count_);
      for (std::size_t v = 0; v < count_; ++v) {
        const State state = state_[p * count_ + v];
        out.phases[p][v] =
            state == kUnreached ? kUnlabelled : static_cast<std::uint8_t>(label_of(state));
      }
    });
    return out;
  }

 private:
  static constexpr std::size_t kLanes = 4;  ///< parts that a bucket is worked on in
  static constexpr std::size_t kWorthSharing = 4096;
  using Queue = std::array<std::vector<Node>, kBuckets>;
  using Steps = std::vector<std::vector<motion::PlaneStep>>;  ///< [phase][voxel]

  /// Offers what lies around a node its label.
  void spread(Node node, std::uint32_t cost, Queue& queue) {
    // Neighbours of other parts of the bucket may change it meanwhile, but to nothing cheaper.
    const State here = std::atomic_ref(state_[node]).load(std::memory_order_relaxed);
    if (cost_of(here) != cost) return;  // reached more cheaply since
    const Grid& grid = in_.images.grid;
    const auto nx = static_cast<Node>(grid.size[0]);
    const auto slice = static_cast<Node>(grid.slice_count());
    const Node p = node / count_;
    const Node v = node - p * count_;
    const Node in_slice = v % slice;
    const Node i = in_slice % nx;
    const std::uint32_t label = label_of(here);
    const float* image = in_.images.phases[p].data();
    const float level = image[v];
    const auto per_mm = [&](Node to) {
      const std::size_t phase = to / count_;
      const std::size_t voxel = to % count_;
      return in_.prices.phases[phase][voxel * VoxelPrices::kLabels + label] *
             (1.0 / VoxelPrices::kUnits);
    };
    const auto offer = [&](Node to, float there, double step_mm) {
      std::atomic_ref<State> target(state_[to]);
      State held = target.load(std::memory_order_relaxed);
      if (cost_of(held) <= cost) return;
      const double jump = std::abs(there - level) - in_.edge_free;
      const double price = step_mm * per_mm(to) + (jump > 0 ? in_.edge_cost * jump : 0.0);
      const auto arc = static_cast<std::uint32_t>(
          std::clamp(price * kUnitsPerMm, 1.0, static_cast<double>(kMaxArc)));
      const State offered = state_of(cost + arc, label);
      while (offered < held) {
        if (!target.compare_exchange_weak(held, offered, std::memory_order_relaxed)) continue;
        // As cheap as before: it waits there already.
        if (cost_of(held) != cost + arc) queue[(cost + arc) % kBuckets].push_back(to);
        break;
      }
    };
    if (i > 0) offer(node - 1, image[v - 1], spacing_[0]);
    if (i + 1 < nx) offer(node + 1, image[v + 1], spacing_[0]);
    if (in_slice >= nx) offer(node - nx, image[v - nx], spacing_[1]);
    if (in_slice + nx < slice) offer(node + nx, image[v + nx], spacing_[1]);
    if (v >= slice) offer(node - slice, image[v - slice], spacing_[2]);
    if (v + slice < count_) offer(node + slice, image[v + slice], spacing_[2]);
    if (phases_ < 2) return;
    const auto offer_in = [&](Node phase, Node to) {
      offer(phase * count_ + to, in_.images.phases[phase][to], in_.phase_step_mm);
    };
    offer_in(p + 1 < phases_ ? p + 1 : 0, moved(p, v, &motion::PhaseMotion::to_next));
    offer_in(p > 0 ? p - 1 : phases_ - 1, moved(p, v, &motion::PhaseMotion::to_previous));
  }

  /// Where what a voxel of phase p holds lies in the phase after or before; there if not known.
  [[nodiscard]] Node moved(Node p, Node voxel, Steps motion::PhaseMotion::*steps) const {
    if (in_.motion == nullptr) return voxel;
    const motion::PlaneStep step = (in_.motion->*steps)[p][voxel];
    return static_cast<Node>(static_cast<std::ptrdiff_t>(voxel) + step[0] +
                             step[1] * static_cast<std::ptrdiff_t>(in_.images.grid.size[0]));
  }

  const CompetitionInput& in_;
  Node count_;
  Node phases_;
  Vec3 spacing_ = in_.images.grid.spacing_mm();
  std::size_t nodes_;
  std::unique_ptr<State[]> state_;
  std::vector<Queue> queues_ = std::vector<Queue>(kLanes);
};

}  // namespace

ImageCycle<std::uint8_t> grow_in_competition(const CompetitionInput& input, StageContext& context) {
  Fronts fronts(input);
  fronts.run(context);
  return fronts.labels();
}

}  // namespace beatlas::segment
