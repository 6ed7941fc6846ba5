/// The parts of `beatlas bench` that are not the stages themselves.
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/assess/bench_phantom.h"
#include "pipeline/assess/bench_plan.h"
#include "pipeline/assess/bench_report.h"
#include "pipeline/assess/pareto.h"
#include "pipeline/assess/truth_set.h"
#include "pipeline/assess/voxel_model.h"
#include "runtime/base/error.h"

namespace beatlas::assess {
namespace {

using nlohmann::json;

TEST(Pareto, KeepsWhatNoOtherPointBeats) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<bool> front =
      pareto_front({{1, 9}, {2, 5}, {3, 5}, {4, 1}, {4, 1}, {9, 9}, {nan, 0}, {0.5, 9.5}});
  EXPECT_EQ(front, (std::vector<bool>{true, true, false, true, true, false, false, true}));
  EXPECT_TRUE(pareto_front({}).empty());
}

TEST(PowerLaw, FindsTheExponentAndHowFarPointsAreFromIt) {
  const std::vector<double> x{1, 2, 4, 8};
  std::vector<double> y;
  for (const double each : x) y.push_back(3 * std::pow(each, 1.5));
  const PowerLaw exact = fit_power_law(x, y);
  EXPECT_NEAR(exact.exponent, 1.5, 1e-12);
  EXPECT_NEAR(exact.factor, 3, 1e-12);
  EXPECT_NEAR(exact.residual, 0, 1e-12);
  // A tenth up and down in turn, symmetric about the middle: the same exponent, residual ln 1.1.
  for (std::size_t n = 0; n < 4; ++n) y[n] *= n == 0 || n == 3 ? 1.1 : 1 / 1.1;
  const PowerLaw rough = fit_power_law(x, y);
  EXPECT_NEAR(rough.exponent, 1.5, 1e-12);
  EXPECT_NEAR(rough.residual, std::log(1.1), 1e-12);
  EXPECT_EQ(rough.points, 4);
  EXPECT_THROW((void)fit_power_law({2, 2}, {1, 3}), Error);
  EXPECT_THROW((void)fit_power_law({1, 2}, {1, 0}), Error);
}

json defaults() {
  return {{"phantom", {{"matrix", 1.0}}},
          {"field", {{"voxel_mm", 1.5}}},
          {"pack", {{"step_mm", 0.01}}},
          {"query", {{"space", "cubic"}, {"time", "cubic"}}}};
}

TEST(BenchPlan, VariesOneKnobAtATimeAndCrossesAxes) {
  const std::vector<Knob> knobs{
      {"voxel", "", Sweep::Exact, Family::Field, {{"/field/voxel_mm", {1.0, 1.5, 3.0}, {1.5}}}},
      {"both",
       "",
       Sweep::Exact,
       Family::Field,
       {{"/field/voxel_mm", {1.0, 1.5}, {1.5}},
        {"/query/space", {"cubic", "nearest"}, {"nearest"}}}}};
  const std::vector<BenchRun> runs = plan_runs(knobs, {}, defaults(), false);
  ASSERT_EQ(runs.size(), 7U);
  for (const BenchRun& run : runs) {
    EXPECT_EQ(run.settings.at("pack"), defaults().at("pack"));
    EXPECT_EQ(run.is_default, run.settings == defaults());
  }
  EXPECT_EQ(first_difference(runs[0].settings, defaults()), "field");
  EXPECT_EQ(first_difference(runs[6].settings, defaults()), "query");
  EXPECT_EQ(first_difference(runs[1].settings, defaults()), "");
  EXPECT_EQ(plan_runs(knobs, {"both"}, defaults(), true).size(), 1U);
  EXPECT_EQ(shown_values(runs[4]), "1, nearest");
}

TEST(BenchPlan, NamesTheKnobsThereAre) {
  try {
    (void)plan_runs(bench_knobs(), {"colour"}, defaults(), false);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Usage);
    const std::string told = error.what();
    EXPECT_NE(told.find("'colour'"), std::string::npos);
    for (const std::string& name : bench_knob_names()) {
      EXPECT_NE(told.find(name), std::string::npos) << name;
    }
  }
}

