// What of a boundary labels tell, because no edge does: among trabeculae and along a wall's rim.

#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/edges/boundary.h"
#include "tests/unit/edges/made_ellipses.h"

namespace beatlas::edges::ellipses {
namespace {

/// What lies beside the wall is muscle, every 4 mm farther inside there is half as much of it.
Slice with_trabeculae(const Ellipse& e, double sigma) {
  Slice s = make(e, sigma);
  for (int j = 0; j < kPixels; ++j) {
    for (int i = 0; i < kPixels; ++i) {
      const auto v = static_cast<std::size_t>(i + kPixels * j);
      const double level = e.level(i * kPixelMm, j * kPixelMm);
      const double muscle = std::exp2(-(1 - std::min(level, 1.0)) * e.a / 4);
      s.image[v] -= static_cast<float>(muscle * (kInside - kOutside)) * s.share[v];
    }
  }
  return s;
}

TEST(Boundary, TakesTrabeculaeInAsLabelsDoTheMoreTheThickerTheyAre) {
  // Beyond what equals out about the outline they would make half a millimetre of wall: with 0.6 mm
  // for the labels, two fifths of the shift are taken back.
  const Ellipse e;
  const Slice s = with_trabeculae(e, 15);
  const double by_edges = outline_error(e, boundary_of(s, s.inside, 50, 15).coverage).mean;
  EXPECT_LT(by_edges, -1);
  EXPECT_NEAR(outline_error(e, boundary_of(s, s.inside, 50, 15, true).coverage).mean / by_edges,
              0.6, 0.05);
}

TEST(Boundary, OfASmoothCavityIsWhereItsEdgeIsAndNotWhereLabelsAre) {
  const Ellipse e;
  Ellipse labelled;
  labelled.a = labelled.b = 20.75;
  const Slice s = make(e, 15);
  EXPECT_NEAR(
      outline_error(e, boundary_of(s, make(labelled, 0).inside, 50, 15, true).coverage).mean, 0,
      0.06);
}

TEST(Boundary, OfARimmedWallKeepsTheSizeOfLabels) {
  const Ellipse labelled;
  Ellipse seen;
  seen.a = seen.b = 20.8;
  const Slice s = make(seen, 15);
  const std::vector<std::uint8_t> labels = make(labelled, 0).inside;
  const auto outward = [&](bool rimmed) {
    return outline_error(labelled, boundary_of(s, labels, 50, 15, false, rimmed).coverage).mean;
  };
  EXPECT_NEAR(outward(false), 0.8, 0.06);
  EXPECT_NEAR(outward(true), 0, 0.06);
}

TEST(Boundary, OfARimmedWallTakesItsShapeFromTheEdges) {
  const Ellipse labelled;
  Ellipse seen;
  seen.a = 21;
  seen.b = 19;
  const Slice s = make(seen, 15);
  const std::vector<std::uint8_t> labels = make(labelled, 0).inside;
  const double by_labels = outline_error(seen, outline_coverage(s.grid, labels)).rms;
  EXPECT_GT(by_labels, 0.6);
  EXPECT_LT(outline_error(seen, boundary_of(s, labels, 50, 15, false, true).coverage).rms, 0.15);
}

}  // namespace
}  // namespace beatlas::edges::ellipses
