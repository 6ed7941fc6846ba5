// Haply's protocol against a server of Boost.Beast, which shares no code with our client.

#include "runtime/device/haply.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>

#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/device/frame_buffer.h"
#include "runtime/device/json_scan.h"

namespace beatlas::device {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using Stream = beast::websocket::stream<asio::ip::tcp::socket>;

std::string frame_of(const std::string& id, const Vec3& haply_m, bool pretty = false) {
  const nlohmann::json json = {
      {"session", {{"id", 7}, {"note", "a \"quoted\" \\ word"}}},
      {"inverse3",
       {{{"device_id", id},
         {"config", {{"handedness", "right"}, {"list", {1, nullptr, true, -2.5e-3}}}},
         {"state",
          {{"cursor_position", {{"x", haply_m.x()}, {"y", haply_m.y()}, {"z", haply_m.z()}}},
           {"cursor_velocity", {{"x", 0.1}, {"y", 0.2}, {"z", 0.3}}}}}},
        {{"device_id", "OTHER"},
         {"state", {{"cursor_position", {{"x", 9}, {"y", 9}, {"z", 9}}}}}}}}};
  return json_text(json, pretty ? 2 : -1);
}

// A service for one connection after the other; `session` plays each.
class Service {
 public:
  explicit Service(std::function<void(Stream&, int)> session)
      : acceptor_(context_, asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), 0)),
        port_(acceptor_.local_endpoint().port()),
        thread_([this, session = std::move(session)](const std::stop_token& stop) {
          for (int n = 0; !stop.stop_requested(); ++n) {
            beast::error_code error;
            asio::ip::tcp::socket socket(context_);
            acceptor_.accept(socket, error);
            if (error || stop.stop_requested()) return;
            socket.set_option(asio::ip::tcp::no_delay(true));
            Stream stream(std::move(socket));
            try {
              stream.accept();
              session(stream, n);
            } catch (const boost::system::system_error&) {
              // The client went away.
            }
          }
        }) {}
  ~Service() {
    thread_.request_stop();
    beast::error_code error;
    asio::ip::tcp::socket waker(context_);  // ends the accept
    waker.connect({asio::ip::address_v4::loopback(), port_}, error);
  }
  [[nodiscard]] HaplyOptions options() const {
    HaplyOptions out;
    out.host = "127.0.0.1";
    out.port = port_;
    out.patience_s = 0;
    out.reply_s = 5;  // a busy machine is no lost device
    return out;
  }

 private:
  asio::io_context context_;
  asio::ip::tcp::acceptor acceptor_;
  std::uint16_t port_;
  std::jthread thread_;
};

void say(Stream& stream, const std::string& text) {
  stream.text(true);
  stream.write(asio::buffer(text));
}
std::string hear(Stream& stream) {
  beast::flat_buffer buffer;
  stream.read(buffer);
  return beast::buffers_to_string(buffer.data());
}

const Vec3 kPlace(0.01, -0.02, 0.03);

TEST(Haply, SpeaksTheProtocolAndTurnsItsAxes) {
  std::vector<nlohmann::json> heard;
  std::atomic<int> replies{0};
  std::optional<Service> service;
  service.emplace([&](Stream& stream, int) {
    say(stream, frame_of("A-1", kPlace));
    for (int n = 0; n < 50; ++n) {
      heard.push_back(parse_json(hear(stream)));
      if (n == 20) stream.ping({});  // answered and passed over
      ++replies;
      say(stream, frame_of("A-1", kPlace + n * Vec3(1e-4, 0, 0), n % 2 == 0));
    }
    heard.push_back(parse_json(hear(stream)));
    stream.close(beast::websocket::close_code::normal);
  });
  {
    HaplyDevice device(service->options());
    EXPECT_EQ(device.device_id(), "A-1");
    std::stop_source source;
    int n = 0;
    double last_s = -1;
    const RunReport report = device.run(
        [&](const DeviceState& state) -> Vec3 {
          EXPECT_TRUE(state.valid);
          EXPECT_GT(state.time_s, last_s);
          last_s = state.time_s;
          // Haply's x right, y away, z up; ours right, up, towards the user.
          EXPECT_LT((state.position_m - Vec3(0.01 + 1e-4 * n, 0.03, 0.02)).norm(), 1e-12);
          EXPECT_LT((state.velocity_m_s - Vec3(0.1, 0.3, -0.2)).norm(), 1e-12);
          if (++n == 50) source.request_stop();
          return {1, 0.5, 0.25 * n};
        },
        source.get_token());
    EXPECT_EQ(report.ticks, 50);
  }
  service.reset();
  // One reply a message; the session is named in the first one only; force as the servo said.
  ASSERT_EQ(heard.size(), 51U);
  EXPECT_EQ(heard[0].at("session").at("configure").at("profile").at("name"), "beatlas");
  for (std::size_t n = 0; n < heard.size(); ++n) {
    EXPECT_EQ(heard[n].contains("session"), n == 0);
    const auto& one = heard[n].at("inverse3").at(0);
    EXPECT_EQ(one.at("device_id"), "A-1");
    const auto& f = one.at("commands").at("set_cursor_force").at("values");
    const bool zero = n == 0 || n == 50;  // before the first tick and at the end
    EXPECT_NEAR(f.at("x").get<double>(), zero ? 0 : 1, 1e-6);
    EXPECT_NEAR(f.at("y").get<double>(), zero ? 0 : -0.25 * static_cast<double>(n), 1e-6);
    EXPECT_NEAR(f.at("z").get<double>(), zero ? 0 : 0.5, 1e-6);
  }
}

