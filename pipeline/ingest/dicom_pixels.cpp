#include "pipeline/ingest/dicom_pixels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <type_traits>

#include <fcntl.h>
#include <unistd.h>

#include "pipeline/ingest/decoded_file.h"
#include "pipeline/ingest/inflated_file.h"
#include "runtime/base/sha256.h"

namespace beatlas::ingest {

/// A file as the decoder, or inflating it, gave it.
struct DicomPixels::Decoded {
  std::unique_ptr<InflatedFile> inflated;  ///< of a deflated file
  std::unique_ptr<DecodedFile> packed;     ///< of another
};

namespace {

static_assert(std::endian::native == std::endian::little);

template <class Word>
Word turned(Word word) {
  auto bytes = std::bit_cast<std::array<std::byte, sizeof(Word)>>(word);
  std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<Word>(bytes);
}

/// Reads `count` words from the file's byte `offset` on; false if it ends before.
template <class Word>
bool read_words(const std::string& file, std::int64_t offset, std::size_t count,
                std::vector<Word>& out) {
  out.resize(count);
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  char* at = reinterpret_cast<char*>(out.data());
  std::size_t left = count * sizeof(Word);
  while (left > 0) {
    const ssize_t got = ::pread(descriptor, at, left, offset);
    if (got <= 0) break;
    at += got;
    offset += got;
    left -= static_cast<std::size_t>(got);
  }
  ::close(descriptor);
  return left == 0;
}

/// The stored bits of words, sign extended if they are signed, as `Whole` wide as `Word`.
template <class Whole, class Word>
void whole_numbers(const std::vector<Word>& words, const PixelLayout& layout,
                   std::span<float> out) {
  constexpr int kBits = 8 * static_cast<int>(sizeof(Word));
  const int up = kBits - 1 - layout.high_bit;
  const int down = kBits - layout.bits_stored;
  if (up == 0 && down == 0) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = static_cast<float>(static_cast<Whole>(words[i]));
    }
    return;
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto raised = static_cast<Whole>(static_cast<Word>(words[i] << up));
    out[i] = static_cast<float>(static_cast<Whole>(raised >> down));
  }
}

template <class Word>
bool read_whole(const std::string& file, const PixelLayout& layout, std::span<float> out) {
  thread_local std::vector<Word> words;  // one a thread: a buffer an image would cost page faults
  if (!read_words(file, layout.offset, out.size(), words)) return false;
  if (layout.big_endian) {
    for (Word& word : words) word = turned(word);
  }
  if (layout.is_signed) {
    whole_numbers<std::make_signed_t<Word>>(words, layout, out);
  } else {
    whole_numbers<Word>(words, layout, out);
  }
  return true;
}

template <class Real, class Word>
bool read_real(const std::string& file, const PixelLayout& layout, std::span<float> out) {
  std::vector<Word> words;
  if (!read_words(file, layout.offset, out.size(), words)) return false;
  std::transform(words.begin(), words.end(), out.begin(), [&](Word word) {
    return static_cast<float>(std::bit_cast<Real>(layout.big_endian ? turned(word) : word));
  });
  return true;
}

/// @param held the file if it is inflated already, or null
bool read_plain(const DicomImage& image, const InflatedFile* held, std::span<float> out) {
  const PixelLayout& layout = image.layout;
  std::optional<InflatedFile> own;
  if (layout.deflated && !held) own.emplace(image.file);
  const InflatedFile* inflated = own ? &*own : held;
  if (inflated && !inflated->good()) return false;
  const std::string file = inflated ? inflated->path() : image.file.string();
  if (layout.kind == PixelLayout::Kind::Float) {
    return layout.bits_allocated == 64 ? read_real<double, std::uint64_t>(file, layout, out)
                                       : read_real<float, std::uint32_t>(file, layout, out);
  }
  if (layout.bits_allocated == 8) return read_whole<std::uint8_t>(file, layout, out);
  if (layout.bits_allocated == 16) return read_whole<std::uint16_t>(file, layout, out);
  return read_whole<std::uint32_t>(file, layout, out);
}

/// Stored value v of an inverted image counts as this less v.
double inversion_sum(const PixelLayout& layout) {
  return layout.is_signed ? -1 : std::ldexp(1.0, layout.bits_stored) - 1;
}

}  // namespace

DicomPixels::DicomPixels() = default;
DicomPixels::~DicomPixels() = default;

void DicomPixels::prepare(const DicomImage& image, double most_bytes) {
  const PixelLayout& layout = image.layout;
  const bool packed = layout.kind == PixelLayout::Kind::Packed;
  if (layout.frames < 2 || !(packed || layout.deflated) || held_.count(image.file) > 0) return;
  const double bytes = static_cast<double>(image.rows) * image.columns * layout.frames *
                       ((layout.bits_allocated + 7) / 8);
  if (held_bytes_ + bytes > most_bytes) release();
  held_bytes_ += bytes;
  auto& decoded = held_[image.file] = std::make_unique<Decoded>();
  if (packed) {
    decoded->packed = std::make_unique<DecodedFile>(image);
  } else {
    decoded->inflated = std::make_unique<InflatedFile>(image.file);
  }
}

void DicomPixels::release() {
  held_.clear();
  held_bytes_ = 0;
}

PixelState DicomPixels::read(const DicomImage& image, std::span<float> out) const {
  if (image.layout.kind == PixelLayout::Kind::Unknown) return PixelState::Damaged;
  const auto held = held_.find(image.file);
  const Decoded* decoded = held != held_.end() ? held->second.get() : nullptr;
  if (image.layout.kind != PixelLayout::Kind::Packed) {
    if (!read_plain(image, decoded ? decoded->inflated.get() : nullptr, out)) {
      return PixelState::Damaged;
    }
  } else {
    std::optional<DecodedFile> own;
    const DecodedFile* file = decoded ? decoded->packed.get() : nullptr;
    if (!file) {
      const std::lock_guard lock(decoder_);
      file = &own.emplace(image);
    }
    if (!file->read(image.frame, out)) return PixelState::Damaged;
  }
  const bool real = image.layout.kind == PixelLayout::Kind::Float;
  if (image.layout.inverted && !real) {
    const double sum = inversion_sum(image.layout);
    for (float& value : out) value = static_cast<float>(sum - static_cast<double>(value));
  }
  const double slope = image.rescale_slope;
  const double intercept = image.rescale_intercept;
  if (slope != 1 || intercept != 0) {
    for (float& value : out) {
      value = static_cast<float>(static_cast<double>(value) * slope + intercept);
    }
  } else if (!real) {
    return PixelState::Good;  // whole numbers are numbers
  }
  const bool numbers =
      std::all_of(out.begin(), out.end(), [](float value) { return std::isfinite(value); });
  return numbers ? PixelState::Good : PixelState::NoNumber;
}

std::string DicomPixels::fingerprint(const DicomImage& image) {
  prepare(image, 0);
  std::vector<float> values(static_cast<std::size_t>(image.columns) *
                            static_cast<std::size_t>(image.rows));
  if (read(image, values) != PixelState::Good) return {};
  return sha256_hex(std::as_bytes(std::span<const float>(values)));
}

}  // namespace beatlas::ingest
