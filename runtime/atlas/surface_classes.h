#pragma once
/// Which table a count of a surface's motion is coded with: how large it is likely to be.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

namespace beatlas::atlas {

/// Counts along the normal, and along either tangent.
inline constexpr std::size_t kMotionKinds = 2;
inline constexpr std::size_t kMotionClasses = 64;

/// A vertex has a count for each mode of the cycle but the mean, and each row of its frame: `slot`
/// 3 * (mode - 1) + row. Its likely magnitude is told from those of the known vertices in the same
/// slot, from those of the same vertex and kind in modes before, and from the kind's mean in this
/// mode. Whole numbers throughout: the same classes on every machine.
class MotionClasses {
 public:
  /// @param scales mean magnitude of a mode's counts in 1/64, [mode - 1][kind], 1..65535
  MotionClasses(std::span<const std::uint16_t> scales, std::size_t vertices)
      : slots_(3 * scales.size() / kMotionKinds),
        magnitudes_(slots_ * vertices),
        sums_(slots_),
        scales_(slots_),
        shares_(slots_) {
    const std::size_t modes = scales.size() / kMotionKinds;
    for (std::size_t n = 0; n < scales.size(); ++n) means_[n % kMotionKinds] += scales[n];
    for (std::uint64_t& mean : means_) mean = 1 + mean / std::max<std::size_t>(1, modes);
    std::array<std::uint64_t, kMotionKinds> before{};
    for (std::size_t slot = 0; slot < slots_; ++slot) {
      const std::size_t kind = kind_of(slot);
      scales_[slot] = scales[slot / 3 * kMotionKinds + kind];
      shares_[slot] = (scales_[slot] << 16U) / (before[kind] + means_[kind]);
      before[kind] += scales_[slot];
    }
  }

  [[nodiscard]] std::size_t slots() const noexcept { return slots_; }
  [[nodiscard]] static constexpr std::size_t kind_of(std::size_t slot) noexcept {
    return slot % 3 == 0 ? 0 : 1;
  }

  /// Before the counts of a vertex, in the order of slots.
  void begin(std::uint32_t vertex, std::span<const std::uint32_t> known) noexcept {
    own_ = magnitudes_.data() + slots_ * vertex;
    of_vertex_ = {};
    if (known.empty()) {
      sums_ = scales_;
      return;
    }
    for (std::size_t slot = 0; slot < slots_; ++slot) {
      std::uint64_t sum = 0;
      for (const std::uint32_t other : known) sum += magnitudes_[slots_ * other + slot];
      sums_[slot] = 64 * sum / known.size();
    }
  }

  [[nodiscard]] std::size_t of(std::size_t slot) const noexcept {
    const std::size_t kind = kind_of(slot);
    const std::uint64_t own = ((64 * of_vertex_[kind] + means_[kind]) * shares_[slot]) >> 16U;
    constexpr std::uint64_t kMost = (std::uint64_t{1} << 31U) - 1;
    const std::uint64_t likely = std::min(kMost, 2 + (5 * sums_[slot] + 11 * own) / 16);
    // Two classes an octave.
    const auto octave = static_cast<std::size_t>(std::bit_width(likely));
    return 2 * (octave - 1) + (likely >> (octave - 2) & 1U);
  }

  void add(std::size_t slot, std::int64_t count) noexcept {
    constexpr std::int64_t kMost = 4095;
    const auto magnitude = static_cast<std::uint16_t>(std::min(kMost, std::abs(count)));
    own_[slot] = magnitude;
    of_vertex_[kind_of(slot)] += magnitude;
  }

 private:
  std::size_t slots_;
  std::vector<std::uint16_t> magnitudes_;  ///< [vertex][slot], of counts seen
  std::vector<std::uint64_t> sums_;        ///< [slot] mean of the known ones in 1/64
  std::vector<std::uint64_t> scales_;      ///< [slot]
  std::vector<std::uint64_t> shares_;      ///< [slot] scale over the vertex's scales before, 2^-16
  std::array<std::uint64_t, kMotionKinds> means_{};
  std::array<std::uint64_t, kMotionKinds> of_vertex_{};
  std::uint16_t* own_ = nullptr;
};

}  // namespace beatlas::atlas