std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Machine);
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

TEST(Haply, AnAbsentDeviceIsSaidInASentenceWithAWayOn) {
  HaplyOptions nobody;
  {
    const Service service([](Stream&, int) {});
    nobody = service.options();
  }  // its port is free again
  const std::string absent = error_of([&] { HaplyDevice device(nobody); });
  EXPECT_NE(absent.find("Haply's service is not there"), std::string::npos) << absent;
  EXPECT_NE(absent.find("another --device"), std::string::npos) << absent;
  for (const std::string& frame :
       {std::string("{\"inverse3\":[]}"), std::string("[]"), std::string("no json"),
        frame_of("B", kPlace), frame_of("A\\\"},{", kPlace)}) {
    const Service service([&](Stream& stream, int) {
      say(stream, frame);
      (void)hear(stream);
    });
    HaplyOptions options = service.options();
    options.device_id = std::string("A");  // GCC 12 warns about the literal
    const std::string none = error_of([&] { HaplyDevice device(options); });
    EXPECT_NE(none.find("lists no Inverse3 A"), std::string::npos) << none;
  }
}

TEST(Haply, ALostDeviceIsToldToTheServoAndTakenUpAgain) {
  std::vector<nlohmann::json> second;
  std::optional<Service> service;
  service.emplace([&](Stream& stream, int connection) {
    say(stream, frame_of("A", kPlace));
    for (int n = 0; connection > 0 || n < 10; ++n) {
      const std::string heard = hear(stream);
      if (connection > 0) second.push_back(parse_json(heard));
      say(stream, frame_of("A", kPlace));
    }
    // The first connection breaks off without a word.
    beast::get_lowest_layer(stream).close();
  });
  HaplyOptions options = service->options();
  options.patience_s = 60;
  int valid = 0;
  int invalid = 0;
  {
    HaplyDevice device(options);
    std::stop_source source;
    (void)device.run(
        [&](const DeviceState& state) -> Vec3 {
          (state.valid ? valid : invalid)++;
          if (valid == 30) source.request_stop();
          return {0, 0, 1};
        },
        source.get_token());
  }
  service.reset();
  EXPECT_EQ(valid, 30);
  EXPECT_GE(invalid, 1);
  ASSERT_GE(second.size(), 2U);
  EXPECT_TRUE(second[0].contains("session"));
  // Nothing of the force before the break comes after it.
  EXPECT_EQ(second[0]["inverse3"][0]["commands"]["set_cursor_force"]["values"]["y"], 0.0);
}

