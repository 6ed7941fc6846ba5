#include "runtime/device/haply.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <thread>

#include <nlohmann/json.hpp>

#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/device/json_scan.h"

namespace beatlas::device {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kLongestId = 64;

// Haply: x right, y away, z up. Ours: right, up, towards the user.
Vec3 from_haply(const Vec3& haply) { return {haply.x(), haply.z(), -haply.y()}; }
Vec3 to_haply(const Vec3& our) { return {our.x(), -our.z(), our.y()}; }

bool read_vector(JsonScan& in, Vec3& out) noexcept {
  unsigned found = 0;
  const bool sound = in.object([&](std::string_view key, JsonScan& value) {
    if (key.size() != 1 || key[0] < 'x' || key[0] > 'z') return value.skip();
    found |= 1U << static_cast<unsigned>(key[0] - 'x');
    return value.number(out[key[0] - 'x']);
  });
  return sound && found == 7U;
}

// An id goes into messages and into what we send: letters, digits and the like only.
bool plain(const std::string& id) {
  return !id.empty() && id.size() <= kLongestId &&
         std::all_of(id.begin(), id.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.' || c == ':';
         });
}

void check(const char* name, double value, double low, double high) {
  if (!(value >= low && value <= high)) {
    throw_invalid(std::string("the Haply device's ") + name + " is out of range");
  }
}

}  // namespace

HaplyDevice::HaplyDevice(const HaplyOptions& options) : options_(options) {
  check("port", options.port, 1, 65535);
  check("connect_s", options.connect_s, 0.01, 60);
  check("reply_s", options.reply_s, 0.005, 5);
  check("patience_s", options.patience_s, 0, 3600);
  if (!options.device_id.empty() && !plain(options.device_id)) {
    throw_invalid("a Haply device's id has letters, digits, - _ . : only, 64 at most");
  }
  open();
}

HaplyDevice::~HaplyDevice() {
  if (socket_.connected()) (void)send_force(Vec3::Zero(), first_);
}

void HaplyDevice::open() {
  try {
    socket_.connect(options_.host, options_.port, options_.connect_s);
  } catch (const Error& error) {
    throw Error(ErrorCode::Machine, std::string("Haply's service is not there (") + error.what() +
                                        "); start it and plug the Inverse3 in, or use another "
                                        "--device");
  }
  first_ = true;
  std::string_view frame;
  std::vector<std::string> ids;
  if (socket_.receive(frame, options_.connect_s) == WebSocket::Received::Text) {
    const nlohmann::json json = parse_json(frame);
    if (json.is_object() && json.contains("inverse3") && json["inverse3"].is_array()) {
      for (const nlohmann::json& one : json["inverse3"]) {
        if (one.is_object() && one.contains("device_id") && one["device_id"].is_string()) {
          ids.push_back(one["device_id"].get<std::string>());
        }
      }
    }
  }
  // Once chosen it stays: another thread may read it while a connection is tried again.
  const std::string& wanted = device_id_.empty() ? options_.device_id : device_id_;
  const auto fits = [&](const std::string& id) {
    return plain(id) && (wanted.empty() || id == wanted);
  };
  const auto found = std::find_if(ids.begin(), ids.end(), fits);
  if (found != ids.end() && device_id_.empty()) device_id_ = *found;
  if (found == ids.end() || !read_state(frame, last_)) {
    socket_.close();
    throw Error(ErrorCode::Machine, "Haply's service lists no Inverse3" +
                                        (wanted.empty() ? std::string() : " " + wanted) +
                                        "; plug it in, or use another --device");
  }
}

