#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include <nifti1_io.h>

#include "pipeline/core/parallel.h"
#include "pipeline/formats/nifti.h"
#include "pipeline/formats/nifti_geometry.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

namespace fs = std::filesystem;

static_assert(sizeof(nifti_1_header) == 348);

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

void set_geometry(nifti_1_header& header, const Grid& grid) {
  const Affine ras = flip_lps_ras(grid.mm_from_index);
  const Vec3 spacing = grid.spacing_mm();
  mat44 m{};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) m.m[r][c] = static_cast<float>(ras.matrix()(r, c));
  }
  m.m[3][3] = 1;
  for (int c = 0; c < 4; ++c) {
    header.srow_x[c] = m.m[0][c];
    header.srow_y[c] = m.m[1][c];
    header.srow_z[c] = m.m[2][c];
  }
  float dx = 0;
  float dy = 0;
  float dz = 0;
  float handedness = 1;
  nifti_mat44_to_quatern(m, &header.quatern_b, &header.quatern_c, &header.quatern_d,
                         &header.qoffset_x, &header.qoffset_y, &header.qoffset_z, &dx, &dy, &dz,
                         &handedness);
  header.pixdim[0] = handedness;
  for (int c = 0; c < 3; ++c) header.pixdim[c + 1] = static_cast<float>(spacing[c]);
  header.sform_code = NIFTI_XFORM_SCANNER_ANAT;
  header.qform_code = NIFTI_XFORM_SCANNER_ANAT;
}

nifti_1_header make_header(const Grid& grid, int phases, double frame_interval_s, short datatype,
                           short bits) {
  nifti_1_header header{};
  header.sizeof_hdr = sizeof(nifti_1_header);
  header.regular = 'r';
  header.dim[0] = phases > 1 ? 4 : 3;
  for (int d = 1; d < 8; ++d) header.dim[d] = 1;
  for (int d = 0; d < 3; ++d) {
    const int size = grid.size[static_cast<std::size_t>(d)];
    if (size < 1 || size > std::numeric_limits<short>::max()) {
      throw_invalid("NIfTI-1 cannot hold an edge of " + std::to_string(size) + " voxels");
    }
    header.dim[d + 1] = static_cast<short>(size);
  }
  header.dim[4] = static_cast<short>(phases);
  for (int d = 0; d < 8; ++d) header.pixdim[d] = 1;
  header.pixdim[4] = static_cast<float>(frame_interval_s);
  header.datatype = datatype;
  header.bitpix = bits;
  header.vox_offset = sizeof(nifti_1_header) + 4;  // four bytes say: no extensions
  header.scl_slope = 1;
  header.xyzt_units = static_cast<char>(SPACE_TIME_TO_XYZT(NIFTI_UNITS_MM, NIFTI_UNITS_SEC));
  std::memcpy(header.descrip, "beatlas", 7);  // unless the caller says another
  std::memcpy(header.magic, "n+1", 4);
  set_geometry(header, grid);
  return header;
}

