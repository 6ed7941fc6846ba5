/// Coverage from elsewhere beside labels of every phase.
#include "pipeline/segment/given_coverage.h"

#include <array>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "pipeline/segment/known_labels.h"
#include "tests/made_images.h"

namespace beatlas::segment {
namespace {

constexpr double kRadiusMm = 20.3;

/// A ball of LV blood in voxels of 2 x 2 x 3 mm, two phases.
struct Ball {
  Grid grid = made::straight_grid({32, 32, 22}, {2, 2, 3});
  Vec3 centre = grid.mm(15.5, 15.5, 10.5);
  Exam exam;
  KnownLabels known;
  GivenCoverage coverage;

  Ball() {
    exam.stack.images.grid = grid;
    exam.stack.images.phases.assign(2, std::vector<float>(grid.count(), 100));
    exam.stack.rr_interval_s = 1;
    known.phases = {0, 1};
    known.labels.grid = grid;
    known.labels.phases.assign(2, std::vector<std::uint8_t>(grid.count(), kLabelBackground));
    // Coverage on a part of the grid alone.
    PartCoverage part;
    part.first = {3, 3, 2};
    part.share.grid = grid.part(part.first, {26, 26, 18});
    part.share.phases.assign(2, std::vector<float>(part.share.grid.count()));
    constexpr int kParts = 6;
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          int inside = 0;
          for (int n = 0; n < kParts * kParts * kParts; ++n) {
            const std::array step{n % kParts, (n / kParts) % kParts, n / (kParts * kParts)};
            const Vec3 off =
                Vec3(step[0], step[1], step[2]) / kParts + Vec3::Constant(0.5 / kParts - 0.5);
            inside += in(grid.mm(i + off[0], j + off[1], k + off[2])) ? 1 : 0;
          }
          const bool centre_in = in(grid.mm(i, j, k));
          const Index3 at{i - 3, j - 3, k - 2};
          for (std::size_t p = 0; p < 2; ++p) {
            if (centre_in) known.labels.phases[p][grid.offset(i, j, k)] = kLabelLvBlood;
            if (!part.share.grid.contains(at[0], at[1], at[2])) continue;
            part.share.phases[p][part.share.grid.offset(at[0], at[1], at[2])] =
                static_cast<float>(inside) / (kParts * kParts * kParts);
          }
        }
      }
    }
    coverage[Structure::LvBlood] = part;
    coverage[Structure::Heart] = part;
  }

  [[nodiscard]] bool in(const Vec3& x) const { return (x - centre).norm() < kRadiusMm; }
  [[nodiscard]] Segmentation segmented() const {
    StageContext context;
    return segment_with_labels(exam, known, {}, {}, context, coverage);
  }
};

TEST(GivenCoverage, TakesThePlaceOfWhatLabelsWouldGive) {
  const Ball ball;
  const Segmentation result = ball.segmented();
  EXPECT_EQ(result.labels.phases, ball.known.labels.phases);
  const PartCoverage& given = ball.coverage.at(Structure::LvBlood);
  const Grid& grid = result.coverage.grid;
  std::size_t covered = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Index3 at{i + result.coverage.first[0] - given.first[0],
                        j + result.coverage.first[1] - given.first[1],
                        k + result.coverage.first[2] - given.first[2]};
        const bool held = given.share.grid.contains(at[0], at[1], at[2]);
        const float want =
            held ? given.share.phases[1][given.share.grid.offset(at[0], at[1], at[2])] : 0.0F;
        const float have = result.coverage.phases.at(Structure::LvBlood)[1][grid.offset(i, j, k)];
        ASSERT_EQ(have, want);
        covered += want > 0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(covered, 3000U);
}

TEST(GivenCoverage, OfOneStructureLeavesTheOthersToTheirLabels) {
  Ball ball;
  const Segmentation without = [&] {
    Ball bare = ball;
    bare.coverage.clear();
    return bare.segmented();
  }();
  ball.coverage.erase(Structure::Heart);
  std::string warned;
  StageContext context;
  context.warn_sink = [&](std::string_view line) { warned += line; };
  const Segmentation result =
      segment_with_labels(ball.exam, ball.known, {}, {}, context, ball.coverage);
  EXPECT_EQ(result.coverage.phases.at(Structure::Heart),
            without.coverage.phases.at(Structure::Heart));
  EXPECT_NE(result.coverage.phases.at(Structure::LvBlood),
            without.coverage.phases.at(Structure::LvBlood));
  EXPECT_EQ(warned, "no coverage of heart was given; its labels tell where its surface runs");
}

TEST(GivenCoverage, OfAnotherSegmentationIsRefused) {
  const auto said = [](const auto& change) {
    Ball ball;
    change(ball);
    return made::refusal([&] { (void)ball.segmented(); });
  };
  // Four voxels aside, 8 mm.
  EXPECT_NE(said([](Ball& ball) {
              PartCoverage& part = ball.coverage.at(Structure::LvBlood);
              part.first[0] -= 3;
              part.share.grid = ball.grid.part(part.first, part.share.grid.size);
            }).find("tell the opposite of"),
            std::string::npos);
  EXPECT_NE(said([](Ball& ball) {
              ball.coverage[Structure::RvBlood] = ball.coverage.at(Structure::LvBlood);
            }).find("the labels hold none of it"),
            std::string::npos);
  EXPECT_NE(said([](Ball& ball) {
              ball.coverage.at(Structure::Heart).share.phases.pop_back();
            }).find("holds 1 image, but the exam has 2 phases"),
            std::string::npos);
  EXPECT_NE(said([](Ball& ball) {
              ball.known.phases.pop_back();
              ball.known.labels.phases.pop_back();
            }).find("labels of every phase"),
            std::string::npos);
}

}  // namespace
}  // namespace beatlas::segment
