#pragma once
/// Seeded region growing by competition through space and time: every label spreads from its
/// seeds over the voxels of all phases, the cycle closed, and each voxel falls to the label that
/// reaches it at least cost (a shortest-path forest, so no label can leak past a cheaper one), of
/// two as cheap to the one of lower number.

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/register/phase_motion.h"

namespace beatlas::segment {

/// What a millimetre costs each label, by intensity and by a class that the caller gives voxels.
class TravelCost {
 public:
  static constexpr int kLabels = 5;
  static constexpr int kClasses = 12;
  static constexpr int kBins = 512;
  static constexpr std::size_t kCells = std::size_t{kClasses} * kBins;

  /// Intensities from 0 to `top` fall into kBins bins; those above into the last.
  explicit TravelCost(double top);

  /// Cost per mm, > 0, of `label` in voxels of `voxel_class` whose intensity falls into `bin`.
  [[nodiscard]] float& at(int label, int voxel_class, int bin);
  /// Where `voxel_class` and `intensity` stand in the costs of every label.
  [[nodiscard]] std::uint16_t cell(int voxel_class, float intensity) const;
  /// All of a label's costs, by cell.
  [[nodiscard]] const std::array<float, kCells>& of(std::uint32_t label) const {
    return table_[label];
  }
  [[nodiscard]] double intensity_of(int bin) const;

 private:
  double top_;
  std::vector<std::array<float, kCells>> table_ =
      std::vector<std::array<float, kCells>>(static_cast<std::size_t>(kLabels));
};

/// What a millimetre costs each label in each voxel, where something knows better than a table by
/// intensity does.
struct VoxelPrices {
  static constexpr int kLabels = 8;
  static constexpr int kUnits = 16;  ///< of a price of 1
  /// [phase][voxel * kLabels + label], price times kUnits, 1..255.
  std::vector<std::vector<std::uint8_t>> phases;
};

struct CompetitionInput {
  const ImageCycle<float>& images;
  /// Class of each voxel of each phase, < TravelCost::kClasses.
  const std::vector<std::vector<std::uint8_t>>& classes;
  /// Label of seeds, kUnlabelled elsewhere; [phase][voxel].
  const std::vector<std::vector<std::uint8_t>>& seeds;
  const TravelCost& cost;
  double phase_step_mm = 3;  ///< what a step to the next phase counts as
  /// Where a step to the next phase and to the one before ends; null: at the same voxel.
  const reg::PhaseMotion* motion = nullptr;
  /// A step across an edge costs every label extra: `edge_cost` for each unit by which intensity
  /// changes beyond `edge_free` (noise).
  double edge_free = 0;
  double edge_cost = 0;
  /// In place of `classes` and `cost`, which are not asked then; may be null.
  const VoxelPrices* prices = nullptr;
};

inline constexpr std::uint8_t kUnlabelled = 255;

/// @returns the winning label of every voxel of every phase; kUnlabelled only if there is no seed.
[[nodiscard]] ImageCycle<std::uint8_t> grow_in_competition(const CompetitionInput& input,
                                                           StageContext& context);

}  // namespace beatlas::segment
