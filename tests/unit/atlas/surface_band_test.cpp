#include "runtime/atlas/surface_band.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace beatlas::atlas {
namespace {

/// Three slices 8 mm apart along the workspace's y, turned round; two phases.
Manifest heart() {
  Manifest out;
  out.source_size = {64, 64, 3};
  out.source_lps_from_index.matrix() << 1.5, 0, 0, -40, 0, 0, -8, 30, 0, 1.5, 0, -50, 0, 0, 0, 1;
  out.workspace_from_lps = Eigen::Translation3d(5, 6, 7);
  out.structures = {{"heart", {500, 400}}, {"lv_blood", {150, 60}}};
  out.structures[1].band = {{{1, 2, 4}, {3, 3, 3}}, {{6, 7, 9}, {5, 5, 5}}};
  return out;
}

class Bands : public ::testing::Test {
 protected:
  /// In phase 0.
  double at(double slice, const Vec3& normal) const {
    return band_.half_width_mm(place(slice), normal, 0);
  }
  static Vec3 place(double slice) {
    const Manifest manifest = heart();
    return manifest.workspace_from_lps * (manifest.source_lps_from_index * Vec3(20, 30, slice));
  }

  BandQuery band_ = band_query(heart(), Structure::LvBlood).value();
  const Vec3 across_ = Vec3(1, 0, -1).normalized();  ///< in the plane of the slices
  const Vec3 along_ = Vec3::UnitY();
};

TEST_F(Bands, TellAcrossAndAlongASliceApart) {
  EXPECT_NEAR(at(1, across_), 2, 1e-9);
  EXPECT_NEAR(at(1, along_), 7, 1e-9);
  EXPECT_NEAR(at(1, -along_), 7, 1e-9);
  const double slope = std::numbers::pi / 6;
  const Vec3 between = std::sin(slope) * across_ - std::cos(slope) * along_;
  EXPECT_NEAR(at(1, between), 2 * std::sin(slope) + 7 * std::cos(slope), 1e-9);
}

TEST_F(Bands, AreLinearBetweenSlicesAndStayBeyondTheLast) {
  EXPECT_NEAR(at(0.5, across_), 1.5, 1e-9);
  EXPECT_NEAR(at(0.25, across_), 1.25, 1e-9);
  EXPECT_NEAR(at(0.5, along_), 6.5, 1e-9);
  EXPECT_NEAR(at(2.5, across_), 4, 1e-9);
  EXPECT_NEAR(at(7, across_), 4, 1e-9);
  EXPECT_NEAR(at(-3, along_), 6, 1e-9);
}

TEST_F(Bands, GoRoundWithTheBeat) {
  const auto across_in = [&](double phase) {
    return band_.half_width_mm(place(0), across_, phase / 2);
  };
  EXPECT_NEAR(across_in(0.25), 1.5, 1e-9);
  EXPECT_NEAR(across_in(1), 3, 1e-9);
  EXPECT_NEAR(across_in(1.5), 2, 1e-9);
  EXPECT_NEAR(across_in(2), 1, 1e-9);
  EXPECT_NEAR(across_in(-0.5), 2, 1e-9);
}

TEST_F(Bands, AreFiniteWhateverIsAsked) {
  const double most = std::numeric_limits<double>::max();
  for (const double odd : {std::nan(""), std::numeric_limits<double>::infinity(), most, -most}) {
    for (const double width : {band_.half_width_mm(Vec3(odd, 0, -odd), across_, 0),
                               band_.half_width_mm(place(1), Vec3(odd, odd, 0), 0),
                               band_.half_width_mm(place(1), across_, odd),
                               band_.half_width_mm(place(1), along_, -odd)}) {
      EXPECT_GE(width, 0) << odd;
      EXPECT_LE(width, 9) << odd;
    }
  }
  EXPECT_NEAR(band_.half_width_mm(place(0), across_, 1e15 + 0.5), 3, 1e-9);
}

TEST_F(Bands, AreNoneWhereThePackageTellsNone) {
  EXPECT_FALSE(band_query(heart(), Structure::Heart).has_value());
  EXPECT_FALSE(band_query(heart(), Structure::RvBlood).has_value());
}

}  // namespace
}  // namespace beatlas::atlas
