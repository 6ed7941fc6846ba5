#pragma once
/// The images of a volume where a plane cuts them, and what blood and muscle look like in them.

#include <cstdint>
#include <span>
#include <vector>

#include "runtime/atlas/payloads.h"
#include "runtime/atlas/volume.h"
#include "runtime/base/geometry.h"

namespace beatlas::viewer {

/// A rectangle of a plane: pixel (i, j) is centred at corner + (i + 1/2) x + (j + 1/2) y.
struct PlaneGrid {
  Vec3 corner_mm = Vec3::Zero();
  Vec3 x_mm = Vec3::UnitX();  ///< a pixel's width
  Vec3 y_mm = Vec3::UnitY();  ///< a pixel's height; perpendicular to x
  int width = 0;
  int height = 0;

  [[nodiscard]] std::size_t pixels() const noexcept {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

/// Two unit vectors that with `normal` make a right-handed frame; the same for the same normal.
struct PlaneAxes {
  Vec3 x;
  Vec3 y;
};
[[nodiscard]] PlaneAxes plane_axes(const Vec3& normal);

/// The least rectangle that holds all of the volume that the plane cuts; of no size if it passes
/// by. @param pixel_mm > 0
[[nodiscard]] PlaneGrid cut_grid(const atlas::VolumePayload& volume, const Vec3& point_mm,
                                 const Vec3& normal, double pixel_mm);

/// Trilinear. @param samples the volume at a moment, 8 bit (atlas::volume_8bit)
/// @param grey_alpha two bytes a pixel: grey, and 255 in the volume, 0 outside
void sample_cut(const atlas::VolumePayload& volume, std::span<const std::uint8_t> samples,
                const PlaneGrid& grid, std::span<std::uint8_t> grey_alpha);

/// Typical intensities at end-diastole.
struct TissueIntensities {
  double muscle = 0;
  double blood = 0;  ///< > muscle
};

/// Medians within the surfaces of `lv_blood` and `lv_myocardium`; without these (null), or if blood
/// is not brighter, from the histogram of all samples.
[[nodiscard]] TissueIntensities tissue_intensities(const atlas::VolumePayload& volume, int phase,
                                                   const atlas::SurfacePayload* lv_blood,
                                                   const atlas::SurfacePayload* lv_myocardium);

}  // namespace beatlas::viewer
