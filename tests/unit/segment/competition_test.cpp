#include "pipeline/segment/competition.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "runtime/atlas/structures.h"
#include "tests/made_images.h"

namespace beatlas::segment {
namespace {

constexpr int kLabels = kLabelRestOfHeart + 1;

/// A scene that a test fills in: uniform images, no seed, every label 1 a mm.
struct Scene {
  Scene(const Index3& size, const Vec3& spacing_mm, int phases, float intensity = 100)
      : images(made::constant_images(made::straight_grid(size, spacing_mm), phases, intensity)),
        seeds(static_cast<std::size_t>(phases),
              std::vector<std::uint8_t>(images.grid.count(), kUnlabelled)) {
    prices.phases.assign(
        static_cast<std::size_t>(phases),
        std::vector<std::uint8_t>(images.grid.count() * VoxelPrices::kLabels, VoxelPrices::kUnits));
  }

  [[nodiscard]] std::uint8_t& price(std::size_t phase, std::size_t voxel, int label) {
    return prices.phases[phase][voxel * VoxelPrices::kLabels + static_cast<std::size_t>(label)];
  }
  void seed(int phase, int i, int j, int k, std::uint8_t label) {
    seeds[static_cast<std::size_t>(phase)][images.grid.offset(i, j, k)] = label;
  }
  [[nodiscard]] ImageCycle<std::uint8_t> grow() const {
    StageContext context;
    return grow_in_competition({images, seeds, prices, phase_step_mm, motion, edge_free, edge_cost},
                               context);
  }

  ImageCycle<float> images;
  LabelImages seeds;
  VoxelPrices prices;
  double phase_step_mm = 3;
  const motion::PhaseMotion* motion = nullptr;
  double edge_free = 0;
  double edge_cost = 0;
};

TEST(Competition, TwoSeedsInAUniformImageMeetHalfWay) {
  // 2 mm voxels: seeds at 10 and 70 mm, so 40 mm is the middle; steps along the axes only.
  Scene scene({41, 21, 1}, {2, 2, 5}, 1);
  scene.seed(0, 5, 10, 0, kLabelBackground);
  scene.seed(0, 35, 10, 0, kLabelLvBlood);
  const auto labels = scene.grow();
  for (int j = 0; j < 21; ++j) {
    for (int i = 0; i < 41; ++i) {
      if (i == 20) continue;  // as far from both
      EXPECT_EQ(labels.phases[0][scene.images.grid.offset(i, j, 0)],
                i < 20 ? kLabelBackground : kLabelLvBlood)
          << i << " " << j;
    }
  }
}

TEST(Competition, ADearerLabelGetsAsMuchLess) {
  // 60 mm apart along slices of 3 mm; one mm costs 1 against 2: they meet at 40 mm.
  Scene scene({1, 1, 21}, {1, 1, 3}, 1);
  for (std::size_t v = 0; v < 21; ++v) {
    scene.price(0, v, kLabelLvBlood) = 2 * VoxelPrices::kUnits;
  }
  scene.seed(0, 0, 0, 0, kLabelRestOfHeart);
  scene.seed(0, 0, 0, 20, kLabelLvBlood);
  const auto labels = scene.grow();
  for (int k = 0; k < 21; ++k) {
    if (3 * k == 39) continue;  // 39 to one and 2 x 21 to the other; neighbours are clear
    EXPECT_EQ(labels.phases[0][static_cast<std::size_t>(k)],
              3 * k < 40 ? kLabelRestOfHeart : kLabelLvBlood)
        << k;
  }
}

TEST(Competition, ALabelGoesWhereTheMotionTakesIt) {
  // A disc is marked in phase 0, and nothing tells it from what is around it. In phase 1 it lies
  // 10 voxels further on; both phases are one image.
  constexpr int kMove = 10;
  Scene scene({50, 30, 1}, {1, 1, 5}, 2);
  const Grid& grid = scene.images.grid;
  const auto in_disc = [](int i, int j) { return std::hypot(i - 15, j - 14) < 7; };
  for (int j = 0; j < 30; ++j) {
    for (int i = 0; i < 50; ++i) {
      scene.seed(0, i, j, 0, in_disc(i, j) ? kLabelLvBlood : kLabelBackground);
    }
  }
  const auto wrong = [&](int move) {
    const auto labels = scene.grow();
    int count = 0;
    for (int j = 0; j < 30; ++j) {
      for (int i = 0; i < 50; ++i) {
        const bool is = labels.phases[1][grid.offset(i, j, 0)] == kLabelLvBlood;
        count += is != in_disc(i - move, j) ? 1 : 0;
      }
    }
    return count;
  };
  EXPECT_EQ(wrong(0), 0) << "without motion it stays";
  motion::PhaseMotion motion;
  motion.to_next.assign(2, std::vector<motion::PlaneStep>(grid.count(), {0, 0}));
  motion.to_previous = motion.to_next;
  for (int j = 0; j < 30; ++j) {
    for (int i = 0; i < 50; ++i) {
      const std::size_t v = grid.offset(i, j, 0);
      const int on = std::min(kMove, 49 - i);
      motion.to_next[0][v] = {static_cast<std::int8_t>(on), 0};
      motion.to_previous[0][v] = motion.to_next[0][v];  // two phases: the next is the previous
    }
  }
  scene.motion = &motion;
  EXPECT_EQ(wrong(kMove), 0);
}

TEST(Competition, AnEdgeStopsGrowthWhereTheMiddleLiesElsewhere) {
  Scene scene({40, 9, 3}, {1, 1, 1}, 1);
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 9; ++j) {
      for (int i = 20; i < 40; ++i) scene.images.phases[0][scene.images.grid.offset(i, j, k)] = 200;
    }
  }
  scene.seed(0, 2, 4, 1, kLabelBackground);
  scene.seed(0, 22, 4, 1, kLabelLvMyocardium);
  const auto count = [&](const ImageCycle<std::uint8_t>& labels) {
    return std::count(labels.phases[0].begin(), labels.phases[0].end(), kLabelLvMyocardium);
  };
  // Without a price on the edge they meet half-way, at 12.
  EXPECT_NEAR(static_cast<double>(count(scene.grow())), 27 * 27.5, 27 * 0.6);
  scene.edge_free = 20;
  scene.edge_cost = 1;  // 80 mm of travel
  const auto labels = scene.grow();
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(labels.phases[0][scene.images.grid.offset(i, 4, 1)],
              i < 20 ? kLabelBackground : kLabelLvMyocardium)
        << i;
  }
  EXPECT_EQ(count(labels), 20 * 27);
  // An edge no higher than texture is none.
  scene.edge_free = 100;
  EXPECT_NEAR(static_cast<double>(count(scene.grow())), 27 * 27.5, 27 * 0.6);
}

