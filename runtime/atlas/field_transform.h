#pragma once
/// The transform in which leaves of fields and volumes are stored; what their decoders and the
/// encoders of `pack` share. Orthonormal: a discrete cosine transform (type II) of the 8 x 8 x 8
/// samples along each axis, and the real discrete Fourier transform of the phases.
///
/// A term of a field is stored as a count of
///
///   quantum / (g(2 pi k / phases) g(pi i / 8) g(pi j / 8) g(pi l / 8)),  g(w) = (2 + cos w) / 3,
///
/// k the frequency in time, i j l those in space: g is what the spline's value at its samples keeps
/// of coefficients of that frequency, so errors of the *value* are even over all frequencies. A
/// volume's coefficients are its values: its terms are counts of the quantum alone.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/atlas/payloads.h"
#include "runtime/base/cycle_modes.h"

namespace beatlas::atlas {

class LeafTransform {
 public:
  static constexpr int kSamples = FieldPayload::kBlockSamples;

  /// What the coefficients are of; it fixes the size of a count.
  enum class Of : std::uint8_t { Spline, Values };

  /// @param phases 1..kMaxPhases
  explicit LeafTransform(int phases, Of of = Of::Spline);

  /// Of a mode in time, see cycle_modes.
  [[nodiscard]] static int frequency(int mode) noexcept { return mode_frequency(mode); }
  /// Weight of a phase in a mode.
  [[nodiscard]] double weight(int mode, int phase) const noexcept {
    return weights_[static_cast<std::size_t>(mode) * static_cast<std::size_t>(phases_) +
                    static_cast<std::size_t>(phase)];
  }
  /// Weight of sample n (0..7) in the cosine of frequency k (0..7).
  [[nodiscard]] double cosine(int k, int n) const noexcept {
    return cosines_[8 * static_cast<std::size_t>(k) + static_cast<std::size_t>(n)];
  }

  /// Terms of a mode from low to high frequency: place i + 8 j + 64 l of each.
  [[nodiscard]] const std::array<std::uint16_t, kSamples>& order() const noexcept { return order_; }
  /// Size of a count over the quantum, by mode and by place in `order`.
  [[nodiscard]] float mode_scale(int mode) const noexcept {
    return mode_scales_[static_cast<std::size_t>(mode)];
  }
  [[nodiscard]] float place_scale(int place) const noexcept {
    return place_scales_[static_cast<std::size_t>(place)];
  }

  /// Counts of a leaf's terms -> its coefficients. Scratch memory for one thread.
  class Inverse {
   public:
    explicit Inverse(const LeafTransform& transform);
    /// All terms 0 again.
    void clear() noexcept;
    /// To write the counts of a mode's terms to, at their places, after clear().
    [[nodiscard]] float* mode(int mode) noexcept {
      used_[static_cast<std::size_t>(mode)] = 1;
      return terms_.data() + static_cast<std::size_t>(mode) * kSamples;
    }
    /// @param quantum of the leaf, in counts of the payload's step
    /// @param to kBlockSamples * phases coefficients, [z][y][phase][x]
    void to_coefficients(float quantum, std::int16_t* to) noexcept;

   private:
    const LeafTransform* transform_;
    std::vector<float> terms_;         ///< [mode][place]
    std::vector<std::uint8_t> used_;   ///< [mode] whether any term is set
    std::vector<std::size_t> cosine_;  ///< modes used, but sines
    std::vector<std::size_t> sine_;
  };

 private:
  int phases_;
  std::vector<double> weights_;        ///< [mode][phase]
  std::vector<float> phase_weights_;   ///< [phase][mode]
  std::array<double, 64> cosines_{};   ///< [frequency][sample]
  std::array<float, 64> cosines_f_{};  ///< the same, rounded
  std::array<std::uint16_t, kSamples> order_{};
  std::vector<float> mode_scales_;
  std::array<float, kSamples> place_scales_{};  ///< [rank]
  std::array<float, kSamples> scales_{};        ///< the same by place
};

}  // namespace beatlas::atlas