TEST(BenchReport, MarksTheFrontsOfEachSweepAlone) {
  const auto row = [](Sweep sweep, double error, std::size_t bytes) {
    BenchRow out;
    out.run.sweep = sweep;
    out.errors[Structure::Heart].mean_mm = error;
    out.package_bytes = bytes;
    out.query_path_ns = 100;
    out.total_s = 1;
    return out;
  };
  std::vector<BenchRow> rows{row(Sweep::Exact, 0.1, 10), row(Sweep::Exact, 0.2, 20),
                             row(Sweep::Images, 0.5, 10), row(Sweep::Exact, 0.05, 30)};
  mark_fronts(rows);
  EXPECT_TRUE(rows[0].front_bytes);
  EXPECT_FALSE(rows[1].front_bytes);
  EXPECT_TRUE(rows[2].front_bytes);
  EXPECT_TRUE(rows[3].front_bytes);
  EXPECT_FALSE(rows[0].front_query);  // equally fast and less near than the last
}

TEST(BenchPhantom, ScaledMatrixKeepsTheFieldOfView) {
  const phantom::PhantomSpec small = phantom::preset("small");
  const phantom::PhantomSpec fine = scaled_matrix(small, 2);
  for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(fine.grid.size[a], 2 * small.grid.size[a]);
  EXPECT_LT((fine.grid.spacing_mm() - 0.5 * small.grid.spacing_mm()).norm(), 1e-12);
  EXPECT_LT((fine.grid.mm(-0.5, -0.5, -0.5) - small.grid.mm(-0.5, -0.5, -0.5)).norm(), 1e-9);
  EXPECT_NO_THROW(phantom::check_spec(fine));
  EXPECT_NO_THROW(phantom::check_spec(scaled_matrix(small, 0.5)));
}

TEST(BenchPhantom, ExactShapeIsTheClosedFormsDistance) {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.phases = 2;
  const phantom::Phantom truth(spec);
  StageContext context;
  Affine map = Affine::Identity();
  map.translation() = Vec3(128, 128, 96);
  const ShapeCycle shape = exact_shape(truth, Structure::LvBlood, map, 2.5, 6, context);
  ASSERT_EQ(shape.level.phase_count(), 2);
  const Grid& grid = shape.level.grid;
  int near = 0;
  for (int k = 0; k < grid.size[2]; k += 3) {
    for (int j = 0; j < grid.size[1]; j += 3) {
      for (int i = 0; i < grid.size[0]; i += 3) {
        const double distance = truth.distance_mm(
            Structure::LvBlood, grid.mm(i, j, k) - Vec3(128, 128, 96), truth.phase_time_s(1));
        const double level = shape.level.phases[1][grid.offset(i, j, k)];
        EXPECT_NEAR(level, std::clamp(distance, -12.5, 12.5), 1e-4);
        near += std::abs(distance) < 12.5;
      }
    }
  }
  EXPECT_GT(near, 100);
}

/// Voxels of 2 x 2 x 4 mm that hold a slab, x < 0 in the first phase and x < 4 in the second.
std::shared_ptr<const LabelCycle> slab() {
  auto out = std::make_shared<LabelCycle>();
  out->grid.size = {20, 20, 10};
  out->grid.mm_from_index.linear() = Vec3(2, 2, 4).asDiagonal();
  out->grid.mm_from_index.translation() = Vec3(-19, -19, -18);
  for (int phase = 0; phase < 2; ++phase) {
    std::vector<std::uint8_t> labels(out->grid.count());
    for (std::size_t v = 0; v < labels.size(); ++v) {
      const int i = static_cast<int>(v % 20);
      labels[v] = i >= 2 && i < 10 + 2 * phase ? kLabelRestOfHeart : kLabelBackground;
    }
    out->phases.push_back(labels);
  }
  return out;
}

TEST(VoxelModel, TouchesInVoxelsAndPushesToTheirFacesAndInterpolatesForce) {
  // A turned workspace: y of the patient is x there.
  Affine map = Affine::Identity();
  map.linear() << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  const VoxelModel model(slab(), Structure::Heart, map, 1.0, 100);
  const auto at = [&](double x, double t) { return model.contact(map * Vec3(x, 0.3, 1.1), t); };
  const Vec3 out = map.linear() * Vec3::UnitX();
  // First frame: faces at x = 0.
  EXPECT_NEAR(at(-3, 0).distance_mm, -3, 1e-9);
  EXPECT_LT((at(-3, 0).force_n - 0.3 * out).norm(), 1e-9);
  EXPECT_NEAR(at(2.5, 0).distance_mm, 2.5, 1e-9);
  EXPECT_FALSE(at(2.5, 0).touching);
  // Half a beat on: at x = 4. A quarter: the mean of the forces, though the depths' mean differs.
  EXPECT_LT((at(1, 0.5).force_n - 0.3 * out).norm(), 1e-9);
  EXPECT_LT((at(1, 0.25).force_n - 0.15 * out).norm(), 1e-9);
  EXPECT_TRUE(at(1, 0.25).touching);
  EXPECT_LT((at(1, 0.75).force_n - 0.15 * out).norm(), 1e-9);  // and back to the first frame
  EXPECT_LT((at(1, -1.5).force_n - at(1, 0.5).force_n).norm(), 1e-12);
}

