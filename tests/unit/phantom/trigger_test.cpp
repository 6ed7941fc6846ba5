#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/phantom/truth.h"
#include "runtime/base/json_text.h"
#include "tests/unit/phantom/scanner_images.h"

namespace beatlas::phantom {
namespace {

/// Voxels of a slice that do not show the mean of the given moments, and those that would show
/// something else at the nominal time.
struct Compared {
  int wrong = 0;
  int moved = 0;
};

Compared compare(const Phantom& phantom, const std::vector<float>& image, int slice,
                 const std::vector<double>& moments_s, double nominal_s) {
  const Grid grid = phantom.spec().imaging_grid();
  const test::PointSignal signal(phantom);
  Compared out;
  for (int j = 0; j < grid.size[1]; ++j) {
    for (int i = 0; i < grid.size[0]; ++i) {
      double mean = 0.0;
      for (double t : moments_s) {
        mean += signal.at(grid.mm(i, j, slice), t) / static_cast<double>(moments_s.size());
      }
      out.wrong += std::abs(image[grid.offset(i, j, slice)] - mean) > 0.51;
      out.moved += std::abs(signal.at(grid.mm(i, j, slice), nominal_s) - mean) > 1.0;
    }
  }
  return out;
}

TEST(PhantomTrigger, JitteredFramesShowTheHeartAtTheirRealTime) {
  PhantomSpec spec = test::of_centres();
  spec.scanner.jitter_sigma_s = 0.02;
  const Phantom phantom(spec);
  const auto images = test::images_of(spec);
  const auto slices = acquisition(spec);
  Compared all;
  for (int k = 3; k < 15; k += 2) {
    for (int p = 0; p < spec.phases; ++p) {
      const double t = phantom.phase_time_s(p);
      const Compared one = compare(phantom, images[p], k, {t + slices[k].offset_s[p]}, t);
      all.wrong += one.wrong;
      all.moved += one.moved;
    }
  }
  EXPECT_EQ(all.wrong, 0);
  EXPECT_GT(all.moved, 50) << "the jitter must show";
}

TEST(PhantomTrigger, JitterHasItsDeviationAndWholeMilliseconds) {
  PhantomSpec spec = test::coarse();
  spec.grid.size[2] = 200;
  spec.phases = 50;
  spec.scanner.jitter_sigma_s = 0.01;
  double sum = 0;
  double squares = 0;
  double n = 0;
  for (const auto& slice : acquisition(spec)) {
    for (double offset : slice.offset_s) {
      EXPECT_NEAR(offset, std::round(offset * 1e3) * 1e-3, 1e-15);
      EXPECT_LE(std::abs(offset), 0.0405);
      ++n;
      sum += offset;
      squares += offset * offset;
    }
  }
  // Five standard errors, and 0.3 ms of rounding in the deviation: negligible.
  EXPECT_NEAR(sum / n, 0.0, 5 * 0.01 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), 0.01, 5 * 0.01 / std::sqrt(2 * n) + 1e-5);
}

TEST(PhantomTrigger, AWindowShowsTheMeanOfItsMoments) {
  PhantomSpec spec = test::of_centres();
  spec.scanner.gating_window_s = 0.1;
  const Phantom phantom(spec);
  const auto images = test::images_of(spec);
  for (int p : {1, 3}) {
    const double t = phantom.phase_time_s(p);
    const Compared one =
        compare(phantom, images[p], 9, {t - 0.04, t - 0.02, t, t + 0.02, t + 0.04}, t);
    EXPECT_EQ(one.wrong, 0);
    EXPECT_GT(one.moved, 10);
  }
  spec.scanner.gating_subphases = 2;
  const auto two = test::images_of(spec);
  const double t = phantom.phase_time_s(1);
  EXPECT_EQ(compare(phantom, two[1], 9, {t - 0.025, t + 0.025}, t).wrong, 0);
}

TEST(PhantomTrigger, SharesOfAWindowAreTheMeanOfTheSharesOfItsMoments) {
  PhantomSpec spec = test::coarse();
  spec.scanner.mistriggered_slices = spec.grid.size[2];
  std::vector<std::vector<float>> mean;
  for (double offset : {-0.02, -0.01, 0.0, 0.01, 0.02}) {
    spec.scanner.mistrigger_s = offset;
    const auto images = test::images_of(spec);
    mean.resize(images.size(), std::vector<float>(images[0].size(), 0.0F));
    for (std::size_t p = 0; p < images.size(); ++p) {
      for (std::size_t v = 0; v < images[p].size(); ++v) mean[p][v] += images[p][v] / 5.0F;
    }
  }
  spec.scanner.mistriggered_slices = 0;
  spec.scanner.gating_window_s = 0.05;
  const auto images = test::images_of(spec);
  double worst = 0.0;
  for (std::size_t p = 0; p < images.size(); ++p) {
    for (std::size_t v = 0; v < images[p].size(); ++v) {
      worst = std::max(worst, std::abs(static_cast<double>(images[p][v]) - mean[p][v]));
    }
  }
  EXPECT_LE(worst, 1.001);  // each of the images is rounded
}

TEST(PhantomTrigger, MistriggeredSlicesAreAsManyAsWantedAndLate) {
  PhantomSpec spec = test::of_centres();
  const auto in_time = test::images_of(spec);
  spec.scanner.mistriggered_slices = 7;
  const auto late = test::images_of(spec);
  const Phantom phantom(spec);
  const auto slices = acquisition(spec);
  const Grid grid = spec.imaging_grid();
  int count = 0;
  Compared all;
  for (int k = 0; k < grid.size[2]; ++k) {
    count += slices[k].mistriggered;
    for (int p = 0; p < spec.phases; ++p) {
      const auto slice = [&](const auto& images) {
        const auto first = images[p].begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, k));
        return std::vector<float>(first, first + static_cast<std::ptrdiff_t>(grid.slice_count()));
      };
      EXPECT_EQ(slices[k].offset_s[p], slices[k].mistriggered ? 0.020 : 0.0);
      if (!slices[k].mistriggered) {
        EXPECT_EQ(slice(late), slice(in_time));
        continue;
      }
      const double t = phantom.phase_time_s(p);
      const Compared one = compare(phantom, late[p], k, {t + 0.020}, t);
      all.wrong += one.wrong;
      all.moved += one.moved;
    }
  }
  EXPECT_EQ(count, 7);
  EXPECT_EQ(all.wrong, 0);
  EXPECT_GT(all.moved, 20);
}

