#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include <nifti1_io.h>

#include "pipeline/formats/nifti.h"
#include "pipeline/formats/nifti_geometry.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kLargestDeflateRatio = 1040;  // deflate cannot pack tighter than 1032:1

struct ImageDeleter {
  void operator()(nifti_image* image) const { nifti_image_free(image); }
};
using ImagePtr = std::unique_ptr<nifti_image, ImageDeleter>;

/// Owns an open file; niftilib's own reader is not used because it turns NaN into 0 silently.
class Stream {
 public:
  explicit Stream(znzFile file) : file_(file) {}
  ~Stream() {
    if (!znz_isnull(file_)) znzclose(file_);
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  [[nodiscard]] znzFile get() const { return file_; }

 private:
  znzFile file_;
};

NiftiGeometry geometry_of(const nifti_image& image) {
  NiftiGeometry out;
  out.pixdim_mm = {std::abs(static_cast<double>(image.dx)), std::abs(static_cast<double>(image.dy)),
                   std::abs(static_cast<double>(image.dz))};
  double to_mm = 1;
  if (image.xyz_units == NIFTI_UNITS_METER) to_mm = 1000;
  if (image.xyz_units == NIFTI_UNITS_MICRON) to_mm = 1e-3;
  for (double& edge : out.pixdim_mm) edge *= to_mm;
  const auto affine = [to_mm](const mat44& m) {
    Affine a = Affine::Identity();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 4; ++c) a.matrix()(r, c) = static_cast<double>(m.m[r][c]) * to_mm;
    }
    return a;
  };
  out.has_sform = image.sform_code > 0;
  out.has_qform = image.qform_code > 0;
  out.sform_ras = affine(image.sto_xyz);
  out.qform_ras = affine(image.qto_xyz);
  return out;
}

double interval_s(const nifti_image& image, bool& is_time) {
  is_time = false;
  if (image.nt < 2 || !std::isfinite(image.dt) || image.dt <= 0) return 0;
  const double step = image.dt;
  is_time = true;
  switch (image.time_units) {
    case NIFTI_UNITS_SEC:
      return step;
    case NIFTI_UNITS_MSEC:
      return step * 1e-3;
    case NIFTI_UNITS_USEC:
      return step * 1e-6;
    default:
      is_time = false;
      return step;
  }
}

template <class Stored, class Value, class Convert>
void convert(const std::vector<std::byte>& bytes, std::vector<Value>& out, Convert&& value_of) {
  for (std::size_t i = 0; i < out.size(); ++i) {
    Stored stored;
    std::memcpy(&stored, bytes.data() + i * sizeof(Stored), sizeof(Stored));
    out[i] = value_of(static_cast<double>(stored));
  }
}

template <class Value, class Convert>
void convert_type(int datatype, const std::vector<std::byte>& bytes, std::vector<Value>& out,
                  Convert&& value_of) {
  switch (datatype) {
    case DT_UINT8:
      return convert<std::uint8_t>(bytes, out, value_of);
    case DT_INT8:
      return convert<std::int8_t>(bytes, out, value_of);
    case DT_UINT16:
      return convert<std::uint16_t>(bytes, out, value_of);
    case DT_INT16:
      return convert<std::int16_t>(bytes, out, value_of);
    case DT_UINT32:
      return convert<std::uint32_t>(bytes, out, value_of);
    case DT_INT32:
      return convert<std::int32_t>(bytes, out, value_of);
    case DT_UINT64:
      return convert<std::uint64_t>(bytes, out, value_of);
    case DT_INT64:
      return convert<std::int64_t>(bytes, out, value_of);
    case DT_FLOAT32:
      return convert<float>(bytes, out, value_of);
    case DT_FLOAT64:
      return convert<double>(bytes, out, value_of);
    case DT_RGB24:
    case DT_RGBA32:
      throw_invalid("it is a colour image, grey values are needed");
    default:
      throw_invalid("its voxel type (NIfTI code " + std::to_string(datatype) +
                    ") is no real number that can be read");
  }
}

/// Whether niftilib can be asked: it prints to stderr about headers that are none.
bool looks_like_nifti(const fs::path& file) {
  const Stream stream(znzopen(file.c_str(), "rb", nifti_is_gzfile(file.c_str())));
  nifti_1_header header{};
  if (znz_isnull(stream.get()) ||
      znzread(&header, 1, sizeof(header), stream.get()) != sizeof(header)) {
    return false;
  }
  if (header.dim[0] < 1 || header.dim[0] > 7) nifti_swap_2bytes(1, &header.dim[0]);
  return header.dim[0] >= 1 && header.dim[0] <= 7 &&
         (std::memcmp(header.magic, "n+1", 4) == 0 || std::memcmp(header.magic, "ni1", 4) == 0);
}

