#include <array>
#include <limits>
#include <span>

#include "pipeline/formats/byte_source.h"
#include "pipeline/formats/nifti.h"
#include "pipeline/formats/nifti_geometry.h"
#include "pipeline/formats/nifti_header.h"
#include "pipeline/formats/voxel_data.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

namespace fs = std::filesystem;

/// `file` with the stem of its name and another end, whatever the case of the end it has.
fs::path with_end(const fs::path& file, const std::string& end) {
  std::string name = file.filename().string();
  const auto dot = name.rfind(
      '.', name.size() > 3 && name.ends_with(".gz") ? name.size() - 4 : std::string::npos);
  return file.parent_path() / (name.substr(0, dot) + end);
}

/// The first of some files that is there; empty if none is.
fs::path first_there(std::initializer_list<fs::path> files) {
  std::error_code ignored;
  for (const fs::path& file : files) {
    if (fs::is_regular_file(file, ignored)) return file;
  }
  return {};
}

bool has_image_end(const fs::path& file) {
  std::string name = file.filename().string();
  if (name.ends_with(".gz") || name.ends_with(".GZ")) name.resize(name.size() - 3);
  return name.ends_with(".img") || name.ends_with(".IMG");
}

/// Of a pair either file may be named.
fs::path header_file(const fs::path& file) {
  if (!has_image_end(file)) return file;
  const fs::path header =
      first_there({with_end(file, ".hdr"), with_end(file, ".HDR"), with_end(file, ".hdr.gz")});
  if (header.empty()) throw_invalid("the header (.hdr) that belongs to it is not beside it");
  return header;
}

fs::path voxel_file(const fs::path& header) {
  const fs::path voxels = first_there(
      {with_end(header, ".img"), with_end(header, ".IMG"), with_end(header, ".img.gz")});
  if (voxels.empty()) throw_invalid("the voxels (.img) that belong to it are not beside it");
  return voxels;
}

Packing packing_of(const fs::path& file) { return is_gzip(file) ? Packing::Deflate : Packing::Raw; }

struct NiftiStart {
  fs::path header;
  NiftiFields fields;
  fs::path voxels;  ///< the file that holds them: the same, or the other of a pair
};

NiftiStart read_nifti_start(const fs::path& named) {
  if (size_of_file(named) == 0) throw_invalid("it is empty");
  NiftiStart out;
  out.header = header_file(named);
  std::array<std::byte, kNiftiHeaderBytes> start{};
  const std::size_t got =
      open_bytes(out.header, 0, packing_of(out.header))->read(start.data(), start.size());
  out.fields = parse_nifti_header(std::span(start).first(got));
  out.voxels = out.fields.pair ? voxel_file(out.header) : out.header;
  return out;
}

VoxelLayout read_layout(const fs::path& named, Grid& grid, ImageFileHeader& told) {
  const NiftiStart start = read_nifti_start(named);
  const NiftiFields& fields = start.fields;
  told = frames_of(fields);
  for (std::size_t d = 0; d < 3; ++d) {
    if (fields.size[d] > std::numeric_limits<int>::max()) throw_invalid("it is too large");
    grid.size[d] = static_cast<int>(fields.size[d]);
  }
  grid.mm_from_index = lps_from_index(geometry_of(fields), told.note);

  VoxelLayout layout;
  layout.type = fields.type;
  layout.big_endian = fields.big_endian;
  layout.packing = packing_of(start.voxels);
  // The place of the voxels counts unpacked bytes.
  const bool packed = layout.packing == Packing::Deflate;
  layout.parts = {{start.voxels, packed ? 0 : fields.offset}};
  layout.skip = packed ? fields.offset : 0;
  layout.fast = fields.size[0] * fields.size[1];
  if (fields.size[2] > (std::int64_t{1} << 40) / layout.fast) throw_invalid("it is truncated");
  layout.fast *= fields.size[2];
  layout.frames = fields.size[3];
  layout.slope = fields.slope;
  layout.intercept = fields.intercept;
  return layout;
}

template <class Value, class Read>
ImageCycle<Value> read_cycle(const fs::path& file, ImageFileHeader* header, Read&& read) {
  try {
    ImageFileHeader told;
    ImageCycle<Value> out;
    const VoxelLayout layout = read_layout(file, out.grid, told);
    out.phases = read(layout);
    if (header) *header = told;
    return out;
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

}  // namespace

ImageCycle<float> read_nifti(const fs::path& file, ImageFileHeader* header) {
  return read_cycle<float>(file, header, read_voxels);
}

std::vector<fs::path> files_of_nifti(const fs::path& file) {
  const NiftiStart start = read_nifti_start(file);
  if (!start.fields.pair) return {start.header};
  return {start.header, start.voxels};
}

ImageCycle<std::uint8_t> read_nifti_labels(const fs::path& file, ImageFileHeader* header) {
  return read_cycle<std::uint8_t>(file, header, read_labels);
}

}  // namespace beatlas::formats
