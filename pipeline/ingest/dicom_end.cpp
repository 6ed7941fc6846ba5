#include "pipeline/ingest/dicom_end.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>

namespace beatlas::ingest {
namespace {

constexpr std::int64_t kUndefined = 0xFFFFFFFF;

class Walk {
 public:
  Walk(const std::filesystem::path& file, const DicomEncoding& encoding)
      : in_(file, std::ios::binary), encoding_(encoding) {
    std::error_code ignored;
    size_ = static_cast<std::int64_t>(std::filesystem::file_size(file, ignored));
  }

  /// Where the fragments that begin at `at` end; nothing if they do not.
  std::optional<std::int64_t> end_of_fragments(std::int64_t at) {
    while (const auto item = bytes<8>(at)) {
      if (number(*item, 0, 2) != 0xFFFE) return std::nullopt;
      at += 8;
      const std::int64_t kind = number(*item, 2, 2);
      if (kind == 0xE0DD) return at;
      if (kind != 0xE000) return std::nullopt;
      at += number(*item, 4, 4);
    }
    return std::nullopt;
  }

  /// Where plain pixels that begin at `at` end: their length stands before them.
  std::optional<std::int64_t> end_of_plain(std::int64_t at, double needed) {
    const auto length = bytes<4>(at - 4);
    if (!length) return std::nullopt;
    const std::int64_t end = at + number(*length, 0, 4);
    // A writer that tells another length has its own idea of what follows.
    if (static_cast<double>(end - at) < needed || number(*length, 0, 4) == kUndefined) {
      return size_;
    }
    return end;
  }

  /// Whether the elements that begin at `at` fill the file.
  bool whole_from(std::int64_t at) {
    while (at < size_) {
      const auto tag = bytes<8>(at);
      // Some archives fill files up with zeros.
      const std::int64_t rest = size_ - at;
      if (!tag) return zeros(at, rest);
      if (number(*tag, 0, 2) == 0) return true;
      std::int64_t length = number(*tag, 4, 4);
      at += 8;
      if (!encoding_.implicit) {
        const std::string_view kind(reinterpret_cast<const char*>(tag->data()) + 4, 2);
        if (!std::all_of(kind.begin(), kind.end(), [](char c) { return c >= 'A' && c <= 'Z'; })) {
          return true;
        }
        length = number(*tag, 6, 2);
        if (is_long(kind)) {
          const auto words = bytes<4>(at);
          if (!words) return false;
          length = number(*words, 0, 4);
          at += 4;
        }
      }
      if (length == kUndefined) return true;  // a sequence: its end is not looked for
      at += length;
    }
    return at == size_;
  }

 private:
  template <std::size_t N>
  std::optional<std::array<unsigned char, N>> bytes(std::int64_t at) {
    std::array<unsigned char, N> out{};
    in_.clear();
    if (!in_.seekg(at) || !in_.read(reinterpret_cast<char*>(out.data()), N)) return std::nullopt;
    return out;
  }

  template <std::size_t N>
  std::int64_t number(const std::array<unsigned char, N>& from, std::size_t first,
                      std::size_t count) const {
    std::int64_t out = 0;
    for (std::size_t i = 0; i < count; ++i) {
      out = out << 8 | from[first + (encoding_.big_endian ? i : count - 1 - i)];
    }
    return out;
  }

  bool zeros(std::int64_t at, std::int64_t count) {
    in_.clear();
    in_.seekg(at);
    for (std::int64_t i = 0; i < count; ++i) {
      if (in_.get() != 0) return false;
    }
    return true;
  }

  static bool is_long(std::string_view kind) {
    constexpr std::array<std::string_view, 13> kLong{"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                                     "SV", "UC", "UN", "UR", "UT", "UV"};
    return std::find(kLong.begin(), kLong.end(), kind) != kLong.end();
  }

  std::ifstream in_;
  DicomEncoding encoding_;
  std::int64_t size_ = 0;
};

}  // namespace

bool goes_on_to_its_end(const std::filesystem::path& file, std::int64_t pixels,
                        double pixels_needed, const DicomEncoding& encoding) {
  Walk walk(file, encoding);
  const auto end =
      encoding.packed ? walk.end_of_fragments(pixels) : walk.end_of_plain(pixels, pixels_needed);
  return end && walk.whole_from(*end);
}

}  // namespace beatlas::ingest
