/// Thick slices, each of its own brightness.
#include "pipeline/segment/slice_gain.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/segment/segment.h"
#include "tests/unit/segment/imaged_phantom.h"
#include "tests/unit/segment/made_images.h"

namespace beatlas::segment {
namespace {

double gain_of(int k) { return 1 + 0.2 * std::sin(2.4 * k); }

TEST(BreathHoldGain, is_found_and_hardly_costs_a_ventricle) {
  made::ImagedPhantom made(made::clinical_part());
  StageContext context;
  const Segmentation even = segment_exam(made.exam, {}, {}, context);
  ImageCycle<float>& images = made.exam.stack.images;
  for (std::vector<float>& phase : images.phases) {
    for (std::size_t v = 0; v < phase.size(); ++v) {
      phase[v] *= static_cast<float>(gain_of(static_cast<int>(v / images.grid.slice_count())));
    }
  }
  const std::vector<double> found = slice_gains(images);
  ASSERT_EQ(found.size(), static_cast<std::size_t>(images.grid.size[2]));
  // Beside what they have in common; the slices of the LV.
  std::vector<double> off;
  for (int k = 3; k <= 8; ++k)
    off.push_back(std::log(found[static_cast<std::size_t>(k)] / gain_of(k)));
  const auto [least, most] = std::minmax_element(off.begin(), off.end());
  EXPECT_LT(*most - *least, 0.1);

  const Segmentation result = segment_exam(made.exam, {}, {}, context);
  for (const std::uint8_t label : {kLabelRvBlood, kLabelLvBlood}) {
    double then = 0;
    double now = 0;
    const std::size_t phases = result.labels.phases.size();
    for (std::size_t p = 0; p < phases; ++p) {
      then += made::label_dice(even.labels.phases[p], made.truth.phases[p], label) / phases;
      now += made::label_dice(result.labels.phases[p], made.truth.phases[p], label) / phases;
    }
    EXPECT_GT(now, then - 0.07) << int{label};
  }
}

}  // namespace
}  // namespace beatlas::segment
