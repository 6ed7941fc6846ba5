#include "pipeline/formats/voxel_data.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "pipeline/formats/byte_source.h"
#include "runtime/base/error.h"
#include "runtime/base/plausible_size.h"

namespace beatlas::formats {
namespace {

constexpr std::int64_t kPiece = std::int64_t{1} << 16;       // values converted at a time
constexpr std::int64_t kMostVoxels = std::int64_t{1} << 40;  // products below stay in range
constexpr std::size_t kMostPadding = std::size_t{1} << 24;   // bytes looked at behind the data
constexpr std::int64_t kDeflateRatio = 1040;                 // deflate packs at most 1032:1

/// [bytes] of voxels in each part: all hold alike much.
std::int64_t share_of_a_part(const VoxelLayout& layout) {
  return layout.fast * layout.frames * layout.slow * bytes_of(layout.type) /
         std::ssize(layout.parts);
}

/// A part, from its first voxel on.
std::unique_ptr<ByteSource> open_part(const VoxelLayout& layout, std::size_t number) {
  const DataPart& part = layout.parts[number];
  std::int64_t offset = part.offset;
  if (offset == DataPart::kAtTheEnd) offset = size_of_file(part.file) - share_of_a_part(layout);
  auto source = open_bytes(part.file, std::max<std::int64_t>(offset, 0), layout.packing);
  std::array<std::byte, 4096> passed;
  for (std::int64_t left = layout.skip; left > 0;) {
    const auto want = static_cast<std::size_t>(
        std::min<std::int64_t>(left, static_cast<std::int64_t>(passed.size())));
    if (source->read(passed.data(), want) != want) break;
    left -= static_cast<std::int64_t>(want);
  }
  return source;
}

/// Stored numbers of a part, whatever their type or packing.
class Numbers {
 public:
  Numbers(const VoxelLayout& layout, std::size_t part)
      : layout_(layout),
        source_(open_part(layout, part)),
        size_(static_cast<std::size_t>(bytes_of(layout.type))) {}

  /// The next `count` (at most kPiece) numbers; fewer at the end.
  const std::vector<double>& next(std::int64_t count) {
    values_.clear();
    if (layout_.packing == Packing::Text) {
      for (double value = 0; std::ssize(values_) < count && word(value);) values_.push_back(value);
      return values_;
    }
    bytes_.resize(static_cast<std::size_t>(count) * size_);
    bytes_.resize(source_->read(bytes_.data(), bytes_.size()) / size_ * size_);
    if (layout_.big_endian == (std::endian::native == std::endian::little) && size_ > 1) {
      for (std::size_t at = 0; at < bytes_.size(); at += size_) {
        std::reverse(bytes_.data() + at, bytes_.data() + at + size_);
      }
    }
    convert();
    return values_;
  }
  /// Reads on to where packed data end, so that their check sum is seen.
  void check_end() {
    std::array<std::byte, 4096> more;
    for (std::size_t passed = 0; passed < kMostPadding;) {
      const std::size_t got = source_->read(more.data(), more.size());
      if (got == 0) break;
      passed += got;
    }
  }
  /// Whether nothing is left.
  bool at_end() {
    if (layout_.packing == Packing::Text) {
      double ignored = 0;
      return !word(ignored);
    }
    std::byte more{};
    return source_->read(&more, 1) == 0;
  }

 private:
  template <class Stored>
  void convert_as() {
    values_.resize(bytes_.size() / sizeof(Stored));
    for (std::size_t i = 0; i < values_.size(); ++i) {
      Stored stored;
      std::memcpy(&stored, bytes_.data() + i * sizeof(Stored), sizeof(Stored));
      values_[i] = static_cast<double>(stored);
    }
  }
  void convert() {
    switch (layout_.type) {
      case ScalarType::Int8:
        return convert_as<std::int8_t>();
      case ScalarType::UInt8:
        return convert_as<std::uint8_t>();
      case ScalarType::Int16:
        return convert_as<std::int16_t>();
      case ScalarType::UInt16:
        return convert_as<std::uint16_t>();
      case ScalarType::Int32:
        return convert_as<std::int32_t>();
      case ScalarType::UInt32:
        return convert_as<std::uint32_t>();
      case ScalarType::Int64:
        return convert_as<std::int64_t>();
      case ScalarType::UInt64:
        return convert_as<std::uint64_t>();
      case ScalarType::Float32:
        return convert_as<float>();
      case ScalarType::Float64:
        return convert_as<double>();
    }
  }

