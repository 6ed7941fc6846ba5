#include "pipeline/report/scatter.h"

#include <cmath>
#include <limits>
#include <regex>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::report {
namespace {

ScatterPlot plot_of(const std::vector<ScatterPoint>& points) {
  return {"error & speed <small>",
          "x",
          "y",
          {{"one", points, true}, {"two", {{5, 5, "", false, false}}}},
          "front"};
}

int count(const std::string& text, const std::string& what) {
  int found = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) {
    ++found;
  }
  return found;
}

/// Whether every element that is opened is closed in its turn, and text holds no bare < or &.
bool is_well_formed(const std::string& svg) {
  std::vector<std::string> open;
  for (std::size_t at = 0; at < svg.size();) {
    if (svg[at] == '&') {
      const std::string entity = svg.substr(at, svg.find(';', at) - at);
      if (entity != "&amp" && entity != "&lt" && entity != "&gt") return false;
    }
    if (svg[at] != '<') {
      ++at;
      continue;
    }
    const std::size_t end = svg.find('>', at);
    if (end == std::string::npos) return false;
    const std::string tag = svg.substr(at + 1, end - at - 1);
    if (count(tag, "\"") % 2 != 0 || tag.find('<') != std::string::npos) return false;
    if (tag[0] == '/') {
      if (open.empty() || open.back() != tag.substr(1)) return false;
      open.pop_back();
    } else if (tag.back() != '/') {
      open.push_back(tag.substr(0, tag.find(' ')));
    }
    at = end + 1;
  }
  return open.empty();
}

/// Centre x, y of every circle that is a point of the first series.
std::vector<std::pair<double, double>> circles(const std::string& svg) {
  std::vector<std::pair<double, double>> out;
  const std::regex circle("<circle cx=\"([0-9.]+)\" cy=\"([0-9.]+)\" r=\"4.5\"");
  for (std::sregex_iterator at(svg.begin(), svg.end(), circle); at != std::sregex_iterator();
       ++at) {
    out.emplace_back(std::stod((*at)[1]), std::stod((*at)[2]));
  }
  return out;
}

TEST(Scatter, IsWellFormedWhateverItsWordsAre) {
  const std::string svg =
      scatter_svg(plot_of({{1, 2, "a<b>&c", true, true}, {30, 0.02, "d", false, true}}));
  EXPECT_TRUE(is_well_formed(svg)) << svg;
  EXPECT_EQ(svg.rfind("<svg ", 0), 0U);
  EXPECT_EQ(count(svg, "a&lt;b&gt;&amp;c"), 1);
  EXPECT_NE(svg.find("fill=\"white\""), std::string::npos);  // also in a reader with dark pages
}

TEST(Scatter, AxesAreLogarithmic) {
  const auto at = circles(scatter_svg(plot_of({{1, 1, ""}, {10, 0.1, ""}, {100, 0.01, ""}})));
  ASSERT_GE(at.size(), 3U);
  // Equal ratios are equal ways; coordinates are written to a tenth.
  EXPECT_NEAR(at[1].first - at[0].first, at[2].first - at[1].first, 0.11);
  EXPECT_NEAR(at[1].second - at[0].second, at[2].second - at[1].second, 0.11);
  EXPECT_GT(at[1].first, at[0].first);
  EXPECT_GT(at[1].second, at[0].second);  // smaller is lower
}

TEST(Scatter, LeavesALabelOutRatherThanWriteItOverAnother) {
  std::vector<ScatterPoint> crowd;
  for (int n = 0; n < 60; ++n) {
    crowd.push_back({10 + 0.01 * n, 1, "label of this point", false, false});
  }
  crowd.push_back({0.1, 100, "alone", false, false});
  crowd.push_back({10.3, 1, "default", true, false});
  const std::string svg = scatter_svg(plot_of(crowd));
  EXPECT_EQ(count(svg, ">alone<"), 1);
  EXPECT_GE(count(svg, ">default<"), 2);  // the point's and the legend's
  EXPECT_LT(count(svg, "label of this point"), 12);
}

TEST(Scatter, DrawsWhatHasALogarithmAndRefusesToDrawNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto at =
      circles(scatter_svg(plot_of({{0, 1, "zero"}, {-1, 1, ""}, {nan, 1, ""}, {3, 3, ""}})));
  EXPECT_EQ(at.size(), 2U);  // the one point and the legend's
  EXPECT_THROW((void)scatter_svg({"t", "x", "y", {{"one", {{0, 1, ""}}}}, ""}), Error);
  ScatterPlot many{"t", "x", "y", {}, ""};
  for (int n = 0; n < 9; ++n) many.series.push_back({"s", {{1, 1, ""}}});
  EXPECT_THROW((void)scatter_svg(many), Error);
}

}  // namespace
}  // namespace beatlas::report