TEST(Competition, AWallOneVoxelThickHolds) {
  constexpr int kN = 19;
  Scene scene({kN, kN, kN}, {1, 1, 1}, 1);
  const auto depth = [](int i, int j, int k) {  // 0 outside, 1 in the wall, 2 inside
    const int r = std::max({std::abs(i - 9), std::abs(j - 9), std::abs(k - 9)});
    return r > 6 ? 0 : r == 6 ? 1 : 2;
  };
  for (int k = 0; k < kN; ++k) {
    for (int j = 0; j < kN; ++j) {
      for (int i = 0; i < kN; ++i) {
        // An eighth of a millimetre's price beside the wall, and in it more than any way around.
        for (int label = 0; label < kLabels; ++label) {
          scene.price(0, scene.images.grid.offset(i, j, k), label) =
              depth(i, j, k) == 1 ? 255 : VoxelPrices::kUnits / 8;
        }
      }
    }
  }
  // The seed inside lies in one corner, the one outside at the opposite one, right at the wall.
  scene.seed(0, 4, 4, 4, kLabelLvBlood);
  scene.seed(0, 16, 16, 16, kLabelBackground);
  const auto labels = scene.grow();
  for (int k = 0; k < kN; ++k) {
    for (int j = 0; j < kN; ++j) {
      for (int i = 0; i < kN; ++i) {
        const std::uint8_t label = labels.phases[0][scene.images.grid.offset(i, j, k)];
        if (depth(i, j, k) == 0) {
          ASSERT_EQ(label, kLabelBackground) << i << " " << j << " " << k;
        }
        if (depth(i, j, k) == 2) {
          ASSERT_EQ(label, kLabelLvBlood) << i << " " << j << " " << k;
        }
      }
    }
  }
}

