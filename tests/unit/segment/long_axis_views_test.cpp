/// The LV's ends from long-axis views, on a phantom whose base plane and apex are known in closed
/// form.
#include "pipeline/segment/long_axis_views.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/phantom/heart_shape.h"
#include "pipeline/phantom/render.h"
#include "pipeline/segment/segment.h"
#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

constexpr int kPhases = 10;
constexpr double kGapMm = 16;
constexpr double kThicknessMm = 6;
constexpr double kViewPixelMm = 1.6;
constexpr double kBlood = 1000;
constexpr double kMuscle = 280;
constexpr double kLung = 40;
constexpr double kFat = 1290;

/// Slices far apart, as short-axis stacks of a quick exam are; the middle one at heart height 0.
phantom::PhantomSpec stack_spec() {
  phantom::PhantomSpec spec = phantom::preset("clinical");
  spec.phases = kPhases;
  spec.grid = phantom::on_matrix(spec.grid, {136, 136, 8}, {2.0, 2.0, kGapMm});
  spec.scanner.slice_thickness_mm = kThicknessMm;
  return spec;
}

/// One slice through the LV's axis, turned about it, 6 mm thick: blood, muscle and lung.
Cine view(const phantom::Phantom& phantom, double turn_deg) {
  const Affine lps = phantom::lps_from_heart(phantom.spec().anatomy);
  const double turn = turn_deg * std::numbers::pi / 180;
  const Vec3 across = lps.linear() * Vec3(std::cos(turn), std::sin(turn), 0);
  const Vec3 up = lps.linear() * Vec3(0, 0, 1);
  Cine out;
  out.rr_interval_s = phantom.spec().rr_interval_s;
  Grid& grid = out.images.grid;
  grid.size = {100, 112, 1};
  grid.mm_from_index.linear().col(0) = kViewPixelMm * across;
  grid.mm_from_index.linear().col(1) = kViewPixelMm * up;
  grid.mm_from_index.linear().col(2) = kThicknessMm * across.cross(up);
  grid.mm_from_index.translation() = lps * Vec3(0, 0, 0) - kViewPixelMm * (50 * across + 56 * up);
  out.images.phases.assign(kPhases, std::vector<float>(grid.count()));
  parallel_for(kPhases, [&](std::size_t p) {
    const auto frame = phantom.frame(phantom.phase_time_s(static_cast<int>(p)));
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        for (const double k : {-1.0 / 3, 0.0, 1.0 / 3}) {
          const Vec3 at = grid.mm(i, j, k);
          const auto in = [&](auto part) { return frame->contains(part, at); };
          const bool blood = in(Structure::LvBlood) || in(Structure::RvBlood) ||
                             in(phantom::Part::LaBlood) || in(phantom::Part::RaBlood) ||
                             in(phantom::Part::Aorta);
          const double signal = in(phantom::Part::PapillaryMuscles) ? kMuscle
                                : blood                             ? kBlood
                                : in(Structure::Heart)              ? kMuscle
                                : in(phantom::Part::Pericardium)    ? kFat
                                                                    : kLung;
          out.images.phases[p][grid.offset(i, j, 0)] += static_cast<float>(signal / 3);
        }
      }
    }
  });
  made::add_noise(out.images, 0.05 * kBlood, static_cast<unsigned>(turn_deg) + 1);
  return out;
}

struct Made {
  Made() : spec(stack_spec()), phantom(spec) {
    StageContext context;
    phantom::Rendering rendering = phantom::render(phantom, context);
    exam.stack = std::move(rendering.cine);
    truth = std::move(rendering.labels);
    for (const double turn : {0.0, 60.0, 120.0}) exam.views.push_back(view(phantom, turn));
  }
  /// Slice index of a height in the heart's frame, on the LV's axis.
  [[nodiscard]] double slice_of(double heart_mm) const {
    const Affine lps = phantom::lps_from_heart(spec.anatomy);
    return (truth.grid.mm_from_index.inverse(Eigen::Affine) * (lps * Vec3(0, 0, heart_mm)))[2];
  }
  phantom::PhantomSpec spec;
  phantom::Phantom phantom;
  Exam exam;
  LabelCycle truth;
};

