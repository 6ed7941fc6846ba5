#pragma once
/// The client's side of a WebSocket (RFC 6455) on a POSIX socket: text messages, no extensions, no
/// TLS. Own code, because a library's would allocate in the loop; its test talks to an independent
/// one. `send` and `connected` may be called from a second thread, all else from one.

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>

#include "runtime/device/frame_buffer.h"

namespace beatlas::device {

class WebSocket {
 public:
  WebSocket() = default;
  ~WebSocket() { close(); }
  WebSocket(const WebSocket&) = delete;
  WebSocket& operator=(const WebSocket&) = delete;

  /// Connects and shakes hands within `timeout_s`.
  /// @throws Error{Machine} that says what was not reached or what it answered.
  void connect(const std::string& host, int port, double timeout_s);
  [[nodiscard]] bool connected() const noexcept { return socket_.load() >= 0; }
  /// Closes at once, with a close frame if it can be sent without waiting.
  void close() noexcept;

  /// Sends one text message whole, within a few ms. Allocates nothing; at most 4 kB. False: the
  /// connection is lost.
  [[nodiscard]] bool send(std::string_view text) noexcept;

  enum class Received : std::uint8_t { Text, Nothing, Lost };
  /// The next text message within `timeout_s`, valid until the next call. Answers the last of the
  /// pings that came before it (RFC 6455, 5.5.3). However much the server sends, it is at most one
  /// message of `FrameBuffer` that is read, and nothing is waited for when the time is over.
  [[nodiscard]] Received receive(std::string_view& text, double timeout_s) noexcept;

 private:
  void forget() noexcept;
  [[nodiscard]] bool send_frame(unsigned opcode, std::string_view payload) noexcept;

  std::atomic<int> socket_{-1};
  std::atomic_flag sending_;  // held while bytes go out, and while the socket is closed
  FrameBuffer in_;
  std::uint32_t mask_ = 0x9e3779b9U;
};

}  // namespace beatlas::device
