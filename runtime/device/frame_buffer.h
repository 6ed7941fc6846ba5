#pragma once
/// What a WebSocket's client makes of the bytes a server sends (RFC 6455, 5.2 to 5.5): messages,
/// put together from frames. Knows no socket. No allocation after `reset`, no exception.

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace beatlas::device {

class FrameBuffer {
 public:
  static constexpr std::size_t kMostBytes = 1U << 20U;  ///< of one message
  /// Frames up to the end of a message: its parts, pings and pongs. A server that sends more is
  /// lost, so that what a message costs is bounded. Parts of 4 kB, as servers cut them, need 256.
  static constexpr int kMostFrames = 1000;

  /// Empty, as after a handshake. Takes its memory.
  void reset();

  /// Where the next bytes go; not empty after `next` said Nothing. Invalidates what `next` gave.
  [[nodiscard]] std::span<char> room() noexcept;
  /// As many were put at the begin of `room`. @pre no more than it has
  void received(std::size_t bytes) noexcept { end_ += bytes; }

  enum class Next : std::uint8_t {
    Message,  ///< a text or binary message, whole
    Ping,     ///< to be answered with the same payload
    Nothing,  ///< more bytes are needed
    Lost,     ///< closed by the server, or it broke the rules; so it stays until `reset`
  };
  /// @param payload of a message or a ping; valid until the next call of anything here
  [[nodiscard]] Next next(std::string_view& payload) noexcept;

 private:
  struct Frame {
    unsigned opcode = 0;
    bool last = false;
    std::string_view payload;
  };

  /// The first whole frame: its size with header; 0 if there is none yet, or `lost_`.
  [[nodiscard]] std::size_t frame(Frame& out) noexcept;
  /// Puts a part of a message behind those before; false if they are too long together.
  [[nodiscard]] bool add_part(const Frame& part) noexcept;

  std::vector<char> in_;   // received, not yet given away; fixed size
  std::size_t begin_ = 0;  // of what is left in it
  std::size_t end_ = 0;
  std::vector<char> message_;  // of more than one frame
  std::size_t message_size_ = 0;
  bool fragmented_ = false;
  int frames_ = 0;  // since the last message
  bool lost_ = false;
};

}  // namespace beatlas::device
