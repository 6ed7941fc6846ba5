/// Frames of noise among good ones.
#include "pipeline/motion/bad_frames.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "pipeline/phantom/render.h"
#include "tests/clinical_part.h"
#include "tests/made_images.h"

namespace beatlas::motion {
namespace {

constexpr int kBad = 3;

ImageCycle<float> clinical() {
  static const ImageCycle<float> made = [] {
    StageContext context;
    return phantom::render(phantom::Phantom(made::clinical_part()), context).cine.images;
  }();
  return made;
}

TEST(BadFrames, OfOneSliceAreDrawnStraightBetweenTheirNeighboursInTime) {
  ImageCycle<float> images = clinical();
  const ImageCycle<float> before{images.grid, images.phases};
  made::make_noise(images, kBad, 5, 5);
  const std::vector<BadFrame> bad = bad_frames(images);
  ASSERT_EQ(bad.size(), 1U);
  EXPECT_EQ(bad[0].k, 5);
  const ImageCycle<float> mended = without_bad_frames(images, bad);
  for (std::size_t v = 0; v < images.grid.count(); ++v) {
    const bool inside = v / images.grid.slice_count() == 5;
    const float wanted = inside ? 0.5F * (before.phases[kBad - 1][v] + before.phases[kBad + 1][v])
                                : before.phases[kBad][v];
    ASSERT_FLOAT_EQ(mended.phases[kBad][v], wanted) << v;
  }
  EXPECT_NE(told(bad, images.grid.size[2], images.phase_count()).at(0).find("phase 3 of slice 5"),
            std::string::npos);
}

void fill(ImageCycle<float>& images, std::size_t phase, int k) {
  const auto first = images.phases[phase].begin() + static_cast<long>(images.grid.offset(0, 0, k));
  std::fill(first, first + static_cast<long>(images.grid.slice_count()), 0.1F);
}

TEST(BadFrames, OfASliceThatWasFilledUpAreAllThatAreBlank) {
  ImageCycle<float> images = clinical();
  const auto n = static_cast<std::size_t>(images.phase_count());
  for (std::size_t p = n / 2; p < n; ++p) fill(images, p, 5);
  for (std::size_t p = 0; p < n; ++p) fill(images, p, 0);  // beyond which there is nothing
  const std::vector<BadFrame> bad = bad_frames(images);
  ASSERT_EQ(bad.size(), n - n / 2);
  for (std::size_t b = 0; b < bad.size(); ++b) {
    EXPECT_EQ(bad[b].k, 5);
    EXPECT_EQ(bad[b].phase, static_cast<int>(n / 2 + b));
  }
}

TEST(BadFrames, ASliceAmidTheStackThatShowsNothingAtAllIsDrawnFromThoseBesideIt) {
  ImageCycle<float> images = clinical();
  const auto n = static_cast<std::size_t>(images.phase_count());
  const ImageCycle<float> before{images.grid, images.phases};
  for (std::size_t p = 0; p < n; ++p) {
    fill(images, p, 4);
    fill(images, p, 5);
  }
  fill(images, kBad, 3);  // which is drawn from its own phases first
  const std::vector<BadFrame> bad = bad_frames(images);
  ASSERT_EQ(bad.size(), 2 * n + 1);
  const ImageCycle<float> mended = without_bad_frames(images, bad);
  const Grid& grid = images.grid;
  for (std::size_t p = 0; p < n; ++p) {
    for (std::size_t v = 0; v < grid.slice_count(); ++v) {
      const float below = mended.phases[p][grid.offset(0, 0, 3) + v];
      const float above = before.phases[p][grid.offset(0, 0, 6) + v];
      ASSERT_NEAR(mended.phases[p][grid.offset(0, 0, 4) + v], (2 * below + above) / 3, 1e-3);
      ASSERT_NEAR(mended.phases[p][grid.offset(0, 0, 5) + v], (below + 2 * above) / 3, 1e-3);
    }
  }
  const std::vector<std::string> said = told(bad, grid.size[2], images.phase_count());
  ASSERT_EQ(said.size(), 2U);
  EXPECT_EQ(said[0].find("slices 4, 5 show nothing in any phase"), 0U) << said[0];
  EXPECT_EQ(said[1].find("phase 3 of slice 3 shows nothing"), 0U) << said[1];
}

}  // namespace
}  // namespace beatlas::motion
