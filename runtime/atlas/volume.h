#pragma once
/// Images of a volume at any moment of the beat, for a renderer to upload: `sample_count()` samples
/// each, x fastest, then y, then z, placed by `workspace_from_index`. Between two phases linear, as
/// a GPU would blend them; periodic. None allocates.

#include <array>
#include <cstdint>
#include <span>

#include "runtime/atlas/payloads.h"

namespace beatlas::atlas {

/// Intensities that become 0 and 255.
struct IntensityWindow {
  double low = 0;
  double high = 0;  ///< > low
};

/// @param beats time over the R-R interval, any number; phase p is at p / phases. What is no number
/// counts as 0.
/// @param to sample_count() of them
/// @pre the payload is sound (check_volume)
void volume_intensities(const VolumePayload& volume, double beats, std::span<float> to) noexcept;

/// Counts moved up to 0..65535: intensity = offset + step * (sample - 32768).
void volume_16bit(const VolumePayload& volume, double beats, std::span<std::uint16_t> to) noexcept;

/// Rounded and clamped to the window.
void volume_8bit(const VolumePayload& volume, double beats, const IntensityWindow& window,
                 std::span<std::uint8_t> to) noexcept;
/// The same of a box alone; what lies outside of it in `to` stays as it is.
/// @param low, high first and last sample along each axis, within the volume
void volume_8bit(const VolumePayload& volume, double beats, const IntensityWindow& window,
                 std::span<std::uint8_t> to, const std::array<int, 3>& low,
                 const std::array<int, 3>& high) noexcept;

/// From the least to the largest intensity of all phases.
[[nodiscard]] IntensityWindow whole_window(const VolumePayload& volume) noexcept;

}  // namespace beatlas::atlas
