#include "pipeline/report/curves.h"

#include <cmath>
#include <sstream>

#include <gtest/gtest.h>

#include "pipeline/report/speed_table.h"
#include "runtime/base/error.h"

namespace beatlas::report {
namespace {

/// The points of the first polyline.
std::vector<std::pair<double, double>> points_of(const std::string& svg) {
  const std::size_t first = svg.find("points=\"") + 8;
  std::istringstream words(svg.substr(first, svg.find('"', first) - first));
  std::vector<std::pair<double, double>> points;
  for (std::string word; words >> word;) {
    points.emplace_back(std::stod(word), std::stod(word.substr(word.find(',') + 1)));
  }
  return points;
}

TEST(Curves, AreClosedAndLinearInVolumeAndTime) {
  const std::vector<double> volume_ml{120, 90, 60, 90};
  const auto points = points_of(volume_curves_svg({{Structure::LvBlood, volume_ml}}, 0.8, 0, 2));
  ASSERT_EQ(points.size(), 5U);
  EXPECT_EQ(points.front().second, points.back().second);
  // Coordinates are written to a tenth.
  const double px_per_ml = (points[2].second - points[0].second) / 60;
  EXPECT_GT(px_per_ml, 0);
  EXPECT_NEAR(points[1].second - points[0].second, 30 * px_per_ml, 0.11);
  for (std::size_t p = 1; p < points.size(); ++p) {
    EXPECT_NEAR(points[p].first - points[p - 1].first, points[1].first - points[0].first, 0.21);
  }
}

TEST(Curves, RefuseCurvesOfDifferentPhases) {
  EXPECT_THROW(
      (void)volume_curves_svg({{Structure::LvBlood, {1, 2}}, {Structure::Heart, {1}}}, 0.8, 0, 0),
      Error);
  EXPECT_THROW((void)volume_curves_svg({}, 0.8, 0, 0), Error);
}

TEST(Curves, StayFiniteForAnEmptyStructure) {
  const std::string svg = volume_curves_svg({{Structure::LvBlood, {0, 0}}}, 0.8, 0, 1);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(SpeedTable, SharesAddUpToTheWhole) {
  const std::string table = speed_table({{"field", 3, 5}, {"mesh", 1, 1}}, 812.4);
  EXPECT_NE(table.find("75.0 %"), std::string::npos);
  EXPECT_NE(table.find("25.0 %"), std::string::npos);
  EXPECT_NE(table.find("4.00 s"), std::string::npos);
  EXPECT_NE(table.find("812 MB"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::report
