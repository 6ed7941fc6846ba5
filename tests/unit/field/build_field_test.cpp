#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/field/field.h"
#include "pipeline/field/surface.h"
#include "runtime/base/error.h"
#include "tests/unit/field/closed_form.h"

namespace beatlas::field {
namespace {

using closed_form::Ellipsoid;
using closed_form::lattice;
using closed_form::Level;
using closed_form::sampled;

struct Errors {
  double mean = 0;
  double max = 0;
  double bias = 0;
  int wrong_signs = 0;  // farther than the largest allowed error from the surface
};

Errors errors_in_band(const FieldCycle& field, std::size_t phase, const Level& truth,
                      double band_mm) {
  Errors out;
  int count = 0;
  const Grid& grid = field.distance_mm.grid;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const double want = truth(grid.mm(i, j, k));
        const double got = field.distance_mm.phases[phase][grid.offset(i, j, k)];
        if (std::abs(want) > 0.15 && (want < 0) != (got < 0)) ++out.wrong_signs;
        if (std::abs(want) > band_mm) continue;
        ++count;
        out.mean += std::abs(got - want);
        out.bias += got - want;
        out.max = std::max(out.max, std::abs(got - want));
      }
    }
  }
  out.mean /= count;
  out.bias /= count;
  return out;
}

ShapeCycle one_phase(const Grid& grid, std::vector<float> level) {
  ShapeCycle shape;
  shape.level.grid = grid;
  shape.level.phases.push_back(std::move(level));
  return shape;
}

const Ellipsoid kHeart{{31, -12, 55}, {33, 38, 46}};

Grid around(const Ellipsoid& e, double mm, double margin_mm = 10) {
  const Vec3 margin = Vec3::Constant(margin_mm);
  return lattice(e.centre_mm - e.radii_mm - margin, e.centre_mm + e.radii_mm + margin, mm);
}

TEST(BuildField, ExactLevelsOfAnEllipsoidGiveItsDistance) {
  const Level truth = [](const Vec3& x) { return kHeart.distance_mm(x); };
  const Grid grid = around(kHeart, 1.0);
  StageContext context;
  const FieldCycle field = build_field(one_phase(grid, sampled(grid, truth)), {}, context);
  const Errors errors = errors_in_band(field, 0, truth, 3.0);
  // A facet of 0.7 mm edge on a radius of 25 mm sags by 0.003 mm; nothing else is lost.
  EXPECT_LT(errors.mean, 0.005);
  EXPECT_LT(errors.max, 0.02);
  EXPECT_EQ(errors.wrong_signs, 0);
  EXPECT_NEAR(field.volume_ml[0] / kHeart.volume_ml(), 1.0, 0.001);
}

TEST(BuildField, CoverageOfVoxelsGivesDistanceWithinATwentiethOfAMillimetre) {
  const Level truth = [](const Vec3& x) { return kHeart.distance_mm(x); };
  const Grid grid = around(kHeart, 1.0);
  StageContext context;
  const FieldCycle field = build_field(
      one_phase(grid, closed_form::coverage_level(
                          grid, truth, [](const Vec3& x) { return kHeart.holds(x); }, 8)),
      {}, context);
  const Errors errors = errors_in_band(field, 0, truth, 3.0);
  EXPECT_LT(errors.mean, 0.05);
  // Coverage saturates half a voxel off the surface, so planes along the lattice ripple by a tenth.
  EXPECT_LT(errors.max, 0.16);
  EXPECT_LT(std::abs(errors.bias), 0.015);
  EXPECT_EQ(errors.wrong_signs, 0);
  EXPECT_NEAR(field.volume_ml[0] / kHeart.volume_ml(), 1.0, 0.003);
}

// The least distance to any triangle, tried one by one.
double slow_distance(const TriangleSoup& surface, const Vec3& p) {
  const auto to_side = [&](const Vec3& u, const Vec3& v) {
    const double length2 = (v - u).squaredNorm();
    const double share = length2 > 0 ? std::clamp((p - u).dot(v - u) / length2, 0.0, 1.0) : 0.0;
    return (p - u - share * (v - u)).norm();
  };
  double best = std::numeric_limits<double>::infinity();
  for (const auto& t : surface.triangles) {
    const Vec3& a = surface.points[t[0]];
    const Vec3& b = surface.points[t[1]];
    const Vec3& c = surface.points[t[2]];
    best = std::min({best, to_side(a, b), to_side(b, c), to_side(c, a)});
    const Vec3 n = (b - a).cross(c - a).stableNormalized();
    const double up = n.dot(p - a);
    const Vec3 q = p - up * n;
    if (n.dot((b - a).cross(q - a)) > 0 && n.dot((c - b).cross(q - b)) > 0 &&
        n.dot((a - c).cross(q - c)) > 0) {
      best = std::min(best, std::abs(up));
    }
  }
  return best;
}

