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
#include <vtkDICOMReader.h>
#include <vtkExecutive.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkType.h>

#include "pipeline/ingest/gdcm_silence.h"
#include "pipeline/ingest/inflated_file.h"
#include "pipeline/ingest/vtk_silence.h"
#include "runtime/base/sha256.h"

namespace beatlas::ingest {

/// A file as the decoder gave it.
struct DicomPixels::Decoded {
  std::filesystem::path file;
  vtkSmartPointer<vtkImageData> data;  ///< null if it could not be decoded
  std::vector<int> slice_of_frame;
};

namespace {

static_assert(std::endian::native == std::endian::little);

template <class Stored>
void as_float(const void* data, std::size_t first, std::span<float> out) {
  const auto* begin = static_cast<const Stored*>(data) + first;
  std::transform(begin, begin + out.size(), out.begin(),
                 [](Stored value) { return static_cast<float>(value); });
}

bool as_float(int type, const void* data, std::size_t first, std::span<float> out) {
  switch (type) {
    case VTK_UNSIGNED_CHAR:
      as_float<unsigned char>(data, first, out);
      return true;
    case VTK_SIGNED_CHAR:
    case VTK_CHAR:
      as_float<signed char>(data, first, out);
      return true;
    case VTK_UNSIGNED_SHORT:
      as_float<unsigned short>(data, first, out);
      return true;
    case VTK_SHORT:
      as_float<short>(data, first, out);
      return true;
    case VTK_UNSIGNED_INT:
      as_float<unsigned int>(data, first, out);
      return true;
    case VTK_INT:
      as_float<int>(data, first, out);
      return true;
    case VTK_FLOAT:
      as_float<float>(data, first, out);
      return true;
    case VTK_DOUBLE:
      as_float<double>(data, first, out);
      return true;
    default:
      return false;
  }
}

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

bool read_plain(const DicomImage& image, std::span<float> out) {
  const PixelLayout& layout = image.layout;
  std::optional<InflatedFile> inflated;
  if (layout.deflated) inflated.emplace(image.file);
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

/// Decodes a whole file; leaves `data` null if that fails.
void decode(const DicomImage& image, vtkSmartPointer<vtkImageData>& data,
            std::vector<int>& slice_of_frame) {
  silence_decoder();
  vtkNew<vtkDICOMReader> reader;
  silence(reader);
  silence(reader->GetExecutive());
  reader->SetFileName(image.file.c_str());
  reader->SortingOff();
  reader->TimeAsVectorOff();
  reader->AutoRescaleOff();
  reader->SetMemoryRowOrderToFileNative();
  reader->Update();
  vtkImageData* decoded = reader->GetOutput();
  const int* size = decoded->GetDimensions();
  const auto frames = static_cast<std::size_t>(image.layout.frames);
  if (reader->GetErrorCode() != 0 || size[0] != image.columns || size[1] != image.rows ||
      static_cast<std::size_t>(size[2]) != frames || decoded->GetNumberOfScalarComponents() != 1 ||
      !decoded->GetScalarPointer()) {
    return;
  }
  slice_of_frame.assign(frames, -1);
  vtkIntArray* frame_of_slice = reader->GetFrameIndexArray();
  for (int slice = 0; slice < size[2]; ++slice) {
    const int frame = frame_of_slice && slice < frame_of_slice->GetNumberOfValues()
                          ? frame_of_slice->GetValue(slice)
                          : slice;
    if (frame < 0 || frame >= size[2]) return;
    slice_of_frame[static_cast<std::size_t>(frame)] = slice;
  }
  data = decoded;
}

}  // namespace

DicomPixels::DicomPixels() = default;
DicomPixels::~DicomPixels() = default;

void DicomPixels::prepare(const DicomImage& image) {
  if (image.layout.kind != PixelLayout::Kind::Packed || image.layout.frames < 2) return;
  if (held_ && held_->file == image.file) return;
  held_.reset();  // before the next is decoded: never two at a time
  held_ = std::make_unique<Decoded>();
  held_->file = image.file;
  decode(image, held_->data, held_->slice_of_frame);
}

PixelState DicomPixels::read(const DicomImage& image, std::span<float> out) const {
  const std::size_t count = out.size();
  if (image.layout.kind != PixelLayout::Kind::Packed) {
    if (!read_plain(image, out)) return PixelState::Damaged;
  } else {
    Decoded own;
    const Decoded* decoded = held_ && held_->file == image.file ? held_.get() : nullptr;
    if (!decoded) {
      const std::lock_guard lock(decoder_);
      decode(image, own.data, own.slice_of_frame);
      decoded = &own;
    }
    const auto frame = static_cast<std::size_t>(image.frame);
    if (!decoded->data || frame >= decoded->slice_of_frame.size() ||
        decoded->slice_of_frame[frame] < 0) {
      return PixelState::Damaged;
    }
    const auto first = static_cast<std::size_t>(decoded->slice_of_frame[frame]) * count;
    if (!as_float(decoded->data->GetScalarType(), decoded->data->GetScalarPointer(), first, out)) {
      return PixelState::Damaged;
    }
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

std::string DicomPixels::fingerprint(const DicomImage& image) const {
  std::vector<float> values(static_cast<std::size_t>(image.columns) *
                            static_cast<std::size_t>(image.rows));
  if (read(image, values) != PixelState::Good) return {};
  return sha256_hex(std::as_bytes(std::span<const float>(values)));
}

}  // namespace beatlas::ingest