ImagePtr open_header(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) throw_invalid("no such file");
  if (!looks_like_nifti(file)) {
    throw_invalid("it is no NIfTI-1 image, or its header is damaged");
  }
  nifti_set_debug_level(0);
  ImagePtr image(nifti_image_read(file.c_str(), 0));
  if (!image || image->nifti_type == NIFTI_FTYPE_ANALYZE) {
    throw_invalid("it is no NIfTI-1 image, or its header is damaged");
  }
  if (image->nx < 1 || image->ny < 1 || image->nz < 1 || image->nt < 1) {
    throw_invalid("its header names an image without voxels");
  }
  if (image->nu > 1 || image->nv > 1 || image->nw > 1) {
    throw_invalid("it has more than four dimensions (x, y, z and time are read)");
  }
  return image;
}

/// Refuses a header that promises more than the file can hold, before memory is asked for.
void check_size(const nifti_image& image, const fs::path& data_file) {
  std::error_code error;
  const auto held = static_cast<double>(fs::file_size(data_file, error));
  if (error) throw_invalid("its data file cannot be read");
  const double needed = static_cast<double>(image.nx) * image.ny * image.nz * image.nt *
                        static_cast<double>(image.nbyper);
  const bool packed = nifti_is_gzfile(data_file.c_str()) != 0;
  const double most = packed ? held * static_cast<double>(kLargestDeflateRatio) : held;
  if (needed + (packed ? 0 : image.iname_offset) > most) {
    throw_invalid("it is truncated: its header names more voxels than the file holds");
  }
}

template <class Value, class Check>
ImageCycle<Value> read_cycle(const fs::path& file, NiftiHeader* header, Check&& checked) {
  const ImagePtr image = open_header(file);
  NiftiHeader told;
  told.frame_interval_s = interval_s(*image, told.has_time_axis);

  ImageCycle<Value> out;
  out.grid.size = {image->nx, image->ny, image->nz};
  out.grid.mm_from_index = lps_from_index(geometry_of(*image), told.note);

  const fs::path data_file = image->iname;
  check_size(*image, data_file);
  const Stream stream(znzopen(data_file.c_str(), "rb", nifti_is_gzfile(data_file.c_str())));
  if (znz_isnull(stream.get()) || znzseek(stream.get(), image->iname_offset, SEEK_SET) < 0) {
    throw_invalid("its data cannot be read");
  }

  double slope = image->scl_slope;
  double intercept = image->scl_inter;
  if (!std::isfinite(slope) || slope == 0 || !std::isfinite(intercept)) {
    slope = 1;
    intercept = 0;
  }
  const auto value_of = [&](double stored) { return checked(stored * slope + intercept); };

  const std::size_t count = out.grid.count();
  std::vector<std::byte> bytes(count * static_cast<std::size_t>(image->nbyper));
  const int native = std::endian::native == std::endian::little ? 1 : 2;
  for (int phase = 0; phase < image->nt; ++phase) {
    if (znzread(bytes.data(), 1, bytes.size(), stream.get()) != bytes.size()) {
      throw_invalid("it is truncated: image " + std::to_string(phase + 1) + " of " +
                    std::to_string(image->nt) + " is incomplete");
    }
    if (image->swapsize > 1 && image->byteorder != native) {
      nifti_swap_Nbytes(bytes.size() / static_cast<std::size_t>(image->swapsize), image->swapsize,
                        bytes.data());
    }
    std::vector<Value> voxels(count);
    convert_type(image->datatype, bytes, voxels, value_of);
    out.phases.push_back(std::move(voxels));
  }
  if (header) *header = told;
  return out;
}

template <class Function>
auto naming(const fs::path& file, Function&& read) {
  try {
    return read();
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

}  // namespace

ImageCycle<float> read_nifti(const fs::path& file, NiftiHeader* header) {
  return naming(file, [&] {
    return read_cycle<float>(file, header, [](double value) {
      if (!(std::abs(value) <= std::numeric_limits<float>::max())) {
        throw_invalid("it holds values that are no numbers (NaN or infinite)");
      }
      return static_cast<float>(value);
    });
  });
}

ImageCycle<std::uint8_t> read_nifti_labels(const fs::path& file, NiftiHeader* header) {
  return naming(file, [&] {
    return read_cycle<std::uint8_t>(file, header, [](double value) {
      constexpr double kRounding = 1e-3;  // a label stored with a slope comes back inexact
      const double whole = std::round(value);
      if (!(std::abs(value - whole) <= kRounding) || whole < 0 || whole > 255) {
        throw_invalid("it is no label image: it holds a value that is no whole number 0..255");
      }
      return static_cast<std::uint8_t>(whole);
    });
  });
}

}  // namespace beatlas::formats
