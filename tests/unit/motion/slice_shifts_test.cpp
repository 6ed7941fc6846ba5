#include "pipeline/motion/slice_shifts.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/phantom/acquisition.h"
#include "pipeline/phantom/render.h"
#include "runtime/base/error.h"

namespace beatlas::motion {
namespace {

struct Case {
  ImageCycle<float> images;
  std::vector<Vec2> truth;
};

/// The phantom `small` with three of its phases.
Case imaged(double sigma_mm, const Vec3& oblique_deg = Vec3::Zero(), int seed = 1) {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.phases = 3;
  spec.oblique_deg = oblique_deg;
  spec.scanner.shift_sigma_mm = sigma_mm;
  spec.scanner.shift_seed = seed;
  spec.scanner.bias_share = 0.3;
  Case out;
  StageContext context;
  out.images = phantom::render(phantom::Phantom(spec), context).cine.images;
  for (const phantom::SliceAcquisition& slice : phantom::acquisition(spec)) {
    out.truth.emplace_back(slice.shift_i_mm, slice.shift_j_mm);
  }
  return out;
}

/// Root mean square of what is left along both axes, beside what cannot be seen: the even trend.
double left_mm(const std::vector<Vec2>& found, const std::vector<Vec2>& truth) {
  const auto n = static_cast<double>(truth.size());
  double squares = 0;
  for (int axis = 0; axis < 2; ++axis) {
    double sum = 0;
    double moment = 0;
    double spread = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      const double x = static_cast<double>(k) - (n - 1) / 2;
      const double off = found[k][axis] - truth[k][axis];
      sum += off;
      moment += x * off;
      spread += x * x;
    }
    for (std::size_t k = 0; k < truth.size(); ++k) {
      const double x = static_cast<double>(k) - (n - 1) / 2;
      const double off = found[k][axis] - truth[k][axis] - sum / n - x * moment / spread;
      squares += off * off;
    }
  }
  return std::sqrt(squares / (2 * n));
}

class ShiftsOf : public testing::TestWithParam<Vec3> {};

TEST_P(ShiftsOf, SlicesAreFoundButForAnEvenTrend) {
  const Case shifted = imaged(2.0, GetParam());
  const SliceShifts found = find_slice_shifts(shifted.images);
  EXPECT_TRUE(found.certain());
  EXPECT_NEAR(found.size_mm, 2.0, 0.5);  // of 88 draws, clipped at 5 mm
  // A quarter of a pixel; the shifts themselves are of a whole one.
  EXPECT_LT(left_mm(found.shift_mm, shifted.truth), 0.5);
}

TEST_P(ShiftsOf, AStillStackAreNone) {
  const SliceShifts found = find_slice_shifts(imaged(0, GetParam()).images);
  EXPECT_FALSE(found.certain());
  EXPECT_LT(found.size_mm, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Directions, ShiftsOf, testing::Values(Vec3(0, 0, 0), Vec3(25, -20, 40)));

TEST(SliceShifts, DoNotDependOnTheNumberOfThreads) {
  const Case shifted = imaged(2.0);
  set_thread_count(1);
  const SliceShifts one = find_slice_shifts(shifted.images);
  set_thread_count(3);
  const SliceShifts three = find_slice_shifts(shifted.images);
  set_thread_count(0);
  for (std::size_t k = 0; k < one.shift_mm.size(); ++k) {
    EXPECT_EQ(one.shift_mm[k], three.shift_mm[k]);
  }
}

/// Fills a slice of all phases.
template <class Value>
void fill_slice(ImageCycle<float>& images, int k, Value value) {
  const auto from = static_cast<std::ptrdiff_t>(images.grid.offset(0, 0, k));
  const auto count = static_cast<std::ptrdiff_t>(images.grid.slice_count());
  for (std::vector<float>& phase : images.phases) {
    std::generate_n(phase.begin() + from, count, value);
  }
}

TEST(SliceShifts, AreNotFeignedBySlicesThatShowNothing) {
  const Case still = imaged(0);
  const int last = still.images.grid.size[2] - 1;
  ImageCycle<float> padded = still.images;
  fill_slice(padded, 0, [] { return 0.0F; });
  fill_slice(padded, last / 2, [] { return 100.0F; });
  std::mt19937 random(5);
  std::normal_distribution<float> noise(100, 40);
  fill_slice(padded, last, [&] { return noise(random); });
  const SliceShifts found = find_slice_shifts(padded);
  EXPECT_FALSE(found.certain());
  EXPECT_LT(found.size_mm, 0.1);
}

TEST(SliceShifts, AreFoundBesideASliceThatShowsNothing) {
  Case shifted = imaged(2.0);
  const auto middle = static_cast<std::size_t>(shifted.images.grid.size[2] / 2);
  fill_slice(shifted.images, static_cast<int>(middle), [] { return 0.0F; });
  const SliceShifts found = find_slice_shifts(shifted.images);
  EXPECT_TRUE(found.certain());
  EXPECT_EQ(found.shift_mm[middle], Vec2(0, 0));
}

TEST(SliceShifts, OfFewOrEmptySlicesAreNone) {
  for (const int slices : {1, 4, 6}) {
    ImageCycle<float> images;
    images.grid.size = {20, 24, slices};
    images.phases.assign(2, std::vector<float>(images.grid.count(), 7.0F));
    const SliceShifts found = find_slice_shifts(images);
    EXPECT_EQ(found.shift_mm.size(), static_cast<std::size_t>(slices));
    EXPECT_FALSE(found.certain());
  }
}

TEST(SliceShifts, OfCoarsePixelsAreNone) {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.phases = 3;
  spec.oblique_deg = Vec3(12, -7, 20);
  StageContext context;
  for (const int width : {32, 48, 64}) {
    phantom::PhantomSpec coarse = spec;
    coarse.grid = phantom::on_matrix(spec.grid, {width, width, 11}, Vec3::Zero());
    const auto images = phantom::render(phantom::Phantom(coarse), context).cine.images;
    EXPECT_FALSE(find_slice_shifts(images).certain()) << width;
  }
}

TEST(WithoutShifts, MovesAWaveBack) {
  ImageCycle<float> images;
  images.grid.size = {60, 50, 2};
  images.grid.mm_from_index.linear() = Vec3(1.5, 2, 8).asDiagonal();
  const Vec2 shift(2.2, -1.3);
  const auto wave = [](double x, double y) {
    return static_cast<float>(100 * std::sin(x / 4) * std::cos(y / 5));
  };
  std::vector<float> still;
  std::vector<float> moved;
  for (int k = 0; k < 2; ++k) {
    for (int j = 0; j < 50; ++j) {
      for (int i = 0; i < 60; ++i) {
        const double x = 1.5 * i;
        const double y = 2.0 * j;
        still.push_back(wave(x, y));
        moved.push_back(k == 0 ? wave(x, y) : wave(x - shift[0], y - shift[1]));
      }
    }
  }
  images.phases = {moved};
  const ImageCycle<float> back = without_shifts(images, {Vec2::Zero(), shift});
  for (int k = 0; k < 2; ++k) {
    for (int j = 4; j < 46; ++j) {
      for (int i = 5; i < 55; ++i) {
        const std::size_t v = images.grid.offset(i, j, k);
        // Waves of 17 and 16 pixels: within a hundredth of their height.
        ASSERT_NEAR(back.phases[0][v], still[v], k == 0 ? 0 : 1.0);
      }
    }
  }
  EXPECT_THROW((void)without_shifts(images, {shift}), Error);
}

TEST(WithAlignedSlices, KeepsAndTellsWhatItUndid) {
  Exam exam;
  const Case shifted = imaged(2.0);
  exam.stack.images = shifted.images;
  const Exam left = with_aligned_slices(exam, {AlignOptions::Slices::Off});
  EXPECT_EQ(left.stack.images.phases, exam.stack.images.phases);
  EXPECT_TRUE(left.slice_shifts_mm.empty());

  const Exam aligned = with_aligned_slices(exam, {});
  EXPECT_EQ(aligned.slice_shifts_mm.size(), shifted.truth.size());
  ASSERT_EQ(aligned.decisions.size(), 1U);
  EXPECT_NE(aligned.decisions[0].find("moved back"), std::string::npos);
  // Slices count from 0, here as in all that is told of them.
  const auto most = std::max_element(
      aligned.slice_shifts_mm.begin(), aligned.slice_shifts_mm.end(),
      [](const Vec2& a, const Vec2& b) { return a.squaredNorm() < b.squaredNorm(); });
  const auto slice = std::to_string(most - aligned.slice_shifts_mm.begin());
  EXPECT_NE(aligned.decisions[0].find("most slice " + slice + ","), std::string::npos)
      << aligned.decisions[0];
  EXPECT_FALSE(find_slice_shifts(aligned.stack.images).certain());

  const Exam still = with_aligned_slices(aligned, {});
  EXPECT_EQ(still.stack.images.phases, aligned.stack.images.phases);
}

}  // namespace
}  // namespace beatlas::motion
