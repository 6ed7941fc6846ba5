#include "pipeline/ingest/dicom_pixels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <span>

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
void as_float(const void* data, std::size_t first, std::vector<float>& out) {
  const auto* begin = static_cast<const Stored*>(data) + first;
  std::transform(begin, begin + out.size(), out.begin(),
                 [](Stored value) { return static_cast<float>(value); });
}

bool as_float(int type, const void* data, std::size_t first, std::vector<float>& out) {
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

/// Whole numbers of `Word`'s width: the stored bits, sign extended if they are signed.
template <class Word>
void whole_numbers(const std::vector<char>& bytes, const PixelLayout& layout,
                   std::vector<float>& out) {
  const int down = layout.high_bit + 1 - layout.bits_stored;
  const auto bits = static_cast<unsigned>(layout.bits_stored);
  const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
  const std::uint64_t sign = std::uint64_t{1} << (bits - 1);
  const char* at = bytes.data();
  for (float& value : out) {
    Word word;
    std::memcpy(&word, at, sizeof(Word));
    at += sizeof(Word);
    if (layout.big_endian) word = turned(word);
    const std::uint64_t stored = (static_cast<std::uint64_t>(word) >> down) & mask;
    value = layout.is_signed && (stored & sign) != 0
                ? static_cast<float>(static_cast<std::int64_t>(stored | ~mask))
                : static_cast<float>(stored);
  }
}

template <class Real>
void real_numbers(const std::vector<char>& bytes, bool big_endian, std::vector<float>& out) {
  const char* at = bytes.data();
  for (float& value : out) {
    Real real;
    std::memcpy(&real, at, sizeof(Real));
    at += sizeof(Real);
    if (big_endian) {
      using Word = std::conditional_t<sizeof(Real) == 4, std::uint32_t, std::uint64_t>;
      real = std::bit_cast<Real>(turned(std::bit_cast<Word>(real)));
    }
    value = static_cast<float>(real);
  }
}

bool read_plain(const DicomImage& image, std::vector<float>& out) {
  const PixelLayout& layout = image.layout;
  std::optional<InflatedFile> inflated;
  if (layout.deflated) inflated.emplace(image.file);
  if (inflated && !inflated->good()) return false;
  std::ifstream in;
  in.rdbuf()->pubsetbuf(nullptr, 0);  // one read, straight into place
  in.open(inflated ? std::filesystem::path(inflated->path()) : image.file, std::ios::binary);
  std::vector<char> bytes(out.size() * static_cast<std::size_t>(layout.bits_allocated / 8));
  in.seekg(layout.offset);
  if (!in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) return false;
  if (layout.kind == PixelLayout::Kind::Float) {
    if (layout.bits_allocated == 64) {
      real_numbers<double>(bytes, layout.big_endian, out);
    } else {
      real_numbers<float>(bytes, layout.big_endian, out);
    }
  } else if (layout.bits_allocated == 8) {
    whole_numbers<std::uint8_t>(bytes, layout, out);
  } else if (layout.bits_allocated == 16) {
    whole_numbers<std::uint16_t>(bytes, layout, out);
  } else {
    whole_numbers<std::uint32_t>(bytes, layout, out);
  }
  return true;
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

PixelState DicomPixels::read(const DicomImage& image, std::vector<float>& out) const {
  const auto count = static_cast<std::size_t>(image.columns) * static_cast<std::size_t>(image.rows);
  out.resize(count);
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
  const bool inverted = image.layout.inverted && image.layout.kind != PixelLayout::Kind::Float;
  const double sum = inversion_sum(image.layout);
  for (float& value : out) {
    const double upright = inverted ? sum - static_cast<double>(value) : value;
    value = static_cast<float>(upright * image.rescale_slope + image.rescale_intercept);
    if (!std::isfinite(value)) return PixelState::NoNumber;
  }
  return PixelState::Good;
}

std::string DicomPixels::fingerprint(const DicomImage& image) const {
  std::vector<float> values;
  if (read(image, values) != PixelState::Good) return {};
  return sha256_hex(std::as_bytes(std::span<const float>(values)));
}

}  // namespace beatlas::ingest
