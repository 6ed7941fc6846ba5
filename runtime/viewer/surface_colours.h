#pragma once
/// Surfaces in colours that stand for something: what they share. Without VTK.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "runtime/atlas/structures.h"
#include "runtime/base/geometry.h"

namespace beatlas::viewer {

enum class ColourBy : std::uint8_t { Structure, Thickness, Stiffness, Segments, Uncertainty };
inline constexpr std::array<const char*, 5> kColourings{"structure", "thickness", "stiffness",
                                                        "segments", "uncertainty"};
/// @throws Error{Usage} if it is none of kColourings
[[nodiscard]] ColourBy colouring_of(const std::string& word);

using Rgb = std::array<std::uint8_t, 3>;

/// Viridis: even steps of a share look even, in grey and to eyes that do not tell red from green
/// too (van der Walt and Smith). @param share 0..1, held within
[[nodiscard]] Rgb colour_of_share(double share) noexcept;
/// Of the 17 segments: a sector has a hue (Okabe and Ito), of which the basal segment is the
/// darkest and the apical one the lightest. @pre 1 <= segment <= 17
[[nodiscard]] Rgb colour_of_segment(int segment) noexcept;

/// The values that the ends of the colour scale stand for.
struct ColourScale {
  std::string title;  ///< with its unit; empty: segments have none
  double low = 0;
  double high = 1;

  [[nodiscard]] Rgb colour_of(double value) const noexcept {
    return colour_of_share((value - low) / (high - low));
  }
};

/// From the value that 1 % are below to the one that 1 % are above, to whole numbers outward.
[[nodiscard]] ColourScale scale_of(std::string title, std::vector<double> values);

/// A surface as it is drawn at a moment.
struct DrawnSurface {
  Structure structure{};
  double beats = 0;                  ///< time over the R-R interval, any number
  std::span<const Vec3f> positions;  ///< workspace [mm]
  std::span<const Vec3f> normals;    ///< outward, of unit length
};

/// Colours of the vertices of one or more surfaces.
class SurfaceColours {
 public:
  SurfaceColours() = default;
  virtual ~SurfaceColours() = default;
  SurfaceColours(const SurfaceColours&) = delete;
  SurfaceColours& operator=(const SurfaceColours&) = delete;

  [[nodiscard]] virtual ColourBy by() const = 0;
  [[nodiscard]] virtual const ColourScale& scale() const = 0;
  /// Whether the structure has such colours.
  [[nodiscard]] virtual bool has(Structure structure) const = 0;
  /// Of each vertex. @pre has(surface.structure)
  virtual void colours_of(const DrawnSurface& surface, std::vector<Rgb>& colours) const = 0;
};

/// How a structure is drawn beside coloured ones. Of the LV's wall: the heart's outside not at all,
/// the right ventricle faintly, though it may have colours, so that the septum is seen, and so what
/// lies beyond the base. By uncertainty all of them as they are.
[[nodiscard]] double coloured_opacity(ColourBy by, Structure structure) noexcept;

/// Multiples of 1, 2 or 5 times a power of ten within the scale, at most `most` + 1 of them.
[[nodiscard]] std::vector<double> scale_marks(const ColourScale& scale, int most);

}  // namespace beatlas::viewer
