#include "runtime/viewer/image_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace beatlas::viewer {
namespace {

/// Between which samples a place lies.
struct Cell {
  std::array<int, 3> low;
  std::array<double, 3> u;  ///< from the lower sample to the higher, 0..1
};

/// False for a place outside of the images.
bool find_cell(const atlas::VolumePayload& volume, const Vec3& index, Cell& cell) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = index[static_cast<Eigen::Index>(axis)];
    const int size = volume.size[axis];
    // Half a voxel of border belongs to the image.
    if (!(at >= -0.5 && at <= size - 0.5)) return false;
    const double held = std::clamp(at, 0.0, size - 1.0);
    cell.low[axis] = std::clamp(static_cast<int>(held), 0, std::max(0, size - 2));
    cell.u[axis] = size > 1 ? held - cell.low[axis] : 0;
  }
  return true;
}

template <class Sample>
bool sample_at(const atlas::VolumePayload& volume, std::span<const Sample> samples,
               const Vec3& index, double& value) {
  Cell cell;
  if (!find_cell(volume, index, cell)) return false;
  const auto n = [](int v) { return static_cast<std::size_t>(v); };
  const std::size_t row = n(volume.size[0]);
  const std::size_t slice = row * n(volume.size[1]);
  const std::size_t first = n(cell.low[0]) + row * n(cell.low[1]) + slice * n(cell.low[2]);
  const std::array<std::size_t, 3> to_higher{1, row, slice};
  value = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::size_t at = first;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool high = (corner >> axis) % 2 == 1;
      weight *= high ? cell.u[axis] : 1 - cell.u[axis];
      if (high && volume.size[axis] > 1) at += to_higher[axis];
    }
    if (weight > 0) value += weight * static_cast<double>(samples[at]);
  }
  return true;
}

double quantile(std::vector<float> values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

}  // namespace

PlaneAxes plane_axes(const Vec3& normal) {
  const Vec3 n = normal.normalized();
  Eigen::Index least = 0;
  n.cwiseAbs().minCoeff(&least);
  const Vec3 x = Vec3::Unit(least).cross(n).normalized();
  return {.x = x, .y = n.cross(x)};
}

PlaneGrid cut_grid(const atlas::VolumePayload& volume, const Vec3& point_mm, const Vec3& normal,
                   double pixel_mm) {
  std::array<Vec3, 8> corners;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    Vec3 index;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool high = (corner >> axis) % 2 == 1;
      index[static_cast<Eigen::Index>(axis)] = high ? volume.size[axis] - 0.5 : -0.5;
    }
    corners[corner] = volume.workspace_from_index * index;
  }
  const Vec3 n = normal.normalized();
  const PlaneAxes axes = plane_axes(normal);
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 high = -low;
  for (std::size_t a = 0; a < 8; ++a) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t b = a | (std::size_t{1} << axis);
      if (b == a) continue;
      const double from = n.dot(corners[a] - point_mm);
      const double to = n.dot(corners[b] - point_mm);
      if ((from >= 0) == (to >= 0)) continue;
      const Vec3 hit = corners[a] + from / (from - to) * (corners[b] - corners[a]) - point_mm;
      const Vec2 in_plane(axes.x.dot(hit), axes.y.dot(hit));
      low = low.cwiseMin(in_plane);
      high = high.cwiseMax(in_plane);
    }
  }
  PlaneGrid grid;
  grid.x_mm = pixel_mm * axes.x;
  grid.y_mm = pixel_mm * axes.y;
  if (!(low.x() < high.x() && low.y() < high.y())) return grid;
  constexpr double kMostPixels = 1024;
  grid.width = static_cast<int>(std::min(kMostPixels, std::ceil((high.x() - low.x()) / pixel_mm)));
  grid.height = static_cast<int>(std::min(kMostPixels, std::ceil((high.y() - low.y()) / pixel_mm)));
  grid.corner_mm = point_mm + low.x() * axes.x + low.y() * axes.y;
  return grid;
}

void sample_cut(const atlas::VolumePayload& volume, std::span<const std::uint8_t> samples,
                const PlaneGrid& grid, std::span<std::uint8_t> grey_alpha) {
  const Affine index_from_workspace = volume.workspace_from_index.inverse();
  const Vec3 corner = index_from_workspace * grid.corner_mm;
  const Vec3 x = index_from_workspace.linear() * grid.x_mm;
  const Vec3 y = index_from_workspace.linear() * grid.y_mm;
  std::size_t to = 0;
  for (int j = 0; j < grid.height; ++j) {
    for (int i = 0; i < grid.width; ++i, to += 2) {
      double value = 0;
      const bool inside = sample_at(volume, samples, corner + (i + 0.5) * x + (j + 0.5) * y, value);
      grey_alpha[to] = inside ? static_cast<std::uint8_t>(std::lround(value)) : 0;
      grey_alpha[to + 1] = inside ? 255 : 0;
    }
  }
}

TissueIntensities tissue_intensities(const atlas::VolumePayload& volume, int phase,
                                     const atlas::SurfacePayload* lv_blood,
                                     const atlas::SurfacePayload* lv_myocardium) {
  std::vector<float> samples(volume.sample_count());
  const double beats = static_cast<double>(phase) / volume.phases;
  atlas::volume_intensities(volume, beats, samples);
  TissueIntensities tissue{.muscle = quantile(samples, 0.5), .blood = quantile(samples, 0.9)};
  if (!(tissue.blood > tissue.muscle)) tissue.blood = tissue.muscle + 1;
  if (lv_blood == nullptr || lv_myocardium == nullptr) return tissue;

  const Affine index_from_workspace = volume.workspace_from_index.inverse();
  const auto median_along = [&](const atlas::SurfacePayload& surface, const auto& place) {
    const auto at_phase = static_cast<std::size_t>(phase) % surface.positions.size();
    std::vector<float> found;
    for (const Vec3f& position : surface.positions[at_phase]) {
      double value = 0;
      if (sample_at(volume, std::span<const float>(samples),
                    index_from_workspace * place(position.cast<double>()), value)) {
        found.push_back(static_cast<float>(value));
      }
    }
    return found.empty() ? std::numeric_limits<double>::quiet_NaN() : quantile(found, 0.5);
  };
  Vec3 middle = Vec3::Zero();
  const auto& cavity =
      lv_blood->positions[static_cast<std::size_t>(phase) % lv_blood->positions.size()];
  for (const Vec3f& position : cavity) middle += position.cast<double>();
  middle /= static_cast<double>(cavity.size());
  // Half-way to the cavity's middle is blood; a little outside of the cavity is the muscle.
  constexpr double kIntoBlood = 0.5;
  constexpr double kIntoMuscle = 1.2;
  const auto along = [&](double share) {
    return [&middle, share](const Vec3& x) { return Vec3(middle + share * (x - middle)); };
  };
  const TissueIntensities measured{.muscle = median_along(*lv_blood, along(kIntoMuscle)),
                                   .blood = median_along(*lv_blood, along(kIntoBlood))};
  return measured.blood > measured.muscle ? measured : tissue;
}

}  // namespace beatlas::viewer
