#pragma once
/// The images and the outlines on them, as the report's page draws them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"

namespace beatlas::report {

struct SheetOptions {
  double margin_mm = 12;               ///< [mm] 0..200: room around the heart
  std::size_t max_bytes = 5'400'000;   ///< of all JPEG files together
  double outline_tolerance_mm = 0.08;  ///< [mm] 0..1: how far a drawn outline may leave its own
};

/// A part of every slice in every phase. Pixel (x, y) of a tile at scale 1 is voxel
/// (first_i + x, first_j + y); pixel centres are at whole numbers.
struct SliceSheets {
  int first_i = 0;
  int first_j = 0;
  int width = 0;  ///< of the part, in voxels
  int height = 0;
  double scale = 1;  ///< pixels of a tile for each voxel, at most 1
  int tile_width = 0;
  int tile_height = 0;
  int columns = 0;  ///< tiles in a row of a sheet; phases run along rows
  int quality = 0;  ///< JPEG's
  std::vector<std::vector<std::uint8_t>> jpeg;  ///< [slice] one sheet of all phases, grey
};

/// The part holds the heart in every phase, the places and a margin; without coverage it is the
/// whole slice. Quality, then scale are lowered until the sheets fit `max_bytes`. One grey window
/// for all: the 1st and 99th percentile of end-diastole and end-systole.
/// @param places [mm] LPS that must be seen
/// @throws Error{InvalidInput} if grids or phases disagree.
[[nodiscard]] SliceSheets slice_sheets(const Cine& cine, const Segmentation* segmentation,
                                       const std::vector<Vec3>& places,
                                       const SheetOptions& options = {});

/// A closed line in voxels of the source's slice.
using Outline = std::vector<std::array<float, 2>>;

/// Where a structure's coverage is one half, between voxels too (marching squares, linear), thinned
/// to the tolerance.
[[nodiscard]] std::vector<Outline> outlines(const Segmentation& segmentation, Structure structure,
                                            int phase, int k, double tolerance_mm);

/// Of one slice: for each phase and each of `structures` the number of lines, and of each line the
/// number of points and their x and y relative to (first_i, first_j), in 32nds of a voxel; all are
/// 16 bit, lower byte first.
[[nodiscard]] std::vector<std::uint8_t> packed_outlines(const Segmentation& segmentation,
                                                        const std::vector<Structure>& structures,
                                                        int k, const SliceSheets& sheets,
                                                        double tolerance_mm);

}  // namespace beatlas::report
