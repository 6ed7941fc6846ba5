#pragma once
/// The ventricles' walls as colour: thickness, stiffness, AHA segments. Without VTK.

#include <memory>
#include <vector>

#include "runtime/atlas/payloads.h"
#include "runtime/palpation/parameters.h"
#include "runtime/viewer/surface_colours.h"

namespace beatlas::viewer {

/// Of what has no wall, or no map.
inline constexpr Rgb kNoWall{150, 150, 150};

/// Colours of surfaces on the ventricles' walls. The RV has a thickness alone: stiffness and
/// segments are the LV's.
class WallColours final : public SurfaceColours {
 public:
  /// @param maps of the surfaces; the scale holds 98 % of their values through the whole beat
  /// @param parameters of the stiffness: Table 1 along the long axis, changed by each segment's
  /// tissue; at rest, under a finger
  WallColours(std::vector<std::shared_ptr<const atlas::SurfaceMapPayload>> maps, ColourBy by,
              const palpation::PalpationParameters& parameters);

  [[nodiscard]] ColourBy by() const override { return by_; }
  [[nodiscard]] const ColourScale& scale() const override { return scale_; }
  /// Whether the structure has a map.
  [[nodiscard]] bool has(Structure structure) const override;
  /// What is shown between two phases lies straight between them.
  void colours_of(const DrawnSurface& surface, std::vector<Rgb>& colours) const override;

 private:
  [[nodiscard]] const atlas::SurfaceMapPayload* map_of(Structure structure) const;
  [[nodiscard]] double stiffness_n_per_m(const atlas::SurfaceMapPayload& map, std::size_t v) const;

  std::vector<std::shared_ptr<const atlas::SurfaceMapPayload>> maps_;
  ColourBy by_;
  palpation::PalpationParameters parameters_;
  ColourScale scale_;
};

}  // namespace beatlas::viewer
