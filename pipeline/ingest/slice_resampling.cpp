#include "pipeline/ingest/slice_resampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "pipeline/core/cubic_convolution.h"

namespace beatlas::ingest {
namespace {

constexpr double kStillWithin = 1e-6;  // pixels, of rounding at an image's edge

/// First of the four pixels, and the weights, for a place along an axis of an image.
struct Taps {
  int first = 0;
  std::array<double, 4> weight{};
  explicit Taps(double at) {
    const double whole = std::floor(at);
    first = static_cast<int>(whole) - 1;
    weight = cubic_weights(at - whole);
  }
};

}  // namespace

SliceResampling::SliceResampling(const DicomImage& image, const Grid& grid, int k)
    : own_columns_(image.columns),
      own_rows_(image.rows),
      columns_(grid.size[0]),
      rows_(grid.size[1]) {
  const Vec3 normal = grid.mm_from_index.linear().col(2).normalized();
  const Vec3 own_normal = image.row_lps.cross(image.column_lps);
  const double along = normal.dot(own_normal);
  turn_deg_ = std::acos(std::min(1.0, std::abs(along))) * 180 / std::numbers::pi;
  const Vec3 own_middle = image.position_lps +
                          image.row_lps * (0.5 * (own_columns_ - 1) * image.column_step_mm) +
                          image.column_lps * (0.5 * (own_rows_ - 1) * image.row_step_mm);
  const Vec3 aside = own_middle - grid.mm(0.5 * (columns_ - 1), 0.5 * (rows_ - 1), k);
  shift_mm_ = (aside - normal * normal.dot(aside)).norm();
  // Along the stack's normal onto the image's plane, and there in its pixels.
  const auto index_of = [&](const Vec3& offset) {
    const Vec3 on_plane = offset - normal * (own_normal.dot(offset) / along);
    return Eigen::Vector2d(image.row_lps.dot(on_plane) / image.column_step_mm,
                           image.column_lps.dot(on_plane) / image.row_step_mm);
  };
  first_ = index_of(grid.mm(0, 0, k) - image.position_lps);
  per_column_ = index_of(grid.mm_from_index.linear().col(0));
  per_row_ = index_of(grid.mm_from_index.linear().col(1));
}

bool SliceResampling::same() const {
  if (columns_ != own_columns_ || rows_ != own_rows_ || turn_deg_ > kSameTurnDeg) return false;
  for (const int i : {0, columns_ - 1}) {
    for (const int j : {0, rows_ - 1}) {
      if ((own_index(i, j) - Eigen::Vector2d(i, j)).norm() > kSamePixels) return false;
    }
  }
  return true;
}

bool SliceResampling::shows_middle() const {
  for (const double across : {0.25, 0.75}) {
    for (const double down : {0.25, 0.75}) {
      const Eigen::Vector2d at =
          first_ + per_column_ * (across * (columns_ - 1)) + per_row_ * (down * (rows_ - 1));
      if (at.x() < 0 || at.y() < 0 || at.x() > own_columns_ - 1 || at.y() > own_rows_ - 1) {
        return false;
      }
    }
  }
  return true;
}

void SliceResampling::resample(std::span<const float> own, std::span<float> out) const {
  const float darkest = *std::min_element(own.begin(), own.end());
  std::size_t next = 0;
  for (int j = 0; j < rows_; ++j) {
    for (int i = 0; i < columns_; ++i) {
      float& pixel = out[next++];
      const Eigen::Vector2d at = own_index(i, j);
      if (at.x() < -kStillWithin || at.y() < -kStillWithin ||
          at.x() > own_columns_ - 1 + kStillWithin || at.y() > own_rows_ - 1 + kStillWithin) {
        pixel = darkest;
        continue;
      }
      const Taps across(at.x());
      const Taps down(at.y());
      double sum = 0;
      float least = own[0];
      float most = own[0];
      for (int b = 0; b < 4; ++b) {
        const auto v = static_cast<std::size_t>(std::clamp(down.first + b, 0, own_rows_ - 1));
        for (int a = 0; a < 4; ++a) {
          const auto u =
              static_cast<std::size_t>(std::clamp(across.first + a, 0, own_columns_ - 1));
          const float value = own[v * static_cast<std::size_t>(own_columns_) + u];
          const auto s = static_cast<std::size_t>(a);
          sum += across.weight.at(s) * down.weight.at(static_cast<std::size_t>(b)) *
                 static_cast<double>(value);
          least = a + b == 0 ? value : std::min(least, value);
          most = a + b == 0 ? value : std::max(most, value);
        }
      }
      pixel = std::clamp(static_cast<float>(sum), least, most);
    }
  }
}

}  // namespace beatlas::ingest
