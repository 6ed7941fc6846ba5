#include "pipeline/field/flicker.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "tests/unit/field/closed_form.h"

namespace beatlas::field {
namespace {

using closed_form::Ellipsoid;

constexpr double kTurn = 2 * std::numbers::pi;

/// Contracts within a third of the cycle, as a ventricle does, and rests for as long.
Ellipsoid beating(double share) {
  const double s = share < 0.7 ? std::pow(std::sin(std::numbers::pi * share / 0.7), 2) : 0.0;
  return {{1, -2, 3 - 4 * s}, {24 - 5 * s, 22 - 4 * s, 30 - 3 * s}};
}

/// Exact distances, clamped.
FieldCycle field_of(int phases, double voxel_mm = 1.5) {
  FieldCycle field;
  field.voxel_mm = voxel_mm;
  field.inner_mm = 15;
  field.outer_mm = 6;
  field.distance_mm.grid = closed_form::lattice({-33, -33, -42}, {35, 31, 43}, voxel_mm);
  for (int p = 0; p < phases; ++p) {
    const Ellipsoid shape = beating(static_cast<double>(p) / phases);
    field.distance_mm.phases.push_back(
        closed_form::sampled(field.distance_mm.grid, [&](const Vec3& x) {
          return std::clamp(shape.distance_mm(x), -field.inner_mm, field.outer_mm);
        }));
  }
  return field;
}

bool near_surface(float distance) { return std::abs(distance) < 3; }

/// Root mean square of what differs where the first is near the surface.
double rms_mm(const FieldCycle& a, const FieldCycle& b) {
  double sum = 0;
  double count = 0;
  for (std::size_t p = 0; p < a.distance_mm.phases.size(); ++p) {
    for (std::size_t v = 0; v < a.distance_mm.phases[p].size(); ++v) {
      if (!near_surface(a.distance_mm.phases[p][v])) continue;
      sum += std::pow(a.distance_mm.phases[p][v] - b.distance_mm.phases[p][v], 2);
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

/// Noise that neighbours share over about 2 mm, new in every phase, where nothing is clamped.
void add_noise(FieldCycle& field, double sigma_mm) {
  std::mt19937 random(7);
  std::normal_distribution<float> normal(0, static_cast<float>(sigma_mm * std::sqrt(8.0)));
  const Grid& grid = field.distance_mm.grid;
  for (std::vector<float>& phase : field.distance_mm.phases) {
    std::vector<float> white(phase.size());
    for (float& value : white) value = normal(random);
    for (int k = 1; k < grid.size[2]; ++k) {
      for (int j = 1; j < grid.size[1]; ++j) {
        for (int i = 1; i < grid.size[0]; ++i) {
          float& value = phase[grid.offset(i, j, k)];
          if (!(value > -field.inner_mm && value < field.outer_mm)) continue;
          for (int n = 0; n < 8; ++n) {
            value += white[grid.offset(i - (n & 1), j - ((n >> 1) & 1), k - (n >> 2))] / 8;
          }
          value = std::clamp(value, static_cast<float>(-field.inner_mm) + 1e-3F,
                             static_cast<float>(field.outer_mm) - 1e-3F);
        }
      }
    }
  }
}

TEST(Flicker, ExactDistancesStay) {
  const FieldCycle exact = field_of(15);
  FieldCycle steady = exact;
  take_off_flicker(steady);
  EXPECT_LT(rms_mm(exact, steady), 0.005);
}

TEST(Flicker, NoiseOfPhasesFalls) {
  const FieldCycle exact = field_of(15);
  FieldCycle noisy = exact;
  add_noise(noisy, 0.1);
  const double before = rms_mm(exact, noisy);
  ASSERT_NEAR(before, 0.1, 0.01);
  FieldCycle steady = noisy;
  take_off_flicker(steady);
  // A sixteenth of the noise's power is in the mean over the cycle, which stays; places that are
  // clamped in some phase stay too.
  EXPECT_LT(rms_mm(exact, steady), 0.6 * before);
}

TEST(Flicker, MotionOfAPlaceOfItsOwnStays) {
  // A patch of 20 mm that bulges when the rest contracts, and for a quarter of the cycle only.
  FieldCycle exact = field_of(20);
  const Grid& grid = exact.distance_mm.grid;
  for (std::size_t p = 0; p < 20; ++p) {
    const double bulge = 3 * std::max(0.0, std::sin(kTurn * (static_cast<double>(p) / 20 - 0.1)));
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          float& value = exact.distance_mm.phases[p][grid.offset(i, j, k)];
          if (!(value > -exact.inner_mm && value < exact.outer_mm)) continue;
          const double away = (grid.mm(i, j, k) - Vec3(22, 0, 0)).norm();
          const double moved = value - bulge * std::exp(-away * away / 200);
          value =
              static_cast<float>(std::clamp(moved, -exact.inner_mm + 1e-3, exact.outer_mm - 1e-3));
        }
      }
    }
  }
  FieldCycle noisy = exact;
  add_noise(noisy, 0.1);
  FieldCycle steady = noisy;
  take_off_flicker(steady);
  double bias = 0;
  double count = 0;
  for (std::size_t p = 4; p <= 10; ++p) {
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const std::size_t v = grid.offset(i, j, k);
          if ((grid.mm(i, j, k) - Vec3(22, 0, 0)).norm() > 8) continue;
          if (!near_surface(exact.distance_mm.phases[p][v])) continue;
          bias += steady.distance_mm.phases[p][v] - exact.distance_mm.phases[p][v];
          ++count;
        }
      }
    }
  }
  EXPECT_LT(std::abs(bias / count), 0.02);
  EXPECT_LT(rms_mm(exact, steady), 0.7 * rms_mm(exact, noisy));
}

TEST(Flicker, ClampedSamplesAndShortCyclesStayAsTheyAre) {
  FieldCycle noisy = field_of(9, 2.5);
  add_noise(noisy, 0.1);
  FieldCycle steady = noisy;
  take_off_flicker(steady);
  EXPECT_NE(noisy.distance_mm.phases, steady.distance_mm.phases);
  for (std::size_t v = 0; v < noisy.distance_mm.grid.count(); ++v) {
    bool clamped = false;
    for (const std::vector<float>& phase : noisy.distance_mm.phases) {
      clamped = clamped || phase[v] == 6.0F || phase[v] == -15.0F;
    }
    if (!clamped) continue;
    for (std::size_t p = 0; p < 9; ++p) {
      ASSERT_EQ(noisy.distance_mm.phases[p][v], steady.distance_mm.phases[p][v]);
    }
  }

  FieldCycle few = field_of(7, 2.5);
  add_noise(few, 0.1);
  FieldCycle same = few;
  take_off_flicker(same);
  EXPECT_EQ(few.distance_mm.phases, same.distance_mm.phases);
}

TEST(Flicker, TheNumberOfThreadsChangesNoBit) {
  FieldCycle one = field_of(10, 2.5);
  add_noise(one, 0.1);
  FieldCycle four = one;
  set_thread_count(1);
  take_off_flicker(one);
  set_thread_count(4);
  take_off_flicker(four);
  set_thread_count(0);
  EXPECT_EQ(one.distance_mm.phases, four.distance_mm.phases);
}

}  // namespace
}  // namespace beatlas::field
