/// What labels make of frames of noise among good ones.
#include "pipeline/motion/bad_frames.h"

#include <gtest/gtest.h>

#include "tests/clinical_part.h"
#include "tests/made_images.h"
#include "tests/unit/segment/imaged_phantom.h"

namespace beatlas::segment::bad_frames_tests {
namespace {

constexpr int kBad = 3;

TEST(BadFrames, AreNamedAndLeaveTheLabelsOfAllPhasesAsTheyWere) {
  made::ImagedPhantom made(made::clinical_part());
  ASSERT_TRUE(motion::bad_frames(made.exam.stack.images).empty());
  const Segmentation good = made::segmented(made.exam);
  const int slices = made.exam.stack.images.grid.size[2];
  made::make_noise(made.exam.stack.images, kBad, 0, slices - 1);
  const std::vector<motion::BadFrame> bad = motion::bad_frames(made.exam.stack.images);
  ASSERT_EQ(bad.size(), static_cast<std::size_t>(slices));
  for (const motion::BadFrame& frame : bad) EXPECT_EQ(frame.phase, kBad);

  const Segmentation result = made::segmented(made.exam);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings.front().find("phase 3 shows nothing"), std::string::npos);
  for (std::size_t p = 0; p < result.labels.phases.size(); ++p) {
    const double least = p == kBad ? 0.93 : 0.96;
    EXPECT_GT(made::label_dice(result.labels.phases[p], good.labels.phases[p], kLabelLvBlood),
              least)
        << p;
    EXPECT_GT(made::label_dice(result.labels.phases[p], good.labels.phases[p], kLabelRvBlood),
              least - 0.02)
        << p;
  }
}

}  // namespace
}  // namespace beatlas::segment::bad_frames_tests
