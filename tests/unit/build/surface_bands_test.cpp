#include "pipeline/build/surface_bands.h"

#include <cmath>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>

namespace beatlas::build {
namespace {

constexpr std::size_t kSlices = 5;

/// Four slices of five 10 mm apart hold labels, the base at low indices; of the circle of radius
/// 20 mm that is labelled in each, `agreed` of 1 is expected too, and nothing else.
Segmentation heart(double agreed) {
  Segmentation out;
  out.labels.grid.size = {4, 4, static_cast<int>(kSlices)};
  out.labels.grid.mm_from_index = Affine::Identity();
  out.labels.grid.mm_from_index.linear().col(2) *= 10;
  out.axis.emplace();
  out.axis->towards_base = -Vec3::UnitZ();
  const double area_mm2 = std::numbers::pi * 20 * 20;
  const SliceBelief slice{area_mm2, agreed * area_mm2, agreed * area_mm2};
  for (const Structure structure : {Structure::LvBlood, Structure::RvBlood}) {
    out.belief[structure] = {{slice, slice, slice, slice, {}}};
  }
  return out;
}

const atlas::SurfaceBand& band_of(const std::map<Structure, atlas::SurfaceBand>& bands) {
  return bands.at(Structure::LvBlood);
}

TEST(SurfaceBands, AreWiderInSlicesByWhatThePriorDoubts) {
  const auto sure = surface_bands(heart(0.99));
  const auto unsure = surface_bands(heart(0.8));
  ASSERT_EQ(band_of(sure).across_mm.size(), 1U);
  ASSERT_EQ(band_of(sure).across_mm[0].size(), kSlices);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_GT(band_of(unsure).across_mm[0][k], band_of(sure).across_mm[0][k] + 0.5);
  }
  // Twice the doubt is twice as much beside what is there without a doubt.
  const double own_mm = band_of(sure).across_mm[0][1];
  const double once = band_of(unsure).across_mm[0][1] - own_mm;
  const double twice = band_of(surface_bands(heart(0.61))).across_mm[0][1] - own_mm;
  EXPECT_NEAR(twice / once, 2, 0.05);
}

TEST(SurfaceBands, AreAsWideAlongAsSlicesAreApart) {
  Segmentation far = heart(0.9);
  far.labels.grid.mm_from_index.linear().col(2) *= 2;
  const atlas::SurfaceBand near = band_of(surface_bands(heart(0.9)));
  const atlas::SurfaceBand twice = band_of(surface_bands(far));
  for (std::size_t k = 0; k < kSlices; ++k) {
    EXPECT_NEAR(twice.along_mm[0][k], 2 * near.along_mm[0][k], 0.02);
    EXPECT_NEAR(twice.across_mm[0][k], near.across_mm[0][k], 1e-9);
  }
}

TEST(SurfaceBands, KnowBaseFromApex) {
  const atlas::SurfaceBand up = band_of(surface_bands(heart(0.9)));
  Segmentation turned = heart(0.9);
  turned.axis->towards_base = Vec3::UnitZ();
  const atlas::SurfaceBand down = band_of(surface_bands(turned));
  EXPECT_GT(up.along_mm[0][0], up.along_mm[0][1]);
  EXPECT_GT(up.along_mm[0][3], up.along_mm[0][1]);
  EXPECT_EQ(up.along_mm[0][4], up.along_mm[0][3]);
  EXPECT_EQ(up.along_mm[0][2], up.along_mm[0][1]);
  EXPECT_EQ(down.along_mm[0][0], up.along_mm[0][3]);
  EXPECT_EQ(down.along_mm[0][3], up.along_mm[0][0]);
  // A cavity is known worse at its valve than at its tip.
  EXPECT_GT(up.along_mm[0][0], up.along_mm[0][3]);
}

TEST(SurfaceBands, OfASliceThatAPersonToldAreAsWideAsAnywhere) {
  Segmentation made = heart(0.9);
  std::vector<SliceBelief>& slices = made.belief[Structure::RvBlood][0];
  slices[2].agreed_mm2 *= 0.8;
  const double widest_mm = surface_bands(made).at(Structure::RvBlood).across_mm[0][2];
  EXPECT_GT(widest_mm, surface_bands(made).at(Structure::RvBlood).across_mm[0][0]);
  slices[0] = {1000, 1000, 1000};
  EXPECT_EQ(surface_bands(made).at(Structure::RvBlood).across_mm[0][0], widest_mm);
  // Where the prior has no doubt, half a pixel is as well as an outline is known.
  slices[1].expected_mm2 = slices[1].agreed_mm2 = slices[1].labelled_mm2 - 1e-6;
  EXPECT_EQ(surface_bands(made).at(Structure::RvBlood).across_mm[0][1], 0.5);
}

TEST(SurfaceBands, AreToldInAReportByEndAndWorstSlice) {
  Segmentation made = heart(0.9);
  made.belief[Structure::LvBlood][0][1].agreed_mm2 *= 0.8;
  const atlas::SurfaceBand band = band_of(surface_bands(made));
  const auto of_lv = [&]() -> std::optional<report::KnownSurface> {
    for (const report::KnownSurface& known : known_surfaces(made)) {
      if (known.structure == Structure::LvBlood) return known;
    }
    return std::nullopt;
  };
  const auto known = of_lv();
  ASSERT_TRUE(known.has_value());
  EXPECT_EQ(known->worst_slice, 1);
  EXPECT_EQ(known->worst_slice_mm, band.across_mm[0][1]);
  EXPECT_EQ(known->in_slices_mm, band.across_mm[0][0]);
  EXPECT_EQ(known->at_base_mm, band.along_mm[0][0]);
  EXPECT_EQ(known->at_apex_mm, band.along_mm[0][3]);
  // A person labels end-diastole, one phase of three: the band stays, the report's row goes.
  auto& phases = made.belief[Structure::LvBlood];
  phases = {phases[0], phases[0], phases[0]};
  for (std::size_t k = 0; k < 4; ++k) phases[0][k] = {1200, 1200, 1200};
  EXPECT_EQ(surface_bands(made).count(Structure::LvBlood), 1U);
  EXPECT_FALSE(of_lv().has_value());
}

TEST(SurfaceBands, AreNoneOfWhatIsNotKnown) {
  EXPECT_EQ(surface_bands(heart(0.9)).count(Structure::LvMyocardium), 0U);
  Segmentation no_axis = heart(0.9);
  no_axis.axis.reset();
  EXPECT_TRUE(surface_bands(no_axis).empty());
  // Somebody told three slices of four.
  Segmentation told = heart(0.9);
  for (std::size_t k = 0; k < 3; ++k) told.belief[Structure::LvBlood][0][k] = {1200, 1200, 1200};
  const auto bands = surface_bands(told);
  EXPECT_EQ(bands.count(Structure::LvBlood), 0U);
  EXPECT_EQ(bands.count(Structure::RvBlood), 1U);
}

}  // namespace
}  // namespace beatlas::build
