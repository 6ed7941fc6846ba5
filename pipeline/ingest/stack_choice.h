#pragma once
/// Which images of an exam make the stack, and which the views beside it.

#include <string>
#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/ingest/ingest.h"
#include "pipeline/ingest/plane_groups.h"

namespace beatlas::ingest {

/// Slices to read and the lattice they make.
struct ChosenCine {
  Grid grid;                     ///< LPS [mm], determinant +1
  std::vector<ImageSet> slices;  ///< that were imaged
  std::vector<int> numbers;      ///< [of `slices`] its k of the grid, ascending
  double first_mm = 0;           ///< along the normal of its plane, of the first slice
  double rr_s = 0;               ///< mean over the slices
  double rr_share = 1;           ///< an R-R interval that was given, by the slices' own
};

struct Choice {
  ChosenCine stack;
  int phases = 0;                 ///< of the stack and of every view
  std::vector<ChosenCine> views;  ///< one slice each, by series number
  std::vector<std::string> decisions;
};

/// So much of a cycle [of the R-R] may lie between two frames: it is bridged and told. Prospective
/// gating leaves out a tenth or two, a breath that was slower than the others' half as much again.
inline constexpr double kMostUnseen = 0.4;

/// Chooses as ingest.h tells.
/// @throws Error{InvalidInput} if the exam holds no stack, or the best one is uneven.
[[nodiscard]] Choice choose_stack(const std::vector<DicomImage>& images,
                                  const IngestOptions& options, const ImageFiles& files);

}  // namespace beatlas::ingest
