/// Images between slices far apart, against what a heart known everywhere shows there.

#include "runtime/viewer/between_slices.h"

#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "runtime/atlas/volume.h"
#include "tests/package/sample_package.h"

namespace beatlas::viewer {
namespace {

using Fields = std::vector<std::shared_ptr<const field::FieldQuery>>;

/// Two beating balls with bumps, one in the other.
Fields nested() {
  const auto field = [](Structure structure, double radius_mm, double beat_mm) {
    return std::make_shared<const field::FieldQuery>(
        std::make_shared<const atlas::FieldPayload>(
            test::beating_field(structure, radius_mm, beat_mm, 12, 1.5)),
        0.8);
  };
  return {field(Structure::Heart, 44, 4), field(Structure::LvBlood, 26, 7)};
}

/// Lung, muscle, blood; edges as wide as a pixel.
double intensity(const Fields& fields, const Vec3& x, double beats) {
  const auto inside = [&](std::size_t which) {
    return 1 / (1 + std::exp(fields[which]->sample(x, 0.8 * beats).distance_mm / 0.5));
  };
  return 20 + 70 * inside(0) + 130 * inside(1);
}

atlas::VolumePayload slices_apart(double gap_mm, int count) {
  atlas::VolumePayload volume;
  volume.size = {72, 72, count};
  volume.phases = 12;
  volume.workspace_from_index.linear() =
      Eigen::AngleAxisd(0.4, Vec3(1, 2, -1).normalized()).toRotationMatrix() *
      Vec3(1.5, 1.5, gap_mm).asDiagonal();
  volume.workspace_from_index.translation() =
      Vec3(128, 128, 96) -
      volume.workspace_from_index.linear() * Vec3(35.5, 35.5, 0.5 * count - 0.4);
  return volume;
}

std::vector<std::uint8_t> images(const Fields& fields, const atlas::VolumePayload& shape,
                                 double beats) {
  std::vector<std::uint8_t> out;
  for (int k = 0; k < shape.size[2]; ++k) {
    for (int j = 0; j < shape.size[1]; ++j) {
      for (int i = 0; i < shape.size[0]; ++i) {
        out.push_back(static_cast<std::uint8_t>(
            std::lround(intensity(fields, shape.workspace_from_index * Vec3(i, j, k), beats))));
      }
    }
  }
  return out;
}

double rms(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  double sum = 0;
  for (std::size_t v = 0; v < a.size(); ++v)
    sum += std::pow(static_cast<double>(a[v]) - static_cast<double>(b[v]), 2);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

const Vec3 kLow(80, 80, 48);
const Vec3 kHigh(176, 176, 144);

TEST(BetweenSlices, IsWhatTheHeartShowsThereFarBetterThanABlend) {
  const Fields fields = nested();
  for (const auto& [gap_mm, count] : {std::pair{10.0, 10}, std::pair{17.7, 6}}) {
    const atlas::VolumePayload volume = slices_apart(gap_mm, count);
    BetweenSlices ours(volume, fields, kLow, kHigh);
    // The same with the box elsewhere blends.
    BetweenSlices blend(volume, fields, kHigh * 9, kHigh * 9 + Vec3::Ones());
    ASSERT_TRUE(ours.needed());
    const std::size_t count_out = ours.shape().sample_count();
    for (const double beats : {0.0, 0.37, 0.72}) {
      const std::vector<std::uint8_t> slices = images(fields, volume, beats);
      const std::vector<std::uint8_t> truth = images(fields, ours.shape(), beats);
      std::vector<std::uint8_t> found(count_out);
      std::vector<std::uint8_t> straight(count_out);
      ours.fill(beats, slices, found);
      blend.fill(beats, slices, straight);
      const double error = rms(found, truth);
      const double without = rms(straight, truth);
      std::cout << gap_mm << " mm, " << beats << ": rms " << error << ", blended " << without
                << "\n";
      EXPECT_LT(error, (gap_mm > 15 ? 0.35 : 0.4) * without);
    }
  }
}

TEST(BetweenSlices, LeavesTheSlicesAsTheyAre) {
  const Fields fields = nested();
  const atlas::VolumePayload volume = slices_apart(10, 10);
  BetweenSlices ours(volume, fields, kLow, kHigh);
  const std::vector<std::uint8_t> slices = images(fields, volume, 0.4);
  std::vector<std::uint8_t> found(ours.shape().sample_count());
  ours.fill(0.4, slices, found);
  const Affine from_shape =
      volume.workspace_from_index.inverse() * ours.shape().workspace_from_index;
  int seen = 0;
  const std::size_t plane = 72 * 72;
  for (int k = 0; k < ours.shape().size[2]; ++k) {
    const double slice = (from_shape * Vec3(0, 0, k)).z();
    if (std::abs(slice - std::round(slice)) > 1e-6) continue;
    ++seen;
    EXPECT_TRUE(
        std::equal(found.begin() + static_cast<std::ptrdiff_t>(plane) * k,
                   found.begin() + static_cast<std::ptrdiff_t>(plane) * (k + 1),
                   slices.begin() + static_cast<std::ptrdiff_t>(plane) * std::lround(slice)))
        << slice;
  }
  EXPECT_EQ(seen, 10);
  // Half a gap beyond the outermost is drawn as well.
  EXPECT_NEAR((from_shape * Vec3(0, 0, 0)).z(), -0.5, 0.1);
  EXPECT_NEAR((from_shape * Vec3(0, 0, ours.shape().size[2] - 1)).z(), 9.5, 0.1);
}

TEST(BetweenSlices, AreNoneWhereSlicesAreNearOrNoFieldTells) {
  const Fields fields = nested();
  for (const bool thin : {true, false}) {
    const atlas::VolumePayload volume = slices_apart(thin ? 2.5 : 10, 10);
    BetweenSlices ours(volume, thin ? fields : Fields{}, kLow, kHigh);
    EXPECT_FALSE(ours.needed());
    EXPECT_EQ(ours.shape().size, volume.size);
    const std::vector<std::uint8_t> slices = images(fields, volume, 0);
    std::vector<std::uint8_t> found(slices.size());
    ours.fill(0, slices, found);
    EXPECT_EQ(found, slices);
  }
}

}  // namespace
}  // namespace beatlas::viewer
