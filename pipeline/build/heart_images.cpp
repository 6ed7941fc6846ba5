#include "pipeline/build/heart_images.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "pipeline/pack/volume_encoder.h"

namespace beatlas::build {
namespace {

HeartImages cut(const ImageCycle<float>& from, const StackBox& of, const StackBox& box) {
  assert(of.holds(box));
  Index3 offset{};
  for (std::size_t axis = 0; axis < 3; ++axis) offset[axis] = box.first[axis] - of.first[axis];
  HeartImages out;
  out.box = box;
  out.images.grid = from.grid.part(offset, box.size);
  for (const std::vector<float>& phase : from.phases) {
    std::vector<float> part;
    part.reserve(out.images.grid.count());
    for (int k = 0; k < box.size[2]; ++k) {
      for (int j = 0; j < box.size[1]; ++j) {
        const auto row = phase.begin() + static_cast<std::ptrdiff_t>(from.grid.offset(
                                             offset[0], offset[1] + j, offset[2] + k));
        part.insert(part.end(), row, row + box.size[0]);
      }
    }
    out.images.phases.push_back(std::move(part));
  }
  return out;
}

}  // namespace

bool StackBox::holds(const StackBox& other) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (other.first[axis] < first[axis]) return false;
    if (other.first[axis] + other.size[axis] > first[axis] + size[axis]) return false;
  }
  return true;
}

StackBox box_around(const Grid& lps_stack, const Affine& workspace_from_lps, const Grid& lattice,
                    double margin_mm) {
  const Affine index_from_workspace = (workspace_from_lps * lps_stack.mm_from_index).inverse();
  Vec3 low = Vec3::Constant(1e9);
  Vec3 high = Vec3::Constant(-1e9);
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 at;
    for (int axis = 0; axis < 3; ++axis) {
      const bool far = (corner >> axis & 1) != 0;
      at[axis] = far ? lattice.size[static_cast<std::size_t>(axis)] - 1 : 0;
    }
    at = lattice.mm_from_index * at;
    low = low.cwiseMin(index_from_workspace * at);
    high = high.cwiseMax(index_from_workspace * at);
  }
  StackBox box;
  const Vec3 spacing_mm = lps_stack.spacing_mm();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    const double margin = margin_mm / spacing_mm[a];
    const double size = lps_stack.size[axis];
    const double first = std::clamp(std::floor(low[a] - margin), 0.0, size);
    const double end = std::clamp(std::ceil(high[a] + margin) + 1, first, size);
    box.first[axis] = static_cast<int>(first);
    box.size[axis] = static_cast<int>(end - first);
  }
  return box;
}

HeartImages cut_images(const HeartImages& from, const Grid& stack, const StackBox& box) {
  HeartImages out = cut(from.images, from.box, box);
  out.images.grid = stack.part(box.first, box.size);
  out.noise = from.noise;
  return out;
}

HeartImages cut_images(const ImageCycle<float>& stack, double noise, const StackBox& box) {
  HeartImages out = cut(stack, {{0, 0, 0}, stack.grid.size}, box);
  out.noise = noise;
  return out;
}

pack::PackedVolume packed_volume(HeartImages around, const Affine& workspace_from_lps,
                                 const FieldCycle& heart, const pack::EncodeOptions& options) {
  around.images.grid.mm_from_index = workspace_from_lps * around.images.grid.mm_from_index;
  return pack::pack_volume(around.images, around.noise, heart, options);
}

}  // namespace beatlas::build
