#include "runtime/atlas/structure_colours.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/colour_vision.h"

namespace beatlas {
namespace {

using test::Eyes;
using test::kAllEyes;

constexpr Colour kPaper{255, 255, 255};

double least_difference(Colour (*colour_of)(Structure) noexcept, Eyes eyes) {
  double least = 1000;
  for (const Structure one : kAllStructures) {
    for (const Structure other : kAllStructures) {
      if (one == other) continue;
      least = std::min(least, test::difference(colour_of(one), colour_of(other), eyes));
    }
  }
  return least;
}

// The measure itself, against pairs of its authors' table (Sharma, Wu and Dalal 2005).
TEST(ColourVision, MeasuresDifferencesAsCiede2000Does) {
  EXPECT_NEAR(test::ciede2000({50, 2.6772, -79.7751}, {50, 0, -82.7485}), 2.0425, 1e-4);
  EXPECT_NEAR(test::ciede2000({50, 2.5, 0}, {73, 25, -18}), 27.1492, 1e-4);
  EXPECT_NEAR(test::ciede2000({50, 2.5, 0}, {50, 0, -2.5}), 4.3065, 1e-4);
  EXPECT_NEAR(test::ciede2000({60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}), 1.2644,
              1e-4);
  EXPECT_NEAR(test::ciede2000({2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}), 0.9082, 1e-4);
}

// Twice and more what is seen at a glance; the colours before this table had 6.7 in the window and
// 0.3 in the report.
TEST(StructureColours, AreToldApartAlsoByEyesWithoutOneKindOfCones) {
  for (const Eyes eyes : kAllEyes) {
    EXPECT_GT(least_difference(structure_colour, eyes), 16) << static_cast<int>(eyes);
  }
  EXPECT_GT(least_difference(structure_colour, Eyes::Usual), 25);
}

TEST(StructureColours, OnPaperAreReadAndToldApart) {
  for (const Eyes eyes : kAllEyes) {
    EXPECT_GT(least_difference(structure_ink, eyes), 11.5) << static_cast<int>(eyes);
  }
  for (const Structure structure : kAllStructures) {
    EXPECT_GT(test::contrast(structure_ink(structure), kPaper), 4.5) << structure_name(structure);
  }
}

// Outlines lie on images, which are grey of any brightness.
TEST(StructureColours, AreToldFromTheGreyOfImages) {
  for (const Structure structure : kAllStructures) {
    const Colour colour = structure_colour(structure);
    for (int grey = 0; grey < 256; ++grey) {
      const auto g = static_cast<std::uint8_t>(grey);
      EXPECT_GT(test::difference(colour, {g, g, g}, Eyes::Usual), 15)
          << structure_name(structure) << " " << grey;
    }
  }
}

TEST(StructureColours, AreWrittenAsPagesReadThem) {
  EXPECT_EQ(colour_code({216, 4, 32}), "#d80420");
}

}  // namespace
}  // namespace beatlas
