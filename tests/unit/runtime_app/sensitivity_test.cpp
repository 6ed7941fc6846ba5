#include "runtime/app/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "runtime/app/play.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"

namespace beatlas::app {
namespace {

class SensitivityTable : public testing::Test {
 protected:
  static void SetUpTestSuite() { found_ = sensitivity_of({}); }

  static const SensitivityRow& row(const std::string& symbol) {
    const auto at = std::find_if(found_.rows.begin(), found_.rows.end(),
                                 [&](const SensitivityRow& r) { return r.symbol == symbol; });
    if (at == found_.rows.end()) throw_invalid("no row " + symbol);
    return *at;
  }
  static inline Sensitivity found_;
};

double edv(const SensitivityFigures& f) { return f.natural.edv_ml; }
double esv(const SensitivityFigures& f) { return f.natural.esv_ml; }
double stroke(const SensitivityFigures& f) { return f.natural.stroke_ml; }
double output(const SensitivityFigures& f) { return f.natural.output_l_per_min; }
double aortic(const SensitivityFigures& f) { return f.natural.aortic_mean_mmhg; }
double peak(const SensitivityFigures& f) { return f.natural.peak_lv_mmhg; }
double mean(const SensitivityFigures& f) { return f.mean_n; }
double diastole(const SensitivityFigures& f) { return f.diastole_n; }

TEST_F(SensitivityTable, NothingIsNominal) {
  // Every symbol that the paper says acts changes the force, and what belongs to the ventricle the
  // loop as well.
  for (const SensitivityRow& r : found_.rows) {
    const double lower = std::abs(mean(r.at_low) / mean(found_.as_it_is) - 1) +
                         std::abs(diastole(r.at_low) / diastole(found_.as_it_is) - 1);
    EXPECT_GT(lower, 1e-3) << r.symbol;
    const bool vertical =
        r.symbol == "K_v" || r.symbol == "C_v" || r.symbol == "S" || r.symbol == "S_n";
    const double loop = std::abs(stroke(r.at_low) / stroke(found_.as_it_is) - 1);
    if (vertical) {
      EXPECT_EQ(loop, 0) << r.symbol << " is of the place under the finger alone";
    } else {
      EXPECT_GT(loop, 1e-3) << r.symbol;
    }
  }
  EXPECT_EQ(found_.rows.size(), 14U);
}

// Statements of physiology, each with the sign that a textbook gives it.
TEST_F(SensitivityTable, APressureInTheAtriumFillsTheVentricle) {  // 1, Frank-Starling
  EXPECT_GT(edv(row("LAP").at_high), edv(row("LAP").at_low));
  EXPECT_GT(stroke(row("LAP").at_high), stroke(row("LAP").at_low));
}
TEST_F(SensitivityTable, AFullVentricleIsFeltHarderInDiastole) {  // 2
  EXPECT_GT(diastole(row("LAP").at_high), diastole(found_.as_it_is));
  EXPECT_LT(diastole(row("LAP").at_low), diastole(found_.as_it_is));
}
TEST_F(SensitivityTable, AStifferWallFillsLess) {  // 3
  EXPECT_LT(edv(row("K_h2").at_high), edv(found_.as_it_is));
  EXPECT_LT(output(row("K_h2").at_high), output(found_.as_it_is));
}
TEST_F(SensitivityTable, AWallThatLetsGoMoreSlowlyFillsLess) {  // 4
  EXPECT_LT(edv(row("C_h").at_high), edv(found_.as_it_is));
  EXPECT_LT(edv(row("K_h1").at_low), edv(found_.as_it_is));
}
TEST_F(SensitivityTable, StrengthEmptiesTheVentricle) {  // 5
  EXPECT_LT(esv(row("E").at_high), esv(found_.as_it_is));
  EXPECT_GT(stroke(row("E").at_high), stroke(found_.as_it_is));
  EXPECT_GT(peak(row("E").at_high), peak(found_.as_it_is));
}
TEST_F(SensitivityTable, LessContractionPumpsLess) {  // 6
  EXPECT_LT(stroke(row("alpha").at_low), stroke(found_.as_it_is));
  EXPECT_LT(peak(row("alpha").at_low), peak(found_.as_it_is));
}
TEST_F(SensitivityTable, AfterloadLeavesMoreBehind) {  // 7
  EXPECT_GT(esv(row("MAP").at_high), esv(found_.as_it_is));
  EXPECT_LT(stroke(row("MAP").at_high), stroke(found_.as_it_is));
  EXPECT_NEAR(aortic(row("MAP").at_low), row("MAP").low, 0.2);
}
TEST_F(SensitivityTable, PressureBehindTheResistanceIsAfterload) {  // 8
  EXPECT_GT(aortic(row("RAP").at_high), aortic(found_.as_it_is));
  EXPECT_LT(stroke(row("RAP").at_high), stroke(found_.as_it_is));
}
TEST_F(SensitivityTable, AFastHeartHasNoTimeToFill) {  // 9
  EXPECT_LT(edv(row("HR").at_high), edv(found_.as_it_is));
  EXPECT_GT(stroke(row("HR").at_low), stroke(found_.as_it_is));
}
TEST_F(SensitivityTable, ALargerBodyHasALargerOutputAtThePressureOfASmallOne) {  // 10
  EXPECT_GT(output(row("W").at_high), 1.5 * output(found_.as_it_is));
  EXPECT_NEAR(aortic(row("W").at_high), aortic(found_.as_it_is), 0.1 * aortic(found_.as_it_is));
}
TEST_F(SensitivityTable, AStifferMuscleIsFeltHarder) {  // 11
  for (const char* symbol : {"K_v", "S", "S_n"}) {
    EXPECT_GT(mean(row(symbol).at_high), mean(found_.as_it_is)) << symbol;
    EXPECT_LT(mean(row(symbol).at_low), mean(found_.as_it_is)) << symbol;
  }
}
TEST_F(SensitivityTable, ADentThatComesBackSlowlyIsFeltHarderWhereTheWallReturns) {  // 12
  EXPECT_GT(diastole(row("C_v").at_high), diastole(found_.as_it_is));
  EXPECT_LT(diastole(row("C_v").at_low), diastole(found_.as_it_is));
}

TEST_F(SensitivityTable, IsWrittenByACommand) {
  const char* words[] = {"beatlas-play", "sensitivity", "--preset", "low_pressure", "--json"};
  std::istringstream in;
  std::ostringstream out;
  std::ostringstream err;
  ASSERT_EQ(play(5, words, in, out, err), 0) << err.str();
  const auto json = parse_json(out.str());
  EXPECT_EQ(json["rows"].size(), 14U);
  EXPECT_EQ(json["rows"][9]["symbol"], "LAP");
  EXPECT_EQ(json["rows"][9]["value"], 3);
  const std::string table = sensitivity_markdown(found_);
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 2 + 2 + 14);
  EXPECT_NE(table.find("| K_h2 | 710 | 355, "), std::string::npos) << table;
}

TEST(Sensitivity, OfAConstantThatIsZeroIsNone) {
  palpation::PalpationParameters parameters;
  parameters.circulation.right_atrial_mmhg = 0;
  const Sensitivity found = sensitivity_of(parameters);
  const auto row = std::find_if(found.rows.begin(), found.rows.end(),
                                [](const SensitivityRow& r) { return r.symbol == "RAP"; });
  ASSERT_NE(row, found.rows.end());
  EXPECT_EQ(row->low, 0);
  EXPECT_EQ(row->high, 0);
  EXPECT_EQ(mean(row->at_high), mean(found.as_it_is));
}

}  // namespace
}  // namespace beatlas::app
