#include "pipeline/phantom/render.h"

#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/core/box_share.h"
#include "pipeline/core/parallel.h"
#include "pipeline/phantom/cover.h"
#include "pipeline/phantom/noise.h"
#include "runtime/base/error.h"

namespace beatlas::phantom {
namespace {

TEST(PhantomNoise, PhiloxGivesItsPublishedAnswers) {
  // Known-answer tests of the Random123 distribution for philox4x32-10.
  const std::array<std::uint32_t, 4> zeros{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8};
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), zeros);
  const std::uint32_t f = 0xffffffff;
  const std::array<std::uint32_t, 4> ones{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd};
  EXPECT_EQ(philox({f, f, f, f}, {f, f}), ones);
}

TEST(PhantomNoise, IsNormalAndUncorrelated) {
  constexpr int kCount = 200000;
  double sum = 0, squares = 0, fourth = 0, cross = 0;
  for (int n = 0; n < kCount; ++n) {
    const auto [a, b] = normal_pair(n, 3, 1);
    sum += a + b;
    squares += a * a + b * b;
    fourth += a * a * a * a + b * b * b * b;
    cross += a * b;
  }
  // Five standard errors of each moment.
  EXPECT_NEAR(sum / (2 * kCount), 0.0, 5.0 / std::sqrt(2.0 * kCount));
  EXPECT_NEAR(squares / (2 * kCount), 1.0, 5.0 * std::sqrt(2.0 / (2 * kCount)));
  EXPECT_NEAR(fourth / (2 * kCount), 3.0, 5.0 * std::sqrt(96.0 / (2 * kCount)));
  EXPECT_NEAR(cross / kCount, 0.0, 5.0 / std::sqrt(1.0 * kCount));
}

TEST(PhantomCover, BoxShareIsTheVolumeBelowThePlane) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int n = 0; n < 300; ++n) {
    const Vec3 half(0.5, 0.7, 1.5);
    Vec3 outward(normal(random), normal(random), normal(random));
    if (n % 4 == 1) outward[n % 3] = 0.0;
    if (n % 4 == 2) outward = Vec3::Unit(n % 3);
    if (n % 4 == 3) outward[n % 3] *= 1e-6;
    outward.normalize();
    const double d = 1.6 * uniform(random);
    // Exact along the steepest edge of the box, midpoint rule across.
    int axis = 0;
    outward.cwiseProduct(half).cwiseAbs().maxCoeff(&axis);
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    constexpr int kSteps = 200;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        const double rest = d + outward[u] * half[u] * ((2 * i + 1.0) / kSteps - 1.0) +
                            outward[v] * half[v] * ((2 * j + 1.0) / kSteps - 1.0);
        const double cut = -rest / std::abs(outward[axis]);
        sum += std::clamp((cut + half[axis]) / (2.0 * half[axis]), 0.0, 1.0);
      }
    }
    EXPECT_NEAR(box_share(half, d, outward), sum / (kSteps * kSteps), 3e-5) << outward.transpose();
  }
}

PhantomSpec quiet(const char* name) {
  PhantomSpec spec = preset(name);
  spec.scanner.snr_blood = std::numeric_limits<double>::infinity();
  return spec;
}

/// What a voxel shows by many points in its box.
double supersampled(const Phantom& phantom, const Grid& grid,
                    const std::vector<ThoraxBody>& tissues, int i, int j, int k,
                    double thickness_share, double t) {
  constexpr int kSteps = 12;
  const auto frame = phantom.frame(t);
  const Signals signals;
  double sum = 0.0;
  for (int a = 0; a < kSteps; ++a) {
    for (int b = 0; b < kSteps; ++b) {
      for (int c = 0; c < kSteps; ++c) {
        const Vec3 x = grid.mm(i + (a + 0.5) / kSteps - 0.5, j + (b + 0.5) / kSteps - 0.5,
                               k + ((c + 0.5) / kSteps - 0.5) * thickness_share);
        double signal = signals.air;
        for (const ThoraxBody& tissue : tissues) {
          if (tissue.surface(x).distance_mm < 0.0) signal = tissue.signal;
        }
        if (frame->contains(Part::Pericardium, x)) signal = signals.fat;
        if (frame->contains(Part::Heart, x)) signal = signals.myocardium;
        for (Part pool :
             {Part::LvBlood, Part::RvBlood, Part::LaBlood, Part::RaBlood, Part::Aorta}) {
          if (frame->contains(pool, x)) signal = signals.blood;
        }
        if (frame->contains(Part::PapillaryMuscles, x)) signal = signals.myocardium;
        sum += signal;
      }
    }
  }
  return sum / (kSteps * kSteps * kSteps) * kBloodCounts;
}

