/// Is a segmentation's boundary as far from the phantom's as it says of itself?
#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>

#include <gtest/gtest.h>

#include "pipeline/segment/segment.h"
#include "tests/made_images.h"
#include "tests/unit/segment/imaged_phantom.h"

namespace beatlas::segment {
namespace {

struct Off {
  double error_mm = 0;  ///< along the true surface's normal
  double sigma_mm = 0;
};

/// In-plane distance [pixels] of a voxel's middle to the outline that covers so much of it, which
/// moves by lean_px from one side of the slice to the other.
double outline_px(double coverage, double lean_px) {
  double low = -0.5 * (1 + lean_px);
  double high = -low;
  for (int n = 0; n < 40; ++n) {
    const double middle = 0.5 * (low + high);
    double mean = 0;
    constexpr int kParts = 50;
    for (int part = 0; part < kParts; ++part) {
      const double at = middle + lean_px * ((part + 0.5) / kParts - 0.5);
      mean += std::clamp(0.5 - at, 0.0, 1.0) / kParts;
    }
    (mean > coverage ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Of boundary points that are 4 mm or more from creases and base planes, every `stride`th.
std::vector<Off> offs(const Segmentation& found, const phantom::Phantom& phantom,
                      Structure structure, std::size_t stride) {
  const Grid& grid = found.coverage.grid;
  const auto nx = static_cast<std::size_t>(grid.size[0]);
  std::vector<Off> out;
  const auto& phases = found.uncertainty.at(structure);
  for (std::size_t p = 0; p < phases.size(); ++p) {
    const auto frame = phantom.frame(phantom.phase_time_s(static_cast<int>(p)));
    const std::vector<float>& covered = found.coverage.phases.at(structure)[p];
    for (std::size_t n = 0; n < phases[p].size(); n += stride) {
      const std::size_t v = phases[p][n].voxel;
      const auto i = static_cast<int>(v % nx);
      const auto j = static_cast<int>(v % grid.slice_count() / nx);
      const auto k = static_cast<int>(v / grid.slice_count());
      if (i < 1 || j < 1 || i + 1 >= grid.size[0] || j + 1 >= grid.size[1]) continue;
      if (std::abs(covered[v] - 0.5F) > 0.3F) continue;  // the rest hardly tells a place
      const double gx = covered[v + 1] - covered[v - 1];
      const double gy = covered[v + nx] - covered[v - nx];
      const double length = std::hypot(gx, gy);
      if (length < 0.1) continue;  // outlines that touch
      const Vec3 normal = frame->nearest(structure, grid.mm(i, j, k)).outward;
      const Vec3 spacing = grid.spacing_mm();
      const Vec3 across = (grid.mm(0, 0, 1) - grid.mm(0, 0, 0)).normalized();
      const double leaning = std::abs(normal.dot(across));
      const double lean_px =
          leaning / std::sqrt(std::max(1e-4, 1 - leaning * leaning)) * spacing[2] / spacing[0];
      if (lean_px > 2) continue;  // there intensities tell how far a slice is covered
      const double inward = outline_px(covered[v], lean_px);
      const Vec3 at = grid.mm(i + inward * gx / length, j + inward * gy / length, k);
      const auto base =
          static_cast<double>(std::min(found.axis->lv_base_mm[p], found.axis->rv_base_mm[p]));
      if (found.axis->height_mm(at) > base - 4) continue;
      if (frame->crease_distance_mm(structure, at) < 4) continue;
      out.push_back({frame->distance_mm(structure, at), phases[p][n].sigma_mm});
    }
  }
  return out;
}

double rms(const std::vector<Off>& list, double (*of)(const Off&)) {
  double sum = 0;
  for (const Off& off : list) sum += of(off) * of(off);
  return std::sqrt(sum / static_cast<double>(list.size()));
}

/// Rms and median (scaled to a normal law's) of error over stated sigma lie in these ranges.
struct Wanted {
  Structure structure;
  double most_rms, most_median;
};

/// What says it is uncertain is: the third with the largest sigma errs more than the other two.
void expect_telling(std::vector<Off> list, const std::string& name) {
  std::sort(list.begin(), list.end(),
            [](const Off& a, const Off& b) { return a.sigma_mm < b.sigma_mm; });
  const auto split = list.begin() + static_cast<std::ptrdiff_t>(2 * list.size() / 3);
  EXPECT_GT(rms({split, list.end()}, [](const Off& o) { return o.error_mm; }),
            1.1 * rms({list.begin(), split}, [](const Off& o) { return o.error_mm; }))
      << name;
}

void expect_calibrated(const std::string& preset, double snr, std::size_t stride,
                       const std::vector<Wanted>& wanted) {
  phantom::PhantomSpec spec = phantom::preset(preset);
  spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  spec.phases = 5;
  spec.scanner.snr_blood = snr;
  const made::ImagedPhantom imaged(spec, made::Views::All);
  const Segmentation found = imaged.segmented();
  ASSERT_TRUE(found.axis);
  std::vector<Off> all;
  for (const Wanted& want : wanted) {
    std::vector<Off> list = offs(found, imaged.phantom, want.structure, stride);
    ASSERT_GT(list.size(), 300U);
    const double ratio = rms(list, [](const Off& o) { return o.error_mm / o.sigma_mm; });
    std::vector<double> sizes;
    for (const Off& off : list) sizes.push_back(std::abs(off.error_mm / off.sigma_mm));
    std::sort(sizes.begin(), sizes.end());
    const double median = sizes[sizes.size() / 2] / 0.6745;
    const std::string name(structure_name(want.structure));
    std::cout << preset << ", SNR " << snr << ", " << name << ": error over stated sigma rms "
              << ratio << ", by median " << median << "; rms error "
              << rms(list, [](const Off& o) { return o.error_mm; }) << " mm, rms sigma "
              << rms(list, [](const Off& o) { return o.sigma_mm; }) << " mm\n";
    EXPECT_GT(ratio, 0.7) << name;
    EXPECT_LT(ratio, want.most_rms) << name;
    EXPECT_GT(median, 0.6) << name;
    EXPECT_LT(median, want.most_median) << name;
    all.insert(all.end(), list.begin(), list.end());
    // Beside the LV levels and noise are the same all around, and the heart errs most where its
    // wall is thinnest.
    if (want.structure == Structure::RvBlood) expect_telling(std::move(list), name);
  }
  if (wanted.size() > 1) expect_telling(std::move(all), "all");
}

// The cavities' errors are those of the noise. Over the RV the outside is off by its wall where
// that was not seen, which no sigma tells: half of the outside lies as near as is stated, and the
// rms is not asked.
TEST(Calibration, Small) {
  expect_calibrated("small", 20, 2,
                    {{Structure::LvBlood, 1.3, 1.2},
                     {Structure::RvBlood, 1.4, 1.3},
                     {Structure::Heart, std::numeric_limits<double>::infinity(), 1.6}});
}

TEST(Calibration, SmallWithMuchNoise) {
  expect_calibrated("small", 10, 2, {{Structure::LvBlood, 1.4, 1.3}});
}

}  // namespace
}  // namespace beatlas::segment
