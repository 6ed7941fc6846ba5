#include "pipeline/build/seed_effect.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "pipeline/segment/connected.h"
#include "pipeline/segment/drawn_seeds.h"

namespace beatlas::build {
namespace {

constexpr std::uint8_t kChanged = 1;
constexpr std::uint8_t kChangedInBall = 2;

ImageCycle<std::uint8_t> changes(const LabelCycle& before, const LabelCycle& after) {
  ImageCycle<std::uint8_t> out{before.grid, {}};
  for (std::size_t p = 0; p < before.phases.size(); ++p) {
    std::vector<std::uint8_t>& phase = out.phases.emplace_back(before.phases[p].size());
    for (std::size_t v = 0; v < phase.size(); ++v) {
      phase[v] = before.phases[p][v] != after.phases[p][v] ? kChanged : 0;
    }
  }
  return out;
}

void mark_ball(const LeakSeed& seed, ImageCycle<std::uint8_t>& changed) {
  const std::vector<std::size_t> ball =
      segment::voxels_of(changed.grid, {seed.label, seed.lps_mm, seed.radius_mm, seed.phase});
  for (std::size_t p = 0; p < changed.phases.size(); ++p) {
    if (seed.phase >= 0 && p != static_cast<std::size_t>(seed.phase)) continue;
    for (const std::size_t v : ball) {
      if (changed.phases[p][v] != 0) changed.phases[p][v] = kChangedInBall;
    }
  }
}

}  // namespace

double changed_elsewhere_ml(const LabelCycle& before, const LabelCycle& after,
                            const std::vector<LeakSeed>& seeds) {
  ImageCycle<std::uint8_t> changed = changes(before, after);
  for (const LeakSeed& seed : seeds) mark_ball(seed, changed);
  segment::clear_marked_parts(kChangedInBall, changed);
  long most = 0;
  for (std::size_t p = 0; p < changed.phases.size(); ++p) {
    std::array<long, 256> gained{};
    for (std::size_t v = 0; v < changed.phases[p].size(); ++v) {
      if (changed.phases[p][v] == 0) continue;
      --gained[before.phases[p][v]];
      ++gained[after.phases[p][v]];
    }
    for (const long voxels : gained) most = std::max(most, std::labs(voxels));
  }
  return static_cast<double>(most) * before.grid.voxel_ml();
}

}  // namespace beatlas::build
