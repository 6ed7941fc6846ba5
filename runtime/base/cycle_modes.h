#pragma once
#include <cstdint>
#include <vector>

namespace beatlas {

/// cos(2 pi turns / of), the same bits on every machine: no library's cosine.
[[nodiscard]] double cosine_of_turn(std::int64_t turns, std::int64_t of) noexcept;

/// The real discrete Fourier transform of a cycle, orthonormal. Modes: the mean, then cosine and
/// sine of 1, 2, ... beats, at last, for an even number of phases, the alternating one. As many as
/// phases. @param phases >= 1
/// @return weights, [mode][phase]
[[nodiscard]] std::vector<double> cycle_modes(int phases);

/// In beats.
[[nodiscard]] constexpr int mode_frequency(int mode) noexcept { return (mode + 1) / 2; }

}  // namespace beatlas
