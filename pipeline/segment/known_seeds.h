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
/// tissue; and automatic seeds stay only near where some known phase has their label, and where
/// none has another pool: a valve plane's way is told by the known phases, not by the image.
/// One known phase tells nothing of how its valves and walls move: if the automatic seeds know the
/// LV, the other phases keep those.
/// @param images, known in the heart's box; @param automatic_lv whether an LV was found; @param
/// seeds the automatic ones, changed in place
void seed_known(const ImageCycle<float>& images, const KnownLabels& known, bool automatic_lv,
                const TissueLevels& levels, LabelImages& seeds);

/// Atria and vessels: voxels of the rest of the heart that tidy_phase took for a leak, since it
/// knows that label as the RV's wall alone, come back where a known phase has it nearby.
/// @param grown labels of a phase before tidy_phase; @param labels after it
void keep_known_rest(const std::vector<std::uint8_t>& near_known_rest,
                     const std::vector<std::uint8_t>& grown, std::vector<std::uint8_t>& labels);

/// 1 where some known phase has rest of the heart within a few millimetres; empty: nowhere.
[[nodiscard]] std::vector<std::uint8_t> near_known_rest(const KnownLabels& known);

/// Takes out of every phase what no known one has.
void drop_unknown_labels(const KnownLabels& known, ImageCycle<std::uint8_t>& labels);

}  // namespace beatlas::segment
