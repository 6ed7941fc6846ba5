#include "pipeline/assess/promises.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/assess/validate.h"
#include "pipeline/phantom/spec.h"

namespace beatlas::assess {
namespace {

/// Cells of the rows of the table in docs/promises.md, without its head.
std::vector<std::vector<std::string>> table() {
  std::ifstream file(std::string(BEATLAS_SOURCE_DIR) + "/docs/promises.md");
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("| ") || line.starts_with("| `--limits`")) continue;
    std::vector<std::string> cells;
    std::istringstream text(line.substr(1));
    for (std::string cell; std::getline(text, cell, '|');) {
      const std::size_t first = cell.find_first_not_of(' ');
      cells.push_back(first == std::string::npos
                          ? ""
                          : cell.substr(first, cell.find_last_not_of(' ') - first + 1));
    }
    rows.push_back(cells);
  }
  return rows;
}

std::optional<double> number(const std::string& cell) {
  return cell.empty() ? std::nullopt : std::optional<double>(std::stod(cell));
}

const Promised& of(const PromiseSet& set, Structure structure) {
  for (const Promised& promised : set.structures) {
    if (promised.structure == structure) return promised;
  }
  throw std::logic_error("no promise");
}

const PromiseSet& named(const char* name) {
  const PromiseSet* set = promise_set(name);
  if (set == nullptr) throw std::logic_error(name);
  return *set;
}

TEST(Promises, AreThoseOfTheirPage) {
  const std::vector<std::vector<std::string>> rows = table();
  ASSERT_EQ(rows.size(), 4 * kPromiseSets.size());
  std::size_t at = 0;
  for (const PromiseSet& set : kPromiseSets) {
    std::size_t row_of_set = 0;
    for (const Promised& promised : set.structures) {
      const std::vector<std::string>& row = rows[at++];
      ASSERT_EQ(row.size(), 7U) << row[0];
      EXPECT_EQ(row[0], set.name);
      EXPECT_EQ(row[1], structure_name(promised.structure)) << set.name;
      EXPECT_EQ(number(row[2]), promised.least_dice) << set.name << " " << row[1];
      EXPECT_EQ(number(row[3]), promised.mean_mm) << set.name << " " << row[1];
      EXPECT_EQ(number(row[4]), promised.bias_mm) << set.name << " " << row[1];
      EXPECT_EQ(number(row[5]), promised.p95_mm) << set.name << " " << row[1];
      EXPECT_EQ(number(row[6]), row_of_set++ == 0 ? set.force_mean_n : std::nullopt) << set.name;
    }
  }
}

TEST(Promises, OfImagesAreNamedAsThePresetsOfPhantoms) {
  for (const char* name : {"adult", "small", "clinical"}) {
    EXPECT_EQ(named(name).name, phantom::preset(name).name);
  }
  for (const char* name : {"infarct", "hard"}) {
    EXPECT_EQ(promise_set(phantom::preset(name).name), nullptr) << "nothing is promised of it";
  }
  EXPECT_EQ(promise_set("none"), nullptr);
}

/// The heart in two phases as good as is promised of the phantom adult.
ValidationReport as_promised() {
  const Promised& heart = of(named("adult"), Structure::Heart);
  PhaseErrors phase;
  phase.dice = *heart.least_dice;
  phase.mean_mm = *heart.mean_mm;
  phase.bias_mm = -*heart.bias_mm;
  phase.p95_mm = *heart.p95_mm;
  phase.points = 100;
  ValidationReport report;
  report.structures.resize(1);
  report.structures[0].structure = Structure::Heart;
  report.structures[0].phases = {phase, phase};
  ForceErrors force;
  force.mean_n = *named("adult").force_mean_n;
  report.force = FeltErrors{Structure::Heart, 150, force};
  return report;
}

std::vector<std::string> failures(ValidationReport report, const char* set = "adult") {
  hold_to(named(set), report);
  EXPECT_EQ(report.passed, report.failures.empty());
  EXPECT_EQ(report.held_to, set);
  return report.failures;
}

TEST(Promises, AreKeptWithinTheMargin) {
  EXPECT_TRUE(failures(as_promised()).empty());
  for (const double share : {1.29, 1.31}) {
    const auto expect = [&](const ValidationReport& report, const char* figure) {
      const std::vector<std::string> found = failures(report);
      ASSERT_EQ(found.size(), share > kPromiseMargin ? 1U : 0U) << figure;
      if (found.empty()) return;
      EXPECT_NE(found[0].find(figure), std::string::npos) << found[0];
      EXPECT_NE(found[0].find("heart"), std::string::npos) << found[0];
      EXPECT_NE(found[0].find("--limits adult"), std::string::npos) << found[0];
    };
    ValidationReport report = as_promised();
    for (PhaseErrors& phase : report.structures[0].phases) phase.mean_mm *= share;
    expect(report, "mean_mm");
    report = as_promised();
    for (PhaseErrors& phase : report.structures[0].phases) phase.bias_mm *= share;
    expect(report, "bias_mm");
    report = as_promised();
    report.structures[0].phases[1].p95_mm *= share;
    expect(report, "p95_mm");
    report = as_promised();
    double& dice = report.structures[0].phases[1].dice;
    dice = 1 - share * (1 - dice);
    expect(report, "Dice");
    report = as_promised();
    report.force->errors.mean_n *= share;
    expect(report, "mean_n");
  }
}

TEST(Promises, OfMeansAreOfAllPhasesTogether) {
  ValidationReport report = as_promised();
  report.structures[0].phases[0].mean_mm *= 1.6;
  report.structures[0].phases[1].mean_mm *= 0.9;
  EXPECT_TRUE(failures(report).empty());
}

TEST(Promises, WhatIsNoNumberIsBeyondThem) {
  ValidationReport report = as_promised();
  report.structures[0].phases[0].mean_mm = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(failures(report).size(), 1U);
}

TEST(Promises, OfWhatThePackageLacksAndOfOtherForcesDoNotCount) {
  ValidationReport report = as_promised();
  report.force.reset();
  EXPECT_TRUE(failures(report).empty());
  report = as_promised();
  report.force->structure = Structure::LvBlood;
  report.force->errors.mean_n = 5;
  EXPECT_TRUE(failures(report).empty());
  report = as_promised();
  report.structures[0].structure = Structure::Aorta;
  report.structures[0].phases[0].mean_mm = 50;
  EXPECT_TRUE(failures(report).empty());
}

TEST(Promises, OfLabelsAreStricterThanThoseOfImagesAndOfCoverageMore) {
  for (const Structure structure : kVentricular) {
    EXPECT_GT(*of(named("adult"), structure).mean_mm, *of(named("labels"), structure).mean_mm);
    EXPECT_GT(*of(named("labels"), structure).mean_mm, *of(named("coverage"), structure).mean_mm);
  }
}

}  // namespace
}  // namespace beatlas::assess
