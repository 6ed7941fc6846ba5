#pragma once
/// What noise adds to the magnitude of a signal.

namespace beatlas::edges {

/// Mean magnitude of a signal >= 0 in noise (Rice's law), to 0.01 of the noise.
/// Gudbjartsson and Patz, Magn. Reson. Med. 34, 1995.
/// @param noise standard deviation of either channel, >= 0
[[nodiscard]] float mean_magnitude(float signal, float noise);
/// The signal of that mean magnitude; 0 where noise alone has as much.
[[nodiscard]] float signal_of(float magnitude, float noise);

/// Two tissues share a voxel, which shows a mean magnitude.
class Mixture {
 public:
  /// @param inner, outer mean magnitudes of voxels that hold the one or the other alone, not equal
  Mixture(float inner, float outer, float noise);

  /// @param share 0..1 of the inner one
  [[nodiscard]] float magnitude(float share) const;
  /// How much less than its share a voxel shows, on the line from outer to inner.
  [[nodiscard]] float missing(float share) const {
    return share - (magnitude(share) - outer_) / (inner_ - outer_);
  }

 private:
  float inner_;
  float outer_;
  float noise_;
  float inner_signal_;
  float outer_signal_;
};

}  // namespace beatlas::edges