/// A file that is closed, and removed unless it was finished.
class Output {
 public:
  explicit Output(const fs::path& file) : file_(file) {
    // Level 1: a cine packs to within a tenth of level 6 in a quarter of its time.
    const bool packed = ends_with(file.string(), ".gz");
    stream_ = znzopen(file.c_str(), packed ? "wb1" : "wb", packed ? 1 : 0);
    if (znz_isnull(stream_)) fail();
  }
  ~Output() {
    if (znz_isnull(stream_)) return;
    znzclose(stream_);
    std::error_code ignored;
    fs::remove(file_, ignored);
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  void write(const void* bytes, std::size_t count) {
    if (znzwrite(bytes, 1, count, stream_) != count) fail();
  }
  void finish() {
    if (znzclose(stream_) != 0) fail();  // sets the stream to null
  }

 private:
  [[noreturn]] void fail() const {
    throw Error(ErrorCode::Machine, file_.string() + ": cannot be written");
  }
  fs::path file_;
  znzFile stream_ = nullptr;
};

template <class T>
using Phases = std::vector<std::vector<T>>;

template <class T>
void check(const fs::path& file, const Grid& grid, const Phases<T>& phases,
           double frame_interval_s) {
  const std::string name = file.string();
  if (!ends_with(name, ".nii") && !ends_with(name, ".nii.gz")) {
    throw_invalid(name + ": the name of a NIfTI file ends in .nii or .nii.gz");
  }
  if (phases.empty() || phases.size() > 32767) {
    throw_invalid(name + ": a NIfTI-1 file holds 1 to 32767 images");
  }
  for (const auto& phase : phases) {
    if (phase.size() != grid.count()) throw_invalid(name + ": images do not fill the grid");
  }
  if (!(frame_interval_s >= 0)) throw_invalid(name + ": the frame interval must be 0 or more");
}

template <class Stored, class T, class Convert>
void write_all(const fs::path& file, const Phases<T>& phases, const nifti_1_header& header,
               Convert&& stored_of) {
  Output out(file);
  out.write(&header, sizeof(header));
  const std::array<char, 4> no_extensions{};
  out.write(no_extensions.data(), no_extensions.size());
  std::vector<Stored> stored(phases.front().size());
  for (const auto& phase : phases) {
    check_stop_flag();
    std::transform(phase.begin(), phase.end(), stored.begin(), stored_of);
    out.write(stored.data(), stored.size() * sizeof(Stored));
  }
  out.finish();
}

/// 1 where rounding to whole numbers costs less than a thousandth of the range, else the step that
/// uses all of int16.
double int16_slope(const Phases<float>& phases, const fs::path& file) {
  constexpr double kMost = 32767;
  constexpr double kFine = 500;  // half a step is then a thousandth of the range
  double most = 0;
  bool whole = true;
  for (const auto& phase : phases) {
    for (const float value : phase) {
      if (!std::isfinite(value)) {
        throw_invalid(file.string() + ": a voxel to write is no number");
      }
      most = std::max(most, std::abs(static_cast<double>(value)));
      whole = whole && value == std::round(value);
    }
  }
  if (most <= kMost && (whole || most >= kFine)) return 1;
  // As the header keeps it, so that reader and writer mean the same step.
  return static_cast<double>(static_cast<float>(most / kMost));
}

}  // namespace

void write_nifti(const fs::path& file, const Grid& grid, const Phases<float>& phases,
                 double frame_interval_s, NiftiStorage storage, const std::string& description) {
  check(file, grid, phases, frame_interval_s);
  if (description.size() >= sizeof(nifti_1_header::descrip)) {
    throw_invalid(file.string() + ": its description must have less than 80 characters");
  }
  const int count = static_cast<int>(phases.size());
  const auto header_of = [&](short datatype, short bits) {
    nifti_1_header header = make_header(grid, count, frame_interval_s, datatype, bits);
    std::fill(std::begin(header.descrip), std::end(header.descrip), '\0');
    std::copy(description.begin(), description.end(), header.descrip);
    return header;
  };
  if (storage == NiftiStorage::Float32) {
    const auto header = header_of(DT_FLOAT32, 32);
    write_all<float>(file, phases, header, [](float value) { return value; });
  } else if (storage == NiftiStorage::UInt16Fraction) {
    auto header = header_of(DT_UINT16, 16);
    header.scl_slope = 1.0F / 65535.0F;
    write_all<std::uint16_t>(file, phases, header, [](float value) {
      const float part = value > 0 ? std::min(value, 1.0F) : 0.0F;  // also NaN -> 0
      return static_cast<std::uint16_t>(std::lround(part * 65535.0F));
    });
  } else {
    const double slope = int16_slope(phases, file);
    auto header = header_of(DT_INT16, 16);
    header.scl_slope = static_cast<float>(slope);
    write_all<std::int16_t>(file, phases, header, [slope](float value) {
      const double step = std::clamp(static_cast<double>(value) / slope, -32768.0, 32767.0);
      return static_cast<std::int16_t>(std::lround(step));
    });
  }
}

void write_nifti_labels(const fs::path& file, const Grid& grid, const Phases<std::uint8_t>& phases,
                        double frame_interval_s) {
  check(file, grid, phases, frame_interval_s);
  const int count = static_cast<int>(phases.size());
  const auto header = make_header(grid, count, frame_interval_s, DT_UINT8, 8);
  write_all<std::uint8_t>(file, phases, header, [](std::uint8_t value) { return value; });
}

void write_nifti(const fs::path& file, const ImageCycle<float>& images, double frame_interval_s,
                 NiftiStorage storage, const std::string& description) {
  write_nifti(file, images.grid, images.phases, frame_interval_s, storage, description);
}

void write_nifti_labels(const fs::path& file, const ImageCycle<std::uint8_t>& labels,
                        double frame_interval_s) {
  write_nifti_labels(file, labels.grid, labels.phases, frame_interval_s);
}

}  // namespace beatlas::formats