TEST(PhantomTrigger, TruthTellsWhatWasRealisedAndStaysUndegraded) {
  PhantomSpec spec = test::coarse();
  const Phantom still(spec);
  spec.scanner.jitter_sigma_s = 0.01;
  spec.scanner.shift_sigma_mm = 2.0;
  spec.scanner.mistriggered_slices = 3;
  const Phantom phantom(spec);
  const nlohmann::json truth = parse_json(json_text(truth_json(phantom)));
  const auto slices = acquisition(spec);
  const nlohmann::json& told = truth.at("acquisition").at("slices");
  ASSERT_EQ(told.size(), slices.size());
  for (std::size_t k = 0; k < slices.size(); ++k) {
    EXPECT_EQ(told[k]["shift_mm"][0].get<double>(), slices[k].shift_i_mm);
    EXPECT_EQ(told[k]["shift_mm"][1].get<double>(), slices[k].shift_j_mm);
    EXPECT_EQ(told[k]["mistriggered"].get<bool>(), slices[k].mistriggered);
    EXPECT_EQ(told[k]["offset_s"].get<std::vector<double>>(), slices[k].offset_s);
  }
  EXPECT_EQ(truth["structures"], truth_json(still)["structures"]);
  StageContext context;
  EXPECT_EQ(render(phantom, context).labels.phases, render(still, context).labels.phases);
  EXPECT_EQ(phantom_from_truth(truth).identity(), phantom.identity());
}

}  // namespace
}  // namespace beatlas::phantom
