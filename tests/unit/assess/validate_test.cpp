#include "pipeline/assess/validate.h"

#include <cmath>
#include <functional>
#include <set>

#include <gtest/gtest.h>

#include "pipeline/assess/statistics.h"
#include "pipeline/assess/zero_level.h"
#include "pipeline/core/parallel.h"
#include "pipeline/pack/pack.h"
#include "runtime/base/error.h"

namespace beatlas::assess {
namespace {

using Level = std::function<float(const Vec3& workspace, double share_of_cycle)>;

/// Samples a level on a lattice as the field room would, and encodes it as the pack room does.
std::shared_ptr<const atlas::FieldPayload> encoded(Structure structure, const Level& level,
                                                   const Vec3& centre, double half_mm,
                                                   double voxel_mm, int phases) {
  FieldCycle field;
  field.structure = structure;
  field.voxel_mm = voxel_mm;
  field.inner_mm = 12.0;
  field.outer_mm = 6.0;
  const int side = static_cast<int>(std::ceil(2.0 * half_mm / voxel_mm)) + 1;
  Grid grid;
  grid.size = {side, side, side};
  grid.mm_from_index.linear() *= voxel_mm;
  grid.mm_from_index.translation() = centre - Vec3::Constant(half_mm);
  field.distance_mm.grid = grid;
  field.distance_mm.phases.assign(phases, std::vector<float>(grid.count()));
  parallel_for(static_cast<std::size_t>(phases), [&](std::size_t p) {
    for (int k = 0; k < side; ++k) {
      for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
          const double value = level(grid.mm(i, j, k), static_cast<double>(p) / phases);
          field.distance_mm.phases[p][grid.offset(i, j, k)] =
              static_cast<float>(std::clamp(value, -field.inner_mm, field.outer_mm));
        }
      }
    }
  });
  field.volume_ml.assign(phases, 1.0);
  return std::make_shared<const atlas::FieldPayload>(pack::encode_field(field, {0.002}));
}

class Validate : public ::testing::Test {
 protected:
  static phantom::PhantomSpec spec() {
    phantom::PhantomSpec out = phantom::preset("small");
    out.phases = 4;
    out.oblique_deg = {4.0, -3.0, 10.0};
    return out;
  }

  Validate() : truth_(spec()) {
    // A turned workspace, so that a frame mistaken for another shows.
    workspace_from_lps_.linear() = truth_.spec().imaging_grid().mm_from_index.linear();
    workspace_from_lps_.linear().colwise().normalize();
    workspace_from_lps_.linear().transposeInPlace();
    workspace_from_lps_.translation() = Vec3(128, 128, 96);
    manifest_.rr_interval_s = truth_.spec().rr_interval_s;
    manifest_.frame_times_s.assign(4, 0.0);
    manifest_.workspace_from_lps = workspace_from_lps_;
    manifest_.source_size = truth_.spec().imaging_grid().size;
    manifest_.source_lps_from_index = truth_.spec().imaging_grid().mm_from_index;
    for (Structure structure : kAllStructures) {
      atlas::StructureEntry entry{std::string(structure_name(structure)), {}};
      for (int p = 0; p < 4; ++p) {
        entry.volume_ml.push_back(truth_.volume_ml(structure, truth_.phase_time_s(p)));
      }
      manifest_.structures.push_back(entry);
    }
  }

  /// The exact LV cavity of the truth, larger by `grown_mm`, moved by `moved_mm`.
  Candidate candidate(double grown_mm, const Vec3& moved_mm = Vec3::Zero()) const {
    const Affine lps_from_workspace = workspace_from_lps_.inverse();
    const Vec3 centre = workspace_from_lps_ *
                        (phantom::lps_from_heart(truth_.spec().anatomy) * Vec3(0.0, 0.0, -16.0));
    const auto field = encoded(
        Structure::LvBlood,
        [&](const Vec3& x, double share) {
          return static_cast<float>(truth_.distance_mm(Structure::LvBlood,
                                                       lps_from_workspace * (x - moved_mm),
                                                       share * truth_.spec().rr_interval_s) -
                                    grown_mm);
        },
        centre, 60.0, 2.0, 4);
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

  phantom::Phantom truth_;
  Affine workspace_from_lps_ = Affine::Identity();
  atlas::Manifest manifest_;
};

TEST_F(Validate, FindsNothingWrongWithTheTruthItself) {
  StageContext context;
  ValidateLimits limits;
  limits.crease_band_mm = 4.0;  // the spline of 2 mm rounds the rim two voxels wide
  const ValidationReport report = validate(candidate(0.0), truth_, limits, context);
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
  ValidateLimits limits;
  limits.max_mean_mm = 0.6;
  const Candidate grown = candidate(0.5);
  EXPECT_TRUE(validate(grown, truth_, limits, context).passed);
  limits.max_bias_mm = 0.4;
  limits.min_dice = 0.999;
  const ValidationReport report = validate(grown, truth_, limits, context);
  EXPECT_FALSE(report.passed);
  EXPECT_EQ(report.failures.size(), 8u);
  EXPECT_NE(report.failures[0].find("lv_blood in phase 0: bias_mm"), std::string::npos);
}

TEST_F(Validate, VolumesAreThoseOfTheManifest) {
  StageContext context;
  Candidate changed = candidate(0.0);
  changed.manifest.structures[1].volume_ml[2] += 7.0;
  const ValidationReport report = validate(changed, truth_, {}, context);
  EXPECT_NEAR(report.structures[0].phases[2].volume_error_ml, 7.0, 1e-9);
  EXPECT_NEAR(report.structures[0].phases[1].volume_error_ml, 0.0, 1e-9);
  changed.manifest.structures[1].volume_ml.pop_back();
  EXPECT_THROW((void)validate(changed, truth_, {}, context), Error);
}

TEST_F(Validate, APackageWithoutSurfaceFails) {
  StageContext context;
  const auto field = encoded(
      Structure::LvBlood, [](const Vec3&, double) { return 5.0F; }, Vec3(128, 128, 96), 30.0, 3.0,
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
  for (const char* key :
       {"dice", "volume_error_ml", "mean_mm", "p95_mm", "hausdorff_mm", "bias_mm"}) {
    EXPECT_TRUE(json["structures"][0]["phases"][3][key].is_number()) << key;
  }
}

TEST(ZeroLevel, PointsOfASphereLieOnItAndAddUpToItsArea) {
  constexpr double kRadiusMm = 20.0;
  const Vec3 centre(100, 90, 80);
  const auto field = encoded(
      Structure::Heart,
      [&](const Vec3& x, double) { return static_cast<float>((x - centre).norm() - kRadiusMm); },
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
  EXPECT_NEAR(s.p95, 1.0, 1e-12);
  EXPECT_NEAR(s.maximum, 3.0, 1e-12);
  other[5].value = 2.0;  // now a tenth of the weight is above 1
  EXPECT_NEAR(pooled_statistics(one, other).p95, 2.0, 1e-12);
  EXPECT_EQ(pooled_statistics({}, {}).mean, 0.0);
}

}  // namespace
}  // namespace beatlas::assess
