#pragma once
#include <array>
#include <cstdint>

namespace beatlas::phantom {

/// Philox 4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011): random
/// bits as a pure function of counter and key, so that no order of evaluation can change them.
[[nodiscard]] std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter,
                                                  std::array<std::uint32_t, 2> key) noexcept;

/// What random numbers are drawn for: each has a sequence of its own, whatever the seed.
enum class Draw : std::uint32_t { Noise, Shift, Jitter, MisTrigger, Bias };

/// Two independent standard normal numbers for this place in the sequence (Box-Muller).
[[nodiscard]] std::array<double, 2> normal_pair(std::uint64_t index, std::uint32_t stream,
                                                std::uint32_t seed,
                                                Draw draw = Draw::Noise) noexcept;

/// Uniform in (0, 1).
[[nodiscard]] double uniform(std::uint64_t index, std::uint32_t seed, Draw draw) noexcept;

}  // namespace beatlas::phantom
