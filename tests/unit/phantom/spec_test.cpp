#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "pipeline/phantom/truth.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"

namespace beatlas::phantom {
namespace {

std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(PhantomSpec, EveryPresetIsValidAndSurvivesJson) {
  for (const std::string& name : preset_names()) {
    const PhantomSpec spec = preset(name);
    EXPECT_EQ(spec.name, name);
    const nlohmann::json json = spec_to_json(spec);
    const PhantomSpec again = spec_from_json(parse_json(json_text(json)));
    EXPECT_EQ(spec_to_json(again), json);
    EXPECT_EQ(Phantom(again).identity(), Phantom(spec).identity());
  }
  EXPECT_NE(error_of([] { (void)preset("child"); }).find("adult"), std::string::npos);
}

TEST(PhantomSpec, AdultIsPaperAsGrid) {
  const PhantomSpec spec = preset("adult");
  EXPECT_EQ(spec.grid.size, kWorkspaceSize);
  EXPECT_TRUE(spec.grid.spacing_mm().isApprox(Vec3(1, 1, 3)));
  EXPECT_EQ(spec.phases, 15);
  EXPECT_EQ(spec.rr_interval_s, 0.75);
}

TEST(PhantomSpec, ClinicalStackLiesAlongTheLongAxis) {
  const PhantomSpec spec = preset("clinical");
  const Vec3 along = spec.imaging_grid().mm_from_index.linear().col(2).normalized();
  EXPECT_NEAR(along.dot(spec.anatomy.apex_direction_lps.normalized()), -1.0, 1e-12);
  EXPECT_NEAR(spec.grid.spacing_mm().z(), 10.0, 1e-12);
}

TEST(PhantomSpec, ObliqueTurnKeepsTheCentreAndSpacing) {
  PhantomSpec spec = preset("adult");
  spec.oblique_deg = {10.0, -7.0, 25.0};
  const Grid turned = spec.imaging_grid();
  EXPECT_TRUE(turned.spacing_mm().isApprox(spec.grid.spacing_mm(), 1e-12));
  EXPECT_TRUE(turned.mm(127.5, 127.5, 31.5).isApprox(spec.grid.mm(127.5, 127.5, 31.5), 1e-9) ||
              turned.mm(127.5, 127.5, 31.5).norm() < 1e-9);
  EXPECT_FALSE(turned.mm_from_index.isApprox(spec.grid.mm_from_index, 1e-3));
}

TEST(PhantomSpec, BadInputIsRefusedByItsPath) {
  const nlohmann::json good = spec_to_json(preset("small"));
  const auto refused = [&](const char* patch) {
    nlohmann::json bad = good;
    bad.merge_patch(parse_json(patch));
    return error_of([&] { (void)spec_from_json(bad); });
  };
  const auto names = [](const std::string& text, const char* what) {
    return text.find(what) != std::string::npos;
  };
  EXPECT_TRUE(names(refused(R"({"phase": 3})"), "/phase is not a known key"));
  EXPECT_TRUE(names(refused(R"({"phases": 1})"), "/phases"));
  EXPECT_TRUE(names(refused(R"({"scanner": {"snr_blood": 0.5}})"), "/scanner/snr_blood"));
  EXPECT_TRUE(names(refused(R"({"scanner": {"snr_blood": "high"}})"), "/scanner/snr_blood"));
  EXPECT_TRUE(names(refused(R"({"grid": {"size": [10, 10]}})"), "/grid"));
  EXPECT_TRUE(names(refused(R"({"anatomy": {"lv_end_diastole": {"radius": 3}}})"),
                    "/anatomy/lv_end_diastole/radius is not a known key"));
  EXPECT_TRUE(names(refused(R"({"anatomy": {"scale": 9}})"), "/anatomy/scale"));
  EXPECT_TRUE(names(refused(R"({"anatomy": {"lv_end_systole": {"base_mm": 80}}})"), "base_mm"));
  EXPECT_TRUE(names(refused(R"({"anatomy": {"rv_direction_lps": [0.6, -0.55, -0.58]}})"),
                    "two directions"));
  EXPECT_EQ(refused(R"({"scanner": {"snr_blood": null}})"), "");
}

TEST(PhantomSpec, HeartOutsideTheFieldOfViewIsRefused) {
  PhantomSpec spec = preset("small");
  spec.anatomy.origin_lps_mm.x() += 40.0;
  EXPECT_NE(error_of([&] { Phantom{spec}; }).find("field of view along index i"),
            std::string::npos);
  spec = preset("small");
  spec.anatomy.origin_lps_mm.z() -= 50.0;
  EXPECT_NE(error_of([&] { Phantom{spec}; }).find("along index k"), std::string::npos);
}

TEST(PhantomSpec, FieldOfViewEndsWhereTheHeartDoes) {
  // The refusal must agree with the distance: shift until refused, then ask for heart at the edge.
  PhantomSpec spec = preset("small");
  const double edge = spec.grid.mm(spec.grid.size[0] - 0.5, 0, 0).x();
  double low = 0.0;
  double high = 60.0;
  const double start = spec.anatomy.origin_lps_mm.x();
  for (int n = 0; n < 40; ++n) {
    spec.anatomy.origin_lps_mm.x() = start + 0.5 * (low + high);
    (error_of([&] { check_spec(spec); }).empty() ? low : high) = 0.5 * (low + high);
  }
  spec.anatomy.origin_lps_mm.x() = start + low;
  const Phantom phantom(spec);
  double reach = -1e300;
  for (const Vec3& x : phantom.sample_surface(Part::Heart, 0.0, 1.0)) {
    reach = std::max(reach, x.x());
  }
  EXPECT_NEAR(reach, edge, 0.05);  // samples are 1 mm apart on a curved surface
  EXPECT_LE(reach, edge + 1e-6);
}

TEST(PhantomTruth, RebuildsThePhantom) {
  PhantomSpec spec = preset("clinical");
  spec.oblique_deg = {3.0, 4.0, 5.0};
  spec.anatomy.scale = 0.9;
  const Phantom phantom(spec);
  const nlohmann::json truth = parse_json(json_text(truth_json(phantom)));
  const Phantom again = phantom_from_truth(truth);
  EXPECT_EQ(again.identity(), phantom.identity());
  EXPECT_EQ(again.distance_mm(Part::Heart, {1, 2, 3}, 0.21),
            phantom.distance_mm(Part::Heart, {1, 2, 3}, 0.21));
  EXPECT_EQ(truth["structures"].size(), kAllParts.size());
  EXPECT_EQ(truth["times_s"].size(), 25u);
  EXPECT_NEAR(truth["ejection_fraction"]["lv_blood"].get<double>(), 0.658, 0.002);
}

TEST(PhantomTruth, ChangedTruthIsRefused) {
  const nlohmann::json truth = truth_json(Phantom(preset("small")));
  nlohmann::json bad = truth;
  bad["spec"]["anatomy"]["scale"] = 1.01;
  EXPECT_NE(error_of([&] { (void)phantom_from_truth(bad); }).find("/identity"), std::string::npos);
  bad = truth;
  bad["structures"][1]["volume_ml"][3] = 7.0;
  EXPECT_NE(error_of([&] { (void)phantom_from_truth(bad); }).find("/structures"),
            std::string::npos);
  EXPECT_NE(error_of([&] { (void)phantom_from_truth(nlohmann::json::array()); }), "");
  EXPECT_NE(error_of([&] { (void)phantom_from_truth(nlohmann::json::object()); }).find("/format"),
            std::string::npos);
}

}  // namespace
}  // namespace beatlas::phantom
