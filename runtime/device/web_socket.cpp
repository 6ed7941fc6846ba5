#include "runtime/device/web_socket.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <random>
#include <thread>
#include <utility>

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/evp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "runtime/base/error.h"

namespace beatlas::device {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::string_view kGuid = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";  // RFC 6455, 1.3
constexpr std::size_t kMostSent = 4096;
constexpr unsigned kText = 1;
constexpr unsigned kClose = 8;
constexpr unsigned kPong = 10;

Clock::time_point after(double seconds) {
  return Clock::now() +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

// Whether the socket is ready for `events` before `until`.
bool wait(int socket, short events, Clock::time_point until) noexcept {
  while (true) {
    const auto left =
        std::chrono::duration_cast<std::chrono::nanoseconds>(until - Clock::now()).count();
    const std::int64_t rest = std::max<std::int64_t>(left, 0);
    const timespec timeout{.tv_sec = rest / 1000000000, .tv_nsec = rest % 1000000000};
    pollfd poller{.fd = socket, .events = events, .revents = 0};
    const int ready = ::ppoll(&poller, 1, &timeout, nullptr);
    if (ready > 0) return true;
    if (ready == 0 || errno != EINTR) return false;
  }
}

std::string base64(const unsigned char* bytes, int count) {
  std::string out(static_cast<std::size_t>(4 * ((count + 2) / 3)) + 1, '\0');
  const int size = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()), bytes, count);
  out.resize(static_cast<std::size_t>(size));
  return out;
}

std::string accept_of(const std::string& key) {
  const std::string text = key + std::string(kGuid);
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha1(), nullptr) != 1) {
    throw Error(ErrorCode::Machine, "libcrypto cannot make a SHA-1 for the WebSocket's handshake");
  }
  return base64(digest.data(), static_cast<int>(size));
}

// Value of a header, lower-case name with colon, in an answer of lines that end with \r\n.
std::string header_value(const std::string& answer, const std::string& name) {
  std::size_t line = answer.find("\r\n");
  while (line != std::string::npos && line + 2 < answer.size()) {
    line += 2;
    const std::size_t end = answer.find("\r\n", line);
    const std::string text = answer.substr(line, end - line);
    const bool same = text.size() >= name.size() &&
                      std::equal(name.begin(), name.end(), text.begin(), [](char a, char b) {
                        return a == (b >= 'A' && b <= 'Z' ? static_cast<char>(b - 'A' + 'a') : b);
                      });
    if (same) {
      const std::size_t first = text.find_first_not_of(' ', name.size());
      return first == std::string::npos
                 ? ""
                 : text.substr(first, text.find_last_not_of(' ') - first + 1);
    }
    line = end;
  }
  return "";
}

int connect_any(const std::string& host, const std::string& port, Clock::time_point until) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) return -1;
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owned(found, &::freeaddrinfo);
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    const int fd =
        ::socket(one->ai_family, one->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, one->ai_protocol);
    if (fd < 0) continue;
    int error = 0;
    socklen_t size = sizeof(error);
    const bool begun = ::connect(fd, one->ai_addr, one->ai_addrlen) == 0 || errno == EINPROGRESS;
    if (begun && wait(fd, POLLOUT, until) &&
        ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0) {
      const int on = 1;
      (void)::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
      return fd;
    }
    ::close(fd);
  }
  return -1;
}

