// A WebSocket server's bytes: whatever they are and however they are cut, messages are the same.
#include <algorithm>
#include <cstring>

#include "runtime/device/frame_buffer.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
namespace {

using device::FrameBuffer;

// As a server writes it, not masked.
std::string frame(unsigned first, const std::string& payload) {
  std::string out(1, static_cast<char>(first));
  const std::size_t size = payload.size();
  if (size < 126) {
    out += static_cast<char>(size);
  } else {
    out += std::string{126, static_cast<char>(size >> 8U), static_cast<char>(size & 0xFFU)};
  }
  return out + payload;
}

struct Heard {
  std::vector<std::string> messages;  // a ping's begins with "ping "
  bool lost = false;
  bool operator==(const Heard&) const = default;
};

Heard listen(std::string_view bytes, std::size_t piece) {
  static FrameBuffer buffer;
  buffer.reset();
  Heard heard;
  while (!bytes.empty()) {
    const std::span<char> room = buffer.room();
    require(!room.empty());
    const std::size_t count = std::min({piece, bytes.size(), room.size()});
    std::memcpy(room.data(), bytes.data(), count);
    buffer.received(count);
    bytes.remove_prefix(count);
    std::string_view payload;
    for (bool more = true; more;) {
      switch (buffer.next(payload)) {
        case FrameBuffer::Next::Message:
          heard.messages.emplace_back(payload);
          break;
        case FrameBuffer::Next::Ping:
          heard.messages.push_back("ping " + std::string(payload));
          break;
        case FrameBuffer::Next::Nothing:
          more = false;
          break;
        case FrameBuffer::Next::Lost:
          heard.lost = true;
          return heard;
      }
    }
  }
  return heard;
}

}  // namespace

std::vector<std::string> seeds() {
  const std::string text = R"({"inverse3":[{"device_id":"1"}]})";
  const std::string large(70000, 'a');
  std::string flood;  // as much as a message may have in front of it
  for (int n = 1; n < FrameBuffer::kMostFrames; ++n) flood += frame(n % 2 == 0 ? 0x89 : 0x8A, "");
  std::string long_frame{'\x81', 127, 0, 0, 0, 0, 0, 1, 0x11, 0x70};
  return {frame(0x81, text) + frame(0x89, "are you there") + frame(0x82, text),
          frame(0x01, "one ") + frame(0x8A, "") + frame(0x00, "two ") + frame(0x80, "three"),
          flood + frame(0x81, text) + flood + frame(0x8A, "") + frame(0x81, text),
          frame(0x81, std::string(300, 'b')) + frame(0x88, "\x03\xe8"), long_frame + large};
}
std::vector<std::string> tokens() {
  return {"\x81\x05", std::string("\x81\x7f\0\0\0\0\0\x10\0\0", 10),
          "\x01\x02", "\x80\x7e",
          "\x89\x7d", "\x88\x02\x03\xe8"};
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas::fuzz;
  using beatlas::device::FrameBuffer;
  const std::string_view bytes = text(data, size);
  const Heard whole = listen(bytes, size);
  std::size_t told = 0;
  for (const std::string& message : whole.messages) told += message.size();
  require(told <= size + 5 * whole.messages.size());
  // Bytes that are no message cost a bounded time.
  int pings = 0;
  for (const std::string& message : whole.messages) {
    pings = message.starts_with("ping ") ? pings + 1 : 0;
    require(pings <= FrameBuffer::kMostFrames);
  }
  const std::size_t piece = size > 2000 ? 997 : 1 + size % 13;
  require(listen(bytes, piece) == whole);
  return 0;
}
