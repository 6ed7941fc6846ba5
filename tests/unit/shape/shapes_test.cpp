#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/core/segmented_volume.h"
#include "pipeline/shape/workspace.h"
#include "tests/unit/shape/made_shapes.h"

namespace beatlas::shape {
namespace {

constexpr double kRadius = 25;
const Vec3 kMiddle(12, -30, 45);

const ShapeCycle& shape_of(const std::vector<ShapeCycle>& shapes, Structure structure) {
  for (const ShapeCycle& shape : shapes) {
    if (shape.structure == structure) return shape;
  }
  throw std::runtime_error("no such shape");
}

std::vector<ShapeCycle> shapes_of(const Segmentation& segmentation, const Affine& map) {
  StageContext context;
  return shapes_in_workspace(segmentation, map, {}, context);
}

struct SurfaceError {
  double mean = 0;
  double rms = 0;
  double largest = 0;
};

/// Surface of a shape against a ball, along 400 directions evenly spread (Fibonacci), or those of
/// them that are within an angle of the slices' plane.
SurfaceError against_ball(const ShapeCycle& shape, const Vec3& centre, double radius,
                          double most_sine = 1) {
  SurfaceError error;
  constexpr int kAll = 400;
  const auto sine = [](int n) { return 1 - (2 * n + 1.0) / kAll; };
  int rays = 0;
  for (int n = 0; n < kAll; ++n) rays += std::abs(sine(n)) <= most_sine;
  for (int n = 0; n < kAll; ++n) {
    const double z = sine(n);
    if (std::abs(z) > most_sine) continue;
    const double angle = n * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    const Vec3 direction(r * std::cos(angle), r * std::sin(angle), z);
    const double off =
        made::surface_along(shape, 0, centre, direction, 0.6 * radius, 1.35 * radius) - radius;
    error.mean += off / rays;
    error.rms += off * off / rays;
    error.largest = std::max(error.largest, std::abs(off));
  }
  error.rms = std::sqrt(error.rms);
  return error;
}

Segmentation ball(const Grid& grid, double radius = kRadius) {
  Segmentation segmentation = made::segmentation_of(grid, 1);
  segmentation.coverage.phases[Structure::Heart] = {made::ball_coverage(grid, kMiddle, radius)};
  return segmentation;
}

TEST(Shape, OfABallsExactCoverageOnThinSlicesIsTheBall) {
  const Segmentation segmentation = ball(made::oblique_grid({76, 76, 28}, {1, 1, 3}, kMiddle));
  const Affine map = workspace_from_lps(segmentation.labels.grid, segmentation.coverage);
  const auto shapes = shapes_of(segmentation, map);
  ASSERT_EQ(shapes.size(), 1U);
  const SurfaceError error = against_ball(shapes[0], map * kMiddle, kRadius);
  // Smoothing of fourth order takes about s^4 / R^3 = 0.0025 mm off a sphere.
  EXPECT_LT(std::abs(error.mean), 0.02);
  EXPECT_LT(error.rms, 0.01);
  EXPECT_LT(error.largest, 0.03);
  EXPECT_NEAR(made::volume_ml(shapes[0], 0) / made::ball_ml(kRadius), 1, 0.003);
  std::cout << "thin: mean " << error.mean << " rms " << error.rms << " max " << error.largest
            << " volume " << made::volume_ml(shapes[0], 0) / made::ball_ml(kRadius) << "\n";
}

TEST(Shape, OfABallsExactCoverageOnThickSlicesIsNearTheBall) {
  const Segmentation segmentation = ball(made::oblique_grid({64, 64, 9}, {1.4, 1.4, 10}, kMiddle));
  const Affine map = workspace_from_lps(segmentation.labels.grid, segmentation.coverage);
  const auto shapes = shapes_of(segmentation, map);
  const SurfaceError error = against_ball(shapes[0], map * kMiddle, kRadius);
  // Along the slices nothing is lost, neither between them nor within, where lines and means would
  // lose h^2 / (12 R) + h^2 / (24 R) = 0.5 mm.
  const SurfaceError sides = against_ball(shapes[0], map * kMiddle, kRadius, 0.6);
  EXPECT_LT(std::abs(sides.mean), 0.08);
  EXPECT_LT(sides.rms, 0.35);  // beside the last slices, where there are not four, lines remain
  // Of the caps half a gap of 5 mm is all that is known.
  EXPECT_NEAR(error.mean, 0, 0.25);
  EXPECT_LT(error.rms, 0.5);
  EXPECT_LT(error.largest, 1.5);
  EXPECT_NEAR(made::volume_ml(shapes[0], 0) / made::ball_ml(kRadius), 1, 0.03);
  std::cout << "thick: sides " << sides.mean << " rms " << sides.rms << " whole mean " << error.mean
            << " rms " << error.rms << " max " << error.largest << " volume "
            << made::volume_ml(shapes[0], 0) / made::ball_ml(kRadius) << "\n";
}

/// Slices twenty pixels apart.
TEST(Shape, OfVoxelsTwentyTimesAsLongAsWideIsNearTheBall) {
  const Segmentation segmentation =
      ball(made::oblique_grid({150, 150, 9}, {0.5, 0.5, 10}, kMiddle));
  const Affine map = workspace_from_lps(segmentation.labels.grid, segmentation.coverage);
  const auto shapes = shapes_of(segmentation, map);
  const SurfaceError error = against_ball(shapes[0], map * kMiddle, kRadius);
  EXPECT_LT(std::abs(against_ball(shapes[0], map * kMiddle, kRadius, 0.6).mean), 0.08);
  EXPECT_NEAR(error.mean, 0, 0.25);
  EXPECT_LT(error.rms, 0.5);
  EXPECT_NEAR(made::volume_ml(shapes[0], 0) / made::ball_ml(kRadius), 1, 0.03);
}

TEST(Shape, LatticeIsIsotropicAndLeavesTheMarginAroundTheStructure) {
  const Segmentation segmentation = ball(made::straight_grid({70, 30, 24}, {1, 1, 3}), 12);
  StageContext context;
  Segmentation moved = segmentation;
  moved.coverage.phases[Structure::Heart] = {
      made::ball_coverage(segmentation.coverage.grid, {30, 15, 36}, 12)};
  const Affine map = workspace_from_lps(moved.labels.grid, moved.coverage);
  RegisterOptions options;
  options.shape_mm = 1.5;
  options.margin_mm = 9;
  const auto shapes = shapes_in_workspace(moved, map, options, context);
  const Grid& lattice = shapes[0].level.grid;
  EXPECT_LT((lattice.spacing_mm() - Vec3::Constant(1.5)).norm(), 1e-12);
  const Vec3 low = lattice.mm(0, 0, 0);
  const Vec3 high = lattice.mm(lattice.size[0] - 1, lattice.size[1] - 1, lattice.size[2] - 1);
  const Vec3 centre = map * Vec3(30, 15, 36);
  for (int a = 0; a < 3; ++a) {
    EXPECT_LE(low[a], centre[a] - 12 - 9 + 1.5);
    EXPECT_GE(high[a], centre[a] + 12 + 9 - 1.5);
    EXPECT_GE(low[a], centre[a] - 12 - 9 - 3 - 3);
  }
}

/// A ball that the stack cuts: its centre lies 8 mm from the stack's last voxel face.
TEST(Shape, EndsFlatHalfAGapBeyondTheStack) {
  struct Stack {
    Vec3 spacing;
    Index3 size;
  };
  for (const Stack& stack : {Stack{{1, 1, 3}, {70, 70, 14}}, Stack{{1.4, 1.4, 8}, {50, 50, 6}}}) {
    for (bool at_top : {true, false}) {
      const Grid grid = made::straight_grid(stack.size, stack.spacing);
      const double face_mm =
          at_top ? (stack.size[2] - 0.5) * stack.spacing[2] : -0.5 * stack.spacing[2];
      const Vec3 centre(34, 35, face_mm + (at_top ? -8 : 8));
      Segmentation segmentation = made::segmentation_of(grid, 1);
      segmentation.coverage.phases[Structure::Heart] = {made::ball_coverage(grid, centre, 20)};
      const Affine map = Affine::Identity();
      const auto shapes = shapes_of(segmentation, map);
      const Vec3 out = Vec3::UnitZ() * (at_top ? 1 : -1);
      for (const Vec3& off : {Vec3(0, 0, 0), Vec3(10, 0, 0), Vec3(-6, 9, 0)}) {
        // The plane is set exactly, after smoothing; the lattice interpolates it linearly.
        EXPECT_NEAR(made::surface_along(shapes[0], 0, centre + off, out, 0, 12), 8, 0.05)
            << stack.spacing[2] << " mm, " << off.transpose() << (at_top ? " top" : " bottom");
      }
    }
  }
}

// A stack whose last slice lies in the tip, wherever in it: cavity and muscle go through that
// slice, and no image shows how they close.
TEST(Shape, OfAVentricleIsClosedByMuscleBeyondTheLastSlice) {
  constexpr double kOuter = 30;
  constexpr double kInner = 25;
  for (const int step : {1, -1}) {
    for (const double beyond_mm : {0.5, 2.0, 3.5, 5.0, 7.0, 9.0}) {
      const Grid grid = made::straight_grid({56, 56, 8}, {1.4, 1.4, 10});
      const double last_mm = step > 0 ? 70 : 0;
      const Vec3 centre(38, 38, last_mm + step * (beyond_mm - kOuter));
      Segmentation segmentation = made::segmentation_of(grid, 1);
      const std::vector<float> filled = made::ball_coverage(grid, centre, kOuter);
      const std::vector<float> blood = made::ball_coverage(grid, centre, kInner);
      std::vector<float> muscle = filled;
      std::transform(filled.begin(), filled.end(), blood.begin(), muscle.begin(), std::minus<>());
      segmentation.coverage.phases[Structure::Heart] = {filled};
      segmentation.coverage.phases[Structure::LvBlood] = {blood};
      segmentation.coverage.phases[Structure::LvMyocardium] = {muscle};
      const ValvePlane base{-step, {centre[2] / 10}};
      segmentation.valve_planes[Structure::LvBlood] = base;
      segmentation.valve_planes[Structure::LvMyocardium] = base;
      const auto shapes = shapes_of(segmentation, Affine::Identity());
      const Vec3 apex = Vec3::UnitZ() * step;
      const auto end = [&](Structure structure, double from) {
        return from + made::surface_along(shape_of(shapes, structure), 0, centre + from * apex,
                                          apex, 0, 36 - from);
      };
      const double cavity = end(Structure::LvBlood, 0);
      const double wall = end(Structure::LvMyocardium, cavity + 0.4);
      const double heart = end(Structure::Heart, 0);
      SCOPED_TRACE("step " + std::to_string(step) + ", " + std::to_string(beyond_mm) + " mm");
      EXPECT_GT(wall - cavity, 1.0);
      EXPECT_NEAR(heart, wall, 0.3);
      EXPECT_NEAR(wall, std::min(kOuter, kOuter - beyond_mm + 5), 2.5);
      // Half a gap is all that is known where the last slice does not show the cavity.
      EXPECT_NEAR(cavity, kInner, beyond_mm > kOuter - kInner ? 2.0 : 5.5);
    }
  }
}

/// Coverage of discs about the middle's line across the slices. @param radius_mm (slice); 0: none
template <class Radius>
std::vector<float> discs(const Grid& grid, const Vec3& middle, const Radius& radius_mm) {
  std::vector<float> out(grid.count(), 0.0F);
  const Vec3 spacing = grid.spacing_mm();
  for (int k = 0; k < grid.size[2]; ++k) {
    if (!(radius_mm(k) > 0)) continue;
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const double d = std::hypot(i * spacing[0] - middle[0], j * spacing[1] - middle[1]);
        out[grid.offset(i, j, k)] =
            static_cast<float>(std::clamp(0.5 - (d - radius_mm(k)) / spacing[0], 0.0, 1.0));
      }
    }
  }
  return out;
}

