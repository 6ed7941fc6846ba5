#include "pipeline/ingest/dicom_end.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace beatlas::ingest {
namespace {

constexpr std::int64_t kUndefined = 0xFFFFFFFF;
constexpr std::int64_t kItem = 0xE000;
constexpr std::int64_t kItemEnd = 0xE00D;
constexpr std::int64_t kSequenceEnd = 0xE0DD;
constexpr std::int64_t kPixelGroup = 0x7FE0;
constexpr int kDeepest = 32;

class Walk {
 public:
  Walk(const std::filesystem::path& file, const DicomEncoding& encoding)
      : in_(file, std::ios::binary), encoding_(encoding) {
    std::error_code ignored;
    size_ = static_cast<std::int64_t>(std::filesystem::file_size(file, ignored));
  }

  /// Where the fragments that begin at `at` end; nothing if they do not.
  std::optional<std::int64_t> end_of_fragments(std::int64_t at) {
    least_group_ = kPixelGroup;
    int fragments = -1;  // the first item is a table
    while (const auto item = bytes<8>(at)) {
      if (number(*item, 0, 2, false) != 0xFFFE) return std::nullopt;
      at += 8;
      const std::int64_t kind = number(*item, 2, 2, false);
      // A frame takes a fragment or more (PS3.5 A.4).
      if (kind == kSequenceEnd)
        return fragments >= encoding_.frames ? std::optional(at) : std::nullopt;
      if (kind != kItem) return std::nullopt;
      at += number(*item, 4, 4, false);
      ++fragments;
    }
    // Only the mark behind the fragments is missing.
    const bool all = encoding_.frames > 0 && fragments >= encoding_.frames && at == size_;
    return all && fragments_close(fragments, at) ? std::optional(size_) : std::nullopt;
  }

  /// Where plain pixels that begin at `at` end: their length stands before them.
  std::optional<std::int64_t> end_of_plain(std::int64_t at, double needed) {
    least_group_ = kPixelGroup;
    const auto length = bytes<4>(at - 4);
    if (!length) return std::nullopt;
    const std::int64_t told = number(*length, 0, 4, encoding_.big_endian);
    // A writer that tells another length has its own idea of what follows.
    if (static_cast<double>(told) < needed || told == kUndefined) return size_;
    return at + told;
  }

  /// Where the data set begins: behind the preamble and the meta header. 0: not to be told.
  std::int64_t start() {
    std::int64_t at = 128;
    const auto mark = bytes<4>(at);
    if (!mark || std::string_view(reinterpret_cast<const char*>(mark->data()), 4) != "DICM") {
      return 0;
    }
    at += 4;
    const DicomEncoding meta;
    for (auto head = bytes<8>(at); head && (*head)[0] == 2 && (*head)[1] == 0;
         head = bytes<8>(at)) {
      const auto next = after_element(at, meta, 0);
      if (!next) return at;
      if ((*head)[2] == 0x10 && (*head)[3] == 0) syntax_ = text(at + 8, *next);
      at = *next;
    }
    return at;
  }

  /// Whether the elements that begin at `at` fill the file.
  bool whole_from(std::int64_t at) {
    while (at < size_) {
      const auto next = after_element(at, encoding_, 0);
      if (!next) return false;
      at = *next;
    }
    return at == size_;
  }

  /// Whether what was walked through is written as the standard has it, to its last byte.
  [[nodiscard]] bool understood() const { return understood_; }
  /// TransferSyntaxUID, once the start was looked for; empty if it is not there.
  [[nodiscard]] const std::string& syntax() const { return syntax_; }
  void set_encoding(const DicomEncoding& encoding) { encoding_ = encoding; }

 private:
  /// Where the walk goes on if it cannot tell: the end of the file.
  std::int64_t not_understood() {
    understood_ = false;
    return size_;
  }

  /// What stands from one place to another, without padding; empty if that is long.
  std::string text(std::int64_t from, std::int64_t to) {
    constexpr std::int64_t kMostUid = 64;
    if (to < from || to - from > kMostUid) return {};
    std::string out(static_cast<std::size_t>(to - from), '\0');
    in_.clear();
    if (!in_.seekg(from) || !in_.read(out.data(), to - from)) return {};
    while (!out.empty() && (out.back() == '\0' || out.back() == ' ')) out.pop_back();
    return out;
  }

  template <std::size_t N>
  std::optional<std::array<unsigned char, N>> bytes(std::int64_t at) {
    constexpr std::int64_t kWindow = 4096;  // heads mostly follow each other closely
    if (at < window_at_ || at + static_cast<std::int64_t>(N) > window_at_ + std::ssize(window_)) {
      if (at < 0) return std::nullopt;
      window_.resize(kWindow);
      in_.clear();
      in_.seekg(at);
      in_.read(window_.data(), kWindow);
      window_.resize(static_cast<std::size_t>(in_ || in_.eof() ? in_.gcount() : 0));
      window_at_ = at;
      if (window_.size() < N) return std::nullopt;
    }
    std::array<unsigned char, N> out{};
    std::copy_n(window_.begin() + (at - window_at_), N, out.begin());
    return out;
  }

  template <std::size_t N>
  static std::int64_t number(const std::array<unsigned char, N>& from, std::size_t first,
                             std::size_t count, bool big_endian) {
    std::int64_t out = 0;
    for (std::size_t i = 0; i < count; ++i) {
      out = out << 8 | from[first + (big_endian ? i : count - 1 - i)];
    }
    return out;
  }

