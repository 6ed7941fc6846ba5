#pragma once
/// Seeded region growing by competition through space and time: every label spreads from its
/// seeds over the voxels of all phases, the cycle closed, and each voxel falls to the label that
/// reaches it at least cost (a shortest-path forest, so no label can leak past a cheaper one), of
/// two as cheap to the one of lower number.

#include <cstdint>
#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/motion/phase_motion.h"

namespace beatlas::segment {

using LabelImages = std::vector<std::vector<std::uint8_t>>;  ///< [phase][voxel]
inline constexpr std::uint8_t kUnlabelled = 255;

/// What a millimetre costs each label in each voxel.
struct VoxelPrices {
  static constexpr int kLabels = 8;
  static constexpr int kUnits = 16;  ///< of a price of 1
  /// [phase][voxel * kLabels + label], price times kUnits, 1..255.
  std::vector<std::vector<std::uint8_t>> phases;
};

struct CompetitionInput {
  const ImageCycle<float>& images;
  const LabelImages& seeds;  ///< label of seeds, kUnlabelled elsewhere
  const VoxelPrices& prices;
  double phase_step_mm = 3;  ///< what a step to the next phase counts as
  /// Where a step to the next phase and to the one before ends; null: at the same voxel.
  const motion::PhaseMotion* motion = nullptr;
  /// A step across an edge costs every label extra: `edge_cost` for each unit by which intensity
  /// changes beyond `edge_free` (noise).
  double edge_free = 0;
  double edge_cost = 0;
};

/// @returns the winning label of every voxel of every phase; kUnlabelled only if there is no seed.
[[nodiscard]] ImageCycle<std::uint8_t> grow_in_competition(const CompetitionInput& input,
                                                           StageContext& context);

}  // namespace beatlas::segment
