#include "pipeline/assess/validate.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/assess/statistics.h"
#include "pipeline/assess/zero_level.h"
#include "runtime/base/error.h"
#include "tests/unit/assess/made_candidate.h"

namespace beatlas::assess {
namespace {

using test::encoded;
using test::Made;

class Validate : public ::testing::Test {
 protected:
  Validate() : made_(Made::small()), truth_(made_.truth), manifest_(made_.manifest) {}

  /// The exact LV cavity of the truth, larger by `grown_mm`, moved by `moved_mm`.
  Candidate candidate(double grown_mm, const Vec3& moved_mm = Vec3::Zero()) const {
    const auto field = made_.field(Structure::LvBlood, [&](const Vec3& x, double share) {
      return made_.distance_mm(Structure::LvBlood, x - moved_mm, share) - grown_mm;
    });
    return {manifest_, {field}};
  }

  std::string refusal(const atlas::Manifest& manifest) const {
    StageContext context;
    try {
      (void)validate(Candidate{manifest, {}}, truth_, {}, context);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  Made made_;
  const phantom::Phantom& truth_;
  atlas::Manifest manifest_;
};

TEST_F(Validate, FindsNothingWrongWithTheTruthItself) {
  StageContext context;
  ValidateOptions options;
  options.compare.crease_band_mm = 4.0;  // the spline of 2 mm rounds the rim two voxels wide
  const ValidationReport report = validate(candidate(0.0), truth_, options, context);
  EXPECT_TRUE(report.passed);
  ASSERT_EQ(report.structures.size(), 1u);
  EXPECT_EQ(report.structures[0].phases.size(), 4u);
  for (const PhaseErrors& errors : report.structures[0].phases) {
    // A cubic spline of 2 mm through the exact distance; the curved apex is the hardest.
    EXPECT_LT(errors.mean_mm, 0.01);
    EXPECT_LT(errors.hausdorff_mm, 0.15);
    EXPECT_LT(std::abs(errors.bias_mm), 0.005);
    EXPECT_GT(errors.dice, 0.99);
    EXPECT_NEAR(errors.volume_error_ml, 0.0, 1e-9);
    EXPECT_LT(errors.rms_mm, 0.02);
    EXPECT_LT(errors.normal_mean_deg, 0.5);
    EXPECT_GT(errors.points, 2000);
  }
  EXPECT_NEAR(*report.structures[0].ejection_fraction_error, 0.0, 1e-12);
}

TEST_F(Validate, AGrownSurfaceIsABiasOfItsGrowth) {
  StageContext context;
  for (double grown : {0.5, -0.5}) {
    const ValidationReport report = validate(candidate(grown), truth_, {}, context);
    for (const PhaseErrors& errors : report.structures[0].phases) {
      EXPECT_NEAR(errors.bias_mm, grown, 0.02);  // the spline, as above
      EXPECT_NEAR(errors.mean_mm, 0.5, 0.02);
      EXPECT_NEAR(errors.rms_mm, 0.5, 0.02);
      EXPECT_NEAR(errors.p95_mm, 0.5, 0.05);
      EXPECT_LT(errors.dice, 0.99);
      EXPECT_GT(errors.dice, 0.92);
    }
  }
}

TEST_F(Validate, AMovedSurfaceHasNoBiasAndTheMoveAsItsMaximum) {
  StageContext context;
  const ValidationReport report =
      validate(candidate(0.0, Vec3(0.0, 2.0, 0.0)), truth_, {}, context);
  for (const PhaseErrors& errors : report.structures[0].phases) {
    EXPECT_NEAR(errors.bias_mm, 0.0, 0.1);  // the base and the creases' band are not symmetric
    EXPECT_NEAR(errors.hausdorff_mm, 2.0, 0.15);
    EXPECT_GT(errors.mean_mm, 0.7);
    EXPECT_LT(errors.mean_mm, 1.4);
  }
}

TEST_F(Validate, ASurfaceBeyondTheBandIsMeasuredToo) {
  StageContext context;
  const ValidationReport report =
      validate(candidate(0.0, Vec3(15.0, 0.0, 0.0)), truth_, {}, context);
  for (const PhaseErrors& errors : report.structures[0].phases) {
    // The clamp outside is 6 mm: a distance taken from the field alone would end there.
    EXPECT_GT(errors.hausdorff_mm, 10.0);
    EXPECT_LT(errors.hausdorff_mm, 15.1);
  }
}

TEST_F(Validate, LimitsDecideAndAreNamed) {
  StageContext context;
  ValidateOptions options;
  Limits& limits = options.limits.all;
  limits.max_mean_mm = 0.6;
  const Candidate grown = candidate(0.5);
  EXPECT_TRUE(validate(grown, truth_, options, context).passed);
  limits.max_bias_mm = 0.4;
  limits.min_dice = 0.999;
  const ValidationReport report = validate(grown, truth_, options, context);
  EXPECT_FALSE(report.passed);
  EXPECT_EQ(report.failures.size(), 8u);
  EXPECT_NE(report.failures[0].find("lv_blood in phase 0: dice"), std::string::npos);
  EXPECT_NE(report.failures[0].find("below the limit of 0.999 (min_dice)"), std::string::npos);
  EXPECT_NE(report.failures[1].find("lv_blood in phase 0: bias_mm"), std::string::npos);
}

TEST_F(Validate, VolumesAreThoseOfTheManifest) {
  StageContext context;
  Candidate changed = candidate(0.0);
  changed.manifest.structures[1].volume_ml[2] += 7.0;
  const ValidationReport report = validate(changed, truth_, {}, context);
  const PhaseErrors& phase = report.structures[0].phases[2];
  EXPECT_NEAR(phase.volume_error_ml, 7.0, 1e-9);
  const double true_ml = truth_.volume_ml(Structure::LvBlood, truth_.phase_time_s(2));
  EXPECT_NEAR(phase.volume_error_percent, 700.0 / true_ml, 1e-9);
  EXPECT_NEAR(report.structures[0].phases[1].volume_error_ml, 0.0, 1e-9);
  changed.manifest.structures[1].volume_ml.pop_back();
  EXPECT_THROW((void)validate(changed, truth_, {}, context), Error);
}

TEST_F(Validate, APackageWithoutSurfaceFails) {
  StageContext context;
  const auto field = encoded(
      Structure::LvBlood, [](const Vec3&, double) { return 5.0; }, Vec3(128, 128, 96), 30.0, 3.0,
      4);
  const ValidationReport report = validate(Candidate{manifest_, {field}}, truth_, {}, context);
  EXPECT_FALSE(report.passed);
  EXPECT_EQ(report.failures.size(), 4u);
  EXPECT_NE(report.failures[0].find("no surface"), std::string::npos);
}

TEST_F(Validate, TruthOfAnotherPhantomIsRefused) {
  EXPECT_NE(refusal(manifest_).find("no field"), std::string::npos) << "the phantom's own";
  atlas::Manifest other = manifest_;
  other.source_lps_from_index.translation().x() += 2.0;
  EXPECT_NE(refusal(other).find("image grid"), std::string::npos);
  other = manifest_;
  other.source_size = {256, 256, 64};
  EXPECT_NE(refusal(other).find("image grid"), std::string::npos);
  other = manifest_;
  other.frame_times_s.push_back(0.7);
  EXPECT_NE(refusal(other).find("4 frames"), std::string::npos);
  other = manifest_;
  other.rr_interval_s = 0.8;
  EXPECT_NE(refusal(other).find("R-R"), std::string::npos);
}

TEST_F(Validate, TheIdentityOfTheImagesDecidesWhereItIsThere) {
  atlas::Manifest other = manifest_;
  other.provenance["phantom_identity"] = truth_.identity();
  EXPECT_NE(refusal(other).find("no field"), std::string::npos) << "the phantom's own";
  // The same heart and scanner, other noise: nothing but the identity tells.
  phantom::PhantomSpec noise = phantom::spec_from_json(phantom::spec_to_json(truth_.spec()));
  noise.anatomy.origin_lps_mm.x() += 1e-3;
  other.provenance["phantom_identity"] = phantom::Phantom(noise).identity();
  EXPECT_NE(refusal(other).find("identity"), std::string::npos);
  // What is no identity counts as none.
  other.provenance["phantom_identity"] = "somebody";
  EXPECT_NE(refusal(other).find("no field"), std::string::npos);
}

TEST_F(Validate, WithoutIdentityAGrossMismatchIsAnotherPhantom) {
  atlas::Manifest other = manifest_;
  for (double& ml : other.structures[0].volume_ml) ml *= 2.1;
  EXPECT_NE(refusal(other).find("its heart holds"), std::string::npos) << refusal(other);
  other = manifest_;
  for (atlas::StructureEntry& entry : other.structures) {
    for (double& ml : entry.volume_ml) ml *= 1.8;  // a bad segmentation, to be measured
  }
  EXPECT_NE(refusal(other).find("no field"), std::string::npos) << refusal(other);
  other = manifest_;
  std::vector<double>& lv = other.structures[1].volume_ml;
  std::rotate(lv.begin(), lv.begin() + 2, lv.end());
  EXPECT_NE(refusal(other).find("end systole"), std::string::npos) << refusal(other);
  StageContext context;
  Candidate elsewhere = candidate(0.0);
  elsewhere.manifest.workspace_from_lps.translation().y() += 30.0;
  try {
    (void)validate(elsewhere, truth_, {}, context);
    FAIL() << "a heart 30 mm away was taken";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("mm from the package"), std::string::npos)
        << error.what();
  }
  Candidate named = elsewhere;  // an honest failure of a segmentation is measured, however bad
  named.manifest.provenance["phantom_identity"] = truth_.identity();
  EXPECT_GT(validate(named, truth_, {}, context).structures[0].phases[0].hausdorff_mm, 15.0);
}

TEST_F(Validate, AnotherOrderOfSlicesIsTheSameGrid) {
  atlas::Manifest other = manifest_;
  Affine flip = Affine::Identity();
  flip.linear()(2, 2) = -1.0;
  flip.translation().z() = other.source_size[2] - 1.0;
  other.source_lps_from_index = other.source_lps_from_index * flip;
  EXPECT_EQ(refusal(other).find("another phantom"), std::string::npos);
}

TEST_F(Validate, JsonHasTheKeysOthersRelyOn) {
  StageContext context;
  const nlohmann::json json = report_to_json(validate(candidate(0.0), truth_, {}, context));
  ASSERT_EQ(json["structures"].size(), 1u);
  EXPECT_EQ(json["structures"][0]["name"], "lv_blood");
  EXPECT_TRUE(json["passed"].is_boolean());
  for (const char* key : {"dice", "volume_error_ml", "mean_mm", "p95_mm", "hausdorff_mm", "bias_mm",
                          "rms_mm", "volume_error_percent", "normal_mean_deg", "normal_p95_deg",
                          "velocity_mean_mm_s", "velocity_p95_mm_s"}) {
    EXPECT_TRUE(json["structures"][0]["phases"][3][key].is_number()) << key;
  }
  EXPECT_FALSE(json.contains("force")) << "there is no field of the heart";
}

/// The truth's left atrium as a surface of triangles, larger by `grown_mm` all about; it is seen as
/// a whole from its middle.
std::shared_ptr<const atlas::SurfacePayload> left_atrium(const test::Made& made, double grown_mm) {
  const int phases = made.truth.spec().phases;
  std::vector<std::shared_ptr<const phantom::Frame>> frames;
  std::vector<Vec3> middles;
  for (int p = 0; p < phases; ++p) {
    const double share = p / static_cast<double>(phases);
    frames.push_back(made.truth.frame(share * made.truth.spec().rr_interval_s));
    Vec3 middle = Vec3::Zero();
    const std::vector<Vec3> samples = frames.back()->sample_surface(Structure::LaBlood, 2);
    for (const Vec3& lps : samples) middle += lps / static_cast<double>(samples.size());
    middles.push_back(middle);
  }
  return test::seen_from_within(Structure::LaBlood, middles, made.workspace_from_lps,
                                [&](std::size_t p, const Vec3& lps) {
                                  return frames[p]->distance_mm(Structure::LaBlood, lps) < grown_mm;
                                });
}

TEST_F(Validate, WhatIsDrawnAndNotFeltIsMeasuredByItsSurface) {
  for (const double grown_mm : {0.0, 1.5}) {
    Candidate with_atrium = candidate(0.0);
    with_atrium.surfaces = {left_atrium(made_, grown_mm)};
    StageContext context;
    const ValidationReport report = validate(with_atrium, truth_, {}, context);
    ASSERT_EQ(report.drawn.size(), 1U);
    EXPECT_EQ(report.drawn[0].structure, Structure::LaBlood);
    ASSERT_EQ(report.drawn[0].phases.size(), 4U);
    for (const DrawnErrors& phase : report.drawn[0].phases) {
      EXPECT_GT(phase.points, 1000);
      EXPECT_NEAR(phase.bias_mm, grown_mm, 0.05);
      EXPECT_NEAR(phase.mean_mm, grown_mm, 0.06);
      EXPECT_LT(phase.hausdorff_mm, grown_mm + 0.5);
      // A surface that is larger by so much all about is larger by its area times that, and more.
      const double added_ml = phase.volume_error_ml;
      EXPECT_GT(added_ml, grown_mm == 0 ? -1 : 8);
      EXPECT_LT(added_ml, grown_mm == 0 ? 0.1 : 25);
    }
    EXPECT_EQ(report_to_json(report)["drawn"][0]["name"], "la_blood");
  }
}

TEST(ZeroLevel, PointsOfASphereLieOnItAndAddUpToItsArea) {
  constexpr double kRadiusMm = 20.0;
  const Vec3 centre(100, 90, 80);
  const auto field = encoded(
      Structure::Heart, [&](const Vec3& x, double) { return (x - centre).norm() - kRadiusMm; },
      centre + Vec3(0.3, 0.4, 0.1), 32.0, 2.0, 2);
  const field::FieldQuery query(field, 0.8);
  double area = 0.0;
  for (const SurfacePoint& point : zero_level(query, 0.1)) {
    EXPECT_NEAR((point.x - centre).norm(), kRadiusMm, 0.01);
    area += point.area_mm2;
  }
  EXPECT_NEAR(area / (4.0 * M_PI * kRadiusMm * kRadiusMm), 1.0, 0.01);
}

TEST(Statistics, PoolBothWaysWithEqualWeight) {
  // One way 1 on all of its area, the other -3 at one point of ten and 0 elsewhere.
  std::vector<Weighted> one{{1.0, 7.0}, {1.0, 2.0}};
  std::vector<Weighted> other(10, {0.0, 0.5});
  other[4].value = -3.0;
  const DistanceStatistics s = pooled_statistics(one, other);
  EXPECT_NEAR(s.mean, 0.5 + 0.15, 1e-12);
  EXPECT_NEAR(s.bias, 0.5 - 0.15, 1e-12);
  EXPECT_NEAR(s.rms, std::sqrt(0.5 * 1.0 + 0.5 * 0.1 * 9.0), 1e-12);
  EXPECT_NEAR(s.p95, 1.0, 1e-12);
  EXPECT_NEAR(s.maximum, 3.0, 1e-12);
  other[5].value = 2.0;  // now a tenth of the weight is above 1
  EXPECT_NEAR(pooled_statistics(one, other).p95, 2.0, 1e-12);
  EXPECT_EQ(pooled_statistics({}, {}).mean, 0.0);
}

}  // namespace
}  // namespace beatlas::assess