  /// Where the element that begins at `at` ends; the file's end where that cannot be told; nothing
  /// if the file ends before.
  std::optional<std::int64_t> after_element(std::int64_t at, DicomEncoding encoding, int depth) {
    const auto head = bytes<8>(at);
    const bool big = encoding.big_endian;
    // Some archives fill files up with zeros.
    if (!head) {
      return zeros(at) || padding(at, big) ? std::optional(not_understood()) : std::nullopt;
    }
    if (number(*head, 0, 2, big) == 0) return not_understood();
    if (depth == 0 && number(*head, 0, 2, big) < least_group_)
      return not_understood();  // tags ascend
    std::int64_t length = number(*head, 4, 4, big);
    at += 8;
    if (!encoding.implicit) {
      const std::string_view kind(reinterpret_cast<const char*>(head->data()) + 4, 2);
      if (!std::all_of(kind.begin(), kind.end(), [](char c) { return c >= 'A' && c <= 'Z'; })) {
        return not_understood();
      }
      length = number(*head, 6, 2, big);
      if (is_long(kind)) {
        const auto words = bytes<4>(at);
        if (!words) return std::nullopt;
        length = number(*words, 0, 4, big);
        at += 4;
      }
      if (kind == "UN" && length == kUndefined) encoding = {.implicit = true};
    }
    if (length == kUndefined) return after_items(at, encoding, depth + 1);
    return at + length <= size_ ? std::optional(at + length) : std::nullopt;
  }

  /// The same of the items of a sequence that does not tell its length.
  std::optional<std::int64_t> after_items(std::int64_t at, const DicomEncoding& encoding,
                                          int depth) {
    if (depth > kDeepest) return not_understood();
    while (at < size_) {
      const auto head = bytes<8>(at);
      if (!head) return std::nullopt;
      const bool big = encoding.big_endian;
      const std::int64_t kind = number(*head, 2, 2, big);
      if (number(*head, 0, 2, big) != 0xFFFE) return not_understood();
      at += 8;
      if (kind == kSequenceEnd) return at;
      if (kind != kItem) return not_understood();
      const std::int64_t length = number(*head, 4, 4, big);
      if (length != kUndefined) {
        at += length;
        continue;
      }
      for (bool open = true; open;) {
        const auto inner = bytes<8>(at);
        if (!inner) return std::nullopt;
        if (number(*inner, 0, 2, big) == 0xFFFE && number(*inner, 2, 2, big) == kItemEnd) {
          at += 8;
          open = false;
        } else if (const auto next = after_element(at, encoding, depth)) {
          at = *next;
          open = at < size_;
        } else {
          return std::nullopt;
        }
      }
    }
    return at == size_ ? std::optional(at) : std::nullopt;
  }

  /// Whether the last fragment ends as a packed image does, or each is a frame of its own.
  bool fragments_close(int fragments, std::int64_t end) {
    if (fragments == encoding_.frames && encoding_.run_lengths) return true;
    const auto tail = bytes<4>(end - 4);
    if (!tail) return false;
    constexpr std::array<unsigned char, 2> kEnd{0xFF, 0xD9};  // of JPEG, JPEG-LS and JPEG 2000
    return std::search(tail->begin(), tail->end(), kEnd.begin(), kEnd.end()) != tail->end();
  }

  /// Whether the few bytes from `at` on cannot be the start of an element.
  bool padding(std::int64_t at, bool big_endian) {
    in_.clear();
    in_.seekg(at);
    std::string rest(static_cast<std::size_t>(size_ - at), '\0');
    if (!in_.read(rest.data(), size_ - at)) return false;
    if (rest.find_first_not_of(std::string_view(" \t\r\n\x1A\0", 6)) == std::string::npos) {
      return true;
    }
    const auto group = bytes<2>(at);
    return group && number(*group, 0, 2, big_endian) < least_group_;
  }

  bool zeros(std::int64_t at) {
    in_.clear();
    in_.seekg(at);
    for (; at < size_; ++at) {
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
  std::string window_;  ///< bytes of the file
  std::int64_t window_at_ = 0;
  std::int64_t least_group_ = 0;  ///< of the elements that may follow
  std::string syntax_;
  bool understood_ = true;
};

}  // namespace

bool goes_on_to_its_end(const std::filesystem::path& file, std::int64_t pixels,
                        double pixels_needed, const DicomEncoding& encoding) {
  Walk walk(file, encoding);
  const auto end =
      encoding.packed ? walk.end_of_fragments(pixels) : walk.end_of_plain(pixels, pixels_needed);
  return end && walk.whole_from(*end);
}

bool is_understood(const std::filesystem::path& file) {
  Walk walk(file, {});
  const std::int64_t start = walk.start();
  if (start == 0 || walk.syntax().empty()) return false;
  walk.set_encoding({.implicit = walk.syntax() == "1.2.840.10008.1.2",
                     .big_endian = walk.syntax() == "1.2.840.10008.1.2.2"});
  return walk.whole_from(start) && walk.understood();
}

bool is_whole(const std::filesystem::path& file, const DicomEncoding& encoding) {
  Walk walk(file, encoding);
  const std::int64_t start = walk.start();
  return start == 0 || walk.whole_from(start);
}

}  // namespace beatlas::ingest
