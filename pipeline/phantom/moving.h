#pragma once
/// What beats: its bodies in one frame, and the signal of a voxel from its shares in them.

#include <vector>

#include "pipeline/phantom/cover.h"
#include "pipeline/phantom/phantom.h"

namespace beatlas::phantom {

/// From the outside in; each layer lies within those before it.
enum class Layer { Fat, Muscle, Blood, Papillary };

struct MovingBody {
  Part part;
  Layer layer;
  int within;  ///< index of the body that holds all of it, or -1
};

/// A body comes after the one that holds it. Bodies of one layer do not overlap.
inline constexpr std::array kMovingBodies{
    MovingBody{Part::Pericardium, Layer::Fat, -1},
    MovingBody{Part::Heart, Layer::Muscle, 0},
    MovingBody{Part::LvBlood, Layer::Blood, 1},
    MovingBody{Part::RvBlood, Layer::Blood, 1},
    MovingBody{Part::LaBlood, Layer::Blood, 1},
    MovingBody{Part::RaBlood, Layer::Blood, 1},
    MovingBody{Part::Aorta, Layer::Blood, 1},
    MovingBody{Part::PapillaryMuscles, Layer::Papillary, 2},
};

/// In the order of kMovingBodies, patient LPS. @param frame must outlive them
[[nodiscard]] std::vector<Body> moving_bodies(const Frame& frame, const Affine& lps_from_heart);

/// Signal of a voxel: what lies behind is painted over by the layers, each by its share, of which
/// an inner one is no larger than an outer one. Near creases the shares come from different planes,
/// so they are made so.
/// @param shares in the order of kMovingBodies; @param blood the signal of blood here
[[nodiscard]] double moving_signal(const Shares& shares, double behind, double blood,
                                   const Signals& signals);

}  // namespace beatlas::phantom
