#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/phantom/coil_bias.h"
#include "pipeline/phantom/render.h"
#include "pipeline/tissue/denoise.h"
#include "pipeline/tissue/shading.h"
#include "pipeline/tissue/tissue.h"

namespace beatlas::tissue {
namespace {

struct Imaged {
  phantom::PhantomSpec spec;
  ImageCycle<float> images;
  std::vector<std::uint8_t> heart;  ///< of the first phase
};

/// The phantom `small` with three of its phases.
Imaged imaged(double bias_share, const std::string& signals, double snr) {
  Imaged out;
  out.spec = phantom::preset("small");
  out.spec.phases = 3;
  out.spec.scanner.signals = signals;
  out.spec.scanner.snr_blood = snr;
  out.spec.scanner.bias_share = bias_share;
  StageContext context;
  phantom::Rendering made = phantom::render(phantom::Phantom(out.spec), context);
  out.images = std::move(made.cine.images);
  out.heart = std::move(made.labels.phases[0]);
  return out;
}

/// Standard deviation, over the heart, of the logarithm of a over b.
double spread(const Imaged& imaged, const std::vector<float>& found) {
  const phantom::CoilBias truth(imaged.spec);
  const Grid& grid = imaged.images.grid;
  double sum = 0;
  double squares = 0;
  double count = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const std::size_t v = grid.offset(i, j, k);
        if (imaged.heart[v] == 0) continue;
        const double value = std::log(found[v] / truth.at(grid.mm(i, j, k)));
        sum += value;
        squares += value * value;
        count += 1;
      }
    }
  }
  return std::sqrt(squares / count - sum * sum / count / count);
}

struct Coil {
  double bias = 0;
  const char* signals = "B";
  double snr = 20;
};

class Shading : public testing::TestWithParam<Coil> {};

TEST_P(Shading, OfTheCoilIsFoundOverTheHeart) {
  const Coil coil = GetParam();
  const Imaged heart = imaged(coil.bias, coil.signals, coil.snr);
  const TemporalStats stats = temporal_stats(heart.images);
  const std::vector<float> found = find_shading(heart.images.grid, stats);
  const double left = spread(heart, found);
  // The logarithms of muscle and blood differ by half at least; a seventh of that does no harm.
  EXPECT_LT(left, 0.07);
  if (coil.bias > 0) {
    EXPECT_LT(left, 0.6 * spread(heart, std::vector<float>(found.size(), 1)));
  }
}

INSTANTIATE_TEST_SUITE_P(Coils, Shading,
                         testing::Values(Coil{0, "B", 20}, Coil{0.3, "B", 20}, Coil{0.5, "B", 10},
                                         Coil{0, "A", 20}, Coil{0.3, "A", 20}, Coil{0.5, "A", 10}));

TEST(SliceGain, OfOneSliceIsFound) {
  Imaged heart = imaged(0, "B", 40);
  const Grid& grid = heart.images.grid;
  const int bright = 20;
  for (auto& phase : heart.images.phases) {
    for (std::size_t v = grid.offset(0, 0, bright); v < grid.offset(0, 0, bright + 1); ++v) {
      phase[v] *= 1.3F;
    }
  }
  const TemporalStats stats = temporal_stats(heart.images);
  const std::vector<float> found = find_shading(grid, stats);
  const std::size_t here = grid.offset(44, 44, bright);
  const std::size_t below = grid.offset(44, 44, bright - 1);
  const std::size_t above = grid.offset(44, 44, bright + 1);
  EXPECT_NEAR(found[here] / found[below], 1.3, 0.04);
  EXPECT_NEAR(found[here] / found[above], 1.3, 0.04);
}

TEST(WithoutShading, Divides) {
  ImageCycle<float> images;
  images.grid.size = {2, 1, 1};
  images.phases = {{6, 8}, {3, 2}};
  const ImageCycle<float> out = without_shading(images, {2, 4});
  EXPECT_EQ(out.phases[0], (std::vector<float>{3, 2}));
  EXPECT_EQ(out.phases[1], (std::vector<float>{1.5, 0.5}));
}

TEST(Shading, OfAnEmptyOrConstantImageIsNone) {
  Grid grid;
  grid.size = {30, 30, 8};
  for (const float value : {0.0F, 5.0F}) {
    ImageCycle<float> images{grid, {}};
    images.phases.assign(2, std::vector<float>(grid.count(), value));
    const std::vector<float> found = find_shading(grid, temporal_stats(images));
    for (const float each : found) ASSERT_NEAR(each, 1, 1e-6);
  }
}

TEST(Denoised, NoiseFallsAndAnEdgeStays) {
  constexpr double kNoise = 10;
  constexpr double kEdge = 50;
  ImageCycle<float> images;
  images.grid.size = {40, 40, 10};
  images.grid.mm_from_index.linear() = Vec3(1.5, 1.5, 3).asDiagonal();
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, kNoise);
  images.phases.assign(6, std::vector<float>(images.grid.count()));
  for (auto& phase : images.phases) {
    for (std::size_t v = 0; v < phase.size(); ++v) {
      phase[v] = static_cast<float>((v % 40 < 20 ? 0 : kEdge) + normal(random));
    }
  }
  const ImageCycle<float> out = denoised(images, kNoise, 3);
  double left_squares = 0;
  double left = 0;
  double right = 0;
  double count = 0;
  for (std::size_t v = 0; v < out.phases[2].size(); v += 40) {
    for (std::size_t i = 5; i < 15; ++i) {
      left_squares += out.phases[2][v + i] * out.phases[2][v + i];
    }
    left += out.phases[2][v + 18];
    right += out.phases[2][v + 21];
    count += 1;
  }
  EXPECT_LT(std::sqrt(left_squares / (10 * count)), 0.4 * kNoise);
  EXPECT_GT((right - left) / count, 0.9 * kEdge);
  EXPECT_EQ(denoised(images, 0, 3).phases, images.phases);
}

}  // namespace
}  // namespace beatlas::tissue
