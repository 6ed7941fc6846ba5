#pragma once
/// Voxels as files hold them -> numbers. What a header of any format says of its data is a
/// VoxelLayout; how the bytes are packed is known here alone.

#include <cstdint>
#include <filesystem>
#include <vector>

namespace beatlas::formats {

enum class ScalarType {
  Int8,
  UInt8,
  Int16,
  UInt16,
  Int32,
  UInt32,
  Int64,
  UInt64,
  Float32,
  Float64,
};
[[nodiscard]] int bytes_of(ScalarType type) noexcept;

enum class Packing {
  Raw,
  Deflate,  ///< gzip or zlib, told apart by its first bytes
  Bzip2,
  Text,  ///< numbers as words
};

/// A file, or the rest of one, that holds voxels.
struct DataPart {
  static constexpr std::int64_t kAtTheEnd = -1;
  std::filesystem::path file;
  std::int64_t offset = 0;  ///< bytes before the data; kAtTheEnd: the data end with the file (Raw)
};

/// The parts follow each other; of several each holds the same number of voxels and nothing behind
/// them. Within them the order is slow x frame x fast, fast first: an image
/// after the other has slow = 1, all images' values of a voxel side by side fast = 1.
struct VoxelLayout {
  ScalarType type{};
  bool big_endian = false;
  Packing packing = Packing::Raw;
  std::vector<DataPart> parts;
  std::int64_t skip = 0;  ///< unpacked bytes to pass over at the start of each part
  std::int64_t fast = 0;
  std::int64_t frames = 0;
  std::int64_t slow = 1;
  double slope = 1;  ///< value = slope * stored + intercept
  double intercept = 0;
};

/// @return [frame][voxel]
/// Memory is taken as data arrive, and of packed data no more than is plausible
/// (runtime/base/plausible_size.h), so a header that promises much costs nothing; beside the result
/// only small buffers are held.
/// @throws Error{InvalidInput} with a clause that follows "FILE: ": truncated, damaged, packed data
///         that are too small for what the header promises, parts that
///         are not of one size (named by number), more voxels than can be, a value that is no
///         finite float
[[nodiscard]] std::vector<std::vector<float>> read_voxels(const VoxelLayout& layout);
/// The same for labels. @throws Error{InvalidInput} also if a value is no whole number 0..255
[[nodiscard]] std::vector<std::vector<std::uint8_t>> read_labels(const VoxelLayout& layout);

}  // namespace beatlas::formats
