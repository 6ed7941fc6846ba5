#include "pipeline/build/corrections.h"

#include <gtest/gtest.h>

#include "runtime/base/error.h"

namespace beatlas::build {
namespace {

/// Each image is filled with one label.
study::GivenLabels labels_of(std::vector<int> phases, const std::vector<std::uint8_t>& fills,
                             const Index3& size = {2, 2, 1}) {
  study::GivenLabels out;
  out.images.grid.size = size;
  for (const std::uint8_t fill : fills) {
    out.images.phases.emplace_back(out.images.grid.count(), fill);
  }
  out.phases = std::move(phases);
  out.sha256 = study::given_sha256(out.images, out.phases);
  return out;
}

std::vector<int> fills_of(const study::GivenLabels& labels) {
  std::vector<int> out;
  for (const auto& image : labels.images.phases) out.push_back(image.front());
  return out;
}

TEST(OtherPhases, StayBesideThoseThatAreGivenNow) {
  const study::GivenLabels both = with_other_phases(labels_of({2}, {5}), labels_of({0, 2}, {1, 3}));
  EXPECT_EQ(both.phases, (std::vector<int>{0, 2}));
  EXPECT_EQ(fills_of(both), (std::vector<int>{1, 5}));
  EXPECT_EQ(both.sha256, labels_of({0, 2}, {1, 5}).sha256);
  // Whichever came last.
  const study::GivenLabels turned = with_other_phases(labels_of({0}, {1}), labels_of({2}, {5}));
  EXPECT_EQ(turned.sha256, both.sha256);
  EXPECT_EQ(turned.file_sha256, both.file_sha256);
}

TEST(OtherPhases, OfLabelsOfEveryPhaseStayToo) {
  const study::GivenLabels all = with_other_phases(labels_of({1}, {5}), labels_of({}, {1, 2, 3}));
  EXPECT_EQ(all.phases, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(fills_of(all), (std::vector<int>{1, 5, 3}));
}

TEST(OtherPhases, GiveWayToLabelsOfEveryPhase) {
  const study::GivenLabels now = with_other_phases(labels_of({}, {1, 2}), labels_of({0}, {3}));
  EXPECT_TRUE(now.phases.empty());
  EXPECT_EQ(fills_of(now), (std::vector<int>{1, 2}));
}

TEST(OtherPhases, OnOtherVoxelsAreRefused) {
  EXPECT_THROW((void)with_other_phases(labels_of({1}, {5}), labels_of({0}, {3}, {4, 2, 1})), Error);
  // Nothing of them would stay.
  EXPECT_NO_THROW((void)with_other_phases(labels_of({0}, {5}), labels_of({0}, {3}, {4, 2, 1})));
}

}  // namespace
}  // namespace beatlas::build
