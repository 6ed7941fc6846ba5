/// The body of a drawn exam, asked where its surfaces lie.

#include "pipeline/phantom/drawn_truth.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/phantom/drawn_exam.h"
#include "runtime/base/error.h"

namespace beatlas::phantom {
namespace {

const DrawnExam& exam() {
  static const DrawnExam kExam = [] {
    StageContext context;
    return drawn_exam(10000, {.most_voxels = 1100000}, context);
  }();
  return kExam;
}

std::string refusal(const nlohmann::json& truth) {
  try {
    const DrawnTruth never(truth);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(DrawnTruth, LabelsOfTheExamAreInsideOfItWhereBreathHoldsMovedItToInTheMean) {
  const DrawnTruth truth(exam().truth);
  ASSERT_EQ(truth.phases(), static_cast<int>(exam().labels.phases.size()));
  EXPECT_EQ(truth.identity(), exam().identity);
  const Grid& grid = exam().labels.grid;
  Vec3 moved = Vec3::Zero();
  const nlohmann::json& shifts = exam().truth["stack"]["shifts_mm"];
  for (const nlohmann::json& shift : shifts) {
    for (int axis = 0; axis < 2; ++axis) {
      moved += shift[static_cast<std::size_t>(axis)].get<double>() *
               grid.mm_from_index.linear().col(axis).normalized() /
               static_cast<double>(shifts.size());
    }
  }
  EXPECT_GT(moved.norm(), 0.1) << "a draw whose breath-holds tell something";
  for (const int p : {0, truth.phases() / 2}) {
    const DrawnTruth::Frame frame = truth.frame(p, 4);
    const auto& labels = exam().labels.phases[static_cast<std::size_t>(p)];
    std::size_t at = 0;
    std::size_t unlike = 0;
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i, ++at) {
          const bool labelled = label_in_structure(labels[at], Structure::LvBlood);
          if (frame.contains(Structure::LvBlood, grid.mm(i, j, k) + moved) != labelled) ++unlike;
        }
      }
    }
    EXPECT_LE(unlike, 3U) << "rounding moves a voxel that lies on the surface; phase " << p;
  }
}

TEST(DrawnTruth, PointsOfASurfaceEncloseTheVolume) {
  const DrawnTruth truth(exam().truth);
  const DrawnTruth::Frame frame = truth.frame(0, 1.2);
  for (const Structure structure : {Structure::LvBlood, Structure::RvBlood}) {
    const std::vector<DrawnTruth::Frame::Point> points = frame.surface(structure);
    ASSERT_GT(points.size(), 1000U);
    double volume = 0;
    int apart = 0;
    for (const auto& point : points) {
      volume += point.lps.dot(point.normal) * point.area_mm2 / 3000;
      const bool in = frame.contains(structure, point.lps - 0.5 * point.normal);
      const bool out = frame.contains(structure, point.lps + 0.5 * point.normal);
      apart += in && !out ? 1 : 0;
    }
    // Normals are rounded where surfaces meet at an edge, as at the valves, over two spacings.
    EXPECT_NEAR(volume / truth.volume_ml(structure, 0), 1, 0.05) << structure_name(structure);
    EXPECT_GT(apart / static_cast<double>(points.size()), 0.97) << structure_name(structure);
  }
}

TEST(DrawnTruth, WhatIsNoTruthOfADrawIsRefusedInASentence) {
  const nlohmann::json truth = exam().truth;
  EXPECT_TRUE(is_drawn_truth(truth));
  EXPECT_FALSE(is_drawn_truth(nlohmann::json::array()));
  EXPECT_FALSE(is_drawn_truth({{"format", "beatlas-phantom-truth"}}));
  EXPECT_NE(refusal({{"format", 3}}).find("/format"), std::string::npos);
  const auto changed = [&](const char* key, const nlohmann::json& value) {
    nlohmann::json out = truth;
    out[key] = value;
    return refusal(out);
  };
  EXPECT_EQ(refusal(truth), "");
  EXPECT_NE(changed("version", 2).find("another version"), std::string::npos);
  EXPECT_NE(changed("has_heart", false).find("without a heart"), std::string::npos);
  EXPECT_NE(changed("seed", 10001).find("differ from the heart of /seed"), std::string::npos);
  EXPECT_NE(changed("attempt", 40).find("/attempt"), std::string::npos);
  EXPECT_NE(changed("contraction", nlohmann::json::array()).find("/contraction"),
            std::string::npos);
  EXPECT_NE(changed("structures", nlohmann::json::array()).find("/structures"), std::string::npos);
  nlohmann::json without = truth;
  without.erase("seed");
  EXPECT_NE(refusal(without).find("/seed"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::phantom
