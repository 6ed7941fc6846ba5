#pragma once
/// The circulation is told in mmHg, ml and s, as physiology tells it; the finger in SI.

namespace beatlas::palpation {

inline constexpr double kPaPerMmhg = 133.322387415;
inline constexpr double kM3PerMl = 1e-6;
inline constexpr double kM2PerCm2 = 1e-4;
inline constexpr double kJPerMmhgMl = kPaPerMmhg * kM3PerMl;

}  // namespace beatlas::palpation
