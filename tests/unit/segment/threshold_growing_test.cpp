/// Plain threshold growing against an independent search, and against competition where it leaks.
#include "pipeline/segment/threshold_growing.h"

#include <deque>
#include <iostream>

#include <gtest/gtest.h>

#include "pipeline/core/segmented_volume.h"
#include "tests/clinical_part.h"
#include "tests/made_images.h"
#include "tests/unit/segment/imaged_phantom.h"

namespace beatlas::segment {
namespace {

/// Two thick rods that meet at a corner only, and one apart.
struct Rods {
  Grid grid = made::straight_grid({24, 20, 8}, {1, 1, 3});
  std::vector<float> image = std::vector<float>(grid.count(), 100);

  void box(const Index3& low, const Index3& high, float value) {
    for (int k = low[2]; k < high[2]; ++k) {
      for (int j = low[1]; j < high[1]; ++j) {
        for (int i = low[0]; i < high[0]; ++i) image[grid.offset(i, j, k)] = value;
      }
    }
  }
  Rods() {
    box({2, 2, 1}, {6, 6, 4}, 500);
    box({6, 6, 4}, {10, 10, 7}, 600);  // touches the first at a corner
    box({14, 2, 1}, {20, 8, 6}, 500);  // apart
    box({3, 3, 2}, {4, 4, 3}, 900);    // a hole in the window
  }
};

std::size_t count(const std::vector<std::uint8_t>& mask) {
  return static_cast<std::size_t>(std::count(mask.begin(), mask.end(), 1));
}

TEST(ThresholdGrowing, TakesWhatTheWindowJoinsToASeed) {
  const Rods rods;
  const std::vector<std::size_t> seed{rods.grid.offset(2, 2, 1)};
  const auto faces = grow_in_window(rods.grid, rods.image, seed, {400, 700, Neighbours::Faces});
  EXPECT_EQ(count(faces), 4U * 4 * 3 - 1);
  const auto all = grow_in_window(rods.grid, rods.image, seed, {400, 700, Neighbours::All});
  EXPECT_EQ(count(all), 4U * 4 * 3 - 1 + 4 * 4 * 3);
  EXPECT_EQ(count(grow_in_window(rods.grid, rods.image, seed, {500, 500, Neighbours::All})),
            4U * 4 * 3 - 1)
      << "ends belong to the window";
  EXPECT_EQ(count(grow_in_window(rods.grid, rods.image, {rods.grid.offset(3, 3, 2)},
                                 {400, 700, Neighbours::All})),
            0U)
      << "a seed beyond the window grows nowhere";
}

struct Scan : made::ImagedPhantom {
  using ImagedPhantom::ImagedPhantom;
  [[nodiscard]] Vec3 lv_middle() const { return phantom.spec().anatomy.origin_lps_mm; }
};

/// Another way to the same: labels spread over the whole image, sweep after sweep, until none
/// moves.
std::vector<std::uint8_t> by_sweeps(const Grid& grid, const std::vector<float>& image,
                                    std::size_t seed, const IntensityWindow& window) {
  std::vector<std::uint8_t> in(image.size(), 0);
  if (image[seed] < window.low || image[seed] > window.high) return in;
  in[seed] = 1;
  for (bool moved = true; moved;) {
    moved = false;
    for (const bool forward : {true, false}) {
      for (std::size_t n = 0; n < image.size(); ++n) {
        const std::size_t v = forward ? n : image.size() - 1 - n;
        if (in[v] != 0 || image[v] < window.low || image[v] > window.high) continue;
        const int x = static_cast<int>(v) % grid.size[0];
        const int y = static_cast<int>(v) / grid.size[0] % grid.size[1];
        const int z = static_cast<int>(v) / (grid.size[0] * grid.size[1]);
        for (int near = 0; near < 27 && in[v] == 0; ++near) {
          const Index3 d{near % 3 - 1, near / 3 % 3 - 1, near / 9 - 1};
          const int axes = (d[0] != 0) + (d[1] != 0) + (d[2] != 0);
          if (axes == 0 || (window.neighbours == Neighbours::Faces && axes != 1)) continue;
          if (!grid.contains(x + d[0], y + d[1], z + d[2])) continue;
          if (in[grid.offset(x + d[0], y + d[1], z + d[2])] != 0) in[v] = 1;
        }
        moved = moved || in[v] != 0;
      }
    }
  }
  return in;
}

TEST(ThresholdGrowing, IsAConnectedComponentOfTheWindowInEveryPhase) {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.phases = 3;
  const Scan scan(spec);
  const Grid& grid = scan.truth.grid;
  const Vec3 at = grid.mm_from_index.inverse(Eigen::Affine) * scan.lv_middle();
  const std::size_t seed =
      grid.offset(static_cast<int>(std::lround(at[0])), static_cast<int>(std::lround(at[1])),
                  static_cast<int>(std::lround(at[2])));
  for (const Neighbours neighbours : {Neighbours::Faces, Neighbours::All}) {
    SegmentOptions options;
    options.method = Method::Threshold;
    options.threshold_low = 650;
    options.threshold_high = 1400;
    options.threshold_neighbours = neighbours;
    // Drawn in one phase, it stands in all.
    const Segmentation found = scan.segmented({{kLabelLvBlood, scan.lv_middle(), 0.1, 1}}, options);
    for (std::size_t p = 0; p < 3; ++p) {
      const auto wanted =
          by_sweeps(grid, scan.exam.stack.images.phases[p], seed, {650, 1400, neighbours});
      ASSERT_GT(count(wanted), 100U);
      for (std::size_t v = 0; v < wanted.size(); ++v) {
        ASSERT_EQ(found.labels.phases[p][v], wanted[v] != 0 ? kLabelLvBlood : kLabelBackground);
      }
    }
    EXPECT_EQ(found.coverage.phases.size(), 2U);
    EXPECT_FALSE(found.axis);
    EXPECT_EQ(found.warnings.size(), 1U);
  }
}

TEST(ThresholdGrowing, FindsItsWindowInImagesWithAnOffset) {
  phantom::PhantomSpec spec = made::clinical_part();
  spec.phases = 4;
  Scan scan(spec);
  SegmentOptions options;
  options.method = Method::Threshold;
  const std::vector<Seed> seeds{{kLabelLvBlood, scan.lv_middle(), 3, -1}};
  const Segmentation plain = scan.segmented(seeds, options);
  for (auto& phase : scan.exam.stack.images.phases) {
    for (float& value : phase) value -= 20000;
  }
  const Segmentation moved = made::segmented(scan.exam, made::Views::One, seeds, options);
  for (std::size_t p = 0; p < 4; ++p) {
    EXPECT_GT(made::label_dice(plain.labels.phases[p], moved.labels.phases[p], kLabelLvBlood), 0.99)
        << p;
  }
}

TEST(ThresholdGrowing, LeaksOnTheHardPhantomWhereTheCompetitionDoesNot) {
  phantom::PhantomSpec spec = phantom::preset("hard");
  spec.grid = phantom::on_matrix(spec.grid, {0, 0, 0}, {2, 2, 4});
  spec.phases = 4;
  const Scan scan(spec);
  const auto overgrown = [&](const Segmentation& found) {
    double most = 0;
    const std::vector<double> curve = segmented_volume_ml(found, Structure::LvBlood);
    for (int p = 0; p < spec.phases; ++p) {
      most = std::max(most,
                      curve[static_cast<std::size_t>(p)] /
                          scan.phantom.volume_ml(Structure::LvBlood, scan.phantom.phase_time_s(p)));
    }
    return most;
  };
  SegmentOptions options;
  const double competition = overgrown(scan.segmented({}, options));
  options.method = Method::Threshold;
  const double threshold = overgrown(scan.segmented({}, options));
  std::cout << "LV blood over its true volume: competition " << competition << ", threshold "
            << threshold << "\n";
  EXPECT_LT(competition, 1.5);
  EXPECT_GT(threshold, 2);
}

TEST(ThresholdGrowing, IsRefusedWhereItCannotBegin) {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.phases = 2;
  const Scan scan(spec);
  SegmentOptions options;
  options.method = Method::Threshold;
  options.threshold_low = 3000;
  options.threshold_high = 4000;
  const auto said = [&] { return made::refusal([&] { (void)scan.segmented({}, options); }); };
  EXPECT_NE(said().find("found nothing in phase 0"), std::string::npos);
  options.threshold_high = 100;
  EXPECT_NE(said().find("threshold_low below threshold_high"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::segment