TEST(Shape, EndsFlatHalfAGapBeyondItsMostBasalSliceInEachPhase) {
  const Grid grid = made::straight_grid({56, 56, 8}, {1.4, 1.4, 8});
  for (int step : {1, -1}) {
    Segmentation segmentation = made::segmentation_of(grid, 2);
    const Vec3 centre(38, 38, 28);
    // A cylinder that a valve is thought to end elsewhere than half-way between two slices.
    const std::vector<double> planes{4.9, 3.6};
    for (const double plane : planes) {
      segmentation.coverage.phases[Structure::LvBlood].push_back(
          discs(grid, centre, [&](int k) { return step * (k - plane) < 0 ? 20.0 : 0.0; }));
    }
    segmentation.valve_planes[Structure::LvBlood] = {step, planes};
    const auto shapes = shapes_of(segmentation, Affine::Identity());
    const std::vector<double> volumes = segmented_volume_ml(segmentation, Structure::LvBlood);
    for (std::size_t p : {std::size_t{0}, std::size_t{1}}) {
      const double plane_mm = 8 * (p == 0 ? 4.5 : 3.5);
      const Vec3 from(centre[0] + 6, centre[1], step > 0 ? 8 : 48);
      const double found = made::surface_along(shapes[0], p, from, Vec3::UnitZ() * step, 0, 45);
      EXPECT_NEAR(from[2] + step * found, plane_mm, 0.05) << step << " phase " << p;
      // What is told as its volume: the disc's radius is off by less than 0.1 mm.
      EXPECT_NEAR(made::volume_ml(shapes[0], p) / volumes[p], 1, 0.02) << step << " phase " << p;
    }
  }
}

