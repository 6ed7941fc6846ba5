#include <set>

#include <gtest/gtest.h>

#include "pipeline/assess/validate.h"

namespace beatlas::assess {
namespace {

/// A report of one structure in two phases without any error.
ValidationReport perfect() {
  ValidationReport report;
  StructureErrors muscle;
  muscle.structure = Structure::LvMyocardium;
  PhaseErrors phase;
  phase.dice = 1.0;
  phase.points = 100;
  muscle.phases = {phase, phase};
  ThicknessErrors wall;
  wall.points = 10;
  muscle.wall_thickness = {wall, wall};
  muscle.motion = MotionErrors{};
  muscle.map = MapErrors{};
  muscle.map->points = muscle.map->named = 10;
  report.structures = {muscle};
  report.force = FeltErrors{Structure::Heart, 150, {}};
  return report;
}

bool passes(const LimitSet& limits, ValidationReport report) {
  judge(limits, report);
  EXPECT_EQ(report.passed, report.failures.empty());
  return report.passed;
}

template <class Errors, std::size_t N, class Place>
void each_is_bounded(const std::array<Figure<Errors>, N>& table, const Place& place,
                     std::set<std::string>& seen) {
  for (const Figure<Errors>& figure : table) {
    if (figure.limit == nullptr) continue;
    const LimitName& name = name_of(figure.limit);
    EXPECT_TRUE(seen.insert(name.name).second) << name.name << " bounds two figures";
    const double limit = 0.5 * std::min(name.most, 1.0);
    for (const double sign : {1.0, -1.0}) {
      if (sign < 0.0 && name.is_least()) continue;
      LimitSet limits;
      limits.all.*figure.limit = limit;
      ValidationReport report = perfect();
      const double inside = sign * (name.is_least() ? 1.01 : 0.99) * limit;
      const double beyond = sign * (name.is_least() ? 0.99 : 1.01) * limit;
      place(report).*figure.value = inside;
      EXPECT_TRUE(passes(limits, report)) << name.name;
      place(report).*figure.value = beyond;
      judge(limits, report);
      ASSERT_EQ(report.failures.size(), 1U) << name.name;
      EXPECT_NE(report.failures[0].find(figure.name), std::string::npos) << report.failures[0];
      EXPECT_NE(report.failures[0].find(name.name), std::string::npos) << report.failures[0];
    }
  }
}

TEST(Limits, EachBoundsItsOwnFigureAndIsNamedWhenItBreaks) {
  std::set<std::string> seen;
  each_is_bounded(
      kPhaseFigures,
      [](ValidationReport& report) -> PhaseErrors& { return report.structures[0].phases[1]; },
      seen);
  each_is_bounded(
      kThicknessFigures,
      [](ValidationReport& report) -> ThicknessErrors& {
        return report.structures[0].wall_thickness[1];
      },
      seen);
  each_is_bounded(
      kMotionFigures,
      [](ValidationReport& report) -> MotionErrors& { return *report.structures[0].motion; }, seen);
  each_is_bounded(
      kMapFigures, [](ValidationReport& report) -> MapErrors& { return *report.structures[0].map; },
      seen);
  each_is_bounded(
      kSegmentFigures,
      [](ValidationReport& report) -> MapErrors& { return *report.structures[0].map; }, seen);
  each_is_bounded(
      kForceFigures, [](ValidationReport& report) -> ForceErrors& { return report.force->errors; },
      seen);
  seen.insert("max_ejection_fraction_error");
  EXPECT_EQ(seen.size(), kLimitNames.size()) << "a limit that bounds nothing";
}

TEST(Limits, ABreachNamesStructurePhaseFigureAndLimit) {
  ValidationReport report = perfect();
  report.structures[0].phases[1].rms_mm = 0.75;
  LimitSet limits;
  limits.all.max_rms_mm = 0.5;
  judge(limits, report);
  ASSERT_EQ(report.failures.size(), 1U);
  EXPECT_EQ(report.failures[0],
            "lv_myocardium in phase 1: rms_mm is 0.75, beyond the limit of 0.5 (max_rms_mm)");
}

TEST(Limits, OfOneStructureReplaceThoseOfAll) {
  ValidationReport report = perfect();
  report.structures[0].phases[0].mean_mm = 0.7;
  LimitSet limits;
  limits.all.max_mean_mm = 0.5;
  EXPECT_FALSE(passes(limits, report));
  limits.structures[Structure::LvMyocardium].max_mean_mm = 0.8;
  EXPECT_TRUE(passes(limits, report));
  limits.structures[Structure::LvMyocardium].max_mean_mm = 0.6;
  EXPECT_FALSE(passes(limits, report));
}

TEST(Limits, OfWhatCouldNotBeMeasuredAreNotKept) {
  ValidationReport report = perfect();
  report.force.reset();
  report.structures[0].wall_thickness.clear();
  LimitSet limits;
  EXPECT_TRUE(passes(limits, report));
  limits.all.max_force_mean_n = 1.0;
  EXPECT_FALSE(passes(limits, report));
  limits = {};
  limits.all.max_thickness_mean_mm = 1.0;
  EXPECT_FALSE(passes(limits, report));
  limits = {};
  limits.structures[Structure::RvBlood].max_mean_mm = 1.0;
  EXPECT_FALSE(passes(limits, report));
  limits = {};
  limits.all.max_motion_mean_mm = 1.0;
  EXPECT_TRUE(passes(limits, report));
  report.structures[0].motion.reset();
  EXPECT_FALSE(passes(limits, report));
}

}  // namespace
}  // namespace beatlas::assess
