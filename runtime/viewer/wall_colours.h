#pragma once
/// The ventricles' walls as colour: thickness, stiffness, AHA segments. Without VTK.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/atlas/payloads.h"
#include "runtime/palpation/parameters.h"

namespace beatlas::viewer {

enum class ColourBy : std::uint8_t { Structure, Thickness, Stiffness, Segments };
inline constexpr std::array<const char*, 4> kColourings{"structure", "thickness", "stiffness",
                                                        "segments"};
/// @throws Error{Usage} if it is none of kColourings
[[nodiscard]] ColourBy colouring_of(const std::string& word);

using Rgb = std::array<std::uint8_t, 3>;

/// Viridis: even steps of a share look even, in grey and to eyes that do not tell red from green
/// too (van der Walt and Smith). @param share 0..1, held within
[[nodiscard]] Rgb colour_of_share(double share) noexcept;
/// Of the 17 segments: a sector has a hue (Okabe and Ito), of which the basal segment is the
/// darkest and the apical one the lightest. @pre 1 <= segment <= 17
[[nodiscard]] Rgb colour_of_segment(int segment) noexcept;
/// Of what has no wall, or no map.
inline constexpr Rgb kNoWall{150, 150, 150};

/// The values that the ends of the colour scale stand for.
struct ColourScale {
  std::string title;  ///< with its unit; empty: segments have none
  double low = 0;
  double high = 1;

  [[nodiscard]] Rgb colour_of(double value) const noexcept {
    return colour_of_share((value - low) / (high - low));
  }
};

/// Colours of the vertices of one or more surfaces on the ventricles' walls. The RV has a thickness
/// alone: stiffness and segments are the LV's.
class WallColours {
 public:
  /// @param maps of the surfaces; the scale holds 98 % of their values through the whole beat
  /// @param parameters of the stiffness: Table 1 along the long axis, changed by each segment's
  /// tissue; at rest, under a finger
  WallColours(std::vector<std::shared_ptr<const atlas::SurfaceMapPayload>> maps, ColourBy by,
              const palpation::PalpationParameters& parameters);

  [[nodiscard]] ColourBy by() const { return by_; }
  [[nodiscard]] const ColourScale& scale() const { return scale_; }
  /// Whether the structure has a map, and so colours.
  [[nodiscard]] bool has(Structure structure) const;
  /// Of each vertex at a moment (time over the R-R interval, any number): what is shown between two
  /// phases lies straight between them. @pre has(structure)
  void colours_at(Structure structure, double beats, std::vector<Rgb>& colours) const;

 private:
  [[nodiscard]] const atlas::SurfaceMapPayload* map_of(Structure structure) const;
  [[nodiscard]] double stiffness_n_per_m(const atlas::SurfaceMapPayload& map, std::size_t v) const;

  std::vector<std::shared_ptr<const atlas::SurfaceMapPayload>> maps_;
  ColourBy by_;
  palpation::PalpationParameters parameters_;
  ColourScale scale_;
};

/// How a structure is drawn beside a coloured wall: the heart's outside not at all; the right
/// ventricle faintly, though it may have colours, so that the septum is seen, and so what lies
/// beyond the base.
[[nodiscard]] double coloured_opacity(Structure structure) noexcept;

/// Multiples of 1, 2 or 5 times a power of ten within the scale, at most `most` + 1 of them.
[[nodiscard]] std::vector<double> scale_marks(const ColourScale& scale, int most);

}  // namespace beatlas::viewer