TEST(BuildField, EverySampleIsAsFarAsTheNearestOfAllTriangles) {
  // A bent shell of 2.5 mm, a ball in it and a rod beside it: creases, thin walls and medial axes.
  const Level truth = [](const Vec3& x) {
    const double shell =
        std::abs((x - Vec3(2, 0, 0)).cwiseQuotient(Vec3(1, 1.2, 0.8)).norm() - 12) - 1.25;
    const double ball = (x - Vec3(5, 3, 0)).norm() - 4;
    const double rod = (x - Vec3(-18, 0, x.z())).norm() - 1.5;
    return std::min({shell, ball, rod});
  };
  const Grid grid = lattice({-24, -20, -16}, {20, 20, 16}, 1.0);
  const std::vector<float> level = sampled(grid, truth);
  FieldOptions options;
  options.inner_mm = 4;
  options.outer_mm = 8;
  options.handles = Handles::Keep;
  StageContext context;
  const FieldCycle field = build_field(one_phase(grid, level), options, context);
  const TriangleSoup surface = level_surface(grid, level);
  const Grid& to = field.distance_mm.grid;
  for (std::size_t n = 0; n < to.count(); n += 13) {
    const auto i = static_cast<int>(n % static_cast<std::size_t>(to.size[0]));
    const auto j = static_cast<int>(n / static_cast<std::size_t>(to.size[0]) %
                                    static_cast<std::size_t>(to.size[1]));
    const auto k = static_cast<int>(n / to.slice_count());
    const float got = field.distance_mm.phases[0][n];
    const double clamp = got < 0 ? options.inner_mm : options.outer_mm;
    ASSERT_NEAR(std::abs(got), std::min(clamp, slow_distance(surface, to.mm(i, j, k))), 2e-5)
        << i << ' ' << j << ' ' << k;
  }
}

TEST(BuildField, ALevelThatNearlyReachesZeroWithinLeavesNoHole) {
  // Two layers that are hardly muscle, deep within: between them the cubic swings outside.
  const Ellipsoid ball{{0, 0, 0}, {14, 14, 14}};
  const Grid grid = lattice({-20, -20, -20}, {20, 20, 20}, 1.0);
  std::vector<float> level = sampled(
      grid, [&](const Vec3& x) { return std::clamp(4 * ball.distance_mm(x), -20.0, 20.0); });
  const int middle = grid.size[0] / 2;
  for (int n = 0; n < 98; ++n) {
    level[grid.offset(middle + n / 49, middle + n / 7 % 7 - 3, middle + n % 7 - 3)] = -0.01F;
  }
  FieldOptions options;
  options.voxel_mm = 0.5;
  options.handles = Handles::Keep;
  StageContext context;
  const FieldCycle field = build_field(one_phase(grid, level), options, context);
  const Errors errors = errors_in_band(
      field, 0, [&](const Vec3& x) { return ball.distance_mm(x); }, 20.0);
  EXPECT_EQ(errors.wrong_signs, 0);
}

TEST(BuildField, DistanceIsRightUpToTheClampAndEndsThere) {
  const Level truth = [](const Vec3& x) { return kHeart.distance_mm(x); };
  const Grid grid = around(kHeart, 1.5);
  FieldOptions options;
  options.inner_mm = 12;
  options.outer_mm = 7;
  StageContext context;
  const FieldCycle field = build_field(one_phase(grid, sampled(grid, truth)), options, context);
  const Errors errors = errors_in_band(
      field, 0, [&](const Vec3& x) { return std::clamp(truth(x), -12.0, 7.0); }, 13.0);
  EXPECT_LT(errors.max, 0.03);
  EXPECT_FLOAT_EQ(
      *std::min_element(field.distance_mm.phases[0].begin(), field.distance_mm.phases[0].end()),
      -12.0F);
  EXPECT_FLOAT_EQ(
      *std::max_element(field.distance_mm.phases[0].begin(), field.distance_mm.phases[0].end()),
      7.0F);
}

TEST(BuildField, LevelsNeedNotBeDistances) {
  // The implicit function is three times steeper at the waist than at the tips.
  const Ellipsoid slim{{3, 4, 5}, {12, 14, 40}};
  const Grid grid = around(slim, 1.0);
  const Level level = [&](const Vec3& x) {
    return (x - slim.centre_mm).cwiseQuotient(slim.radii_mm).norm() - 1.0;
  };
  StageContext context;
  const FieldCycle field = build_field(one_phase(grid, sampled(grid, level)), {}, context);
  const Errors errors = errors_in_band(
      field, 0, [&](const Vec3& x) { return slim.distance_mm(x); }, 3.0);
  EXPECT_LT(errors.mean, 0.01);
  EXPECT_LT(errors.max, 0.1);  // the tips' radius is 3.6 mm
  EXPECT_EQ(errors.wrong_signs, 0);
}

