#include "tests/made_images.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/core/box_share.h"

namespace beatlas::made {

Grid straight_grid(const Index3& size, const Vec3& spacing_mm) {
  Grid grid{size, Affine::Identity()};
  grid.mm_from_index.linear() = spacing_mm.asDiagonal();
  return grid;
}

Grid oblique_grid(const Index3& size, const Vec3& spacing_mm, const Vec3& middle_lps) {
  Grid grid = straight_grid(size, spacing_mm);
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(0.5, Vec3::UnitZ()) * Eigen::AngleAxisd(-0.35, Vec3::UnitY()) *
       Eigen::AngleAxisd(0.7, Vec3::UnitX()))
          .toRotationMatrix();
  grid.mm_from_index.linear() = turn * grid.mm_from_index.linear();
  const Vec3 middle = 0.5 * Vec3(size[0] - 1, size[1] - 1, size[2] - 1);
  grid.mm_from_index.translation() = middle_lps - grid.mm_from_index.linear() * middle;
  return grid;
}

ImageCycle<float> constant_images(const Grid& grid, int count, float value) {
  return {grid, std::vector<std::vector<float>>(static_cast<std::size_t>(count),
                                                std::vector<float>(grid.count(), value))};
}

void add_noise(ImageCycle<float>& images, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, sigma);
  for (auto& phase : images.phases) {
    for (float& value : phase) value += static_cast<float>(normal(random));
  }
}

void make_noise(ImageCycle<float>& images, int phase, int first, int last) {
  ImageCycle<float> noise = constant_images(images.grid, 1, 150);
  add_noise(noise, 100, 11);
  const std::size_t begin = images.grid.offset(0, 0, first);
  const std::size_t end = images.grid.offset(0, 0, last) + images.grid.slice_count();
  for (std::size_t v = begin; v < end; ++v) {
    images.phases[static_cast<std::size_t>(phase)][v] = noise.phases[0][v];
  }
}

void add_rician_noise(ImageCycle<float>& images, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, sigma);
  for (auto& phase : images.phases) {
    for (float& value : phase) {
      const double real = value + normal(random);
      value = static_cast<float>(std::hypot(real, normal(random)));
    }
  }
}

Vec3 BeatingEllipsoid::semi_axes_mm(int phase, int phases) const {
  return largest_mm * (1 - squeeze * 0.5 * (1 - std::cos(2 * std::numbers::pi * phase / phases)));
}

double BeatingEllipsoid::volume_ml(int phase, int phases) const {
  return 4.0 / 3.0 * std::numbers::pi * semi_axes_mm(phase, phases).prod() * 1e-3;
}

bool BeatingEllipsoid::contains(const Vec3& lps, int phase, int phases) const {
  const Vec3 x = lps_from_axes.transpose() * (lps - centre_lps);
  return x.cwiseQuotient(semi_axes_mm(phase, phases)).squaredNorm() < 1;
}

double BeatingEllipsoid::share(const Grid& grid, int i, int j, int k, int phase, int phases) const {
  const Vec3 semi = semi_axes_mm(phase, phases);
  const Vec3 x = lps_from_axes.transpose() * (grid.mm(i, j, k) - centre_lps);
  const Vec3 half = 0.5 * grid.spacing_mm();
  // f = |x / semi| is 1 on the surface, and (f - 1) / |grad f| the distance to it nearby.
  const double f = x.cwiseQuotient(semi).norm();
  if (f < 0.5) return 1;
  const Vec3 gradient = x.cwiseQuotient(semi.cwiseProduct(semi)) / f;
  const double distance = (f - 1) / gradient.norm();
  if (distance > half.norm() + 1) return 0;
  if (distance < -half.norm() - 1) return 1;
  const Vec3 outward_lps = lps_from_axes * gradient.normalized();
  const Eigen::Matrix3d axes = grid.mm_from_index.linear().colwise().normalized();
  return box_share(half, distance, axes.transpose() * outward_lps);
}

Exam ellipsoid_exam(const Grid& grid, const BeatingEllipsoid& body, int phases, double inside,
                    double outside) {
  Exam exam;
  exam.source_format = "nifti";
  exam.stack.rr_interval_s = 0.8;
  exam.stack.images = constant_images(grid, phases, 0);
  for (int p = 0; p < phases; ++p) {
    exam.stack.frame_times_s.push_back(0.8 * p / phases);
    std::vector<float>& image = exam.stack.images.phases[static_cast<std::size_t>(p)];
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          image[grid.offset(i, j, k)] = static_cast<float>(
              outside + (inside - outside) * body.share(grid, i, j, k, p, phases));
        }
      }
    }
  }
  return exam;
}

double dice(std::size_t count, const std::function<bool(std::size_t)>& a,
            const std::function<bool(std::size_t)>& b) {
  double both = 0;
  double sum = 0;
  for (std::size_t v = 0; v < count; ++v) {
    const bool in_a = a(v);
    const bool in_b = b(v);
    both += in_a && in_b;
    sum += static_cast<double>(in_a) + static_cast<double>(in_b);
  }
  return sum > 0 ? 2 * both / sum : 1;
}

double label_dice(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b,
                  std::uint8_t label) {
  return dice(
      a.size(), [&](std::size_t v) { return a[v] == label; },
      [&](std::size_t v) { return b[v] == label; });
}

std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  ADD_FAILURE() << "nothing was refused";
  return {};
}

}  // namespace beatlas::made