TEST(Haply, FramesThatAreDamagedOrWithoutTheDeviceAreInvalidStates) {
  const std::string sound = frame_of("A", kPlace);
  const std::vector<std::string> frames{
      sound,
      sound.substr(0, sound.size() / 2),
      "",
      "{}",
      "\xff\xfe",
      R"({"inverse3":[{"device_id":"A","state":{"cursor_position":{"x":1,"y":2}}}]})",
      R"({"inverse3":[{"device_id":"A","state":{"cursor_position":{"x":1,"y":2,"z":1e999}}}]})",
      std::string(100000, '['),
      frame_of("C", kPlace),
      sound + "x",
      sound};
  Service service([&](Stream& stream, int) {
    say(stream, sound);
    for (const std::string& frame : frames) {
      (void)hear(stream);
      if (frame.starts_with('\xff')) stream.binary(true);
      stream.text(!frame.starts_with('\xff'));
      stream.write(asio::buffer(frame));
    }
    (void)hear(stream);
  });
  HaplyDevice device(service.options());
  std::vector<bool> valid;
  std::stop_source source;
  (void)device.run(
      [&](const DeviceState& state) -> Vec3 {
        valid.push_back(state.valid);
        EXPECT_TRUE(state.position_m.allFinite());
        if (valid.size() == frames.size()) source.request_stop();
        return Vec3::Zero();
      },
      source.get_token());
  std::vector<bool> expected(frames.size(), false);
  expected.front() = expected.back() = true;
  EXPECT_EQ(valid, expected);
}

TEST(Haply, AServiceThatGoesSilentIsALostDevice) {
  Service service([&](Stream& stream, int connection) {
    if (connection > 0) return;  // nobody is there again
    say(stream, frame_of("A", kPlace));
    (void)hear(stream);
    (void)hear(stream);  // no reply to the first; this waits for the end of the connection
  });
  HaplyOptions options = service.options();
  options.reply_s = 0.05;
  HaplyDevice device(options);
  bool valid = false;
  const std::string lost = error_of([&] {
    (void)device.run(
        [&](const DeviceState& state) -> Vec3 {
          valid = valid || state.valid;
          return Vec3::Zero();
        },
        {});
  });
  EXPECT_FALSE(valid);
  EXPECT_NE(lost.find("was lost and did not come back"), std::string::npos) << lost;
}

TEST(Haply, AnotherThreadMayDropTheForceWhileTheServoHangs) {
  std::atomic<int> heard{0};
  std::atomic<bool> zero_heard{false};
  std::optional<Service> service;
  service.emplace([&](Stream& stream, int) {
    say(stream, frame_of("A", kPlace));
    while (true) {
      const auto json = parse_json(hear(stream));
      const double f = json["inverse3"][0]["commands"]["set_cursor_force"]["values"]["x"];
      if (heard++ > 2 && f == 0) zero_heard = true;
      say(stream, frame_of("A", kPlace));
    }
  });
  HaplyDevice device(service->options());
  std::stop_source source;
  std::atomic<bool> hangs{false};
  std::thread watch([&] {
    while (!hangs) std::this_thread::yield();
    device.drop_force();
  });
  int n = 0;
  (void)device.run(
      [&](const DeviceState&) -> Vec3 {
        if (++n == 5) {
          hangs = true;
          while (!zero_heard) std::this_thread::yield();  // hangs until the force is off
          source.request_stop();
        }
        return {1, 0, 0};
      },
      source.get_token());
  watch.join();
  EXPECT_TRUE(zero_heard);
}

// As a server writes it, not masked.
std::string control_frame(unsigned opcode, const std::string& payload) {
  return std::string{static_cast<char>(0x80U | opcode), static_cast<char>(payload.size())} +
         payload;
}

std::string pings(int count) {
  std::string out;
  for (int n = 0; n < count; ++n) out += control_frame(9, std::to_string(n));
  return out;
}

TEST(Haply, PingsInFrontOfAReplyCostATickOneAnswer) {
  constexpr int kTicks = 20;
  constexpr int kPings = 500;
  std::vector<std::string> pongs;
  std::optional<Service> service;
  service.emplace([&](Stream& stream, int) {
    stream.control_callback([&](beast::websocket::frame_type type, beast::string_view payload) {
      if (type == beast::websocket::frame_type::pong) pongs.emplace_back(payload);
    });
    say(stream, frame_of("A", kPlace));
    while (true) {
      (void)hear(stream);
      asio::write(stream.next_layer(), asio::buffer(pings(kPings)));
      say(stream, frame_of("A", kPlace));
    }
  });
  {
    HaplyDevice device(service->options());
    std::stop_source source;
    int ticks = 0;
    (void)device.run(
        [&](const DeviceState& state) -> Vec3 {
          EXPECT_TRUE(state.valid);
          if (++ticks == kTicks) source.request_stop();
          return Vec3::Zero();
        },
        source.get_token());
    EXPECT_EQ(ticks, kTicks);
  }
  service.reset();
  // One a piece that came alone; all pieces of 2.4 kB come together, but for a busy machine's.
  EXPECT_GE(pongs.size(), static_cast<std::size_t>(kTicks - 1));
  EXPECT_LT(pongs.size(), static_cast<std::size_t>(kTicks * kPings / 10));
  EXPECT_EQ(pongs.back(), std::to_string(kPings - 1));
}