  int character() {
    if (at_ == bytes_.size()) {
      bytes_.resize(kPiece);
      bytes_.resize(source_->read(bytes_.data(), bytes_.size()));
      at_ = 0;
      if (bytes_.empty()) return -1;
    }
    return static_cast<int>(bytes_[at_++]);
  }
  bool word(double& value) {
    const auto between = [](int c) {
      return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ',' || c == '\f' || c == '\v';
    };
    int c = character();
    while (between(c)) c = character();
    std::string text;
    constexpr std::size_t kLongestWord = 64;
    for (; c >= 0 && !between(c) && text.size() < kLongestWord; c = character()) {
      text.push_back(static_cast<char>(c));
    }
    if (text.empty()) return false;
    std::string_view digits = text;
    if (digits.starts_with('+')) digits.remove_prefix(1);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size()) {
      throw_invalid("its data hold a word that is no number");
    }
    return true;
  }

  const VoxelLayout& layout_;
  std::unique_ptr<ByteSource> source_;
  std::size_t size_;
  std::vector<std::byte> bytes_;
  std::size_t at_ = 0;  ///< in bytes_, of text
  std::vector<double> values_;
};

[[noreturn]] void truncated() {
  throw_invalid("it is truncated: its header names more voxels than the file holds");
}

[[noreturn]] void wrong_share(const VoxelLayout& layout, std::size_t part, bool longer) {
  throw_invalid("data file " + std::to_string(part + 1) + " of the " +
                std::to_string(layout.parts.size()) + " that its header names is " +
                (longer ? "longer" : "shorter") +
                " than its share of the voxels; correct the header's list, or copy or export the "
                "file again");
}

/// Several parts hold whole images or whole slices, all alike many.
void check_count_of_parts(const VoxelLayout& layout, std::int64_t values) {
  const std::int64_t parts = std::ssize(layout.parts);
  const std::int64_t outer = layout.slow > 1 ? layout.slow : layout.frames;
  if (values % parts == 0 && (outer % parts == 0 || parts % outer == 0)) return;
  throw_invalid("its header names " + std::to_string(parts) + " data files for " +
                std::to_string(layout.frames) + (layout.frames == 1 ? " image" : " images") +
                ": they cannot hold alike much each; correct the header's list");
}

void check_raw_parts(const VoxelLayout& layout) {
  const std::int64_t share = share_of_a_part(layout);
  for (std::size_t part = 0; part < layout.parts.size(); ++part) {
    const std::int64_t offset = layout.parts[part].offset;
    const std::int64_t held =
        size_of_file(layout.parts[part].file) - std::max<std::int64_t>(offset, 0) - layout.skip;
    const bool any_start = offset == DataPart::kAtTheEnd;
    if (held < share || (held > share && !any_start)) {
      wrong_share(layout, part, held > share);
    }
  }
}

/// Packed data could stand for anything: they are believed by their size.
/// @param held bytes of packed data  @param bytes that the voxels take in memory
/// @param skipped unpacked bytes to pass over before them
void check_plausible(std::int64_t held, std::int64_t bytes, std::int64_t skipped) {
  const auto packed = static_cast<std::uint64_t>(std::max<std::int64_t>(held, 0));
  const std::uint64_t most = plausible_bytes(packed, kImageUnpack);
  const auto wanted = static_cast<std::uint64_t>(bytes) + static_cast<std::uint64_t>(skipped);
  if (wanted <= most) return;
  throw_invalid("its header names voxels that take " + in_megabytes(wanted) + ", but its " +
                in_megabytes(packed) + " of packed data are believed to hold at most " +
                in_megabytes(most) +
                "; correct the header, or save the file unpacked if it is right");
}

/// Refuses sizes that cannot be, and what the files are too short for, before memory is asked for.
/// @param value_bytes of a voxel in memory
void check_size(const VoxelLayout& layout, std::size_t value_bytes) {
  std::int64_t values = 1;
  for (const std::int64_t factor : {layout.fast, layout.frames, layout.slow}) {
    if (factor < 1) throw_invalid("its header names an image without voxels");
    if (factor > kMostVoxels / values) truncated();
    values *= factor;
  }
  if (layout.parts.size() > 1) {
    check_count_of_parts(layout, values);
    if (layout.packing == Packing::Raw) check_raw_parts(layout);
  }
  std::int64_t held = 0;
  for (const DataPart& part : layout.parts) {
    held += size_of_file(part.file) - std::max<std::int64_t>(part.offset, 0);
  }
  const std::int64_t bytes = values * bytes_of(layout.type);
  const std::int64_t skipped = layout.skip * static_cast<std::int64_t>(layout.parts.size());
  if (layout.packing == Packing::Raw && held - skipped < bytes) truncated();
  if (layout.packing == Packing::Deflate && held < bytes / kDeflateRatio) truncated();
  if (layout.packing == Packing::Text && held < 2 * values - 1) truncated();
  if (layout.packing == Packing::Deflate || layout.packing == Packing::Bzip2) {
    check_plausible(held, values * static_cast<std::int64_t>(value_bytes), skipped);
  }
}

/// @param row of the layout that is incomplete
[[noreturn]] void ends_within(const VoxelLayout& layout, std::size_t part, std::int64_t row) {
  if (layout.parts.size() > 1) wrong_share(layout, part, false);
  if (layout.slow > 1 || layout.frames == 1) truncated();
  throw_invalid("it is truncated: image " + std::to_string(row + 1) + " of " +
                std::to_string(layout.frames) + " is incomplete");
}

/// Sorts values that come in a layout's order into its frames.
template <class Value>
class FrameSorter {
 public:
  explicit FrameSorter(const VoxelLayout& layout)
      : layout_(layout), room_(layout.fast * layout.slow) {}