// What is left of a ventricle in a slice beyond its valve is no reason for all of it to end
// elsewhere than in the phases beside, where nothing is left; and it is no column of a slice.
TEST(Shape, EndsWhereItDoesWhetherOrNotAPartIsInOneMoreSlice) {
  constexpr double kGapMm = 12;
  const Grid grid = made::straight_grid({56, 56, 7}, {1.4, 1.4, kGapMm});
  const Vec3 middle(38, 38, 0);
  const Vec3 aside(50, 38, 0);  // of the part
  for (const int step : {1, -1}) {
    SCOPED_TRACE("base at slices " + std::to_string(step));
    const auto nth = [&](int k) { return step > 0 ? k : 6 - k; };  // counted from the apex
    Segmentation segmentation = made::segmentation_of(grid, 2);
    const std::vector<float> whole =
        discs(grid, middle, [&](int k) { return nth(k) <= 3 ? 22.0 : 0.0; });
    std::vector<float> with_part =
        discs(grid, aside, [&](int k) { return nth(k) == 4 ? 6.0 : 0.0; });
    std::transform(whole.begin(), whole.end(), with_part.begin(), with_part.begin(), std::plus<>());
    segmentation.coverage.phases[Structure::LvBlood] = {whole, with_part};
    const double plane = step > 0 ? 3.9 : 6 - 3.9;
    segmentation.valve_planes[Structure::LvBlood] = {step, {plane, plane}};
    const std::vector<double> volumes = segmented_volume_ml(segmentation, Structure::LvBlood);
    const auto shapes = shapes_of(segmentation, Affine::Identity());
    const auto end = [&](std::size_t p, const Vec3& from) {
      const Vec3 start(from[0], from[1], kGapMm * nth(2));
      return made::surface_along(shapes[0], p, start, Vec3::UnitZ() * step, 0, 40) / kGapMm + 2;
    };
    const Vec3 other(26, 38, 0);
    EXPECT_NEAR(end(0, other), 3.5, 0.01);
    EXPECT_NEAR(end(1, other), 3.5, 0.1);
    EXPECT_NEAR(end(0, aside), 3.5, 0.01);
    EXPECT_NEAR(end(1, aside), 4 + 6.0 * 6 / (22 * 22), 0.05);
    for (const std::size_t p : {std::size_t{0}, std::size_t{1}}) {
      EXPECT_NEAR(made::volume_ml(shapes[0], p) / volumes[p], 1, 0.04) << p;
    }
    EXPECT_NEAR(made::volume_ml(shapes[0], 1) / made::volume_ml(shapes[0], 0), 1, 0.04);
  }
}

