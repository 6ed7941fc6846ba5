#include "runtime/atlas/volume.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace beatlas::atlas {
namespace {

constexpr int kEdge = VolumePayload::kBlockEdge;

/// Calls put(place, count) for every sample from `low` to `high`; the count is linear between the
/// phases around `beats`.
template <class Put>
void for_each_sample(const VolumePayload& volume, double beats, const std::array<int, 3>& low,
                     const std::array<int, 3>& high, const Put& put) noexcept {
  double turn = beats - std::floor(beats);
  if (!(turn >= 0 && turn < 1)) turn = 0;  // no number, or 1 by rounding
  const double phase = turn * volume.phases;
  const int before = std::min(static_cast<int>(phase), volume.phases - 1);
  const int after = before + 1 < volume.phases ? before + 1 : 0;
  const auto share = static_cast<float>(phase - before);
  for (int z = low[2]; z <= high[2]; ++z) {
    for (int y = low[1]; y <= high[1]; ++y) {
      const std::size_t line =
          (static_cast<std::size_t>(z) * static_cast<std::size_t>(volume.size[1]) +
           static_cast<std::size_t>(y)) *
          static_cast<std::size_t>(volume.size[0]);
      for (int first = low[0] - low[0] % kEdge; first <= high[0]; first += kEdge) {
        const std::int16_t* row = volume.counts.data() + volume.row_at(first / kEdge, y, z);
        const std::int16_t* a = row + before * kEdge;
        const std::int16_t* b = row + after * kEdge;
        const int end = std::min(kEdge, high[0] + 1 - first);
        for (int x = std::max(0, low[0] - first); x < end; ++x) {
          const auto from = static_cast<float>(a[x]);
          put(line + static_cast<std::size_t>(first + x),
              from + share * (static_cast<float>(b[x]) - from));
        }
      }
    }
  }
}

template <class Put>
void for_each_sample(const VolumePayload& volume, double beats, const Put& put) noexcept {
  for_each_sample(volume, beats, {0, 0, 0},
                  {volume.size[0] - 1, volume.size[1] - 1, volume.size[2] - 1}, put);
}

}  // namespace

void volume_intensities(const VolumePayload& volume, double beats, std::span<float> to) noexcept {
  assert(to.size() == volume.sample_count());
  const auto offset = static_cast<float>(volume.offset);
  const auto step = static_cast<float>(volume.step);
  for_each_sample(volume, beats,
                  [&](std::size_t at, float count) { to[at] = offset + step * count; });
}

void volume_16bit(const VolumePayload& volume, double beats, std::span<std::uint16_t> to) noexcept {
  assert(to.size() == volume.sample_count());
  for_each_sample(volume, beats, [&](std::size_t at, float count) {
    to[at] = static_cast<std::uint16_t>(count + 32768.5F);  // never below 0.5
  });
}

void volume_8bit(const VolumePayload& volume, double beats, const IntensityWindow& window,
                 std::span<std::uint8_t> to) noexcept {
  volume_8bit(volume, beats, window, to, {0, 0, 0},
              {volume.size[0] - 1, volume.size[1] - 1, volume.size[2] - 1});
}

void volume_8bit(const VolumePayload& volume, double beats, const IntensityWindow& window,
                 std::span<std::uint8_t> to, const std::array<int, 3>& low,
                 const std::array<int, 3>& high) noexcept {
  assert(to.size() == volume.sample_count());
  const double scale = 255 / (window.high - window.low);
  const auto factor = static_cast<float>(volume.step * scale);
  const auto first = static_cast<float>((volume.offset - window.low) * scale + 0.5);
  for_each_sample(volume, beats, low, high, [&](std::size_t at, float count) {
    to[at] = static_cast<std::uint8_t>(std::clamp(first + factor * count, 0.0F, 255.0F));
  });
}

IntensityWindow whole_window(const VolumePayload& volume) noexcept {
  // Samples of a block beyond the volume count too: they are as those at its edge.
  const auto [low, high] = std::minmax_element(volume.counts.begin(), volume.counts.end());
  if (low == volume.counts.end()) return {volume.offset, volume.offset + 1};
  const double least = volume.offset + volume.step * *low;
  return {least, std::max(volume.offset + volume.step * *high, least + volume.step)};
}

}  // namespace beatlas::atlas
