#pragma once
/// What scanners do to a slice of a drawn heart, whatever its pixels: blur, ghosts, blanked edges.
/// Images are square, [row][column].

#include <vector>

#include "pipeline/phantom/family.h"

namespace beatlas::phantom {

/// Separable Gaussian, edges repeated; nothing below a fifth of a pixel. @param sigma [pixel]
void blur(std::vector<float>& image, int columns, float sigma);

/// A weak copy of the image along the phase-encoding direction, wrapped round.
class Ghost {
 public:
  explicit Ghost(const Family& family);
  void add(std::vector<float>& image, int columns) const;

 private:
  float strength_ = 0;  ///< 0: none
  float shift_ = 0;     ///< over the image's edge
  bool along_rows_ = false;
};

/// What a scanner blanks: beyond the field of view, bent by the gradients, or beyond a disc.
class BlankedEdge {
 public:
  explicit BlankedEdge(const Family& family);
  /// @param x, y from the image's middle, over half of its edge
  [[nodiscard]] bool blanks(float x, float y) const;

 private:
  bool there_ = false;
  bool round_ = false;
  float edge_ = 1, bend_ = 0, cosine_ = 1, sine_ = 0;
};

}  // namespace beatlas::phantom
