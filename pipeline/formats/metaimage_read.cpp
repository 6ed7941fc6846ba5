#include <limits>

#include "pipeline/formats/byte_source.h"
#include "pipeline/formats/header_text.h"
#include "pipeline/formats/metaimage.h"
#include "pipeline/formats/metaimage_header.h"
#include "pipeline/formats/voxel_data.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

namespace fs = std::filesystem;

/// The files beside a header that hold its voxels; none where it holds them itself.
std::vector<fs::path> meta_data_files(const fs::path& file, std::string_view text,
                                      const MetaFields& fields) {
  if (lower(fields.data_file) == "local") return {};
  return data_files(fields.data_file, text.substr(fields.bytes), file.parent_path());
}

VoxelLayout layout_of(const fs::path& file, std::string_view text, const MetaFields& fields,
                      Grid& grid) {
  VoxelLayout layout;
  layout.type = fields.type;
  layout.packing = fields.packing;
  layout.big_endian = fields.big_endian;
  layout.slope = fields.slope;
  layout.intercept = fields.intercept;
  layout.fast = 1;
  for (std::size_t d = 0; d < 3; ++d) {
    if (fields.size[d] > std::numeric_limits<int>::max()) throw_invalid("it is too large");
    grid.size[d] = static_cast<int>(fields.size[d]);
    if (fields.size[d] > kMostBytes / layout.fast) {
      throw_invalid("it is truncated: its header names more voxels than the file holds");
    }
    layout.fast *= fields.size[d];
  }
  layout.frames = fields.size.size() == 4 ? fields.size[3] : 1;
  if (lower(fields.data_file) == "local") {
    layout.parts = {{file, static_cast<std::int64_t>(fields.bytes)}};
    return layout;
  }
  if (fields.header_size < 0 && layout.packing != Packing::Raw) {
    throw_invalid("only raw data may end with their file");
  }
  for (const fs::path& data : meta_data_files(file, text, fields)) {
    layout.parts.push_back(
        {data, fields.header_size < 0 ? DataPart::kAtTheEnd : fields.header_size});
  }
  return layout;
}

}  // namespace

ImageFile read_metaimage(const fs::path& file) {
  try {
    const std::string text = read_start(file);
    const MetaFields fields = parse_meta_header(text);
    ImageFile out;
    out.header = frames_of(fields);
    out.images.grid.mm_from_index = lps_from_index(fields, out.header.note);
    out.images.phases = read_voxels(layout_of(file, text, fields, out.images.grid));
    return out;
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

std::vector<fs::path> data_files_of_metaimage(const fs::path& file) {
  const std::string text = read_start(file);
  return meta_data_files(file, text, parse_meta_header(text));
}

}  // namespace beatlas::formats
