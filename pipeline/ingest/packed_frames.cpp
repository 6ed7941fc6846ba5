#include "pipeline/ingest/packed_frames.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace beatlas::ingest {
namespace {

using namespace std::string_view_literals;

constexpr auto kJpegStart = "\xFF\xD8"sv;
constexpr auto kJpeg2000Start = "\xFF\x4F\xFF\x51"sv;  // with the segment that names the size
constexpr auto kJpeg2000Boxes = "\0\0\0\x0CjP  "sv;
constexpr std::size_t kMostBoxes = std::size_t{1} << 16;  // bytes before the frame proper
constexpr std::uint64_t kMostComponents = 4;
constexpr std::uint64_t kLeastTilePart = 12;  // bytes of its head alone

/// A number of some bytes, highest first; 0 beyond the end.
std::uint64_t number(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint64_t out = 0;
  for (std::size_t n = 0; n < count; ++n) {
    out = out << 8 | (at + n < bytes.size() ? static_cast<unsigned char>(bytes[at + n]) : 0U);
  }
  return out;
}

struct Extent {
  std::uint64_t columns;
  std::uint64_t rows;

  [[nodiscard]] bool within(const Extent& other) const {
    return columns <= other.columns && rows <= other.rows;
  }
};

/// ITU-T T.81 B.2, T.87 C.2: each start of frame (SOF) names the size.
bool jpeg_fits(std::string_view frame, const Extent& image) {
  std::size_t at = kJpegStart.size();
  while (at < frame.size()) {
    // Decoders pass over what stands between segments.
    at = frame.find('\xFF', at);
    while (at < frame.size() && frame[at] == '\xFF') ++at;
    if (at >= frame.size()) return true;
    const auto marker = static_cast<unsigned char>(frame[at++]);
    const bool alone = marker == 0 || marker == 1 || (marker >= 0xD0 && marker <= 0xD7);
    if (alone) continue;
    // Pixels or the end; at the start of another image a decoder gives up.
    if (marker >= 0xD8 && marker <= 0xDA) return true;
    const bool start =
        (marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC) ||
        marker == 0xF7;
    if (start) {
      const Extent told{.columns = number(frame, at + 5, 2), .rows = number(frame, at + 3, 2)};
      if (!told.within(image) || number(frame, at + 7, 1) > kMostComponents) return false;
    }
    at += std::max<std::size_t>(number(frame, at, 2), 2);
  }
  return true;
}

/// ISO/IEC 15444-1 A.5.1. @param frame from its start on
bool jpeg_2000_fits(std::string_view frame, const Extent& image) {
  const auto word = [&](std::size_t n) { return number(frame, 8 + 4 * n, 4); };
  const std::uint64_t right = word(0);
  const std::uint64_t bottom = word(1);
  if (right < word(2) || bottom < word(3)) return false;
  const Extent told{.columns = right - word(2), .rows = bottom - word(3)};
  if (!told.within(image) || number(frame, 40, 2) > kMostComponents) return false;
  if (word(4) == 0 || word(5) == 0) return false;
  // Each tile is in the frame with a head of its own.
  const std::uint64_t tiles = ((right - std::min(right, word(6))) / word(4) + 1) *
                              ((bottom - std::min(bottom, word(7))) / word(5) + 1);
  return tiles <= frame.size() / kLeastTilePart;
}

}  // namespace

bool frame_fits(std::string_view frame, int columns, int rows) {
  const Extent image{.columns = static_cast<std::uint64_t>(std::max(columns, 0)),
                     .rows = static_cast<std::uint64_t>(std::max(rows, 0))};
  if (frame.starts_with(kJpegStart)) return jpeg_fits(frame, image);
  if (frame.starts_with(kJpeg2000Boxes)) {
    const std::size_t at = frame.substr(0, kMostBoxes).find(kJpeg2000Start);
    return at != std::string_view::npos && jpeg_2000_fits(frame.substr(at), image);
  }
  return !frame.starts_with(kJpeg2000Start) || jpeg_2000_fits(frame, image);
}

bool packed_frames_fit(const std::filesystem::path& file, std::int64_t pixels, int columns,
                       int rows) {
  std::ifstream in(file, std::ios::binary);
  if (!in.seekg(pixels)) return false;
  const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  // A frame may go on in the next fragment, so they are joined as decoders join them.
  std::string joined;
  std::vector<std::size_t> starts;
  constexpr std::size_t kHead = 8;
  constexpr auto kItem = "\xFE\xFF\x00\xE0"sv;
  for (std::size_t at = 0; bytes.compare(at, kItem.size(), kItem) == 0;) {
    std::uint64_t length = 0;
    for (std::size_t n = 0; n < 4; ++n) {
      length = length << 8 | number(bytes, at + kHead - 1 - n, 1);
    }
    at += kHead;
    starts.push_back(joined.size());
    joined.append(bytes, std::min(at, bytes.size()), length);
    at += length;
    if (at >= bytes.size()) break;
  }
  return std::all_of(starts.begin(), starts.end(), [&](std::size_t start) {
    return frame_fits(std::string_view(joined).substr(start), columns, rows);
  });
}

}  // namespace beatlas::ingest
