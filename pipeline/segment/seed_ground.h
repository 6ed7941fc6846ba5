#pragma once
/// What a person's marks say before anything grows, where no prior does: what each label looks
/// like about its marks, and where it can be as they lie to each other. Labels known in some phases
/// are marks, too. No size of any heart is known here.

#include <vector>

#include "pipeline/core/box.h"
#include "pipeline/segment/ground.h"
#include "pipeline/segment/options.h"

namespace beatlas::segment {

/// Whether marks tell all that a ground needs: blood and muscle of the LV, and what is no heart,
/// which labels that are known somewhere leave about them. Fewer marks correct a heart that was
/// found otherwise.
/// @param marks [phase][voxel] as they are drawn, so that of marks on each other the last one
/// counts; labels that are known among them
[[nodiscard]] bool tell_heart(const LabelImages& marks, const KnownLabels& known);

/// The box in which the marked heart lies: beyond it all is background.
/// @param marks on the stack's grid @pre tell_heart(marks, ...)
[[nodiscard]] Box box_of_marks(const Grid& stack, const LabelImages& marks);

/// Seeds, prices and levels from marks alone. The seeds are what was marked, and background where
/// no marked heart can be: farther from its marks than its chambers' middles are from each other
/// (as chambers that lie side by side are), and one gap between marked slices beyond the outermost.
/// @param images evenly lit, of a part of the stack's grid
/// @param marks on their grid, kUnlabelled elsewhere; blood and muscle of the LV among them
/// @param noise of the images
/// @param first labels that grew from such a ground before, null: none. Their cavities tell how
/// thick the wall is in each phase, and they all what tissues look like in their slice; where that
/// leaves no doubt are seeds, too.
[[nodiscard]] Ground lay_seed_ground(const ImageCycle<float>& images, const LabelImages& marks,
                                     double noise, const ImageCycle<std::uint8_t>* first = nullptr);

}  // namespace beatlas::segment