bool HaplyDevice::read_state(std::string_view frame, DeviceState& state) const noexcept {
  bool found = false;
  JsonScan in(frame);
  Vec3 position = Vec3::Zero();
  Vec3 velocity = Vec3::Zero();
  const auto one_device = [&](JsonScan& device) {
    bool ours_is_this = false;
    bool has_position = false;
    bool has_velocity = false;
    Vec3 x = Vec3::Zero();
    Vec3 v = Vec3::Zero();
    const bool sound = device.object([&](std::string_view key, JsonScan& value) {
      if (key == "device_id") {
        std::string_view id;
        const bool read = value.string(id);
        ours_is_this = read && id == device_id_;
        return read;
      }
      if (key != "state") return value.skip();
      return value.object([&](std::string_view name, JsonScan& number) {
        if (name == "cursor_position") return has_position = read_vector(number, x);
        if (name == "cursor_velocity") return has_velocity = read_vector(number, v);
        return number.skip();
      });
    });
    if (sound && ours_is_this && has_position) {
      found = true;
      position = x;
      velocity = has_velocity ? v : Vec3::Zero();
    }
    return sound;
  };
  const bool sound = in.object([&](std::string_view key, JsonScan& value) {
    return key == "inverse3" ? value.array(one_device) : value.skip();
  });
  if (!sound || !found || !in.at_end()) return false;
  state.position_m = from_haply(position);
  state.velocity_m_s = from_haply(velocity);
  return true;
}

bool HaplyDevice::send_force(const Vec3& force_n, bool first) noexcept {
  std::array<char, 512> text;
  const Vec3 f = force_n.allFinite() ? to_haply(force_n) : Vec3::Zero();
  const int size = std::snprintf(
      text.data(), text.size(),
      "{%s\"inverse3\":[{\"device_id\":\"%s\",\"commands\":{\"set_cursor_force\":{\"values\":"
      "{\"x\":%.6f,\"y\":%.6f,\"z\":%.6f}}}}]}",
      first ? R"("session":{"configure":{"profile":{"name":"beatlas"}}},)" : "", device_id_.c_str(),
      f.x(), f.y(), f.z());
  if (size < 0 || static_cast<std::size_t>(size) >= text.size()) return false;
  return socket_.send({text.data(), static_cast<std::size_t>(size)});
}

void HaplyDevice::drop_force() noexcept {
  // A reply more than asked for only goes by.
  if (socket_.connected()) (void)send_force(Vec3::Zero(), false);
}

void HaplyDevice::wait_for_device(const ServoFn& servo, const std::stop_token& stop,
                                  Clock::time_point start, RunReport& report) {
  const Clock::time_point lost = Clock::now();
  const auto since = [](Clock::time_point then) {
    return std::chrono::duration<double>(Clock::now() - then).count();
  };
  while (!stop.stop_requested()) {
    DeviceState state = last_;
    state.time_s = since(start);
    state.valid = false;
    (void)servo(state);
    ++report.ticks;
    try {
      open();
      return;
    } catch (const Error&) {
      if (since(lost) >= options_.patience_s) {
        throw Error(ErrorCode::Machine,
                    "the Haply device was lost and did not come back; check its cable and Haply's "
                    "service and start again, or use another --device");
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
}

RunReport HaplyDevice::run(const ServoFn& servo, std::stop_token stop) {
  const Clock::time_point start = Clock::now();
  RunReport report;
  Vec3 force_n = Vec3::Zero();
  Clock::time_point seen = start;  // our device, in a sound frame
  while (!stop.stop_requested()) {
    std::string_view frame;
    const bool sent = send_force(force_n, first_);
    first_ = false;
    const WebSocket::Received received =
        sent ? socket_.receive(frame, options_.reply_s) : WebSocket::Received::Lost;
    const Clock::time_point now = Clock::now();
    DeviceState state = last_;
    state.time_s = std::chrono::duration<double>(now - start).count();
    state.valid = received == WebSocket::Received::Text && read_state(frame, state);
    if (state.valid) {
      last_ = state;
      seen = now;
    }
    const bool lost = std::chrono::duration<double>(now - seen).count() > options_.reply_s;
    if (received != WebSocket::Received::Text || lost) {
      socket_.close();
      wait_for_device(servo, stop, start, report);
      seen = Clock::now();
      force_n = Vec3::Zero();
      continue;
    }
    force_n = servo(state);
    ++report.ticks;
  }
  if (socket_.connected()) (void)send_force(Vec3::Zero(), first_);
  return report;
}

}  // namespace beatlas::device
