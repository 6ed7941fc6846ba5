#pragma once
/// How well the place of a surface is known, as colour. Without VTK.

#include <map>
#include <vector>

#include "runtime/atlas/surface_band.h"
#include "runtime/viewer/surface_colours.h"
#include "runtime/viewer/surface_motion.h"

namespace beatlas::viewer {

/// Colours by half of the width of the band in which the true surface lies with 90 %
/// (atlas::BandQuery), [mm]; the brighter, the less is known.
class BandColours final : public SurfaceColours {
 public:
  /// A structure whose band the package tells.
  struct Banded {
    Structure structure{};
    atlas::BandQuery band;
    const SurfaceMotion* motion = nullptr;  ///< read by the constructor alone
  };
  /// The scale holds 98 % of the widths of all surfaces through the whole beat.
  explicit BandColours(const std::vector<Banded>& surfaces);

  [[nodiscard]] ColourBy by() const override { return ColourBy::Uncertainty; }
  [[nodiscard]] const ColourScale& scale() const override { return scale_; }
  [[nodiscard]] bool has(Structure structure) const override { return bands_.contains(structure); }
  void colours_of(const DrawnSurface& surface, std::vector<Rgb>& colours) const override;

 private:
  std::map<Structure, atlas::BandQuery> bands_;
  ColourScale scale_;
};

}  // namespace beatlas::viewer