  /// @param checked a value with slope and intercept -> as it is kept
  template <class Checked>
  void take(const std::vector<double>& piece, Checked&& checked) {
    for (std::size_t at = 0; at < piece.size();) {
      std::vector<Value>& frame = frame_of(row_ % layout_.frames);
      const auto count = std::min<std::int64_t>(std::ssize(piece) - static_cast<std::int64_t>(at),
                                                layout_.fast - inside_);
      for (std::int64_t i = 0; i < count; ++i) {
        frame.push_back(checked(piece[at++] * layout_.slope + layout_.intercept));
      }
      inside_ += count;
      if (inside_ == layout_.fast) {
        inside_ = 0;
        ++row_;
      }
    }
  }
  /// The row that is not yet complete.
  [[nodiscard]] std::int64_t row() const { return row_; }
  [[nodiscard]] std::vector<std::vector<Value>> frames() && { return std::move(frames_); }

 private:
  std::vector<Value>& frame_of(std::int64_t frame) {
    // Of images one after the other none is begun before its data are there.
    while (std::ssize(frames_) <= frame) {
      frames_.emplace_back();
      frames_.back().reserve(static_cast<std::size_t>(room_));
    }
    return frames_[static_cast<std::size_t>(frame)];
  }

  const VoxelLayout& layout_;
  std::int64_t room_;  ///< values a frame
  std::vector<std::vector<Value>> frames_;
  std::int64_t row_ = 0;     ///< of `fast` values, all of one frame
  std::int64_t inside_ = 0;  ///< values of the row that are read
};

template <class Value, class Checked>
std::vector<std::vector<Value>> read_all(const VoxelLayout& layout, Checked&& checked) {
  check_size(layout, sizeof(Value));
  FrameSorter<Value> sorter(layout);
  std::int64_t left = layout.slow * layout.frames * layout.fast;
  const std::int64_t share = left / std::ssize(layout.parts);
  std::size_t part = 0;
  std::int64_t left_in_part = share;
  auto numbers = std::make_unique<Numbers>(layout, part);
  while (left > 0) {
    if (left_in_part == 0) {
      if (!numbers->at_end()) wrong_share(layout, part, true);
      numbers = std::make_unique<Numbers>(layout, ++part);
      left_in_part = share;
    }
    const std::int64_t want = std::min(left_in_part, kPiece);
    const std::vector<double>& piece = numbers->next(want);
    left -= std::ssize(piece);
    left_in_part -= std::ssize(piece);
    sorter.take(piece, checked);
    if (std::ssize(piece) < want) ends_within(layout, part, sorter.row());
  }
  if (layout.parts.size() > 1 && !numbers->at_end()) wrong_share(layout, part, true);
  numbers->check_end();
  return std::move(sorter).frames();
}

}  // namespace

int bytes_of(ScalarType type) noexcept {
  switch (type) {
    case ScalarType::Int8:
    case ScalarType::UInt8:
      return 1;
    case ScalarType::Int16:
    case ScalarType::UInt16:
      return 2;
    case ScalarType::Int32:
    case ScalarType::UInt32:
    case ScalarType::Float32:
      return 4;
    case ScalarType::Int64:
    case ScalarType::UInt64:
    case ScalarType::Float64:
      return 8;
  }
  return 1;
}

std::vector<std::vector<float>> read_voxels(const VoxelLayout& layout) {
  return read_all<float>(layout, [](double value) {
    if (!(std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max()))) {
      throw_invalid("it holds values that are no numbers (NaN or infinite)");
    }
    return static_cast<float>(value);
  });
}

std::vector<std::vector<std::uint8_t>> read_labels(const VoxelLayout& layout) {
  return read_all<std::uint8_t>(layout, [](double value) {
    constexpr double kRounding = 1e-3;  // a label stored with a slope comes back inexact
    const double whole = std::round(value);
    if (!(std::abs(value - whole) <= kRounding) || whole < 0 || whole > 255) {
      throw_invalid("it is no label image: it holds a value that is no whole number 0..255");
    }
    return static_cast<std::uint8_t>(whole);
  });
}

}  // namespace beatlas::formats
