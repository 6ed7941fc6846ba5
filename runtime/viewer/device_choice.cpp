#include "runtime/viewer/device_choice.h"

#include <algorithm>
#include <fstream>

#include "runtime/base/error.h"
#include "runtime/device/hardware.h"
#include "runtime/device/replay.h"
#include "runtime/device/simulated.h"
#include "runtime/field/surface_point.h"

namespace beatlas::viewer {
namespace {

constexpr double kHardwareClearMm = 20;
// What the simulated hand does, as `beatlas-play --device simulated` does by default.
constexpr double kDepthMm = 4;
constexpr double kAmplitudeMm = 4;
constexpr double kFrequencyHz = 1.5;
constexpr double kLongS = 36000;

std::unique_ptr<device::Device> open_replay(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw_invalid(file + " cannot be read; check its name and rights");
  return std::make_unique<device::ReplayDevice>(device::read_recording(stream, file),
                                                device::ReplayOptions{});
}

std::unique_ptr<device::Device> open_simulated(const Vec3& surface_mm, const Vec3& pressed) {
  device::SimulatedOptions options;
  options.path.anchor_m = kMPerMm * surface_mm;
  options.path.direction = pressed;
  options.path.offset_m = kMPerMm * kDepthMm;
  options.path.amplitude_m = kMPerMm * kAmplitudeMm;
  options.path.frequency_hz = kFrequencyHz;
  options.seconds = kLongS;
  return std::make_unique<device::SimulatedDevice>(options);
}

device::HardwareOptions hardware_options(const DeviceChoice& choice, const std::string& detail) {
  device::HardwareOptions options;
  options.device = choice.name;
  options.library = detail;
  options.line = detail;
  if (choice.name != "haply") return options;
  const std::size_t colon = detail.rfind(':');
  options.host = detail.substr(0, colon);
  const std::string port = colon == std::string::npos ? "" : detail.substr(colon + 1);
  const bool digits = !port.empty() && port.size() <= 5 &&
                      port.find_first_not_of("0123456789") == std::string::npos;
  options.port = digits ? std::stoi(port) : 0;
  if (options.host.empty() || options.port < 1 || options.port > 65535) {
    throw Error(ErrorCode::Usage, "\"" + detail + "\" is not HOST:PORT, as localhost:10001");
  }
  return options;
}

}  // namespace

ReadyDevice open_device(const DeviceChoice& choice, const std::string& detail,
                        const atlas::Manifest& manifest, const field::FieldQuery& field,
                        const Vec3& direction, const ToolPlace& place) {
  if (choice.name == "replay") return {.device = open_replay(detail)};
  const double end_diastole_s =
      manifest.rr_interval_s * manifest.end_diastole / std::max(1, manifest.phase_count());
  const Vec3 outward = direction.normalized();
  const Vec3 surface_mm = field::surface_point_mm(field, outward, end_diastole_s);
  if (choice.name == "simulated") {
    return {.device = open_simulated(surface_mm, place.in_cavity ? outward : Vec3(-outward))};
  }
  double clear_mm = place.effusion_mm > 0 ? place.effusion_mm / 2 : kHardwareClearMm;
  if (place.in_cavity) clear_mm = -(surface_mm - field.centre_mm()).norm();
  return {.device = device::open_hardware(hardware_options(choice, detail)),
          .workspace_from_device = device::workspace_from_hardware(manifest.workspace_from_lps,
                                                                   surface_mm, outward, clear_mm)};
}

}  // namespace beatlas::viewer
