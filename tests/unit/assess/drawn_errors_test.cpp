/// Surfaces against the body of a drawn exam.

#include "pipeline/assess/drawn_errors.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/assess/statistics.h"
#include "pipeline/assess/validate.h"
#include "pipeline/phantom/drawn_exam.h"
#include "runtime/base/error.h"
#include "tests/unit/assess/made_candidate.h"

namespace beatlas::assess {
namespace {

using phantom::DrawnTruth;

class DrawnErrorsOfADraw : public ::testing::Test {
 protected:
  static constexpr double kSpacingMm = 2;

  static const phantom::DrawnExam& exam() {
    static const phantom::DrawnExam kExam = [] {
      StageContext context;
      return phantom::drawn_exam(10000, {.most_voxels = 1100000}, context);
    }();
    return kExam;
  }

  DrawnErrorsOfADraw() : truth_(exam().truth), frame_(truth_.frame(0, kSpacingMm)) {}

  DrawnTruth truth_;
  DrawnTruth::Frame frame_;
};

TEST_F(DrawnErrorsOfADraw, DistancesAreThoseByWhichAPointWasMoved) {
  const TrueSurface surface =
      true_surface(frame_, Structure::LvBlood, kSpacingMm, exam().labels.grid);
  for (const double moved_mm : {-2.0, 0.0, 3.0}) {
    std::vector<Weighted> off;
    for (const auto& point : frame_.surface(Structure::LvBlood)) {
      const std::optional<double> distance =
          surface.distance_mm(point.lps + moved_mm * point.normal);
      if (distance) off.push_back({*distance - moved_mm});
    }
    const DistanceStatistics statistics = pooled_statistics(off, {});
    EXPECT_GT(off.size(), 1000U);
    // Beside edges another face is nearer than the one that a point was moved from.
    EXPECT_LT(statistics.mean, 0.15) << moved_mm;
    EXPECT_LT(std::abs(statistics.bias), 0.15) << moved_mm;
  }
}

TEST_F(DrawnErrorsOfADraw, WhatNoImageShowsIsNotAsked) {
  Grid low = exam().labels.grid;
  low.size[2] = std::max(1, low.size[2] / 2);
  const TrueSurface whole =
      true_surface(frame_, Structure::LvBlood, kSpacingMm, exam().labels.grid);
  const TrueSurface half = true_surface(frame_, Structure::LvBlood, kSpacingMm, low);
  EXPECT_LT(half.points.size(), whole.points.size());
  EXPECT_FALSE(half.distance_mm(exam().labels.grid.mm(0, 0, low.size[2] + 1)).has_value());
  const TrueSurface heart = true_surface(frame_, Structure::Heart, kSpacingMm, exam().labels.grid);
  for (const TrueSurface::Point& point : heart.points) {
    ASSERT_TRUE(frame_.below_base(point.lps)) << "the outside of atria is no outside of the heart";
  }
}

Vec3 middle_of(const std::vector<DrawnTruth::Frame::Point>& points) {
  Vec3 out = Vec3::Zero();
  for (const auto& point : points) out += point.lps / static_cast<double>(points.size());
  return out;
}

/// Across the surface, of a way away from its middle.
double share_across(const DrawnTruth::Frame& frame) {
  const auto points = frame.surface(Structure::LvBlood);
  const Vec3 middle = middle_of(points);
  double across = 0;
  double area = 0;
  for (const auto& point : points) {
    across += point.area_mm2 * (point.lps - middle).normalized().dot(point.normal);
    area += point.area_mm2;
  }
  return across / area;
}

/// The LV of the truth, larger by `grown_mm` as seen from its middle.
Candidate grown_lv(const DrawnTruth& truth, const Grid& seen, double grown_mm) {
  Candidate out;
  out.manifest.rr_interval_s = truth.rr_interval_s();
  out.manifest.frame_times_s.assign(static_cast<std::size_t>(truth.phases()), 0.0);
  out.manifest.source_size = seen.size;
  out.manifest.source_lps_from_index = seen.mm_from_index;
  out.manifest.workspace_from_lps.translation() = Vec3(5, -7, 30);
  out.manifest.provenance["phantom_identity"] = truth.identity();
  std::vector<DrawnTruth::Frame> frames;
  std::vector<Vec3> middles;
  for (int p = 0; p < truth.phases(); ++p) {
    frames.push_back(truth.frame(p, 4));
    middles.push_back(middle_of(frames.back().surface(Structure::LvBlood)));
  }
  out.surfaces = {test::seen_from_within(
      Structure::LvBlood, middles, out.manifest.workspace_from_lps,
      [&](std::size_t p, const Vec3& lps) {
        const double way = (lps - middles[p]).norm();
        const double shrunk = std::max(0.0, way - grown_mm);
        return frames[p].contains(Structure::LvBlood,
                                  middles[p] + shrunk / std::max(way, 1e-9) * (lps - middles[p]));
      })};
  return out;
}

/// In the workspace.
Vec3 axis_of_slices(const atlas::Manifest& manifest) {
  return (manifest.workspace_from_lps * manifest.source_lps_from_index)
      .inverse()
      .linear()
      .row(2)
      .transpose()
      .normalized();
}

TEST_F(DrawnErrorsOfADraw, APackageIsComparedSurfaceBySurface) {
  StageContext context;
  for (const double grown_mm : {0.0, 2.0}) {
    const Candidate candidate = grown_lv(truth_, exam().labels.grid, grown_mm);
    ValidateOptions options;
    options.limits.all.max_mean_mm = 1;
    const ValidationReport report = validate(candidate, truth_, options, context);
    EXPECT_TRUE(report.structures.empty());
    ASSERT_EQ(report.drawn.size(), 1U);
    ASSERT_EQ(report.drawn[0].phases.size(), static_cast<std::size_t>(truth_.phases()));
    for (int p = 0; p < truth_.phases(); ++p) {
      const DrawnErrors& phase = report.drawn[0].phases[static_cast<std::size_t>(p)];
      // Not all of a ventricle is seen from its middle.
      EXPECT_NEAR(phase.bias_mm, share_across(truth_.frame(p, 4)) * grown_mm, 0.3);
      EXPECT_LT(phase.mean_mm, grown_mm + 0.3);
      EXPECT_GT(phase.points, 1000);
    }
    EXPECT_EQ(report.passed, grown_mm == 0);
    if (grown_mm > 0) {
      EXPECT_NE(report.failures.at(0).find("lv_blood in phase 0: mean_mm"), std::string::npos);
    }
  }
}

TEST_F(DrawnErrorsOfADraw, ABandHoldsWhatLiesNearer) {
  StageContext context;
  Candidate candidate = grown_lv(truth_, exam().labels.grid, 2);
  candidate.manifest.end_systole = truth_.phases() - 1;
  EXPECT_FALSE(validate(candidate, truth_, {}, context).drawn.at(0).band_percent.has_value());
  const auto phases = static_cast<std::size_t>(truth_.phases());
  const auto slices = static_cast<std::size_t>(candidate.manifest.source_size[2]);
  double before = 0;
  for (const double known_mm : {0.0, 1.0, 4.0, 60.0}) {
    const std::vector table(phases, std::vector<double>(slices, known_mm));
    candidate.manifest.structures = {
        {"lv_blood", std::vector<double>(phases, 100), atlas::SurfaceBand{table, table}}};
    const ValidationReport report = validate(candidate, truth_, {}, context);
    const DrawnStructure& lv = report.drawn.at(0);
    ASSERT_EQ(lv.vertices.size(), phases > 1 ? 2U : 1U);
    double within = 0;
    double all = 0;
    for (const auto& [phase, vertices] : lv.vertices) {
      for (const VertexError& vertex : vertices) {
        EXPECT_NEAR(vertex.normal.norm(), 1, 1e-6);
        all += vertex.area_mm2;
        const double cosine = std::abs(vertex.normal.dot(axis_of_slices(candidate.manifest)));
        const double most_mm = known_mm * (cosine + std::sqrt(1 - cosine * cosine));
        if (std::abs(vertex.off_mm) <= most_mm) within += vertex.area_mm2;
      }
    }
    EXPECT_NEAR(lv.band_percent.value(), 100 * within / all, 0.01) << known_mm;
    EXPECT_GE(*lv.band_percent, before);
    before = *lv.band_percent;
  }
  EXPECT_DOUBLE_EQ(before, 100);
}

TEST_F(DrawnErrorsOfADraw, APackageOfOtherImagesIsRefused) {
  Candidate candidate = grown_lv(truth_, exam().labels.grid, 0);
  StageContext context;
  const auto refusal = [&]() -> std::string {
    try {
      (void)validate(candidate, truth_, {}, context);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  candidate.manifest.frame_times_s.push_back(1);
  EXPECT_NE(refusal().find("phases"), std::string::npos);
  candidate.manifest.provenance["phantom_identity"] = "0000";
  EXPECT_NE(refusal().find("another draw"), std::string::npos);
  candidate.manifest.provenance.erase("phantom_identity");
  EXPECT_NE(refusal().find("another draw"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::assess
