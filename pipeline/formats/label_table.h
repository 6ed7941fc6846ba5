#pragma once
/// What the numbers of a label image stand for, in the files that editors of label images read.

#include <string>

namespace beatlas::formats {

/// ITK-SNAP's label descriptions (Segmentation, Import Label Descriptions): a line a label, with
/// the structure's name and its colour of runtime/atlas/structure_colours.h.
[[nodiscard]] std::string itk_snap_labels();

/// The same as a colour table of 3D Slicer (.ctbl), which also reads it beside a segmentation.
[[nodiscard]] std::string slicer_colour_table();

}  // namespace beatlas::formats
