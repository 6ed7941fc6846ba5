#include <gtest/gtest.h>

#include "pipeline/edges/coverage.h"
#include "runtime/atlas/structures.h"

namespace beatlas::edges {
namespace {

/// A row of voxels in one phase, and what covers them.
class Row {
 public:
  explicit Row(std::vector<std::uint8_t> labels) {
    labels_.grid.size = {static_cast<int>(labels.size()), 1, 1};
    labels_.phases.push_back(std::move(labels));
    covered_.grid = labels_.grid;
  }
  void cover(Structure structure, std::vector<float> shares) {
    covered_.phases[structure].push_back(std::move(shares));
  }
  [[nodiscard]] std::vector<std::uint8_t> followed() {
    follow_coverage(covered_, labels_);
    return labels_.phases[0];
  }

 private:
  ImageCycle<std::uint8_t> labels_;
  CoverageCycle covered_;
};

constexpr std::uint8_t kNone = kLabelBackground;
constexpr std::uint8_t kRv = kLabelRvBlood;
constexpr std::uint8_t kWall = kLabelLvMyocardium;
constexpr std::uint8_t kLv = kLabelLvBlood;
constexpr std::uint8_t kRest = kLabelRestOfHeart;

TEST(FollowCoverage, AVoxelIsOfWhatCoversMostOfIt) {
  Row row({kNone, kRest, kRv, kRv, kWall, kWall, kLv, kLv});
  row.cover(Structure::Heart, {0.7F, 1, 1, 1, 1, 1, 1, 1});
  row.cover(Structure::RvBlood, {0, 0.6F, 1, 0.4F, 0, 0, 0, 0});
  row.cover(Structure::LvMyocardium, {0, 0, 0, 0.6F, 1, 0.3F, 0, 0});
  row.cover(Structure::LvBlood, {0, 0, 0, 0, 0, 0.7F, 1, 1});
  EXPECT_EQ(row.followed(),
            (std::vector<std::uint8_t>{kRest, kRv, kRv, kWall, kWall, kLv, kLv, kLv}));
}

TEST(FollowCoverage, WhatLostItsOwnIsWallOrRestOrNoHeart) {
  Row row({kRv, kLv, kRv, kWall, kRest, kRest});
  row.cover(Structure::Heart, {1, 1, 0.2F, 1, 0.9F, 0.4F});
  row.cover(Structure::RvBlood, {0.4F, 0, 0.1F, 0, 0, 0});
  row.cover(Structure::LvMyocardium, {0, 0.3F, 0, 0.2F, 0, 0});
  row.cover(Structure::LvBlood, {0, 0.4F, 0, 0, 0, 0});
  EXPECT_EQ(row.followed(), (std::vector<std::uint8_t>{kRest, kWall, kNone, kRest, kRest, kNone}));
}

TEST(FollowCoverage, LabelsWithoutCoverageStayWithinTheHeart) {
  Row row({kLabelAorta, kLabelAorta, kLv});
  row.cover(Structure::Heart, {1, 0.1F, 1});
  row.cover(Structure::LvBlood, {0, 0, 1});
  EXPECT_EQ(row.followed(), (std::vector<std::uint8_t>{kLabelAorta, kNone, kLv}));
}

TEST(FollowCoverage, WithoutTheHeartNothingMoves) {
  Row row({kRv, kLv});
  row.cover(Structure::LvBlood, {1, 0});
  EXPECT_EQ(row.followed(), (std::vector<std::uint8_t>{kRv, kLv}));
}

}  // namespace
}  // namespace beatlas::edges