TEST(BuildField, AClosedCavityThatIsKeptIsOutside) {
  const Ellipsoid outer{{0, 0, 0}, {20, 20, 20}};
  const Ellipsoid inner{{0, 0, 0}, {14, 14, 14}};
  const Level truth = [&](const Vec3& x) {
    return std::max(outer.distance_mm(x), -inner.distance_mm(x));
  };
  const Grid grid = around(outer, 1.0);
  StageContext context;
  FieldOptions options;
  options.handles = Handles::Keep;
  const FieldCycle field = build_field(one_phase(grid, sampled(grid, truth)), options, context);
  const Errors errors = errors_in_band(field, 0, truth, 3.0);
  EXPECT_LT(errors.max, 0.02);
  EXPECT_EQ(errors.wrong_signs, 0);
  EXPECT_NEAR(field.volume_ml[0] / (outer.volume_ml() - inner.volume_ml()), 1.0, 0.003);
}

TEST(BuildField, AllPhasesShareALatticeThatHoldsEveryPhaseWithItsMargin) {
  ShapeCycle shape;
  shape.level.grid = lattice({-40, -40, -40}, {60, 40, 40}, 1.0);
  for (int p = 0; p < 3; ++p) {
    const Ellipsoid e{{p * 10.0, 0, 0}, {20, 22, 18}};
    shape.level.phases.push_back(
        sampled(shape.level.grid, [&](const Vec3& x) { return e.distance_mm(x); }));
  }
  StageContext context;
  const FieldCycle field = build_field(shape, {}, context);
  const Grid& grid = field.distance_mm.grid;
  const Vec3 last = grid.mm(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
  EXPECT_LE((grid.mm(0, 0, 0) - Vec3(-26, -28, -24)).maxCoeff(), 0.01);
  EXPECT_GE((last - Vec3(46, 28, 24)).minCoeff(), -0.01);
  for (const std::vector<float>& phase : field.distance_mm.phases) {
    ASSERT_EQ(phase.size(), grid.count());
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        // Interpolation beyond the lattice repeats its border, which must be outside.
        ASSERT_GT(phase[grid.offset(0, j, k)], 0);
        ASSERT_GT(phase[grid.offset(grid.size[0] - 1, j, k)], 0);
      }
    }
  }
}

TEST(BuildField, AShapeCutByItsLatticeIsClosedThereAndSaidSo) {
  const Ellipsoid e{{0, 0, 0}, {20, 20, 20}};
  const Grid grid = lattice({-30, -30, -30}, {30, 30, 8}, 1.0);
  StageContext context;
  std::string log;
  context.warn_sink = [&](std::string_view line) { log += line; };
  const FieldCycle field = build_field(
      one_phase(grid, sampled(grid, [&](const Vec3& x) { return e.distance_mm(x); })), {}, context);
  EXPECT_NE(log.find("border"), std::string::npos);
  const double cut_mm = grid.mm(0, 0, grid.size[2] - 1).z() + 0.5;
  // Volume of a ball up to the height of the cut.
  const double want =
      std::numbers::pi * (2.0 / 3.0 * 8000 + 400 * cut_mm - std::pow(cut_mm, 3) / 3.0) * 1e-3;
  EXPECT_NEAR(field.volume_ml[0] / want, 1.0, 0.01);
}

TEST(BuildField, TheNumberOfThreadsChangesNoBit) {
  ShapeCycle shape;
  shape.level.grid = lattice({-35, -35, -35}, {35, 35, 35}, 1.0);
  for (int p = 0; p < 4; ++p) {
    const Ellipsoid e{{0, 0, 0}, {22.0 - p, 24, 20}};
    shape.level.phases.push_back(
        sampled(shape.level.grid, [&](const Vec3& x) { return e.distance_mm(x); }));
  }
  StageContext context;
  set_thread_count(1);
  const FieldCycle alone = build_field(shape, {}, context);
  set_thread_count(4);
  const FieldCycle together = build_field(shape, {}, context);
  set_thread_count(0);
  EXPECT_EQ(alone.distance_mm.phases, together.distance_mm.phases);
  EXPECT_EQ(alone.volume_ml, together.volume_ml);
  EXPECT_TRUE(alone.distance_mm.grid == together.distance_mm.grid);
}

