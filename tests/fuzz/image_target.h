#pragma once
/// What must hold for an image file of any format that was read.

#include "pipeline/formats/image_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/unit/formats/image_bytes.h"

namespace beatlas::fuzz {

inline void read_image(const std::filesystem::path& file) {
  only_errors([&] {
    const formats::ImageFile image = formats::read_image_file(file);
    for (const auto& phase : image.images.phases) {
      require(phase.size() == image.images.grid.count());
    }
    require(image.images.grid.mm_from_index.matrix().allFinite());
    require(image.images.grid.voxel_ml() > 0);
  });
}

[[nodiscard]] inline test::Beating tiny_object() {
  test::Beating out = test::oblique_object();
  out.grid.size = {4, 3, 3};
  out.frames = 3;
  return out;
}

}  // namespace beatlas::fuzz
