#include "runtime/app/fingers.h"

#include <exception>
#include <filesystem>
#include <functional>
#include <latch>
#include <memory>
#include <ostream>
#include <set>
#include <stop_token>
#include <string_view>
#include <thread>
#include <utility>

#include "runtime/app/play_device.h"
#include "runtime/app/text.h"
#include "runtime/app/touched_heart.h"
#include "runtime/base/error.h"
#include "runtime/base/interrupts.h"
#include "runtime/base/json_object.h"
#include "runtime/base/json_text.h"

namespace beatlas::app {
namespace {

namespace fs = std::filesystem;

void read_one_of(JsonObject& object, const char* key, std::string& value,
                 std::initializer_list<std::string_view> words) {
  object.read(key, value);
  std::string all;
  for (const std::string_view word : words) {
    if (value == word) return;
    all += (all.empty() ? "" : ", ") + std::string(word);
  }
  throw_invalid(object.path() + "/" + key + " must be one of " + all);
}

PlayArguments read_finger(const nlohmann::json& entry, const std::string& path,
                          const fs::path& folder, PlayArguments finger) {
  JsonObject object(entry, path);
  read_one_of(object, "device", finger.device,
              {"simulated", "replay", "haply", "3ds", "dhd", "lever"});
  object.read("device_name", finger.hardware.name);
  std::string recording;
  object.read("recording", recording);
  read_one_of(object, "hand", finger.hand, {"still", "palpation"});
  read_one_of(object, "side", finger.side,
              {"left", "right", "anterior", "posterior", "superior", "inferior"});
  object.read("depth_mm", finger.depth_mm, -50, 50);
  object.read("amplitude_mm", finger.amplitude_mm, 0, 50);
  object.read("frequency_hz", finger.frequency_hz, 0, 20);
  object.read("mass_kg", finger.mass_kg, 0, 10);
  object.read("tool_radius_mm", finger.tool_radius_mm, 0, 50);
  object.finish();
  if ((finger.device == "replay") == recording.empty()) {
    throw_invalid(path + ": device replay and a recording belong together; give both or neither");
  }
  if (!recording.empty()) finger.recording = (folder / recording).string();
  return finger;
}

/// Of the finger n, counted from 0: t.csv to t_1.csv.
std::string numbered(const std::string& file, std::size_t n) {
  const fs::path path(file);
  return (path.parent_path() /
          (path.stem().string() + "_" + std::to_string(n + 1) + path.extension().string()))
      .string();
}

struct Finger {
  PlayArguments arguments;
  TouchingTool tool;
  std::unique_ptr<device::Device> device;
  SessionOptions options;
  Session session;
  std::exception_ptr failed = nullptr;
};

/// Runs every finger in a thread of its own, and waits for all.
void run_together(std::vector<Finger>& fingers) {
  std::latch begin(1);
  std::vector<std::jthread> threads;
  const auto run = [&begin](Finger& finger) {
    begin.wait();
    try {
      finger.session = run_session(*finger.device, *finger.tool.servo, finger.options);
    } catch (...) {
      finger.failed = std::current_exception();
    }
    finger.device.reset();  // No force from here on.
  };
  try {
    for (Finger& finger : fingers) threads.emplace_back(run, std::ref(finger));
  } catch (...) {  // No thread to be had: those that wait must not wait forever.
    begin.count_down();
    throw;
  }
  begin.count_down();
}

}  // namespace

std::vector<PlayArguments> read_fingers(const std::string& file, const PlayArguments& all) {
  const nlohmann::json document = read_json_file(file);
  std::vector<PlayArguments> out;
  try {
    JsonObject object(document, "");
    int version = 1;
    object.read("version", version, 1, 1);
    const nlohmann::json& list = object.at("fingers");
    object.finish();
    if (!list.is_array() || list.size() < kFewestFingers || list.size() > kMostFingers) {
      throw_invalid("/fingers must be a list of two to eight");
    }
    std::set<std::pair<std::string, std::string>> hardware;
    for (std::size_t n = 0; n < list.size(); ++n) {
      const std::string path = "/fingers/" + std::to_string(n);
      out.push_back(read_finger(list[n], path, fs::path(file).parent_path(), all));
      const PlayArguments& finger = out.back();
      if (is_hardware(finger.device) &&
          !hardware.emplace(finger.device, finger.hardware.name).second) {
        throw_invalid(path +
                      " is of a device that another finger has; tell them apart by "
                      "device_name");
      }
      if (is_hardware(finger.device) && finger.fast) {
        throw_invalid(path + " is of a real device, which keeps its own time; leave --fast out");
      }
    }
  } catch (const Error& error) {
    throw error.with_context(file);
  }
  return out;
}

void run_fingers(const PlayArguments& arguments, std::ostream& out) {
  const TouchedHeart heart(arguments);
  std::stop_source interrupted;
  const Interrupts interrupts([&interrupted] { interrupted.request_stop(); });
  std::vector<Finger> fingers;
  for (PlayArguments& told : read_fingers(arguments.fingers, arguments)) {
    Finger finger;
    finger.arguments = std::move(told);
    finger.tool = heart.tool(finger.arguments, 0);
    finger.device = open_device(finger.arguments, heart.field(), heart.manifest(), finger.options);
    finger.options.stop = interrupted.get_token();
    finger.options.keep_trace = !arguments.trace.empty();
    finger.options.watchdog = !arguments.fast;
    fingers.push_back(std::move(finger));
  }
  run_together(fingers);
  nlohmann::json reports = nlohmann::json::array();
  for (std::size_t n = 0; n < fingers.size(); ++n) {
    const Finger& finger = fingers[n];
    if (!arguments.trace.empty()) {
      write_file(numbered(arguments.trace, n), trace_csv(finger.session.trace));
    }
    reports.push_back(report_json(finger.arguments, finger.tool.touch,
                                  heart.rate_per_min(arguments), finger.session.report));
    if (!arguments.json) {
      out << "finger " << n + 1 << ": " << session_text(finger.session.report);
    }
  }
  if (arguments.json) out << json_text(nlohmann::json{{"fingers", reports}}, 2) << '\n';
  const auto who = [](std::size_t n) { return "finger " + std::to_string(n + 1); };
  for (std::size_t n = 0; n < fingers.size(); ++n) {
    if (fingers[n].failed) std::rethrow_exception(fingers[n].failed);
    if (fingers[n].session.lost) throw fingers[n].session.lost->with_context(who(n));
  }
  interrupts.check();
  for (std::size_t n = 0; n < fingers.size(); ++n) {
    const SessionReport& report = fingers[n].session.report;
    if (report.faults > 0) throw Error(ErrorCode::Machine, who(n) + ": " + faults_told(report));
  }
}

}  // namespace beatlas::app
