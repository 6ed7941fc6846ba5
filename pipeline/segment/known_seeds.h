#pragma once
/// What labels that are known in some phases say of the others, before anything grows.

#include "pipeline/segment/seeds.h"
#include "pipeline/segment/segment.h"

namespace beatlas::segment {

/// The heart's box made to hold the known labels, with a margin.
[[nodiscard]] Box box_with_labels(const Grid& grid, const Box& box, const KnownLabels& known);

/// The known labels in a box.
[[nodiscard]] KnownLabels crop(const KnownLabels& known, const Box& box);

/// Makes seeds of what is known. In a known phase: its labels, well in from their edges, which are
/// left to the image and then tell how it errs (see known_outlines.h). In the others: where all
/// known phases agree well in from their edges, unless the image there is as bright as another
/// tissue; and automatic seeds stay only near where some known phase has their label.
/// @param images, known in the heart's box; @param seeds the automatic ones, changed in place
void seed_known(const ImageCycle<float>& images, const KnownLabels& known,
                const TissueLevels& levels, LabelImages& seeds);

/// Takes out of every phase what no known one has.
void drop_unknown_labels(const KnownLabels& known, ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