// Discs of 8 mm radius, each 14 mm beside the one in the slice before, hardly lie over each other.
TEST(Shape, OfAThinLeaningBodyHangsTogetherBetweenThickSlices) {
  constexpr double kRadiusMm = 8;
  constexpr double kGapMm = 16;
  const Grid grid = made::straight_grid({76, 48, 5}, {1.4, 1.4, kGapMm});
  const auto middle_mm = [&](double k) { return 24.0 + 14 * k; };
  std::vector<float> leaning;
  for (int k = 0; k < 5; ++k) {
    for (int j = 0; j < 48; ++j) {
      for (int i = 0; i < 76; ++i) {
        const double d = std::hypot(i * 1.4 - middle_mm(k), j * 1.4 - 33) - kRadiusMm;
        leaning.push_back(static_cast<float>(std::clamp(0.5 - d / 1.4, 0.0, 1.0)));
      }
    }
  }
  Segmentation segmentation = made::segmentation_of(grid, 1);
  segmentation.coverage.phases[Structure::RvBlood] = {leaning};
  const auto shapes = shapes_of(segmentation, Affine::Identity());
  for (double k = 0.5; k < 4; k += 1) {
    const Vec3 middle(middle_mm(k), 33, kGapMm * k);
    EXPECT_LT(made::level_at(shapes[0], 0, middle), -5) << "slice " << k;  // in place: -1
    const double ahead = made::surface_along(shapes[0], 0, middle, Vec3::UnitX(), 0, 20);
    EXPECT_NEAR(ahead, kRadiusMm, 1) << "slice " << k;
  }
}