// All of it, or false. Local and small: what a full buffer does not take within 5 ms, all parts
// together, is lost.
bool send_all(int socket, const char* from, std::size_t size) noexcept {
  const Clock::time_point until = after(0.005);
  while (size > 0) {
    const ssize_t sent = ::send(socket, from, size, MSG_NOSIGNAL);
    if (sent > 0) {
      from += sent;
      size -= static_cast<std::size_t>(sent);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      if (!wait(socket, POLLOUT, until)) return false;
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

// For a few microseconds; false if the other thread does not let go.
class Turn {
 public:
  explicit Turn(std::atomic_flag& flag) noexcept : flag_(flag) {
    const Clock::time_point until = after(0.01);
    while (flag_.test_and_set(std::memory_order_acquire)) {
      if (Clock::now() > until) return;
      std::this_thread::yield();
    }
    mine_ = true;
  }
  ~Turn() {
    if (mine_) flag_.clear(std::memory_order_release);
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  [[nodiscard]] bool mine() const noexcept { return mine_; }

 private:
  std::atomic_flag& flag_;
  bool mine_ = false;
};

}  // namespace

void WebSocket::forget() noexcept {
  const int socket = socket_.exchange(-1);
  const Turn turn(sending_);  // nobody sends on a number that may be another file's soon
  if (socket >= 0) ::close(socket);
}

void WebSocket::connect(const std::string& host, int port, double timeout_s) {
  close();
  const std::string where = host + ":" + std::to_string(port);
  const Clock::time_point until = after(timeout_s);
  const int socket = connect_any(host, std::to_string(port), until);
  if (socket < 0) throw Error(ErrorCode::Machine, "nothing answers at " + where);
  in_.reset();

  std::random_device random;
  std::array<unsigned char, 16> nonce{};
  for (unsigned char& byte : nonce) byte = static_cast<unsigned char>(random());
  mask_ = random() | 1U;
  const std::string key = base64(nonce.data(), static_cast<int>(nonce.size()));
  const std::string request =
      "GET / HTTP/1.1\r\nHost: " + where +
      "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: " + key +
      "\r\nSec-WebSocket-Version: 13\r\n\r\n";
  std::string answer;
  bool whole = send_all(socket, request.data(), request.size());
  while (whole && answer.find("\r\n\r\n") == std::string::npos) {
    whole = answer.size() < 8192 && wait(socket, POLLIN, until);
    if (!whole) break;
    std::array<char, 1024> part{};
    const ssize_t got = ::recv(socket, part.data(), part.size(), 0);
    if (got > 0) {
      answer.append(part.data(), static_cast<std::size_t>(got));
    } else if (got == 0 || (errno != EAGAIN && errno != EINTR)) {
      whole = false;
    }
  }
  if (!whole || !answer.starts_with("HTTP/1.1 101") ||
      header_value(answer, "sec-websocket-accept:") != accept_of(key)) {
    ::close(socket);
    throw Error(ErrorCode::Machine, "what answers at " + where + " does not speak WebSocket");
  }
  // What came behind the answer's end is the first frame's begin.
  const std::size_t rest = answer.find("\r\n\r\n") + 4;
  std::copy(answer.begin() + static_cast<std::ptrdiff_t>(rest), answer.end(), in_.room().begin());
  in_.received(answer.size() - rest);
  socket_ = socket;
}

void WebSocket::close() noexcept {
  if (!connected()) return;
  (void)send_frame(kClose, "\x03\xe8");  // 1000: done
  forget();
}

bool WebSocket::send(std::string_view text) noexcept { return send_frame(kText, text); }

bool WebSocket::send_frame(unsigned opcode, std::string_view payload) noexcept {
  if (payload.size() > kMostSent) return false;
  const Turn turn(sending_);
  const int socket = socket_.load();
  if (!turn.mine() || socket < 0) return false;
  std::array<char, kMostSent + 8> frame;  // 2 of header, 2 of length, 4 of mask
  std::size_t size = 0;
  frame[size++] = static_cast<char>(0x80U | opcode);
  if (payload.size() < 126) {
    frame[size++] = static_cast<char>(0x80U | payload.size());
  } else {
    frame[size++] = static_cast<char>(0x80U | 126U);
    frame[size++] = static_cast<char>(payload.size() >> 8U);
    frame[size++] = static_cast<char>(payload.size() & 0xFFU);
  }
  // A mask hides nothing from a local server; it only must differ (xorshift).
  mask_ ^= mask_ << 13U;
  mask_ ^= mask_ >> 17U;
  mask_ ^= mask_ << 5U;
  std::array<char, 4> mask;
  std::memcpy(mask.data(), &mask_, 4);
  for (char byte : mask) frame[size++] = byte;
  for (std::size_t n = 0; n < payload.size(); ++n) {
    frame[size++] = static_cast<char>(payload[n] ^ mask[n % 4]);
  }
  return send_all(socket, frame.data(), size);
}

WebSocket::Received WebSocket::receive(std::string_view& text, double timeout_s) noexcept {
  const int socket = socket_.load();
  if (socket < 0) return Received::Lost;
  const Clock::time_point until = after(timeout_s);
  // The last ping, which is answered before anything is waited for or given away: a pong for each
  // of a thousand would hold the tick up.
  std::array<char, 125> ping;
  std::size_t ping_size = 0;
  bool asked = false;
  const auto answered = [&] {
    return !std::exchange(asked, false) || send_frame(kPong, {ping.data(), ping_size});
  };
  // A server that never pauses is heard no longer than one that is silent.
  bool late = false;
  while (true) {
    switch (in_.next(text)) {
      case FrameBuffer::Next::Message:
        return answered() ? Received::Text : Received::Lost;
      case FrameBuffer::Next::Lost:
        return Received::Lost;
      case FrameBuffer::Next::Ping:
        ping_size = text.copy(ping.data(), ping.size());
        asked = true;
        break;
      case FrameBuffer::Next::Nothing:
        if (late) return answered() ? Received::Nothing : Received::Lost;
        late = Clock::now() >= until;
        const std::span<char> room = in_.room();
        const ssize_t got = ::recv(socket, room.data(), room.size(), 0);
        if (got > 0) {
          in_.received(static_cast<std::size_t>(got));
        } else if (got == 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)) {
          return Received::Lost;
        } else if (!answered()) {
          return Received::Lost;
        } else if (!wait(socket, POLLIN, until)) {
          return Received::Nothing;
        }
        break;
    }
  }
}

}  // namespace beatlas::device