class TruthSetTest : public ::testing::Test {
 protected:
  static phantom::PhantomSpec spec() {
    phantom::PhantomSpec out = phantom::preset("small");
    out.phases = 3;
    return out;
  }
  TruthSetTest() : phantom_(spec()) {
    options_.spacing_mm = 12;
    options_.palpated_places = 2;
    map_.linear() = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    map_.translation() = Vec3(128, 120, 90);
    StageContext context;
    truth_ = make_truth_set(phantom_, {Structure::Heart}, options_, context);
  }
  /// The closed form itself, its surface moved outward.
  MakeTouch closed_form(double grown_mm) const {
    const Affine back = map_.inverse();
    return [this, back, grown_mm] {
      return [this, back, grown_mm](const Vec3& x, double t) {
        const auto nearest = phantom_.frame(t)->nearest(Structure::Heart, back * x);
        haptics::Contact out;
        out.distance_mm = nearest.distance_mm - grown_mm;
        out.normal = map_.linear() * nearest.outward;
        out.force_n =
            haptics::contact_force_n(options_.stiffness_n_per_m, out.distance_mm, out.normal);
        return out;
      };
    };
  }

  phantom::Phantom phantom_;
  TruthOptions options_;
  Affine map_ = Affine::Identity();
  TruthSet truth_;
};

TEST_F(TruthSetTest, TheTruthHasNoErrorAndAGrownOneItsGrowth) {
  const double rr = phantom_.spec().rr_interval_s;
  const auto& points = truth_.surfaces.at(Structure::Heart);
  EXPECT_GT(points.size(), 500U);
  const SurfaceErrors none = surface_errors(closed_form(0), points, map_, rr);
  EXPECT_LT(none.p95_mm, 1e-6);
  EXPECT_LT(none.normal_p95_deg, 1e-3);
  EXPECT_LT(force_errors({closed_form(0), map_, rr}, truth_.forces).max_n, 1e-6);
  const SurfaceErrors grown = surface_errors(closed_form(0.5), points, map_, rr);
  EXPECT_NEAR(grown.bias_mm, 0.5, 1e-6);
  EXPECT_NEAR(grown.mean_mm, 0.5, 1e-6);
  const ForceErrors force = force_errors({closed_form(0.5), map_, rr}, truth_.forces);
  EXPECT_NEAR(force.max_n, 150 * 0.5e-3, 1e-6);  // K times the growth
  EXPECT_GT(force.contact_ticks, 300);
}

TEST_F(TruthSetTest, MeshErrorsAreThoseOfItsCornersAndMiddles) {
  // A triangle whose corners lie 1 mm outside of a smooth place of the surface.
  const auto frame = phantom_.frame(0);
  const TruthPoint& at = truth_.surfaces.at(Structure::Heart).front();
  ASSERT_EQ(at.share, 0);
  const Vec3 u = at.normal.unitOrthogonal();
  const Vec3 v = at.normal.cross(u);
  std::vector<std::vector<Vec3f>> positions(1);
  for (const Vec3& side : {Vec3(u), Vec3(v), Vec3(-u - v)}) {
    positions[0].push_back((map_ * Vec3(at.lps + at.normal + 0.1 * side)).cast<float>());
  }
  const SurfaceErrors errors =
      mesh_errors({{0, 1, 2}}, positions, Structure::Heart, phantom_, map_, 0);
  EXPECT_EQ(errors.points, 4);
  EXPECT_NEAR(errors.bias_mm, 1, 0.01);
  EXPECT_LT(errors.normal_p95_deg, 1);
}

}  // namespace
}  // namespace beatlas::assess