// A ventricle of 30 mm radius in slices 0 to 3, of which an outflow tract of 7 mm goes on to
// slice 6.
TEST(Shape, OfAPartWithoutACounterpartEndsFlatAndBendsNothing) {
  constexpr double kGapMm = 10;
  const Grid grid = made::straight_grid({60, 60, 7}, {1.5, 1.5, kGapMm});
  const Vec3 axis(44, 44, 0);
  const Vec3 tract = axis + Vec3(-20, 0, 0);
  std::vector<float> coverage;
  for (int k = 0; k < 7; ++k) {
    for (int j = 0; j < 60; ++j) {
      for (int i = 0; i < 60; ++i) {
        const Vec3 x(i * 1.5, j * 1.5, 0);
        const double d = k < 4 ? (x - axis).norm() - 30 : (x - tract).norm() - 7;
        coverage.push_back(static_cast<float>(std::clamp(0.5 - d / 1.5, 0.0, 1.0)));
      }
    }
  }
  Segmentation segmentation = made::segmentation_of(grid, 1);
  segmentation.coverage.phases[Structure::RvBlood] = {coverage};
  const auto shapes = shapes_of(segmentation, Affine::Identity());
  const auto end_above = [&](double off_mm) {
    return made::surface_along(shapes[0], 0, axis + Vec3(off_mm, 0, 25), Vec3::UnitZ(), 0, 30);
  };
  // Slice 3 lies 5 mm above where the search begins, half-way to the next one another 5.
  for (const double off_mm : {0.0, 10.0, 20.0}) EXPECT_NEAR(end_above(off_mm), 10, 1.5) << off_mm;
  for (const double height : {10.0, 20.0, 25.0, 30.0}) {
    const double radius =
        made::surface_along(shapes[0], 0, axis + Vec3(0, 0, height), Vec3::UnitX(), 10, 42);
    EXPECT_NEAR(radius, 30, 1) << height;
  }
  for (const double height : {40.0, 50.0}) {
    const double radius =
        made::surface_along(shapes[0], 0, tract + Vec3(0, 0, height), Vec3::UnitX(), 0, 15);
    EXPECT_NEAR(radius, 7, 1) << height;
  }
}

