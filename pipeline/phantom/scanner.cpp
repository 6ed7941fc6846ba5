#include "pipeline/phantom/scanner.h"

#include <array>
#include <cmath>

#include "pipeline/phantom/signals.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::phantom {
namespace {

constexpr int kMostSeed = std::numeric_limits<int>::max();

constexpr std::array kNumbers{
    ScannerNumber<double>{"slice_thickness_mm", &ScannerSpec::slice_thickness_mm, 0.0, 50.0},
    ScannerNumber<double>{"in_plane_sigma_mm", &ScannerSpec::in_plane_sigma_mm, 0.0, 5.0},
    ScannerNumber<double>{"slice_sigma_mm", &ScannerSpec::slice_sigma_mm, 0.0, 10.0},
    ScannerNumber<double>{"bias_share", &ScannerSpec::bias_share, 0.0, 0.9},
    ScannerNumber<double>{"gating_window_s", &ScannerSpec::gating_window_s, 0.0, 0.5},
    ScannerNumber<double>{"jitter_sigma_s", &ScannerSpec::jitter_sigma_s, 0.0, 0.1},
    ScannerNumber<double>{"mistrigger_s", &ScannerSpec::mistrigger_s, -0.2, 0.2},
    ScannerNumber<double>{"shift_sigma_mm", &ScannerSpec::shift_sigma_mm, 0.0, 20.0},
    ScannerNumber<double>{"shift_limit_mm", &ScannerSpec::shift_limit_mm, 0.0, 50.0},
    ScannerNumber<double>{"flow_void_share", &ScannerSpec::flow_void_share, 0.0, 1.0},
};
constexpr std::array kWholeNumbers{
    ScannerNumber<int>{"noise_seed", &ScannerSpec::noise_seed, 0, kMostSeed},
    ScannerNumber<int>{"bias_seed", &ScannerSpec::bias_seed, 0, kMostSeed},
    ScannerNumber<int>{"trigger_seed", &ScannerSpec::trigger_seed, 0, kMostSeed},
    ScannerNumber<int>{"shift_seed", &ScannerSpec::shift_seed, 0, kMostSeed},
    ScannerNumber<int>{"gating_subphases", &ScannerSpec::gating_subphases, 1, 25},
    ScannerNumber<int>{"mistriggered_slices", &ScannerSpec::mistriggered_slices, 0, 1024},
};

template <class T>
void check_field(const ScannerSpec& scanner, const ScannerNumber<T>& field) {
  const T value = scanner.*field.member;
  if (!(value >= field.low && value <= field.high)) {
    throw_invalid(std::string("/scanner/") + field.key + " must be a number from " +
                  nlohmann::json(field.low).dump() + " to " + nlohmann::json(field.high).dump());
  }
}

constexpr std::array kPartialVolumes{std::pair{PartialVolume::Exact, "exact"},
                                     std::pair{PartialVolume::Supersampled, "supersampled"},
                                     std::pair{PartialVolume::None, "none"}};

}  // namespace

std::span<const ScannerNumber<double>> scanner_numbers() { return kNumbers; }
std::span<const ScannerNumber<int>> scanner_whole_numbers() { return kWholeNumbers; }

std::vector<std::string> partial_volume_names() {
  std::vector<std::string> out;
  for (const auto& each : kPartialVolumes) out.emplace_back(each.second);
  return out;
}

PartialVolume partial_volume_from_name(const std::string& name) {
  for (const auto& [value, text] : kPartialVolumes) {
    if (name == text) return value;
  }
  throw_invalid("partial_volume must be \"exact\", \"supersampled\" or \"none\"");
}

void check_scanner(const ScannerSpec& scanner, int slices) {
  for (const auto& field : kNumbers) check_field(scanner, field);
  for (const auto& field : kWholeNumbers) check_field(scanner, field);
  if (!(scanner.snr_blood >= 1.0)) {
    throw_invalid("/scanner/snr_blood must be a number of at least 1, or null for no noise");
  }
  if (scanner.mistriggered_slices > slices) {
    throw_invalid("/scanner/mistriggered_slices must be a number from 0 to " +
                  std::to_string(slices) + ", the number of slices");
  }
  if (scanner.phase_encoding != "i" && scanner.phase_encoding != "j") {
    throw_invalid("/scanner/phase_encoding must be \"i\" or \"j\"");
  }
  try {
    (void)signals_preset(scanner.signals);
  } catch (const Error& error) {
    throw error.with_context("/scanner");
  }
}

nlohmann::json scanner_to_json(const ScannerSpec& scanner) {
  nlohmann::json out{{"signals", scanner.signals},
                     {"snr_blood", nullptr},
                     {"arms", scanner.arms},
                     {"phase_encoding", scanner.phase_encoding}};
  if (std::isfinite(scanner.snr_blood)) out["snr_blood"] = scanner.snr_blood;
  for (const auto& [value, name] : kPartialVolumes) {
    if (scanner.partial_volume == value) out["partial_volume"] = name;
  }
  for (const auto& field : kNumbers) out[field.key] = scanner.*field.member;
  for (const auto& field : kWholeNumbers) out[field.key] = scanner.*field.member;
  return out;
}

ScannerSpec scanner_from_json(const nlohmann::json& json, const std::string& path) {
  ScannerSpec out;
  JsonObject object(json, path);
  object.read("signals", out.signals);
  if (object.has("snr_blood") && !object.at("snr_blood").is_null()) {
    object.read("snr_blood", out.snr_blood, 1.0, 1e6);
  }
  if (object.has("partial_volume")) {
    std::string name;
    object.read("partial_volume", name);
    try {
      out.partial_volume = partial_volume_from_name(name);
    } catch (const Error& error) {
      throw error.with_context(path);
    }
  }
  for (const auto& field : kNumbers) {
    object.read(field.key, out.*field.member, field.low, field.high);
  }
  for (const auto& field : kWholeNumbers) {
    object.read(field.key, out.*field.member, field.low, field.high);
  }
  object.read("arms", out.arms);
  object.read("phase_encoding", out.phase_encoding);
  object.finish();
  return out;
}

}  // namespace beatlas::phantom