TEST(PhantomRender, AVoxelShowsTheMeanSignalOfItsBox) {
  for (const char* name : {"small", "clinical"}) {
    PhantomSpec spec = quiet(name);
    spec.phases = 3;
    spec.oblique_deg = {5.0, 0.0, 12.0};
    const Phantom phantom(spec);
    StageContext context;
    const Rendering out = render(phantom, context);
    const Grid grid = out.cine.grid();
    const auto tissues = thorax(spec.anatomy, Signals{});
    const double share = spec.scanner.slice_thickness_mm > 0
                             ? spec.scanner.slice_thickness_mm / grid.spacing_mm().z()
                             : 1.0;
    const int phase = 1;
    const double t = phantom.phase_time_s(phase);
    std::mt19937 random(9);
    int tried = 0;
    double squares = 0.0;
    double mean = 0.0;
    while (tried < 400) {
      const int i = static_cast<int>(random() % grid.size[0]);
      const int j = static_cast<int>(random() % grid.size[1]);
      const int k = static_cast<int>(random() % grid.size[2]);
      const auto frame = phantom.frame(t);
      double nearest = 1e300;
      for (Part part : kAllParts) {
        nearest = std::min(nearest, std::abs(frame->distance_mm(part, grid.mm(i, j, k))));
      }
      if (nearest > 2.0) continue;
      const double expected = supersampled(phantom, grid, tissues, i, j, k, share, t);
      const double error = out.cine.images.phases[phase][grid.offset(i, j, k)] - expected;
      // 60 counts of 1000: a crease, where the share of a body is counted and not measured.
      EXPECT_LT(std::abs(error), 60.0) << name << " " << i << " " << j << " " << k;
      squares += error * error;
      mean += error;
      ++tried;
    }
    // 12 points an edge tell a share to about 1/100.
    EXPECT_LT(std::sqrt(squares / tried), 12.0) << name;
    EXPECT_LT(std::abs(mean / tried), 2.0) << name;
  }
}

TEST(PhantomRender, LabelsAndSignalsEncloseTheTrueVolumes) {
  const Phantom phantom(quiet("small"));
  StageContext context;
  const Rendering out = render(phantom, context);
  const Grid grid = out.cine.grid();
  EXPECT_EQ(out.cine.phase_count(), 10);
  EXPECT_EQ(out.cine.frame_times_s.size(), 10u);
  for (int p = 0; p < out.labels.phase_count(); ++p) {
    for (Structure structure : kAllStructures) {
      double count = 0;
      for (std::uint8_t label : out.labels.phases[p]) count += label_in_structure(label, structure);
      const double truth = phantom.volume_ml(structure, phantom.phase_time_s(p));
      EXPECT_NEAR(count * grid.voxel_ml() / truth, 1.0, 0.015)
          << structure_name(structure) << " phase " << p;
    }
  }
}

TEST(PhantomRender, DoesNotDependOnTheNumberOfThreads) {
  PhantomSpec spec = preset("small");
  spec.phases = 2;
  const Phantom phantom(spec);
  StageContext context;
  set_thread_count(1);
  const Rendering one = render(phantom, context);
  set_thread_count(4);
  const Rendering four = render(phantom, context);
  set_thread_count(0);
  EXPECT_EQ(one.cine.images.phases, four.cine.images.phases);
  EXPECT_EQ(one.labels.phases, four.labels.phases);
  EXPECT_NE(one.cine.images.phases[0], one.cine.images.phases[1]);
}

TEST(PhantomRender, NoiseIsRician) {
  PhantomSpec spec = preset("small");
  spec.phases = 2;
  const Phantom phantom(spec);
  StageContext context;
  const Rendering out = render(phantom, context);
  const Grid grid = out.cine.grid();
  const auto frame = phantom.frame(0.0);
  const double sigma = kBloodCounts / spec.scanner.snr_blood;
  double n = 0, sum = 0, squares = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (frame->distance_mm(Part::LvBlood, grid.mm(i, j, k)) > -4.0 ||
            frame->distance_mm(Part::PapillaryMuscles, grid.mm(i, j, k)) < 4.0) {
          continue;
        }
        const double value = out.cine.images.phases[0][grid.offset(i, j, k)];
        ++n;
        sum += value;
        squares += value * value;
      }
    }
  }
  ASSERT_GT(n, 2000);
  const double mean = sum / n;
  const double deviation = std::sqrt(squares / n - mean * mean);
  // At this signal Rice's mean is S + sigma^2 / (2 S); five standard errors.
  EXPECT_NEAR(mean, kBloodCounts + sigma * sigma / (2 * kBloodCounts), 5 * sigma / std::sqrt(n));
  EXPECT_NEAR(deviation, sigma, 5 * sigma / std::sqrt(2 * n));
  for (float value : out.cine.images.phases[0]) {
    ASSERT_TRUE(value >= 0 && value <= 4095 && value == std::round(value));
  }
}

TEST(PhantomRender, CanBeStopped) {
  const Phantom phantom(preset("small"));
  StageContext context;
  const std::atomic<bool> stop{true};
  context.cancel = &stop;
  EXPECT_THROW((void)render(phantom, context), Error);
}

}  // namespace
}  // namespace beatlas::phantom
