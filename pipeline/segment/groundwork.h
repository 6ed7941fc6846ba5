#pragma once
/// What is known before anything grows: it hangs on the images alone, but for seeds that reach
/// beyond the heart's box or add a slice to the LV or turn it over, so a solve with other seeds may
/// begin from it.

#include <optional>
#include <vector>

#include "pipeline/core/solve_memory.h"
#include "pipeline/segment/chambers.h"
#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/segment/seeds.h"

namespace beatlas::segment {

/// Slices that were looked at, and what drawn seeds added to those that show an LV.
struct LvSlices {
  Grid grid;
  std::vector<int> found;        ///< slices of the grid, ascending
  std::vector<LvPlace> adopted;  ///< from seeds in others
  std::vector<int> doubted;  ///< a seed in one of them turns base and apex over, see drawn_ends.h
  bool turned = false;
};

/// Places of seeds in slices where no LV was found.
[[nodiscard]] std::vector<LvPlace> places_beside(const std::vector<int>& found, const Grid& grid,
                                                 const std::vector<Seed>& drawn);

/// Whether seeds of LV blood lie in a slice of what was taken for the base, and should not.
[[nodiscard]] bool turned_by(const std::vector<Seed>& drawn, const LvSlices& slices);

struct Groundwork {
  Box moving;  ///< around what moves at the heart rate
  Box box;     ///< that with a technician's seeds; all else here is of it
  double noise = 0;
  std::vector<std::uint8_t> motion;  ///< see classify_motion
  Chambers chambers;
  LabelImages automatic;         ///< seeds, before any is drawn
  std::vector<LvSlices> looked;  ///< the stack's slices, and those across the axis if there is one
};

/// @param images the part of the stack in `box`; @param drawn seeds, see box_with_seeds
/// @param parts_atria whether a long axis is looked for
/// @param known_step of the base in thick slices, from labels of some phases; 0: not known
[[nodiscard]] Groundwork lay_groundwork(const ImageCycle<float>& images, const Box& moving,
                                        const Box& box, const std::vector<Seed>& drawn,
                                        bool parts_atria, int known_step,
                                        double tricuspid_excursion_mm, StageContext& context);

/// What a solve leaves for the next.
struct KeptSolve {
  Groundwork ground;
  LabelImages grown;     ///< by the competition
  LabelImages drawn;     ///< seeds, kUnlabelled elsewhere
  LabelImages tidied;    ///< by tidy_phase
  LabelImages bounded;   ///< by bound_apex
  LabelImages smoothed;  ///< by smooth_outlines
};

/// @param box_grid of the box  @pre chambers.found_lv()
[[nodiscard]] SolveMemory kept(const Grid& box_grid, KeptSolve solve);

/// What was kept, if it holds for these seeds: they neither widen the box nor add other slices to
/// the LV nor turn its base and apex over, and there is an LV, for else seeds tell the tissues'
/// levels.
/// @param drawn seeds, before box_with_seeds
[[nodiscard]] std::optional<KeptSolve> recall(SolveMemory memory, const Grid& stack, int phases,
                                              std::vector<Seed> drawn);

}  // namespace beatlas::segment
