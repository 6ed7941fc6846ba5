#pragma once
/// Images whose truth is known in closed form, and the measures that tests of several rooms share.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "runtime/base/error.h"

namespace beatlas::made {

/// A grid along the patient's axes whose corner voxel is centred on the origin.
[[nodiscard]] Grid straight_grid(const Index3& size, const Vec3& spacing_mm);

/// A grid turned out of all three axes, its middle at `middle_lps`.
[[nodiscard]] Grid oblique_grid(const Index3& size, const Vec3& spacing_mm, const Vec3& middle_lps);

/// `count` images of `value`.
[[nodiscard]] ImageCycle<float> constant_images(const Grid& grid, int count, float value);

/// Gaussian noise, the same for the same seed.
void add_noise(ImageCycle<float>& images, double sigma, unsigned seed);
/// Noise alone in slices first..last of a phase.
void make_noise(ImageCycle<float>& images, int phase, int first, int last);
/// What is left of an intensity s in the magnitude of two channels with Gaussian noise.
void add_rician_noise(ImageCycle<float>& images, double sigma, unsigned seed);

/// An ellipsoid that beats about its centre: in phase p of n every semi-axis is `largest_mm` times
/// 1 - squeeze (1 - cos(2 pi p / n)) / 2.
struct BeatingEllipsoid {
  Vec3 centre_lps = Vec3::Zero();
  Eigen::Matrix3d lps_from_axes = Eigen::Matrix3d::Identity();
  Vec3 largest_mm = Vec3::Constant(30);
  double squeeze = 0.06;

  [[nodiscard]] Vec3 semi_axes_mm(int phase, int phases) const;
  [[nodiscard]] double volume_ml(int phase, int phases) const;
  [[nodiscard]] bool contains(const Vec3& lps, int phase, int phases) const;
  /// Share of the voxel's box inside: the ellipsoid's face taken as flat in the box.
  [[nodiscard]] double share(const Grid& grid, int i, int j, int k, int phase, int phases) const;
};

/// The ellipsoid at `inside` on a background of `outside`, partial-volume voxels.
[[nodiscard]] Exam ellipsoid_exam(const Grid& grid, const BeatingEllipsoid& body, int phases,
                                  double inside, double outside);

/// 2 |a and b| / (|a| + |b|) of the voxels for which each tells true.
[[nodiscard]] double dice(std::size_t count, const std::function<bool(std::size_t)>& a,
                          const std::function<bool(std::size_t)>& b);
/// The same of one label in two images.
[[nodiscard]] double label_dice(const std::vector<std::uint8_t>& a,
                                const std::vector<std::uint8_t>& b, std::uint8_t label);

/// Message of the Error of kind InvalidInput that `call` throws; fails the test if there is none.
[[nodiscard]] std::string refusal(const std::function<void()>& call);

}  // namespace beatlas::made