ErrorCode code_of(const ShapeCycle& shape, const FieldOptions& options = {}) {
  StageContext context;
  try {
    (void)build_field(shape, options, context);
  } catch (const Error& error) {
    return error.code();
  }
  ADD_FAILURE() << "no error";
  return ErrorCode::Usage;
}

TEST(BuildField, SamplesThatAreNearlyZeroAreOnTheSurface) {
  // Of a ball through lattice points those on it become the smallest numbers there are, of either
  // sign; they divide by nothing that rounds to 0.
  Grid grid = lattice({-12, -12, -12}, {12, 12, 12}, 1.0);
  grid.mm_from_index.translation() = Vec3(-12, -12, -12);
  const Level truth = [](const Vec3& x) { return x.norm() - 5.0; };
  std::vector<float> samples = sampled(grid, truth);
  int tiny = 0;
  for (float& value : samples) {
    if (std::abs(value) > 1e-6F) continue;
    value = std::numeric_limits<float>::denorm_min() * (++tiny % 2 == 0 ? 1.0F : -3.0F);
  }
  ASSERT_EQ(tiny, 30);  // (5, 0, 0) and (3, 4, 0), in any order and sign
  StageContext context;
  const FieldCycle field = build_field(one_phase(grid, std::move(samples)), {}, context);
  const Errors errors = errors_in_band(field, 0, truth, 3.0);
  EXPECT_LT(errors.mean, 0.02);
  EXPECT_LT(errors.max, 0.1);
  EXPECT_EQ(errors.wrong_signs, 0);
}

TEST(BuildField, BadShapesAndOptionsAreRefused) {
  const Grid grid = lattice({-10, -10, -10}, {10, 10, 10}, 1.0);
  const auto ball = [](const Vec3& x) { return x.norm() - 6.0; };
  const ShapeCycle good = one_phase(grid, sampled(grid, ball));

  ShapeCycle empty_phase = good;
  empty_phase.level.phases.emplace_back(grid.count(), 1.0F);
  EXPECT_EQ(code_of(empty_phase), ErrorCode::InvalidInput);

  ShapeCycle full_phase = good;
  full_phase.level.phases.emplace_back(grid.count(), -1.0F);
  EXPECT_EQ(code_of(full_phase), ErrorCode::InvalidInput);

  ShapeCycle none = good;
  none.level.phases.clear();
  EXPECT_EQ(code_of(none), ErrorCode::InvalidInput);

  ShapeCycle short_phase = good;
  short_phase.level.phases[0].pop_back();
  EXPECT_EQ(code_of(short_phase), ErrorCode::InvalidInput);

  ShapeCycle not_a_number = good;
  not_a_number.level.phases[0][5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(code_of(not_a_number), ErrorCode::InvalidInput);

  ShapeCycle anisotropic = good;
  anisotropic.level.grid.mm_from_index.linear()(2, 2) = 3.0;
  EXPECT_EQ(code_of(anisotropic), ErrorCode::InvalidInput);

  FieldOptions tiny;
  tiny.voxel_mm = 0.1;
  EXPECT_EQ(code_of(good, tiny), ErrorCode::Usage);
  FieldOptions narrow;
  narrow.voxel_mm = 4;
  narrow.outer_mm = 3;
  EXPECT_EQ(code_of(good, narrow), ErrorCode::Usage);
}

TEST(BuildField, TakesItsSamplesFromTheLatticeOfTheShape) {
  const auto made_on = [](double lattice_mm, const FieldOptions& options) {
    const Grid grid = lattice({-14, -14, -14}, {14, 14, 14}, lattice_mm);
    StageContext context;
    return build_field(one_phase(grid, sampled(grid, [](const Vec3& x) { return x.norm() - 6.0; })),
                       options, context)
        .voxel_mm;
  };
  EXPECT_EQ(made_on(0.5, {}), 1.5);
  EXPECT_EQ(made_on(1, {}), 1.5);
  EXPECT_DOUBLE_EQ(made_on(4.0 / 3, {}), 2);
  FieldOptions told;
  told.voxel_mm = 1;
  EXPECT_EQ(made_on(4.0 / 3, told), 1);
}

TEST(BuildField, StopsOnRequest) {
  const Grid grid = lattice({-10, -10, -10}, {10, 10, 10}, 1.0);
  const std::atomic<bool> stop{true};
  StageContext context;
  context.cancel = &stop;
  EXPECT_THROW((void)build_field(
                   one_phase(grid, sampled(grid, [](const Vec3& x) { return x.norm() - 6.0; })), {},
                   context),
               Error);
}

}  // namespace
}  // namespace beatlas::field