TEST(Shape, OfTheMyocardiumIsTheSpaceBetweenTwoFilledShapes) {
  for (const Vec3& spacing : {Vec3(1, 1, 3), Vec3(1.4, 1.4, 8)}) {
    const Grid grid =
        made::straight_grid({static_cast<int>(84 / spacing[0]), static_cast<int>(84 / spacing[1]),
                             static_cast<int>(90 / spacing[2])},
                            spacing);
    // Between slices: a section half-way up the wall shows both radii.
    const Vec3 centre(41, 42, 45);
    Segmentation segmentation = made::segmentation_of(grid, 1);
    const auto blood = made::ball_coverage(grid, centre, 22);
    auto muscle = made::ball_coverage(grid, centre, 31);
    for (std::size_t v = 0; v < muscle.size(); ++v) muscle[v] -= blood[v];
    segmentation.coverage.phases[Structure::LvBlood] = {blood};
    segmentation.coverage.phases[Structure::LvMyocardium] = {muscle};
    const auto shapes = shapes_of(segmentation, Affine::Identity());
    const ShapeCycle& wall = shape_of(shapes, Structure::LvMyocardium);
    EXPECT_GT(made::level_at(wall, 0, centre), 0);  // the cavity is no wall
    for (int n = 0; n < 16; ++n) {
      const double angle = 2 * std::numbers::pi * (n + 0.3) / 16;
      const Vec3 direction(std::cos(angle), std::sin(angle), 0);
      EXPECT_LT(made::level_at(wall, 0, centre + 26.5 * direction), 0);
      const double outer = made::surface_along(wall, 0, centre, direction, 26.5, 40);
      const double inner =
          26.5 - made::surface_along(wall, 0, centre + 26.5 * direction, -direction, 0, 20);
      // As for the ball: chord between slices, mean section of a slice, smoothing; 0.1 mm to spare.
      const double slack = 0.1 + spacing[2] * spacing[2] * (1.0 / 8 + 1.0 / 24) / 22 + 1.0 / 22;
      EXPECT_NEAR(outer, 31, slack) << spacing[2];
      EXPECT_NEAR(inner, 22, slack) << spacing[2];
    }
  }
}

// The ring ends a slice before the cavity does, which is narrower there: an outflow tract.
TEST(Shape, OfTheMyocardiumHasNoLidWhereTheCavityNarrowsTowardTheBase) {
  const Grid grid = made::straight_grid({56, 56, 8}, {1.4, 1.4, 10});
  constexpr double kOuterMm = 31;
  constexpr double kInnerMm = 23;
  constexpr double kTractMm = 12;
  const Vec3 middle(38, 38, 0);
  for (const int step : {1, -1}) {
    SCOPED_TRACE("base at slices " + std::to_string(step));
    const auto slice = [&](int n) { return step > 0 ? n : 7 - n; };  // counted from the apex
    Segmentation segmentation = made::segmentation_of(grid, 1);
    std::vector<float> blood(grid.count(), 0);
    std::vector<float> muscle(grid.count(), 0);
    for (int n = 0; n < 7; ++n) {
      for (int j = 0; j < 56; ++j) {
        for (int i = 0; i < 56; ++i) {
          const double r = std::hypot(i * 1.4 - middle[0], j * 1.4 - middle[1]);
          const auto disc = [&](double radius) {
            return static_cast<float>(std::clamp(0.5 - (r - radius) / 1.4, 0.0, 1.0));
          };
          const std::size_t at = grid.offset(i, j, slice(n));
          const bool tract = n == 6;
          blood[at] = n == 0 ? 0 : disc(tract ? kTractMm : kInnerMm);
          muscle[at] = tract ? 0 : disc(kOuterMm) - blood[at];
        }
      }
    }
    segmentation.coverage.phases[Structure::LvBlood] = {blood};
    segmentation.coverage.phases[Structure::LvMyocardium] = {muscle};
    segmentation.valve_planes[Structure::LvBlood] = {step, {step > 0 ? 6.5 : 0.5}};
    segmentation.valve_planes[Structure::LvMyocardium] = {step, {step > 0 ? 6.0 : 1.0}};
    const auto shapes = shapes_of(segmentation, Affine::Identity());
    const ShapeCycle& wall = shape_of(shapes, Structure::LvMyocardium);
    const auto at = [&](double radius, double from_apex) {
      const double k = step > 0 ? from_apex : 7 - from_apex;
      return made::level_at(wall, 0, middle + Vec3(radius, 0, 10 * k));
    };
    for (double n = 5; n < 6; n += 0.1) {
      for (const double radius : {0.0, 10.0, 14.0, 18.0, 21.0}) {
        EXPECT_GT(at(radius, n), 0) << "slice " << n << ", " << radius << " mm from the middle";
      }
    }
    EXPECT_LT(at(27, 5), -2);    // the wall itself, in its last slice
    EXPECT_LT(at(25, 5.2), -1);  // and beyond it, where it grows thin
    EXPECT_LT(at(10, 0.2), -1);  // muscle closes the apex
  }
}

