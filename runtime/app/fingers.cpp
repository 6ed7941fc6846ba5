#include "runtime/app/fingers.h"

#include <barrier>
#include <exception>
#include <filesystem>
#include <functional>
#include <latch>
#include <memory>
#include <optional>
#include <ostream>
#include <set>
#include <sstream>
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
#include "runtime/base/replace_file.h"

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
              {"mouse", "simulated", "replay", "haply", "3ds", "dhd", "lever"});
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

constexpr double kMPerMm = 1e-3;

/// The step that all fingers take together where no clock paces them.
class Lockstep {
 public:
  Lockstep(std::size_t fingers, std::shared_ptr<palpation::CommonCirculation> circulation)
      : barrier_(static_cast<std::ptrdiff_t>(fingers), Advance{std::move(circulation)}) {}
  void wait() { barrier_.arrive_and_wait(); }
  void leave() { barrier_.arrive_and_drop(); }

 private:
  struct Advance {
    std::shared_ptr<palpation::CommonCirculation> circulation;
    void operator()() noexcept { circulation->advance(); }
  };
  std::barrier<Advance> barrier_;
};

/// Has a finger tell the circulation where it is, tick by tick, and take it on.
/// @param lockstep null in real time: there whoever comes first does
void join(Finger& finger, std::size_t n,
          const std::shared_ptr<palpation::CommonCirculation>& circulation, Lockstep* lockstep) {
  finger.options.after_tick = [n, circulation, lockstep](const haptics::Tick& felt, double phase) {
    const bool lost = felt.status == haptics::TickStatus::Fault;
    circulation->tell(n, felt.contact.proxy_mm, lost ? -1 : -kMPerMm * felt.contact.distance_mm,
                      phase);
    if (lockstep != nullptr) return lockstep->wait();
    circulation->advance();
  };
}

/// Runs every finger in a thread of its own, and waits for all.
/// @param circulation of the muscle; null where another model is felt
void run_together(std::vector<Finger>& fingers, bool fast,
                  const std::shared_ptr<palpation::CommonCirculation>& circulation) {
  std::latch begin(1);
  std::optional<Lockstep> lockstep;
  if (circulation && fast) lockstep.emplace(fingers.size(), circulation);
  Lockstep* const together = lockstep ? &*lockstep : nullptr;
  std::vector<std::jthread> threads;
  const auto run = [&](Finger& finger, std::size_t n) {
    begin.wait();
    try {
      finger.session = run_session(*finger.device, *finger.tool.servo, finger.options);
    } catch (...) {
      finger.failed = std::current_exception();
    }
    finger.device.reset();  // No force from here on.
    if (circulation) circulation->lift(n);
    if (together != nullptr) together->leave();
  };
  try {
    for (std::size_t n = 0; n < fingers.size(); ++n) {
      if (circulation) join(fingers[n], n, circulation, together);
      threads.emplace_back(run, std::ref(fingers[n]), n);
    }
  } catch (...) {  // No thread to be had: those that wait must not wait forever.
    for (std::size_t n = threads.size(); together != nullptr && n < fingers.size(); ++n) {
      together->leave();
    }
    begin.count_down();
    throw;
  }
  begin.count_down();
}

/// What is of all fingers, after what was told of each.
void tell_together(const PlayArguments& arguments, const nlohmann::json& reports,
                   const palpation::CommonCirculation* circulation, std::ostream& out) {
  nlohmann::json all{{"fingers", reports}};
  if (circulation != nullptr) {
    const palpation::Signals now = circulation->published();
    all["circulation"] = {{"natural_output_l_per_min", now.natural_output_l_per_min},
                          {"output_l_per_min", now.beat.output_l_per_min},
                          {"aortic_mean_mmhg", now.beat.aortic_mean_mmhg},
                          {"beats", now.beats}};
  }
  if (arguments.json) {
    out << json_text(all, 2) << '\n';
  } else if (circulation != nullptr) {
    std::ostringstream text;
    text.precision(3);
    text << "the circulation behind them: " << all["circulation"]["output_l_per_min"].get<double>()
         << " l/min in the last beat, "
         << all["circulation"]["natural_output_l_per_min"].get<double>() << " without a finger\n";
    out << text.str();
  }
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
      if (finger.device == "mouse" && (n > 0 || all.headless)) {
        throw_invalid(path + "/device may be mouse of the first finger in the window alone");
      }
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
  const double rate_per_min = arguments.heart_rate_per_min;
  using C = palpation::CirculationParameters;
  if (is_patch(arguments) && rate_per_min > 0 &&
      !(rate_per_min >= C::kSlowestPerMin && rate_per_min <= C::kQuickestPerMin)) {
    throw Error(ErrorCode::Usage,
                "--heart-rate must be from 30 to 220 where fingers share a circulation");
  }
  const TouchedHeart heart(arguments);
  std::stop_source interrupted;
  const Interrupts interrupts([&interrupted] { interrupted.request_stop(); });
  std::vector<PlayArguments> all = read_fingers(arguments.fingers, arguments);
  for (std::size_t n = 0; !arguments.trace.empty() && n < all.size(); ++n) {
    refuse_other_kind(numbered(arguments.trace, n), trace_csv({}));
  }
  FingerOfSeveral which = heart.in_common(arguments, all.size());
  const auto circulation = which.circulation;
  std::vector<Finger> fingers;
  for (PlayArguments& told : all) {
    Finger finger;
    finger.arguments = std::move(told);
    which.finger = fingers.size();
    finger.tool = heart.tool(finger.arguments, 0, which);
    finger.device = open_device(finger.arguments, heart.field(), heart.manifest(), finger.options);
    finger.options.stop = interrupted.get_token();
    finger.options.keep_trace = !arguments.trace.empty();
    finger.options.watchdog = !arguments.fast;
    fingers.push_back(std::move(finger));
  }
  run_together(fingers, arguments.fast, circulation);
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
  tell_together(arguments, reports, circulation.get(), out);
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
