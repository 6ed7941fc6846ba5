// A DICOM file through the header's reader, the walk to its end, inflating and the decoders of its
// pixels. The first byte says what follows: f a file, d a data set that is deflated here, because
// hardly a change of packed bytes would leave them so.
#include <cmath>

#include "pipeline/ingest/dicom_end.h"
#include "pipeline/ingest/dicom_file.h"
#include "pipeline/ingest/dicom_pixels.h"
#include "pipeline/ingest/packed_frames.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/unit/ingest/dicom_bytes.h"
#include "tests/unit/ingest/packed_frame.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  using namespace test;
  const std::string eight(12, '\x21');
  std::vector<std::string> out;
  for (const char* syntax : {kImplicit, kExplicit, kBigEndian}) {
    out.push_back("f" + dicom_file({.syntax = syntax}));
  }
  out.push_back("f" + dicom_file({.frames = 2, .bits = 8, .pixels = eight + eight}));
  out.push_back("d" + data_set({.syntax = kDeflated}));
  out.push_back("d" +
                data_set({.syntax = kDeflated, .frames = 2, .bits = 8, .pixels = eight + eight}));
  const std::string packed = run_lengths(eight);
  out.push_back("f" + dicom_file({.syntax = kRunLengths, .bits = 8, .fragments = {packed}}));
  out.push_back(
      "f" +
      dicom_file({.syntax = kRunLengths, .frames = 2, .bits = 8, .fragments = {packed, packed}}));
  for (const PackedFrame& frame : packed_frames()) {
    DicomForm form{.syntax = frame.syntax, .bits = frame.bits, .fragments = {frame.bytes}};
    out.push_back("f" + dicom_file(form));
    if (frame.bits != 8) continue;
    form.frames = 2;
    form.fragments = {frame.bytes.substr(0, 20), frame.bytes.substr(20), frame.bytes};
    out.push_back("f" + dicom_file(form));
  }
  return out;
}
std::vector<std::string> tokens() {
  using namespace std::string_literals;
  return {"\xFE\xFF\x00\xE0"s,
          "\xFE\xFF\xDD\xE0"s,
          "\xFE\xFF\x0D\xE0"s,
          "\xFF\xFF\xFF\xFF"s,
          "SQ\0\0"s,
          "UN\0\0"s,
          "OB\0\0"s,
          "\xE0\x7F\x10\x00"s,
          "\x28\x00\x08\x00IS\x02\x00"s,
          "\xFF\xC2"s,
          "\xFF\xC3"s,
          "\xFF\xDA"s,
          "\xFF\xD9"s,
          "100000",
          "1.2.840.10008.1.2.4.90"};
}
}  // namespace beatlas::fuzz

// vtk-dicom asks for the length that an element tells before it looks whether the file is so long.
extern "C" void beatlas_libraries_may_hear_no();
extern "C" void beatlas_libraries_may_hear_no() {}
// And hearing no it leaves its buffer behind.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libvtkDICOM"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  if (size == 0) return 0;
  static const fuzz::MemoryFolder folder;
  const std::string_view rest = fuzz::text(data + 1, size - 1);
  const auto file =
      folder.write("a", data[0] == 'd' ? test::with_head(test::kDeflated, std::string(rest))
                                       : std::string(rest));
  for (const bool implicit : {false, true}) {
    const ingest::DicomEncoding encoding{
        .packed = implicit, .implicit = implicit, .big_endian = size % 2 == 0, .frames = 1};
    (void)ingest::is_whole(file, encoding);
    (void)ingest::goes_on_to_its_end(file, static_cast<std::int64_t>(size / 2), 8, encoding);
  }
  (void)ingest::frame_fits(rest, 4, 3);

  ingest::IdentityWords words;
  const ingest::FileHeader header = ingest::read_header(file, words);
  fuzz::require(header.images.empty() || header.kind == ingest::FileHeader::Kind::Image ||
                header.kind == ingest::FileHeader::Kind::Wrong);
  if (header.kind != ingest::FileHeader::Kind::Image) return 0;
  constexpr std::size_t kMostFrames = 3;
  constexpr std::int64_t kMostPixels = std::int64_t{1} << 22;  // more would only take time
  ingest::DicomPixels pixels;
  for (std::size_t n = 0; n < std::min(header.images.size(), kMostFrames); ++n) {
    const ingest::DicomImage& image = header.images[n];
    fuzz::require(image.rows > 0 && image.columns > 0 && image.position_lps.allFinite());
    fuzz::require(image.row_step_mm > 0 && image.column_step_mm > 0);
    const std::int64_t count = std::int64_t{image.rows} * image.columns;
    if (count * image.layout.frames > kMostPixels) return 0;
    pixels.prepare(image, 1e7);
    std::vector<float> values(static_cast<std::size_t>(count));
    if (pixels.read(image, values) != ingest::PixelState::Good) continue;
    for (const float value : values) fuzz::require(std::isfinite(value));
  }
  return 0;
}