TEST(Competition, TheCycleIsClosed) {
  Scene scene({2, 2, 1}, {1, 1, 1}, 10);
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      scene.seed(0, i, j, 0, kLabelLvBlood);
      scene.seed(5, i, j, 0, kLabelBackground);
    }
  }
  const auto labels = scene.grow();
  for (int p : {8, 9, 0, 1, 2}) EXPECT_EQ(labels.phases[p][0], kLabelLvBlood) << p;
  for (int p : {3, 4, 5, 6, 7}) EXPECT_EQ(labels.phases[p][0], kLabelBackground) << p;
}

TEST(Competition, AStepInTimeCountsAsItsMillimetres) {
  // From a seed in another phase it is 7 mm in time, from one in the same phase 6 or 8 mm.
  Scene scene({10, 1, 1}, {1, 1, 1}, 2);
  scene.phase_step_mm = 7;
  for (int i = 0; i < 10; ++i) scene.seed(0, i, 0, 0, kLabelLvBlood);
  scene.seed(1, 0, 0, 0, kLabelBackground);
  const auto labels = scene.grow();
  EXPECT_EQ(labels.phases[1][6], kLabelBackground);
  EXPECT_EQ(labels.phases[1][8], kLabelLvBlood);
}

/// Noise, a coarse pattern of intensities and a few seeds, two phases.
Scene random_scene() {
  Scene scene({16, 14, 6}, {1, 1.5, 4}, 2);
  std::mt19937 random(11);
  for (auto& phase : scene.images.phases) {
    for (float& value : phase) value = static_cast<float>(random() % 1000);
  }
  for (std::size_t p = 0; p < 2; ++p) {
    for (std::size_t v = 0; v < scene.images.grid.count(); ++v) {
      const auto price = static_cast<std::uint8_t>(8 + random() % 64);
      for (int label = 0; label < kLabels; ++label) scene.price(p, v, label) = price;
    }
  }
  for (int n = 0; n < 12; ++n) {
    scene.seed(n % 2, static_cast<int>(random() % 16), static_cast<int>(random() % 14),
               static_cast<int>(random() % 6), static_cast<std::uint8_t>(random() % kLabels));
  }
  scene.edge_free = 100;
  scene.edge_cost = 0.02;
  return scene;
}

TEST(Competition, EachVoxelFallsToTheLabelNearestByAnIndependentSearch) {
  // One price for all labels, so who comes first is who is nearest: relaxation until nothing
  // changes (Bellman and Ford), one label at a time.
  const Scene scene = random_scene();
  const auto labels = scene.grow();
  const Grid& grid = scene.images.grid;
  const Vec3 spacing = grid.spacing_mm();
  std::vector<std::vector<std::vector<double>>> cost(kLabels);
  for (int label = 0; label < kLabels; ++label) {
    auto& phases = cost[static_cast<std::size_t>(label)];
    phases.assign(2, std::vector<double>(grid.count(), 1e30));
    for (std::size_t p = 0; p < 2; ++p) {
      for (std::size_t v = 0; v < grid.count(); ++v) {
        if (scene.seeds[p][v] == label) phases[p][v] = 0;
      }
    }
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t p = 0; p < 2; ++p) {
        for (int k = 0; k < grid.size[2]; ++k) {
          for (int j = 0; j < grid.size[1]; ++j) {
            for (int i = 0; i < grid.size[0]; ++i) {
              const std::size_t here = grid.offset(i, j, k);
              const float value = scene.images.phases[p][here];
              const auto from = [&](std::size_t q, std::size_t v, double step_mm) {
                const double jump = std::abs(scene.images.phases[q][v] - value) - scene.edge_free;
                const double arc = step_mm * scene.prices.phases[p][here * VoxelPrices::kLabels] /
                                       VoxelPrices::kUnits +
                                   scene.edge_cost * std::max(0.0, jump);
                if (phases[q][v] + arc < phases[p][here] - 1e-9) {
                  phases[p][here] = phases[q][v] + arc;
                  changed = true;
                }
              };
              if (i > 0) from(p, here - 1, spacing[0]);
              if (i + 1 < grid.size[0]) from(p, here + 1, spacing[0]);
              if (j > 0) from(p, grid.offset(i, j - 1, k), spacing[1]);
              if (j + 1 < grid.size[1]) from(p, grid.offset(i, j + 1, k), spacing[1]);
              if (k > 0) from(p, grid.offset(i, j, k - 1), spacing[2]);
              if (k + 1 < grid.size[2]) from(p, grid.offset(i, j, k + 1), spacing[2]);
              from(1 - p, here, scene.phase_step_mm);
            }
          }
        }
      }
    }
  }
  int decided = 0;
  for (std::size_t p = 0; p < 2; ++p) {
    for (std::size_t v = 0; v < grid.count(); ++v) {
      double least = 1e30;
      for (const auto& each : cost) least = std::min(least, each[p][v]);
      const std::uint8_t winner = labels.phases[p][v];
      ASSERT_LT(winner, kLabels);
      // Prices are cut down to 1/16 mm a step, and no path here has more than 60 steps.
      EXPECT_LE(cost[winner][p][v], least + 60.0 / 16) << p << " " << v;
      int near = 0;
      for (const auto& each : cost) near += each[p][v] <= least + 60.0 / 16 ? 1 : 0;
      decided += near == 1;
    }
  }
  EXPECT_GT(decided, static_cast<int>(grid.count()));  // of 2 x count: the check means something
}