const Made& made() {
  static const Made instance;
  return instance;
}

ViewSearch search_of(const std::vector<Cine>& views) {
  ViewSearch search{views, made().truth, {}, 1, 0};
  for (int k = 0; k < made().truth.grid.size[2]; ++k) {
    const auto* slice = made().truth.phases[0].data() + made().truth.grid.offset(0, 0, k);
    const auto* end = slice + made().truth.grid.slice_count();
    if (std::find(slice, end, kLabelLvBlood) != end) search.lv_slices.push_back(k);
  }
  return search;
}

TEST(LongAxisViews, tell_the_base_to_three_millimetres_and_the_apex_to_four) {
  std::string trouble;
  const auto found = find_lv_ends_in_views(search_of(made().exam.views), trouble);
  ASSERT_TRUE(found) << trouble;
  EXPECT_EQ(found->views, 3);
  ASSERT_EQ(found->apex_k.size(), static_cast<std::size_t>(kPhases));
  for (int p = 0; p < kPhases; ++p) {
    const auto at = static_cast<std::size_t>(p);
    const phantom::HeartShape& shape =
        made().phantom.frame(made().phantom.phase_time_s(p))->shape();
    EXPECT_NEAR((found->base_k[at] - made().slice_of(shape.lv_base_z_mm)) * kGapMm, 0, 3) << p;
    const double apex = shape.lv_cavity.centre_mm.z() - shape.lv_cavity.semi_axes_mm.z();
    EXPECT_NEAR((found->apex_k[at] - made().slice_of(apex)) * kGapMm, 0, 4) << p;
  }
}

TEST(LongAxisViews, place_the_base_of_a_stack_of_distant_slices) {
  StageContext context;
  const Segmentation result = segment_exam(made().exam, {}, {}, context);
  const auto cut = result.base_cuts.find(Structure::LvBlood);
  ASSERT_NE(cut, result.base_cuts.end());
  for (int p = 0; p < kPhases; ++p) {
    const auto frame = made().phantom.frame(made().phantom.phase_time_s(p));
    const double base = made().slice_of(frame->shape().lv_base_z_mm);
    EXPECT_NEAR((cut->second.k[static_cast<std::size_t>(p)] - base) * kGapMm, 0, 3) << p;
  }
}

TEST(LongAxisViews, that_show_no_ventricle_leave_the_rule_and_say_so) {
  std::string trouble;
  std::vector<Cine> views = made().exam.views;
  for (Cine& view : views) {
    // The base's side is noise: walls end anywhere.
    Grid& grid = view.images.grid;
    const std::size_t from = grid.offset(0, grid.size[1] * 2 / 5, 0);
    unsigned state = 1;
    for (std::vector<float>& image : view.images.phases) {
      for (std::size_t v = from; v < image.size(); ++v) {
        state = state * 1664525U + 1013904223U;
        image[v] = static_cast<float>(state >> 22);
      }
    }
  }
  EXPECT_FALSE(find_lv_ends_in_views(search_of(views), trouble));
  EXPECT_NE(trouble.find("by rule"), std::string::npos);
}

TEST(LongAxisViews, beside_the_heart_tell_nothing) {
  std::string trouble = "none yet";
  std::vector<Cine> views = made().exam.views;
  for (Cine& view : views) {
    Grid& grid = view.images.grid;
    grid.mm_from_index.translation() += 40 * grid.mm_from_index.linear().col(2).normalized();
  }
  EXPECT_FALSE(find_lv_ends_in_views(search_of(views), trouble));
  EXPECT_EQ(trouble, "");
}

}  // namespace
}  // namespace beatlas::segment
