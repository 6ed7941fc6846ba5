#include "pipeline/segment/competition.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace beatlas::segment {
namespace {

constexpr double kUnitsPerMm = 16;
constexpr std::uint32_t kMaxArc = 4095;  ///< dearest step, in units: 256 mm worth
constexpr std::uint32_t kUnreached = std::numeric_limits<std::uint32_t>::max();

}  // namespace

TravelCost::TravelCost(double top)
    : top_(top), table_(static_cast<std::size_t>(kLabels * kClasses * kBins), 1.0F) {}

float& TravelCost::at(int label, int voxel_class, int bin) {
  return table_[static_cast<std::size_t>((label * kClasses + voxel_class) * kBins + bin)];
}

float TravelCost::at(int label, int voxel_class, float intensity) const {
  const int bin = std::clamp(static_cast<int>(intensity / top_ * kBins), 0, kBins - 1);
  return table_[static_cast<std::size_t>((label * kClasses + voxel_class) * kBins + bin)];
}

double TravelCost::intensity_of(int bin) const { return (bin + 0.5) * top_ / kBins; }

ImageCycle<std::uint8_t> grow_in_competition(const CompetitionInput& input, StageContext& context) {
  const Grid& grid = input.images.grid;
  const auto phases = static_cast<std::size_t>(input.images.phase_count());
  const std::size_t count = grid.count();
  const Vec3 spacing = grid.spacing_mm();

  ImageCycle<std::uint8_t> labels{grid, input.seeds};
  std::vector<std::uint32_t> cost(count * phases, kUnreached);
  // Costs grow by at most kMaxArc from the front, so a ring of buckets is a full queue. Inside a
  // bucket nodes leave in the order they came: one thread, one order, one result.
  std::vector<std::vector<std::uint32_t>> buckets(kMaxArc + 1);
  for (std::size_t p = 0; p < phases; ++p) {
    for (std::size_t v = 0; v < count; ++v) {
      if (labels.phases[p][v] == kUnlabelled) continue;
      cost[p * count + v] = 0;
      buckets[0].push_back(static_cast<std::uint32_t>(p * count + v));
    }
  }

  const auto nx = static_cast<std::size_t>(grid.size[0]);
  const std::size_t slice = grid.slice_count();
  std::uint32_t settled_cost = 0;
  std::size_t empty_run = 0;
  std::size_t visited = 0;
  std::vector<std::uint32_t> current;
  while (empty_run <= kMaxArc) {
    std::vector<std::uint32_t>& bucket = buckets[settled_cost % (kMaxArc + 1)];
    if (bucket.empty()) {
      ++empty_run;
      ++settled_cost;
      continue;
    }
    empty_run = 0;
    current.swap(bucket);
    bucket.clear();
    for (const std::uint32_t node : current) {
      if (cost[node] != settled_cost) continue;  // reached more cheaply since
      if ((++visited & 0xFFFFF) == 0) {
        context.check_cancelled();
        context.progress(
            std::min(1.0, static_cast<double>(visited) / static_cast<double>(count * phases)));
      }
      const std::size_t p = node / count;
      const std::size_t v = node % count;
      const int label = labels.phases[p][v];
      const float here = input.images.phases[p][v];
      const auto relax = [&](std::size_t to_phase, std::size_t to_voxel, double step_mm) {
        const std::size_t to = to_phase * count + to_voxel;
        if (cost[to] <= settled_cost) return;
        const float per_mm = input.cost.at(label, input.classes[to_phase][to_voxel],
                                           input.images.phases[to_phase][to_voxel]);
        const double jump =
            std::abs(input.images.phases[to_phase][to_voxel] - here) - input.edge_free;
        const double price = step_mm * per_mm + (jump > 0 ? input.edge_cost * jump : 0.0);
        const auto arc = static_cast<std::uint32_t>(
            std::clamp(price * kUnitsPerMm, 1.0, static_cast<double>(kMaxArc)));
        const std::uint32_t reached = settled_cost + arc;
        if (reached < cost[to]) {
          cost[to] = reached;
          labels.phases[to_phase][to_voxel] = static_cast<std::uint8_t>(label);
          buckets[reached % (kMaxArc + 1)].push_back(static_cast<std::uint32_t>(to));
        }
      };
      const auto i = static_cast<int>(v % nx);
      const auto j = static_cast<int>(v % slice / nx);
      const auto k = static_cast<int>(v / slice);
      if (i > 0) relax(p, v - 1, spacing[0]);
      if (i + 1 < grid.size[0]) relax(p, v + 1, spacing[0]);
      if (j > 0) relax(p, v - nx, spacing[1]);
      if (j + 1 < grid.size[1]) relax(p, v + nx, spacing[1]);
      if (k > 0) relax(p, v - slice, spacing[2]);
      if (k + 1 < grid.size[2]) relax(p, v + slice, spacing[2]);
      if (phases > 1) {
        relax((p + 1) % phases, v, input.phase_step_mm);
        relax((p + phases - 1) % phases, v, input.phase_step_mm);
      }
    }
    current.clear();
    if (bucket.empty()) ++settled_cost;
  }
  return labels;
}

}  // namespace beatlas::segment
