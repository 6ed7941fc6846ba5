#include <limits>

#include "pipeline/formats/byte_source.h"
#include "pipeline/formats/header_text.h"
#include "pipeline/formats/nrrd.h"
#include "pipeline/formats/nrrd_header.h"
#include "pipeline/formats/voxel_data.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

namespace fs = std::filesystem;

/// The files beside a header that hold its voxels; none where it holds them itself.
std::vector<fs::path> nrrd_data_files(const fs::path& file, std::string_view text,
                                      const NrrdFields& fields) {
  if (!fields.data_file) return {};
  return data_files(*fields.data_file, text.substr(fields.bytes), file.parent_path());
}

void set_parts(const fs::path& file, std::string_view text, const NrrdFields& fields,
               VoxelLayout& layout) {
  const bool beside = fields.data_file.has_value();
  std::vector<fs::path> files = nrrd_data_files(file, text, fields);
  if (!beside) files.push_back(file);
  for (const fs::path& data : files) {
    const std::int64_t start = beside ? 0 : static_cast<std::int64_t>(fields.bytes);
    layout.parts.push_back({data, after_lines(data, start, fields.line_skip)});
  }
  if (fields.byte_skip < 0) {
    if (layout.packing != Packing::Raw) throw_invalid("only raw data may end with their file");
    for (DataPart& part : layout.parts) part.offset = DataPart::kAtTheEnd;
  } else {
    layout.skip = fields.byte_skip;
  }
}

VoxelLayout layout_of(const NrrdFields& fields, Grid& grid) {
  VoxelLayout layout;
  layout.type = fields.type;
  layout.packing = fields.packing;
  layout.big_endian = fields.big_endian.value_or(false);
  const int frame_axis = frame_axis_of(fields);
  layout.fast = layout.slow = layout.frames = 1;
  std::size_t edge = 0;
  for (int a = 0; a < std::ssize(fields.axes); ++a) {
    const std::int64_t size = fields.axes[static_cast<std::size_t>(a)].size;
    if (a == frame_axis) {
      layout.frames = size;
      continue;
    }
    if (size > std::numeric_limits<int>::max()) throw_invalid("it is too large");
    grid.size[edge++] = static_cast<int>(size);
    std::int64_t& product = a < frame_axis || frame_axis < 0 ? layout.fast : layout.slow;
    if (size > kMostBytes / product)
      throw_invalid("it is truncated: its header names more voxels than the file holds");
    product *= size;
  }
  return layout;
}

}  // namespace

ImageFile read_nrrd(const fs::path& file) {
  try {
    const std::string text = read_start(file);
    const NrrdFields fields = parse_nrrd_header(text);
    ImageFile out;
    out.header = frames_of(fields);
    VoxelLayout layout = layout_of(fields, out.images.grid);
    out.images.grid.mm_from_index = lps_from_index(fields, out.header.note);
    set_parts(file, text, fields, layout);
    out.images.phases = read_voxels(layout);
    return out;
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

std::vector<fs::path> data_files_of_nrrd(const fs::path& file) {
  const std::string text = read_start(file);
  return nrrd_data_files(file, text, parse_nrrd_header(text));
}

}  // namespace beatlas::formats
