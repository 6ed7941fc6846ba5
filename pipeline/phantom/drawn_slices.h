#pragma once
/// Slices of a heart of the family, as a network sees them: what prior/README.md calls channels,
/// with the label of every pixel.

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "pipeline/phantom/family.h"

namespace beatlas::phantom {

inline constexpr int kDrawnPixels = 128;      ///< along either edge
inline constexpr float kDrawnPixelMm = 2.0F;  ///< edge of a pixel
inline constexpr int kDrawnChannels = 5;      ///< frame, below, above, mean, deviation
inline constexpr float kDrawnScale = 212;     ///< of a byte for a channel's 1

/// One frame of one slice: channels, then labels; row-major bytes.
struct DrawnSample {
  static constexpr std::size_t kPixels = std::size_t{kDrawnPixels} * kDrawnPixels;
  std::array<std::array<std::uint8_t, kPixels>, kDrawnChannels + 1> planes;
};

/// Contraction, 0 to 1, at a share of the beat in [0, 1): systole to 0.35 of it, quick filling,
/// diastasis, atrial kick; after the normalised elastance of Stergiopulos 1996 and volume curves of
/// cine MRI.
[[nodiscard]] float contraction_at(float time);

/// Columns: the heart's axes in the patient (LPS), for the heart of textbooks, turned a little.
[[nodiscard]] Eigen::Matrix3f heart_axes(const Family& family);

/// Up to three frames of one slice of the heart with this seed, each with a contrast and a
/// scanner's faults of its own.
[[nodiscard]] std::vector<DrawnSample> drawn_samples(std::uint32_t seed);

}  // namespace beatlas::phantom
