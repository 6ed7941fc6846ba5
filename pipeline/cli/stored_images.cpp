#include "pipeline/cli/stored_images.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "runtime/atlas/volume.h"

namespace beatlas::cli {
namespace {

constexpr double kWholeNumbersFrom = 4;  // of noise: rounding adds 0.3 to it, which is nothing

/// Where the volume's first voxel lies in the source; nothing if it is not a part of its grid.
std::optional<Index3> place_in(const atlas::VolumePayload& volume, const Grid& source,
                               const Affine& workspace_from_lps) {
  if (source.count() == 0) return std::nullopt;
  const Affine source_from_volume =
      (workspace_from_lps * source.mm_from_index).inverse() * volume.workspace_from_index;
  constexpr double kTolerance = 1e-3;  // of a voxel
  if (!source_from_volume.linear().isIdentity(1e-6)) return std::nullopt;
  Index3 first{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = source_from_volume.translation()[static_cast<Eigen::Index>(axis)];
    if (std::abs(at - std::round(at)) > kTolerance) return std::nullopt;
    if (at < -kTolerance || at + volume.size[axis] > source.size[axis] + kTolerance) {
      return std::nullopt;
    }
    first[axis] = static_cast<int>(std::lround(at));
  }
  return first;
}

}  // namespace

ImageCycle<float> images_of(const atlas::VolumePayload& volume, const Grid& lps_source,
                            const Affine& workspace_from_lps) {
  const std::optional<Index3> first = place_in(volume, lps_source, workspace_from_lps);
  ImageCycle<float> out;
  out.grid = first ? lps_source
                   : Grid{volume.size, workspace_from_lps.inverse() * volume.workspace_from_index};
  const Index3 at = first.value_or(Index3{0, 0, 0});
  std::vector<float> part(volume.sample_count());
  for (int p = 0; p < volume.phases; ++p) {
    atlas::volume_intensities(volume, static_cast<double>(p) / volume.phases, part);
    if (volume.noise >= kWholeNumbersFrom) {
      for (float& value : part) value = std::round(value);
    }
    std::vector<float> phase(out.grid.count(), 0.0F);
    auto row = part.begin();
    for (int k = 0; k < volume.size[2]; ++k) {
      for (int j = 0; j < volume.size[1]; ++j, row += volume.size[0]) {
        std::copy_n(row, volume.size[0],
                    phase.begin() +
                        static_cast<std::ptrdiff_t>(out.grid.offset(at[0], at[1] + j, at[2] + k)));
      }
    }
    out.phases.push_back(std::move(phase));
  }
  return out;
}

}  // namespace beatlas::cli
