#pragma once
/// A slice that was acquired on pixels of its own, shown on those of its stack.

#include <span>

#include "pipeline/core/grid.h"
#include "pipeline/ingest/dicom_scan.h"

namespace beatlas::ingest {

/// In-plane distance between a slice's own pixels and its stack's, in pixels, that is still none.
inline constexpr double kSamePixels = 0.1;

/// Angle between the normals of slices that were planned as one stack [degrees].
inline constexpr double kSameTurnDeg = 0.1;

/// Where the pixels of a stack's slice lie on those that an image of it was acquired on. Seen along
/// the stack's normal: a slice that is turned against the stack counts as parallel.
class SliceResampling {
 public:
  /// @param grid LPS [mm]
  /// @param k the slice of it
  SliceResampling(const DicomImage& image, const Grid& grid, int k);

  /// The image's pixels are the stack's, within kSamePixels and kSameTurnDeg everywhere.
  [[nodiscard]] bool same() const;
  /// The image shows the middle half of the stack's slice along rows and columns, where the heart
  /// of a cardiac exam lies.
  [[nodiscard]] bool shows_middle() const;
  /// Between the middles of the image and of the stack's slice, along the plane [mm].
  [[nodiscard]] double shift_mm() const { return shift_mm_; }
  /// Angle between the slice's normal and the stack's [degrees], 0 to 90.
  [[nodiscard]] double turn_deg() const { return turn_deg_; }

  /// Cubic convolution (pipeline/core/cubic_convolution.h), held within the range of the pixels
  /// that it is made from; beyond the image as dark as its darkest pixel.
  /// @param own of the image, columns fastest
  /// @param out of the stack's slice
  void resample(std::span<const float> own, std::span<float> out) const;

 private:
  [[nodiscard]] Eigen::Vector2d own_index(int i, int j) const {
    return first_ + per_column_ * i + per_row_ * j;
  }

  int own_columns_;
  int own_rows_;
  int columns_;
  int rows_;
  Eigen::Vector2d first_;       ///< index (column, row) in the image of the stack's first pixel
  Eigen::Vector2d per_column_;  ///< of its next column
  Eigen::Vector2d per_row_;
  double shift_mm_ = 0;
  double turn_deg_ = 0;
};

}  // namespace beatlas::ingest