TEST(Competition, OfTwoLabelsAsCheapTheLowerNumberWins) {
  // Five voxels, a seed at either end: the middle one is as far from both, whoever comes first.
  for (const bool turned : {false, true}) {
    Scene scene({5, 1, 1}, {1, 1, 1}, 1);
    scene.seed(0, turned ? 4 : 0, 0, 0, kLabelRvBlood);
    scene.seed(0, turned ? 0 : 4, 0, 0, kLabelLvBlood);
    EXPECT_EQ(scene.grow().phases[0][2], kLabelRvBlood);
  }
}

TEST(Competition, WideFrontsAreTheSameOnOneThreadAndTwo) {
  // Whole planes move together, so that a bucket is large enough to be worked on in parts, and
  // every second voxel is a tie.
  Scene scene({128, 64, 9}, {1, 1, 1}, 3);
  for (int j = 0; j < 64; ++j) {
    for (int i = 0; i < 128; ++i) {
      for (int p = 0; p < 3; ++p) {
        scene.seed(p, i, j, 0, i % 2 == 0 ? kLabelLvBlood : kLabelLvMyocardium);
        scene.seed(p, i, j, 8, kLabelRvBlood);
      }
    }
  }
  set_thread_count(1);
  const auto one = scene.grow();
  set_thread_count(2);
  const auto two = scene.grow();
  set_thread_count(0);
  EXPECT_EQ(one.phases, two.phases);
  EXPECT_EQ(one.phases[0][scene.images.grid.offset(7, 7, 4)], kLabelRvBlood);
}

TEST(Competition, IsTheSameOnOneThreadAndTwo) {
  const Scene scene = random_scene();
  set_thread_count(1);
  const auto one = scene.grow();
  set_thread_count(2);
  const auto two = scene.grow();
  set_thread_count(0);
  EXPECT_EQ(one.phases, two.phases);
}

TEST(Competition, WithoutASeedNothingIsLabelled) {
  const Scene scene({4, 4, 2}, {1, 1, 1}, 3);
  const auto labels = scene.grow();
  for (const auto& phase : labels.phases) {
    for (std::uint8_t label : phase) EXPECT_EQ(label, kUnlabelled);
  }
}

TEST(Competition, TakesIntensitiesOfAnySize) {
  Scene scene({8, 1, 1}, {1, 1, 1}, 1);
  scene.images.phases[0] = {-32768, -1, 0, 65535, 1e9F, 1000, 999, -1e9F};
  scene.edge_cost = 1;
  scene.seed(0, 0, 0, 0, kLabelRvBlood);
  const auto labels = scene.grow();
  for (std::uint8_t label : labels.phases[0]) EXPECT_EQ(label, kLabelRvBlood);
}

TEST(Competition, CanBeStopped) {
  Scene scene({128, 128, 65}, {1, 1, 1}, 1);
  scene.seed(0, 0, 0, 0, kLabelRvBlood);
  const std::atomic<bool> stop{true};
  StageContext context;
  context.cancel = &stop;
  EXPECT_THROW((void)grow_in_competition(
                   {.images = scene.images, .seeds = scene.seeds, .prices = scene.prices}, context),
               Error);
}

}  // namespace
}  // namespace beatlas::segment