TEST(Haply, AServerThatOnlyPingsIsALostDevice) {
  // Faster than it can be answered, and so slowly that the time alone tells.
  for (const bool fast : {true, false}) {
    SCOPED_TRACE(fast);
    const std::string burst = pings(fast ? 2000 : 1);
    const std::chrono::milliseconds pause(fast ? 0 : 2);
    bool went = false;
    std::optional<Service> service;
    service.emplace([&](Stream& stream, int connection) {
      if (connection > 0) return;
      say(stream, frame_of("A", kPlace));
      // Its answers are taken, so that none of them stops the client.
      std::jthread taker([socket = stream.next_layer().native_handle()] {
        std::array<char, 4096> taken;
        while (::recv(socket, taken.data(), taken.size(), 0) > 0) {
        }
      });
      beast::error_code error;
      const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
      while (!error && std::chrono::steady_clock::now() < until) {
        asio::write(stream.next_layer(), asio::buffer(burst), error);
        std::this_thread::sleep_for(pause);
      }
      went = bool(error);
      stream.next_layer().shutdown(asio::ip::tcp::socket::shutdown_both, error);
    });
    HaplyOptions options = service->options();
    options.reply_s = 0.2;
    {
      HaplyDevice device(options);
      int told = 0;
      const std::string lost = error_of([&] {
        (void)device.run(
            [&](const DeviceState& state) -> Vec3 {
              told += state.valid ? 0 : 1;
              return Vec3::Zero();
            },
            {});
      });
      EXPECT_NE(lost.find("was lost"), std::string::npos) << lost;
      EXPECT_GE(told, 1);
    }
    service.reset();
    EXPECT_TRUE(went) << "the client heard it out";
  }
}

TEST(FrameBuffer, OfMoreFramesThanAMessageNeedsIsLost) {
  const auto first = [](const std::string& bytes) {
    FrameBuffer buffer;
    buffer.reset();
    std::copy(bytes.begin(), bytes.end(), buffer.room().begin());
    buffer.received(bytes.size());
    std::string_view payload;
    FrameBuffer::Next next = buffer.next(payload);
    while (next == FrameBuffer::Next::Ping) next = buffer.next(payload);
    return next;
  };
  const auto many = [](const std::string& frame, int count) {
    std::string out;
    for (int n = 0; n < count; ++n) out += frame;
    return out;
  };
  const int most = FrameBuffer::kMostFrames;
  const std::string text{'\x81', 1, 'a'};
  for (const std::string& frame : {control_frame(9, ""), control_frame(10, "abc")}) {
    EXPECT_EQ(first(many(frame, most - 1) + text), FrameBuffer::Next::Message);
    EXPECT_EQ(first(many(frame, most) + text), FrameBuffer::Next::Lost);
  }
  // Parts of a message that hold nothing.
  const std::string begin{1, 0};
  const std::string part{0, 0};
  const std::string end{'\x80', 0};
  EXPECT_EQ(first(begin + many(part, most - 2) + end), FrameBuffer::Next::Message);
  EXPECT_EQ(first(begin + many(part, most - 1) + end), FrameBuffer::Next::Lost);
}

TEST(JsonScan, EndsWithinAnyText) {
  const std::string sound = frame_of("A", kPlace, true);
  JsonScan whole(sound);
  EXPECT_TRUE(whole.skip());
  EXPECT_TRUE(whole.at_end());
  for (std::size_t n = 0; n < sound.size(); ++n) {
    JsonScan cut(std::string_view(sound).substr(0, n));
    EXPECT_FALSE(cut.skip() && n > 0);
    std::string changed = sound;
    changed[n] = '"';
    JsonScan scan(changed);
    (void)scan.skip();
  }
}

}  // namespace
}  // namespace beatlas::device
