#include "pipeline/study/images.h"

#include <cmath>
#include <string>

#include "pipeline/formats/nifti.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::study {
namespace fs = std::filesystem;
namespace {

/// A viewer that saves a file again keeps its place to single precision.
constexpr double kPlaceToleranceMm = 0.01;

/// What helps where a file of the study was saved by another program.
const std::string kSaveAgain =
    "save it again on the grid it had, or have it made anew with --discard-edits";

/// Of a file that cannot be read at all.
Error with_advice(const Error& error) {
  if (error.code() != ErrorCode::InvalidInput) return error;
  return {error.code(), std::string(error.what()) + "; " + kSaveAgain};
}

bool fits_int16(const std::vector<std::vector<float>>& phases) {
  for (const std::vector<float>& phase : phases) {
    for (float value : phase) {
      if (!(std::abs(value) <= 32767.0F) || value != std::floor(value) ||
          (value == 0 && std::signbit(value))) {
        return false;
      }
    }
  }
  return true;
}

template <class T>
void check(const fs::path& file, const ImageCycle<T>& found, const ExpectedImages& expected) {
  const Grid& grid = expected.lps_grid;
  if (found.grid.size != grid.size || found.phase_count() != expected.phases) {
    throw_invalid(file.string() + " has " + std::to_string(found.grid.size[0]) + " x " +
                  std::to_string(found.grid.size[1]) + " x " + std::to_string(found.grid.size[2]) +
                  " voxels in " + std::to_string(found.phase_count()) + " phases, the study says " +
                  std::to_string(grid.size[0]) + " x " + std::to_string(grid.size[1]) + " x " +
                  std::to_string(grid.size[2]) + " in " + std::to_string(expected.phases) + "; " +
                  kSaveAgain);
  }
  for (int corner = 0; corner < 8; ++corner) {
    const double i = (corner & 1) != 0 ? grid.size[0] - 1 : 0;
    const double j = (corner & 2) != 0 ? grid.size[1] - 1 : 0;
    const double k = (corner & 4) != 0 ? grid.size[2] - 1 : 0;
    if (!((found.grid.mm(i, j, k) - grid.mm(i, j, k)).norm() <= kPlaceToleranceMm)) {
      throw_invalid(file.string() +
                    " has its voxels elsewhere in the patient than the study says (moved, turned "
                    "or mirrored); " +
                    kSaveAgain);
    }
  }
}

}  // namespace

void write_images(const fs::path& file, const std::vector<std::vector<float>>& phases,
                  const Grid& lps_grid, double frame_interval_s) {
  const auto storage =
      fits_int16(phases) ? formats::NiftiStorage::Int16 : formats::NiftiStorage::Float32;
  replace_file(file, [&](const fs::path& temporary) {
    formats::write_nifti(temporary, lps_grid, phases, frame_interval_s, storage);
  });
}

void write_labels(const fs::path& file, const std::vector<std::vector<std::uint8_t>>& phases,
                  const Grid& lps_grid, double frame_interval_s) {
  replace_file(file, [&](const fs::path& temporary) {
    formats::write_nifti_labels(temporary, lps_grid, phases, frame_interval_s);
  });
}

ImageCycle<float> read_images(const fs::path& file, const ExpectedImages& expected) {
  ImageCycle<float> images;
  try {
    images = formats::read_nifti(file);
  } catch (const Error& error) {
    throw with_advice(error);
  }
  check(file, images, expected);
  images.grid = expected.grid;
  return images;
}

LabelCycle read_labels(const fs::path& file, const ExpectedImages& expected) {
  LabelCycle labels;
  try {
    labels = formats::read_nifti_labels(file);
  } catch (const Error& error) {
    throw with_advice(error);
  }
  check(file, labels, expected);
  labels.grid = expected.grid;
  return labels;
}

}  // namespace beatlas::study
