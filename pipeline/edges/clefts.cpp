#include "pipeline/edges/clefts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/faces.h"
#include "pipeline/edges/slice_image.h"
#include "runtime/atlas/structures.h"

namespace beatlas::edges {
namespace {

constexpr double kCalmPx = 0.7;      ///< Gaussian before fat is told from blood
constexpr double kMostLetIn = 0.03;  ///< of the heart
constexpr double kFilmMm = 3;        ///< thickest film of fat and lung

/// Takes out of the heart what a mask names and hangs together with what it names outside. Parts
/// of more than kMostLetIn are none of it: blood that flows in.
/// @return voxels that were taken out
std::vector<std::uint32_t> let_in(const Grid& grid, const std::vector<std::uint8_t>& foreign,
                                  std::vector<std::uint8_t>& labels) {
  const auto heart = static_cast<double>(
      labels.size() - static_cast<std::size_t>(std::count(labels.begin(), labels.end(), 0)));
  std::vector<std::uint8_t> reached(labels.size(), 0);
  std::vector<std::uint32_t> part;
  const auto grow = [&](std::size_t from) {
    for_faces(grid, from, [&](std::size_t v) {
      if (reached[v] != 0 || labels[v] == kLabelBackground || foreign[v] == 0) return;
      reached[v] = 1;
      part.push_back(static_cast<std::uint32_t>(v));
    });
  };
  std::vector<std::uint32_t> out;
  const std::vector<std::uint8_t> before = labels;
  for (std::size_t v = 0; v < before.size(); ++v) {
    if (before[v] != kLabelBackground || foreign[v] == 0) continue;
    part.clear();
    grow(v);
    std::size_t next = 0;
    while (next < part.size()) grow(part[next++]);
    if (static_cast<double>(part.size()) > kMostLetIn * heart) continue;
    for (const std::uint32_t voxel : part) labels[voxel] = kLabelBackground;
    out.insert(out.end(), part.begin(), part.end());
  }
  return out;
}

/// The heart's voxels from a place straight on, a `step` at a time, up to fat; none where something
/// else bounds them, or where they are more than a film.
std::vector<std::uint32_t> film_from(const Grid& grid, const Index3& at,
                                     const std::array<int, 2>& step, double step_mm,
                                     const std::vector<std::uint8_t>& bright,
                                     const std::vector<std::uint8_t>& dark,
                                     const std::vector<std::uint8_t>& labels) {
  std::vector<std::uint32_t> film;
  for (int n = 1; (n - 2) * step_mm <= kFilmMm; ++n) {
    const Index3 next{at[0] + n * step[0], at[1] + n * step[1], at[2]};
    if (!grid.contains(next[0], next[1], next[2])) return {};
    const std::size_t v = grid.offset(next[0], next[1], next[2]);
    if (labels[v] != kLabelBackground) {
      film.push_back(static_cast<std::uint32_t>(v));
      continue;
    }
    if (bright[v] == 0 || dark[v] != 0) return {};
    return film;
  }
  return {};
}

/// A film of the heart between fat on one side and lung on the other, beside lung that was let in,
/// is both of them in one voxel.
void drop_films(const Grid& grid, const std::vector<std::uint8_t>& bright,
                const std::vector<std::uint8_t>& dark, const std::vector<std::uint32_t>& lung,
                std::vector<std::uint8_t>& labels) {
  constexpr std::array<std::array<int, 2>, 4> kWays{{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
  const Vec3 spacing = grid.spacing_mm();
  std::vector<std::uint32_t> films;
  for (const std::uint32_t from : lung) {
    const Index3 at = index_of(grid, from);
    for (const auto& way : kWays) {
      const double step_mm = std::hypot(way[0] * spacing[0], way[1] * spacing[1]);
      for (const int sense : {-1, 1}) {
        const std::array<int, 2> step{sense * way[0], sense * way[1]};
        const std::vector<std::uint32_t> film =
            film_from(grid, at, step, step_mm, bright, dark, labels);
        films.insert(films.end(), film.begin(), film.end());
      }
    }
  }
  for (const std::uint32_t voxel : films) labels[voxel] = kLabelBackground;
}

}  // namespace

void let_others_in(const Grid& grid, const std::vector<float>& image, const LayerLevels& levels,
                   std::vector<std::uint8_t>& labels) {
  std::vector<std::uint8_t> bright(labels.size());
  std::vector<std::uint8_t> dark(labels.size());
  const auto least_fat = static_cast<float>(0.5 * (levels.blood + levels.fat));
  const auto most_lung = static_cast<float>(kLungShare * levels.muscle);
  for (int k = 0; k < grid.size[2]; ++k) {
    cv::Mat calm;
    cv::GaussianBlur(slice_of(grid, image, k), calm, {0, 0}, kCalmPx);
    cv::Mat(calm > least_fat).copyTo(slice_of(grid, bright, k));
    cv::Mat(slice_of(grid, image, k) < most_lung).copyTo(slice_of(grid, dark, k));
  }
  (void)let_in(grid, bright, labels);
  drop_films(grid, bright, dark, let_in(grid, dark, labels), labels);
}

}  // namespace beatlas::edges
