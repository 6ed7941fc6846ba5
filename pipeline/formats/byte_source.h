#pragma once
/// The unpacked bytes of a file, front to back.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "pipeline/formats/voxel_data.h"

namespace beatlas::formats {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;

  /// Fills `bytes` as far as there is something; fewer than `count` only at the end.
  /// @throws Error{InvalidInput} where packed data are damaged
  [[nodiscard]] virtual std::size_t read(std::byte* bytes, std::size_t count) = 0;

 protected:
  ByteSource() = default;
};

/// @param offset bytes of the file to pass over, >= 0
/// @param packing Text is read as Raw
/// @throws Error{InvalidInput} if the file cannot be read
[[nodiscard]] std::unique_ptr<ByteSource> open_bytes(const std::filesystem::path& file,
                                                     std::int64_t offset, Packing packing);

/// [bytes] of a regular file. @throws Error{InvalidInput} if it is none or is not there
[[nodiscard]] std::int64_t size_of_file(const std::filesystem::path& file);

/// Whether the file starts as gzip does, whatever its name.
[[nodiscard]] bool is_gzip(const std::filesystem::path& file);

}  // namespace beatlas::formats
