#include "pipeline/edges/boundary.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "tests/made_images.h"
#include "tests/unit/edges/made_ellipses.h"

namespace beatlas::edges::boundary_tests {
namespace {

using ellipses::area_mm2;
using ellipses::boundary_of;
using ellipses::Ellipse;
using ellipses::kInside;
using ellipses::kOutside;
using ellipses::kPixelMm;
using ellipses::kPixels;
using ellipses::make;
using ellipses::outline_error;
using ellipses::OutlineError;
using ellipses::Slice;

const std::vector<Ellipse> kShapes{{47.3, 46.6, 20, 20, 0}, {47.3, 46.6, 25, 15, 0.4}};

/// A bowl of muscle full of blood, open where a straight base cuts it; beyond lies lung.
TEST(Boundary, OfAnOpenBaseIsToldByTheBloodThatMeetsIt) {
  constexpr double kFineMm = 1;
  constexpr double kBaseMm = 36.9;
  constexpr double kLung = 40;
  constexpr double kMuscle = 340;
  constexpr double kBlood = 1000;
  constexpr int kSteps = 10;
  const Ellipse cavity{31.5, 31.1, 16, 16, 0};
  const Ellipse outside{31.5, 31.1, 21, 21, 0};
  Slice s;
  s.grid = made::straight_grid({kPixels, kPixels, 1}, {kFineMm, kFineMm, 8});
  std::vector<std::uint8_t> muscle;
  std::vector<std::uint8_t> blood;
  for (int j = 0; j < kPixels; ++j) {
    for (int i = 0; i < kPixels; ++i) {
      double sum = 0;
      int in = 0;
      for (int b = 0; b < kSteps; ++b) {
        for (int a = 0; a < kSteps; ++a) {
          const double x = (i + (a + 0.5) / kSteps - 0.5) * kFineMm;
          const double y = (j + (b + 0.5) / kSteps - 0.5) * kFineMm;
          const bool heart = outside.level(x, y) < 1 && y < kBaseMm;
          in += heart;
          sum += !heart ? kLung : cavity.level(x, y) < 1 ? kBlood : kMuscle;
        }
      }
      const double mean = sum / (kSteps * kSteps);
      s.image.push_back(static_cast<float>(mean));
      // Growing takes a mixed voxel for muscle.
      s.inside.push_back(in > 20);
      muscle.push_back(in > 20 && mean < 670);
      blood.push_back(in > 20 && mean >= 670);
    }
  }
  const auto error_mm = [&](const std::vector<std::uint8_t>* bare) {
    const Boundary found =
        find_boundary({.grid = s.grid,
                       .image = s.image,
                       .inside = s.inside,
                       .tells_inner = muscle,
                       .tells_outer = std::vector<std::uint8_t>(s.inside.size(), 1),
                       .bare = bare,
                       .contrast = 50,
                       .noise = 10});
    double most = 0;
    for (int i = 25; i < 38; ++i) {  // off the muscle, 8 mm and more
      for (int j = 20; j + 1 < kPixels; ++j) {
        const double here = found.coverage[static_cast<std::size_t>(i + kPixels * j)] - 0.5;
        const double next = found.coverage[static_cast<std::size_t>(i + kPixels * (j + 1))] - 0.5;
        if (here < 0 || next >= 0) continue;
        most = std::max(most, std::abs((j + here / (here - next)) * kFineMm - kBaseMm));
      }
    }
    return most;
  };
  EXPECT_LT(error_mm(&blood), 0.2 * kFineMm);
  EXPECT_GT(error_mm(nullptr), 0.3 * kFineMm) << "muscle beside it tells a place too far out";
}

TEST(Boundary, OfADiscOrEllipseLiesWithinATenthOfAPixel) {
  for (const Ellipse& e : kShapes) {
    const Slice s = make(e, 0);
    const auto coverage = boundary_of(s, s.inside, 50, 0).coverage;
    const OutlineError error = outline_error(e, coverage);
    RecordProperty("rms_mm", std::to_string(error.rms));
    // Without noise what is left is the smoothing along the outline, 1.5 pixels.
    EXPECT_LT(std::abs(error.mean), 0.1 * kPixelMm) << e.a;
    EXPECT_LT(error.rms, 0.1 * kPixelMm) << e.a;
    EXPECT_LT(error.largest, 0.25 * kPixelMm) << e.a;
    EXPECT_NEAR(area_mm2(coverage) / e.area(), 1, 0.015) << e.a;
  }
}

TEST(Boundary, StandsNoiseOfAClinicalImage) {
  // sigma 50 on a contrast of 700: CNR 14.
  for (const Ellipse& e : kShapes) {
    const Slice s = make(e, 50);
    const auto coverage = boundary_of(s, s.inside, 2.5 * 50, 50).coverage;
    const OutlineError error = outline_error(e, coverage);
    EXPECT_LT(std::abs(error.mean), 0.1 * kPixelMm) << e.a;
    EXPECT_LT(error.rms, 0.15 * kPixelMm) << e.a;
    EXPECT_LT(error.largest, 0.4 * kPixelMm) << e.a;
    EXPECT_NEAR(area_mm2(coverage) / e.area(), 1, 0.02) << e.a;
  }
}

TEST(Boundary, MovesAnOutlineThatIsOffByAPixelToWhereTheIntensityIs) {
  const Ellipse e;
  const Slice s = make(e, 0);
  for (double off_mm : {-1.2, 1.2}) {
    Ellipse wrong = e;
    wrong.a += off_mm;
    wrong.b += off_mm;
    const auto inside = make(wrong, 0).inside;
    const auto coverage = boundary_of(s, inside, 50, 0).coverage;
    // Two thirds of the shift at least is taken back: what is left is a third of a pixel.
    EXPECT_LT(std::abs(outline_error(e, coverage).mean), 0.3 * kPixelMm) << off_mm;
  }
}

TEST(Boundary, OfAConstantImageIsTheMasksOwnSmoothOutline) {
  const Ellipse e;
  Slice s = make(e, 0);
  std::fill(s.image.begin(), s.image.end(), 500.0F);
  const auto coverage = boundary_of(s, s.inside, 50, 0).coverage;
  const OutlineError error = outline_error(e, coverage);
  // The mask tells its outline to a fraction of a pixel where a staircase is smoothed.
  EXPECT_LT(error.rms, 0.2 * kPixelMm);
  EXPECT_LT(error.largest, 0.5 * kPixelMm);
  EXPECT_NEAR(area_mm2(coverage) / e.area(), 1, 0.02);
}

TEST(Boundary, IsOfTheSamePlaceWhenDarkAndBrightAreSwapped) {
  const Ellipse e;
  Slice s = make(e, 0);
  const auto bright = boundary_of(s, s.inside, 50, 0).coverage;
  for (float& value : s.image) value = 1300 - value;
  const auto dark = boundary_of(s, s.inside, 50, 0).coverage;
  for (std::size_t v = 0; v < bright.size(); ++v) EXPECT_NEAR(bright[v], dark[v], 1e-3);
}

TEST(Boundary, FarFromTheOutlineCoverageIsTheMask) {
  const Ellipse e;
  const Slice s = make(e, 50);
  const auto coverage = boundary_of(s, s.inside, 125, 50).coverage;
  for (int j = 0; j < kPixels; ++j) {
    for (int i = 0; i < kPixels; ++i) {
      const double off = (e.level(i * kPixelMm, j * kPixelMm) - 1) * e.a;
      const float c = coverage[static_cast<std::size_t>(i + kPixels * j)];
      ASSERT_TRUE(c >= 0 && c <= 1);
      if (off < -4 * kPixelMm) {
        EXPECT_EQ(c, 1) << i << " " << j;
      }
      if (off > 4 * kPixelMm) {
        EXPECT_EQ(c, 0) << i << " " << j;
      }
    }
  }
}

TEST(Boundary, OfNothingIsNothingAndOfEverythingIsEverything) {
  const Slice s = make(Ellipse{}, 0);
  const std::vector<std::uint8_t> none(s.inside.size(), 0);
  const std::vector<std::uint8_t> all(s.inside.size(), 1);
  for (float c : boundary_of(s, none, 50, 0).coverage) EXPECT_EQ(c, 0);
  for (float c : boundary_of(s, all, 50, 0).coverage) EXPECT_EQ(c, 1);
}

/// Of every boundary point: how far the boundary there is from the ellipse's, a circle's, in units
/// of what it says of itself, over several draws of the noise.
struct Calibration {
  double rms = 0;
  double mean_sigma_mm = 0;
  int points = 0;
};

Calibration calibration(double sigma, double contrast) {
  Calibration out;
  const Ellipse e;  // a circle of 20 mm
  for (unsigned draw = 0; draw < 8; ++draw) {
    Slice s = make(e, 0);
    std::mt19937 random(100 + draw);
    std::normal_distribution<double> normal(0, sigma);
    if (contrast == 0) std::fill(s.image.begin(), s.image.end(), 500.0F);
    for (float& value : s.image) value += static_cast<float>(normal(random));
    const Boundary found = boundary_of(s, s.inside, 2.5 * sigma + 50, sigma);
    for (const BoundaryPoint& point : found.points) {
      const int i = static_cast<int>(point.voxel) % kPixels;
      const int j = static_cast<int>(point.voxel) / kPixels;
      const double radius = std::hypot(i * kPixelMm - e.x, j * kPixelMm - e.y);
      // Coverage falls by one in a pixel, across the outline.
      const double off = radius + (found.coverage[point.voxel] - 0.5) * kPixelMm - e.a;
      out.rms += off * off / (point.sigma_mm * point.sigma_mm);
      out.mean_sigma_mm += point.sigma_mm;
      ++out.points;
    }
  }
  out.rms = std::sqrt(out.rms / out.points);
  out.mean_sigma_mm /= out.points;
  return out;
}

TEST(BoundaryUncertainty, IsTheErrorsSizeWhereNoiseMakesIt) {
  double before = 0;
  for (const double sigma : {50.0, 100.0}) {  // contrast over noise 14 and 7
    const Calibration found = calibration(sigma, 1);
    EXPECT_GT(found.points, 8 * 60);
    EXPECT_NEAR(found.rms, 1, 0.25) << sigma;
    EXPECT_GT(found.mean_sigma_mm, before);
    before = found.mean_sigma_mm;
    // A single profile cannot do better than sqrt(2 sqrt(pi) s p) / CNR, s the width of a pixel's
    // own blur; a Gaussian of 1.5 pixels along the outline holds 2 sqrt(pi) 1.5 of them.
    const double cnr = (kInside - kOutside) / sigma;
    const double limit =
        std::sqrt(2 * std::sqrt(std::numbers::pi) * kPixelMm / std::sqrt(12.0) * kPixelMm) / cnr;
    EXPECT_GT(found.mean_sigma_mm, 0.9 * limit / std::sqrt(2 * std::sqrt(std::numbers::pi) * 1.5));
    EXPECT_LT(found.mean_sigma_mm, 1.5 * limit) << "averaging along the outline gains";
  }
}

TEST(BoundaryUncertainty, IsLargeWhereNoIntensityTellsThePlace) {
  const Calibration found = calibration(20, 0);
  EXPECT_NEAR(found.mean_sigma_mm, 0.625 * kPixelMm, 0.01);
  EXPECT_LT(found.rms, 1);
}

TEST(BoundaryUncertainty, IsStatedInTheVoxelsThatTheOutlineCrosses) {
  const Slice s = make(Ellipse{}, 50);
  const Boundary found = boundary_of(s, s.inside, 125, 50);
  std::vector<std::uint8_t> stated(s.inside.size(), 0);
  for (std::size_t n = 0; n < found.points.size(); ++n) {
    if (n > 0) {
      EXPECT_LT(found.points[n - 1].voxel, found.points[n].voxel);
    }
    EXPECT_GT(found.points[n].sigma_mm, 0);
    stated[found.points[n].voxel] = 1;
  }
  for (std::size_t v = 0; v < stated.size(); ++v) {
    EXPECT_EQ(stated[v] != 0, found.coverage[v] > 0 && found.coverage[v] < 1);
  }
}

TEST(Boundary, OfMuscleInLungIsNotMovedByNoiseThatMagnitudesHold) {
  constexpr double kMuscle = 340;
  constexpr double kLung = 40;
  constexpr double kNoise = 50;
  const Ellipse e;
  double mean = 0;
  constexpr int kDraws = 8;
  for (unsigned draw = 0; draw < kDraws; ++draw) {
    Slice s = make(e, 0);
    std::mt19937 random(200 + draw);
    std::normal_distribution<double> normal(0, kNoise);
    for (std::size_t v = 0; v < s.image.size(); ++v) {
      const double signal = kLung + (kMuscle - kLung) * static_cast<double>(s.share[v]);
      s.image[v] = static_cast<float>(std::hypot(signal + normal(random), normal(random)));
    }
    mean += outline_error(e, boundary_of(s, s.inside, 100, kNoise).coverage).mean / kDraws;
  }
  // Taken for shares as they are, such magnitudes put it 0.047 pixels too far in.
  EXPECT_LT(std::abs(mean), 0.03 * kPixelMm);
}

TEST(Boundary, OfALeaningSurfaceInThinSlicesCoversWhatItCovers) {
  // A cone, its outline moves by two pixels from slice to slice.
  constexpr int kSlices = 5;
  constexpr int kParts = 10;
  constexpr double kLeanPx = 2;
  Slice cone;
  cone.grid = made::straight_grid({kPixels, kPixels, kSlices}, {kPixelMm, kPixelMm, 3});
  for (int k = 0; k < kSlices; ++k) {
    std::vector<float> share(static_cast<std::size_t>(kPixels) * kPixels);
    for (int part = 0; part < kParts; ++part) {
      Ellipse e;
      e.a = e.b = 20 + (k - 2 + (part + 0.5) / kParts - 0.5) * kLeanPx * kPixelMm;
      const Slice thin = make(e, 0);
      for (std::size_t v = 0; v < share.size(); ++v) share[v] += thin.share[v] / kParts;
    }
    for (const float c : share) {
      cone.share.push_back(c);
      cone.inside.push_back(c >= 0.5F);
      cone.image.push_back(static_cast<float>(kOutside + (kInside - kOutside) * c));
    }
  }
  const std::vector<float> found = boundary_of(cone, cone.inside, 50, 0).coverage;
  double square = 0;
  int count = 0;
  const std::size_t slice = static_cast<std::size_t>(kPixels) * kPixels;
  for (std::size_t v = slice; v < 4 * slice; ++v) {
    if (!(cone.share[v] > 0.02F && cone.share[v] < 0.98F)) continue;
    square += (found[v] - cone.share[v]) * (found[v] - cone.share[v]);
    ++count;
  }
  ASSERT_GT(count, 300);
  // A step of a pixel at the true place is off by 0.14.
  EXPECT_LT(std::sqrt(square / count), 0.05);
}

TEST(BoundaryUncertainty, IsSmallerAlongTheNormalOfALeaningSurface) {
  // A cone whose outline moves by a pixel from slice to slice, 1.5 mm apart: 45 degrees. Each slice
  // holds the mean over its thickness.
  Slice flat = make(Ellipse{}, 0);
  Slice cone = flat;
  cone.grid = made::straight_grid({kPixels, kPixels, 3}, {kPixelMm, kPixelMm, kPixelMm});
  cone.image.clear();
  cone.inside.clear();
  std::mt19937 random(4);
  std::normal_distribution<double> normal(0, 50);
  for (int k = 0; k < 3; ++k) {
    constexpr int kParts = 5;
    std::vector<float> image(flat.image.size());
    for (int part = 0; part < kParts; ++part) {
      Ellipse e;
      e.a = e.b = 20 + (k - 1 + (part + 0.5) / kParts - 0.5) * kPixelMm;
      const Slice thin = make(e, 0);
      for (std::size_t v = 0; v < image.size(); ++v) image[v] += thin.image[v] / kParts;
      if (part != kParts / 2) continue;
      cone.inside.insert(cone.inside.end(), thin.inside.begin(), thin.inside.end());
    }
    for (float& value : image) value += static_cast<float>(normal(random));
    cone.image.insert(cone.image.end(), image.begin(), image.end());
  }
  flat = make(Ellipse{}, 50);
  const auto mean = [](const std::vector<BoundaryPoint>& points, std::size_t from, std::size_t to) {
    double sum = 0;
    int count = 0;
    for (const BoundaryPoint& point : points) {
      if (point.voxel < from || point.voxel >= to) continue;
      sum += point.sigma_mm;
      ++count;
    }
    return sum / count;
  };
  const std::size_t slice = flat.inside.size();
  const double upright = mean(boundary_of(flat, flat.inside, 125, 50).points, 0, slice);
  const double leaning = mean(boundary_of(cone, cone.inside, 125, 50).points, slice, 2 * slice);
  // 1 / sqrt(2) for the way along the normal, but the step is twice as wide and half as steep.
  EXPECT_LT(leaning / upright, 0.9);
  EXPECT_GT(leaning / upright, 1 / std::numbers::sqrt2);
}

}  // namespace
}  // namespace beatlas::edges::boundary_tests
