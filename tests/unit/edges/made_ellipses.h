#pragma once
/// Slices that hold a disc or an ellipse, what find_boundary makes of them, and how far that is
/// off.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/edges/boundary.h"
#include "tests/made_images.h"

namespace beatlas::edges::ellipses {

inline constexpr double kPixelMm = 1.5;
inline constexpr int kPixels = 64;
inline constexpr double kInside = 1000;
inline constexpr double kOutside = 300;

/// A disc or ellipse, its centre between pixels.
struct Ellipse {
  double x = 47.3;  ///< [mm]
  double y = 46.6;
  double a = 20;
  double b = 20;
  double turn = 0.4;

  [[nodiscard]] double level(double px, double py) const {  // < 1 inside
    const double u = (px - x) * std::cos(turn) + (py - y) * std::sin(turn);
    const double v = -(px - x) * std::sin(turn) + (py - y) * std::cos(turn);
    return std::hypot(u / a, v / b);
  }
  [[nodiscard]] double area() const { return std::numbers::pi * a * b; }
};

struct Slice {
  Grid grid = made::straight_grid({kPixels, kPixels, 1}, {kPixelMm, kPixelMm, 8});
  std::vector<float> share;
  std::vector<float> image;
  std::vector<std::uint8_t> inside;
};

inline Slice make(const Ellipse& ellipse, double sigma) {
  constexpr int kSteps = 10;
  Slice s;
  std::mt19937 random(4);
  std::normal_distribution<double> normal(0, 1);
  for (int j = 0; j < kPixels; ++j) {
    for (int i = 0; i < kPixels; ++i) {
      int hits = 0;
      for (int b = 0; b < kSteps; ++b) {
        for (int a = 0; a < kSteps; ++a) {
          hits += ellipse.level((i + (a + 0.5) / kSteps - 0.5) * kPixelMm,
                                (j + (b + 0.5) / kSteps - 0.5) * kPixelMm) < 1;
        }
      }
      const double share = static_cast<double>(hits) / (kSteps * kSteps);
      s.share.push_back(static_cast<float>(share));
      s.inside.push_back(share >= 0.5);
      s.image.push_back(
          static_cast<float>(kOutside + (kInside - kOutside) * share + sigma * normal(random)));
    }
  }
  return s;
}

inline Boundary boundary_of(const Slice& s, const std::vector<std::uint8_t>& inside,
                            double contrast, double noise, bool trabeculated = false,
                            bool rimmed = false) {
  return find_boundary({.grid = s.grid,
                        .image = s.image,
                        .inside = inside,
                        .tells_inner = inside,
                        .tells_outer = std::vector<std::uint8_t>(inside.size(), 1),
                        .trabeculated = trabeculated,
                        .rimmed = rimmed,
                        .contrast = contrast,
                        .noise = noise});
}

inline double area_mm2(const std::vector<float>& coverage) {
  return std::accumulate(coverage.begin(), coverage.end(), 0.0) * kPixelMm * kPixelMm;
}

/// Distances [mm] of the 0.5 contour from the ellipse, along 128 rays, outward positive.
struct OutlineError {
  double mean = 0;
  double rms = 0;
  double largest = 0;
};

inline OutlineError outline_error(const Ellipse& e, const std::vector<float>& coverage) {
  OutlineError error;
  constexpr int kRays = 128;
  for (int n = 0; n < kRays; ++n) {
    const double t = 2 * std::numbers::pi * n / kRays;
    const double ux = std::cos(e.turn) * e.a * std::cos(t) - std::sin(e.turn) * e.b * std::sin(t);
    const double uy = std::sin(e.turn) * e.a * std::cos(t) + std::cos(e.turn) * e.b * std::sin(t);
    const auto value = [&](double f) {  // bilinear, at f times the outline's radius
      const double px = (e.x + f * ux) / kPixelMm;
      const double py = (e.y + f * uy) / kPixelMm;
      const int i = static_cast<int>(px);
      const int j = static_cast<int>(py);
      const double u = px - i;
      const double v = py - j;
      const auto at = [&](int x, int y) {
        return coverage[static_cast<std::size_t>(x + kPixels * y)];
      };
      return (1 - v) * ((1 - u) * at(i, j) + u * at(i + 1, j)) +
             v * ((1 - u) * at(i, j + 1) + u * at(i + 1, j + 1));
    };
    double low = 0.7;
    double high = 1.3;
    EXPECT_GT(value(low), 0.5);
    EXPECT_LT(value(high), 0.5);
    while (high - low > 1e-5) {
      const double middle = 0.5 * (low + high);
      (value(middle) > 0.5 ? low : high) = middle;
    }
    // Along the ray; an ellipse of 25 x 15 leaves the normal by 28 degrees at most.
    const double off = (low - 1) * std::hypot(ux, uy);
    error.mean += off / kRays;
    error.rms += off * off / kRays;
    error.largest = std::max(error.largest, std::abs(off));
  }
  error.rms = std::sqrt(error.rms);
  return error;
}

}  // namespace beatlas::edges::ellipses
