#include "runtime/device/frame_buffer.h"

#include <algorithm>

namespace beatlas::device {
namespace {

constexpr std::size_t kMostHeader = 10;  // a server's, which has no mask
constexpr unsigned kContinuation = 0;
constexpr unsigned kText = 1;
constexpr unsigned kBinary = 2;
constexpr unsigned kClose = 8;
constexpr unsigned kPing = 9;
constexpr unsigned kPong = 10;

}  // namespace

void FrameBuffer::reset() {
  in_.resize(kMostBytes + kMostHeader);
  message_.resize(kMostBytes);
  begin_ = end_ = message_size_ = 0;
  frames_ = 0;
  fragmented_ = lost_ = false;
}

std::span<char> FrameBuffer::room() noexcept {
  if (begin_ > 0) {
    std::copy(in_.begin() + static_cast<std::ptrdiff_t>(begin_),
              in_.begin() + static_cast<std::ptrdiff_t>(end_), in_.begin());
    end_ -= begin_;
    begin_ = 0;
  }
  return std::span(in_).subspan(end_);
}

std::size_t FrameBuffer::frame(Frame& out) noexcept {
  const std::size_t have = end_ - begin_;
  const auto byte = [&](std::size_t n) {
    return static_cast<std::size_t>(static_cast<unsigned char>(in_[begin_ + n]));
  };
  if (have < 2) return 0;
  out.opcode = static_cast<unsigned>(byte(0) & 0x0FU);
  out.last = (byte(0) & 0x80U) != 0;
  std::size_t size = byte(1) & 0x7FU;
  std::size_t header = 2;
  // No extension was agreed on, and a server never masks.
  if ((byte(0) & 0x70U) != 0 || (byte(1) & 0x80U) != 0) lost_ = true;
  if (size >= 126) {
    header += size == 126 ? 2 : 8;
    if (have < header) return 0;
    size = 0;
    for (std::size_t n = 2; n < header; ++n) {
      if (size > kMostBytes) lost_ = true;
      size = (size << 8U) | byte(n);
    }
  }
  if (size > kMostBytes || (out.opcode >= kClose && (size > 125 || !out.last))) lost_ = true;
  if (lost_ || have < header + size) return 0;
  out.payload = std::string_view(in_.data() + begin_ + header, size);
  return header + size;
}

bool FrameBuffer::add_part(const Frame& part) noexcept {
  if (!fragmented_) message_size_ = 0;
  fragmented_ = !part.last;
  if (message_size_ + part.payload.size() > message_.size()) return false;
  std::copy(part.payload.begin(), part.payload.end(),
            message_.begin() + static_cast<std::ptrdiff_t>(message_size_));
  message_size_ += part.payload.size();
  return true;
}

FrameBuffer::Next FrameBuffer::next(std::string_view& payload) noexcept {
  while (!lost_) {
    Frame one;
    const std::size_t size = frame(one);
    if (lost_) break;
    if (size == 0) return Next::Nothing;
    begin_ += size;
    if (++frames_ > kMostFrames) break;
    if (one.opcode == kPong) continue;
    if (one.opcode == kPing) {
      payload = one.payload;
      return Next::Ping;
    }
    const bool data = one.opcode == kText || one.opcode == kBinary || one.opcode == kContinuation;
    if (!data || (one.opcode == kContinuation) != fragmented_) break;
    if (one.last) frames_ = 0;
    if (one.last && !fragmented_) {
      payload = one.payload;
      return Next::Message;
    }
    if (!add_part(one)) break;
    if (one.last) {
      payload = std::string_view(message_.data(), message_size_);
      return Next::Message;
    }
  }
  lost_ = true;
  return Next::Lost;
}

}  // namespace beatlas::device
