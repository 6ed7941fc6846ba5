#include "pipeline/segment/open_base.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "runtime/atlas/structures.h"

namespace beatlas::segment {
namespace {

// A cup of inner radius 15 mm and wall 8 mm whose mouth at height 20 mm is covered by a film, in a
// stack that is cut at 40 degrees to its axis.
struct Cup {
  Grid grid{{60, 60, 40}};
  Chambers chambers;
  ImageCycle<std::uint8_t> labels;

  Cup(double film_mm, bool atria) {
    grid.mm_from_index = Eigen::Translation3d(-60, -60, -60) * Eigen::Scaling(2.0, 2.0, 3.0);
    LongAxis axis;
    axis.towards_base = Vec3(std::sin(0.7), 0, std::cos(0.7));
    axis.apex_mm = {-30};
    axis.lv_base_mm = {20};
    axis.atria = atria;
    chambers.height_mm = axis.heights_mm(grid);
    chambers.axis = axis;
    labels.grid = grid;
    labels.phases.emplace_back(grid.count(), std::uint8_t{kLabelBackground});
    visit([&](double height, double radius, std::uint8_t& label) {
      if (radius < 23 && height < 20) label = kLabelLvMyocardium;
      if (radius < 15 && height < 20 - film_mm && height > -22) label = kLabelLvBlood;
    });
  }

  template <class Do>
  void visit(Do act) {
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const Vec3 at = grid.mm(i, j, k);
          const double height = chambers.axis->height_mm(at);
          act(height, (at - height * chambers.axis->towards_base).norm(),
              labels.phases[0][grid.offset(i, j, k)]);
        }
      }
    }
  }
};

TEST(OpenBase, AFilmOverTheMouthIsNoMuscle) {
  Cup cup(2.5, false);
  cut_at_base(cup.chambers, cup.labels);
  int film = 0;
  cup.visit([&](double height, double radius, std::uint8_t label) {
    if (radius < 12 && height > 17.5 && height < 20) {
      EXPECT_EQ(label, kLabelRestOfHeart) << height << ' ' << radius;
      ++film;
    }
    if (height > -30 && height < 20 && radius > 18 && radius < 23) {
      EXPECT_EQ(label, kLabelLvMyocardium) << height << ' ' << radius;
    }
    if (height < 17.5 && height > -22 && radius < 15) {
      EXPECT_EQ(label, kLabelLvBlood);
    }
    if (height < -22 && height > -40 && radius < 23) {
      EXPECT_EQ(label, kLabelLvMyocardium);
    }
  });
  EXPECT_GT(film, 50);
}

TEST(OpenBase, AThickRoofStays) {
  Cup cup(12, false);
  const auto before = cup.labels.phases[0];
  cut_at_base(cup.chambers, cup.labels);
  EXPECT_EQ(cup.labels.phases[0], before);
}

TEST(OpenBase, WithAtriaNothingOfTheVentricleLiesBeyondThePlane) {
  Cup cup(2.5, true);
  cup.chambers.axis->lv_base_mm = {10};
  cut_at_base(cup.chambers, cup.labels);
  cup.visit([&](double height, double radius, std::uint8_t label) {
    if (radius >= 23 || height >= 20) return;
    EXPECT_EQ(label == kLabelRestOfHeart, static_cast<float>(height) > 10.0F) << height;
  });
}

}  // namespace
}  // namespace beatlas::segment