/// A ball's shape ends at a place of its grid beside the middle, along an axis of the grid.
void expect_end(const Segmentation& of_ball, const Affine& map, const Vec3& end_lps, int axis) {
  const auto shapes = shapes_of(of_ball, map);
  const Grid& grid = of_ball.coverage.grid;
  const Vec3 along = (map.linear() * grid.mm_from_index.linear().col(axis)).normalized();
  const Vec3 middle = map * kMiddle;
  const double end_mm = (map * end_lps - middle).dot(along);
  ASSERT_LT(end_mm, 0.8 * kRadius);
  const auto level = [&](double mm) {
    return made::level_at(shapes[0], 0, middle + (end_mm + mm) * along);
  };
  EXPECT_LT(level(-2), 0);
  for (double mm = 1; mm < 10; mm += 1) EXPECT_GT(level(mm), 0) << mm;
}

TEST(Shape, EndsWhereTheCoverageOfThinSlicesEndsWithinIt) {
  const Grid grid = made::oblique_grid({76, 76, 28}, {1, 1, 3}, kMiddle);
  const Segmentation whole = ball(grid);
  Segmentation part = whole;
  part.coverage.first = {6, 5, 4};
  part.coverage.grid = grid.part(part.coverage.first, {65, 66, 14});
  part.coverage.phases[Structure::Heart] = {
      made::ball_coverage(part.coverage.grid, kMiddle, kRadius)};
  expect_end(part, workspace_from_lps(grid, whole.coverage), grid.mm(38, 38, 17.5), 2);
}

TEST(Shape, OfThickSlicesEndsWhereTheImageDoes) {
  const Grid cut = made::oblique_grid({76, 76, 9}, {1, 1, 8}, kMiddle).part({0, 0, 0}, {45, 76, 9});
  const Segmentation whole = ball(cut);
  expect_end(whole, workspace_from_lps(cut, whole.coverage), cut.mm(44.5, 38, 4), 0);
}

TEST(Shape, FollowsACoverageThatIsAPartOfTheStack) {
  const Grid grid = made::oblique_grid({76, 76, 28}, {1, 1, 3}, kMiddle);
  Segmentation part = ball(grid);
  const Segmentation whole = part;
  const Index3 first{6, 5, 4};
  part.coverage.first = first;
  part.coverage.grid = grid.part(first, {65, 66, 21});
  part.coverage.phases[Structure::Heart] = {
      made::ball_coverage(part.coverage.grid, kMiddle, kRadius)};
  const Affine map = workspace_from_lps(grid, whole.coverage);
  const auto a = shapes_of(whole, map);
  const auto b = shapes_of(part, map);
  ASSERT_EQ(a[0].level.grid.size, b[0].level.grid.size);
  for (std::size_t v = 0; v < a[0].level.phases[0].size(); ++v) {
    ASSERT_NEAR(a[0].level.phases[0][v], b[0].level.phases[0][v], 1e-5);
  }
}

TEST(Shape, IsTheSameOnOneThreadAndTwo) {
  Segmentation segmentation = ball(made::straight_grid({50, 50, 20}, {1, 1, 3}));
  auto& phases = segmentation.coverage.phases[Structure::Heart];
  phases = {made::ball_coverage(segmentation.coverage.grid, {25, 25, 30}, 15),
            made::ball_coverage(segmentation.coverage.grid, {25, 25, 30}, 13)};
  set_thread_count(1);
  const auto one = shapes_of(segmentation, Affine::Identity());
  set_thread_count(2);
  const auto two = shapes_of(segmentation, Affine::Identity());
  set_thread_count(0);
  EXPECT_EQ(one[0].level.phases, two[0].level.phases);
}

TEST(Shape, OfAStructureWithoutAVoxelIsRefusedByName) {
  Segmentation segmentation = ball(made::straight_grid({20, 20, 8}, {1, 1, 3}), 0.1);
  segmentation.coverage.phases.clear();
  segmentation.coverage.phases[Structure::RvBlood] = {
      std::vector<float>(segmentation.coverage.grid.count(), 0.3F)};
  try {
    (void)shapes_of(segmentation, Affine::Identity());
    FAIL() << "nothing was refused";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("rv_blood"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace beatlas::shape
