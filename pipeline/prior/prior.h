#pragma once
/// Exam -> what each voxel of each phase is likely to be, by a network that has seen many hearts.

#include <cstdint>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/prior/model.h"

namespace beatlas::prior {

/// What each voxel of each phase is likely to be, on the network's own lattice: the stack's slices
/// and directions, square pixels of ModelCard::pixel_mm about the same middle; smaller ones of a
/// heart that the network was shown larger (enlarged.h).
struct PriorCycle {
  static constexpr int kUnits = 16;  ///< of a stored log-probability in 1
  static constexpr int kLeast = -8;  ///< log-probabilities are no smaller

  Grid grid;                         ///< patient LPS [mm]
  std::vector<std::uint8_t> labels;  ///< atlas Label of each output, e.g. {0,1,2,3,4,5,6,7}
  /// [phase][output * grid.count() + voxel]: natural log-probability times kUnits, -128..0.
  std::vector<std::vector<std::int8_t>> phases;
  /// [slice] in which share of the places where views cross it the network did not know the slice
  /// by itself (crossing_views.h); empty without views.
  std::vector<double> unknown = {};

  [[nodiscard]] int phase_count() const { return static_cast<int>(phases.size()); }
  /// Label of the likeliest output; of those as likely the first.
  [[nodiscard]] std::uint8_t likeliest(std::size_t phase, std::size_t voxel) const {
    const std::vector<std::int8_t>& logs = phases[phase];
    const std::size_t count = grid.count();
    std::size_t best = 0;
    for (std::size_t o = 1; o < labels.size(); ++o) {
      if (logs[o * count + voxel] > logs[best * count + voxel]) best = o;
    }
    return labels[best];
  }
};

/// What the network says of each phase by itself (see courses.h), of the stack and of the views
/// that cross it (see crossing_views.h). The same for any number of threads.
/// @throws Error{InvalidInput} if the exam has no voxels; as Model::load if the network cannot be
/// run on slices of this size; as StageContext::check_cancelled
[[nodiscard]] PriorCycle heart_prior(const Exam& exam, const Model& model, StageContext& context);

/// Probabilities of all outputs of one phase at the voxel centres of `part`: linear in plane, at
/// the edge those of the edge.
/// @param part of the stack's grid, see Grid::part
/// @return [output][voxel], > 0, of each voxel 1 in sum
/// @throws Error{InvalidInput} if `part` is none of the grid that the prior was made of
[[nodiscard]] std::vector<std::vector<float>> probabilities_on(const PriorCycle& prior, int phase,
                                                               const Grid& part);

}  // namespace beatlas::prior
