/// Places that networks see otherwise from phase to phase, on made priors of one place.
#include "pipeline/prior/courses.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/prior/stored.h"
#include "runtime/atlas/structures.h"

namespace beatlas::prior {
namespace {

/// The place under test is the first voxel; the others hold as much LV blood as each phase says.
constexpr int kVoxels = 12;

struct Made {
  PriorCycle prior;

  explicit Made(const std::vector<int>& lv_voxels) {
    prior.grid.size = {kVoxels, 1, 1};
    prior.labels = {kLabelBackground,  kLabelRvBlood, kLabelLvMyocardium, kLabelLvBlood,
                    kLabelRestOfHeart, kLabelLaBlood, kLabelRaBlood,      kLabelAorta};
    for (const int voxels : lv_voxels) {
      prior.phases.emplace_back(prior.labels.size() * kVoxels, std::int8_t{-128});
      for (int v = 1; v < kVoxels; ++v) {
        set(prior.phases.size() - 1, v <= voxels ? kLabelLvBlood : kLabelBackground, 1, v);
      }
    }
  }

  void set(std::size_t phase, std::size_t output, double probability, int voxel = 0) {
    prior.phases[phase][output * kVoxels + static_cast<std::size_t>(voxel)] =
        stored_log(static_cast<float>(probability));
  }

  [[nodiscard]] double at(std::size_t phase, std::size_t output) const {
    return std::exp(prior.phases[phase][output * kVoxels] /
                    static_cast<double>(PriorCycle::kUnits));
  }
};

TEST(Courses, APlaceDoesNotLeaveAndEnterTheVentriclesInTurn) {
  Made made({11, 10, 8, 6, 4, 5, 7, 9});
  for (std::size_t p = 0; p < 8; ++p) {
    const bool odd = p % 2 == 1;
    made.set(p, kLabelLvBlood, odd ? 0.55 : 0.1);
    made.set(p, kLabelLaBlood, odd ? 0.4 : 0.85);
    made.set(p, kLabelBackground, 0.05);
  }
  hold_courses(made.prior);
  for (std::size_t p = 0; p < 8; ++p) {
    EXPECT_GT(made.at(p, kLabelLaBlood), 0.7) << p;  // .4 in every other one before
    EXPECT_EQ(made.prior.likeliest(p, 0), kLabelLaBlood) << p;
  }
}

TEST(Courses, TheBaseLeavesAPlaceAsTheVentricleEmptiesAndComesBack) {
  Made made({11, 10, 8, 6, 4, 5, 7, 9});
  for (std::size_t p = 0; p < 8; ++p) {
    const bool low = p >= 3 && p <= 5;
    made.set(p, kLabelLvBlood, low ? 0.1 : 0.85);
    made.set(p, kLabelLaBlood, low ? 0.85 : 0.1);
    made.set(p, kLabelBackground, 0.05);
  }
  made.set(4, kLabelLvBlood, 0.6);  // one phase at which it hesitates
  made.set(4, kLabelLaBlood, 0.35);
  hold_courses(made.prior);
  for (std::size_t p = 0; p < 8; ++p) {
    EXPECT_EQ(made.prior.likeliest(p, 0), p >= 3 && p <= 5 ? kLabelLaBlood : kLabelLvBlood) << p;
  }
}

TEST(Courses, NoPlaceIsOfTheVentriclesAtEndSystoleAlone) {
  Made made({11, 8, 4, 8});
  for (std::size_t p = 0; p < 4; ++p) {
    made.set(p, kLabelLvBlood, p == 2 ? 0.7 : 0.05);
    made.set(p, kLabelLaBlood, p == 2 ? 0.25 : 0.9);
    made.set(p, kLabelBackground, 0.05);
  }
  hold_courses(made.prior);
  for (std::size_t p = 0; p < 4; ++p) EXPECT_EQ(made.prior.likeliest(p, 0), kLabelLaBlood) << p;
}

TEST(Courses, SharesAreThoseOfTheCoursesByTheirWeight) {
  Made made({11, 4});
  made.set(0, kLabelLvBlood, 0.8);
  made.set(0, kLabelLaBlood, 0.2);
  made.set(1, kLabelLvBlood, 0.4);
  made.set(1, kLabelLaBlood, 0.6);
  hold_courses(made.prior);
  // Within throughout, beyond throughout, beyond in the phase that holds less: a third each.
  // What goes in and what comes out is rounded by 3 % each.
  const double within = 0.8 * 0.4;
  const double beyond = 0.2 * 0.6;
  const double leaves = 0.8 * 0.6;
  const double all = within + beyond + leaves;
  EXPECT_NEAR(made.at(0, kLabelLvBlood), (within + leaves) / all, 0.06);
  EXPECT_NEAR(made.at(1, kLabelLvBlood), within / all, 0.06);
  EXPECT_NEAR(made.at(1, kLabelLaBlood), (beyond + leaves) / all, 0.06);
}

TEST(Courses, BloodOfTheLeftAndTheRightHeartDoNotChangePlaces) {
  Made made({11, 8, 4, 8});
  for (std::size_t p = 0; p < 4; ++p) {
    made.set(p, kLabelRvBlood, p == 1 ? 0.5 : 0.2);
    made.set(p, kLabelAorta, p == 1 ? 0.2 : 0.6);
    made.set(p, kLabelRestOfHeart, p == 1 ? 0.3 : 0.2);
  }
  hold_courses(made.prior);
  for (std::size_t p = 0; p < 4; ++p) {
    EXPECT_NE(made.prior.likeliest(p, 0), kLabelRvBlood) << p;
    EXPECT_LT(made.at(p, kLabelRvBlood), 0.05) << p;
  }
}

TEST(Courses, WhatIsSureOrAloneStays) {
  Made made({11, 4, 8});
  for (std::size_t p = 0; p < 3; ++p) {
    made.set(p, kLabelBackground, 0.3);
    made.set(p, kLabelLvMyocardium, 0.7);
  }
  const PriorCycle before = made.prior;
  hold_courses(made.prior);
  EXPECT_EQ(made.prior.phases, before.phases);
  Made single({11});
  single.set(0, kLabelLvBlood, 0.5);
  single.set(0, kLabelLaBlood, 0.5);
  const PriorCycle one = single.prior;
  hold_courses(single.prior);
  EXPECT_EQ(single.prior.phases, one.phases);
}

TEST(Courses, ABeatOfManyPhasesStaysFinite) {
  Made made(std::vector<int>(400, 6));
  for (std::size_t p = 0; p < 400; ++p) {
    made.set(p, kLabelLvBlood, 0.99);
    made.set(p, kLabelRaBlood, 0.01);
  }
  hold_courses(made.prior);
  for (std::size_t p = 0; p < 400; ++p) EXPECT_EQ(made.prior.likeliest(p, 0), kLabelLvBlood);
}

}  // namespace
}  // namespace beatlas::prior
