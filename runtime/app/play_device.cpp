#include "runtime/app/play_device.h"

#include <fstream>

#include "runtime/app/text.h"
#include "runtime/app/touch.h"
#include "runtime/base/error.h"
#include "runtime/device/hardware.h"
#include "runtime/device/replay.h"
#include "runtime/device/simulated.h"
#include "runtime/field/surface_point.h"

namespace beatlas::app {
namespace {

constexpr double kHardwareClearMm = 20;  // a device's middle lies this far outside

bool is_in_cavity(const PlayArguments& arguments) {
  return !arguments.inside.empty() && arguments.inside != kPericardium;
}

// Directions of the body in LPS.
Vec3 side_lps(const std::string& side) {
  if (side == "left") return Vec3::UnitX();
  if (side == "right") return -Vec3::UnitX();
  if (side == "posterior") return Vec3::UnitY();
  if (side == "anterior") return -Vec3::UnitY();
  return side == "superior" ? Vec3(Vec3::UnitZ()) : Vec3(-Vec3::UnitZ());
}

// On a side of what is touched, at end-diastole.
Vec3 full_surface_mm(const field::FieldQuery& field, const atlas::Manifest& manifest,
                     const Vec3& outward) {
  const double end_diastole_s = manifest.rr_interval_s * manifest.end_diastole / field.phases();
  return field::surface_point_mm(field, outward, end_diastole_s);
}

std::unique_ptr<device::Device> make_device(const PlayArguments& arguments, const Vec3& outward,
                                            const field::FieldQuery& field,
                                            const atlas::Manifest& manifest, double& seconds) {
  const device::Pace pace = arguments.fast ? device::Pace::Fast : device::Pace::RealTime;
  if (arguments.device == "replay") {
    std::ifstream stream = open_text(arguments.recording);
    auto replay = std::make_unique<device::ReplayDevice>(
        device::read_recording(stream, arguments.recording),
        device::ReplayOptions{.rate_hz = 1000, .pace = pace});
    seconds = replay->seconds();
    return replay;
  }
  seconds = arguments.seconds;
  device::SimulatedOptions options;
  options.path.anchor_m = 1e-3 * full_surface_mm(field, manifest, outward);
  options.path.direction = is_in_cavity(arguments) ? outward : Vec3(-outward);
  options.path.offset_m = 1e-3 * arguments.depth_mm;
  if (arguments.hand == "palpation") {
    options.path.amplitude_m = 1e-3 * arguments.amplitude_mm;
    options.path.frequency_hz = arguments.frequency_hz;
  }
  options.hand.mass_kg = arguments.mass_kg;
  options.seconds = seconds;
  options.pace = pace;
  return std::make_unique<device::SimulatedDevice>(options);
}

}  // namespace

bool is_hardware(const std::string& device) {
  return device != "simulated" && device != "replay" && device != "mouse";
}

std::unique_ptr<device::Device> open_device(const PlayArguments& arguments,
                                            const field::FieldQuery& field,
                                            const atlas::Manifest& manifest,
                                            SessionOptions& options) {
  return open_device(arguments, manifest.workspace_from_lps.linear() * side_lps(arguments.side),
                     field, manifest, options);
}

std::unique_ptr<device::Device> open_device(const PlayArguments& arguments, const Vec3& direction,
                                            const field::FieldQuery& field,
                                            const atlas::Manifest& manifest,
                                            SessionOptions& options) {
  const Vec3 outward = direction.normalized();
  double seconds = arguments.seconds;
  std::unique_ptr<device::Device> device;
  if (is_hardware(arguments.device)) {
    device::HardwareOptions hardware = arguments.hardware;
    hardware.device = arguments.device;
    device = device::open_hardware(hardware);
    const Vec3 surface_mm = full_surface_mm(field, manifest, outward);
    // In a cavity a device's middle is the cavity's, in the pericardium that of the fluid.
    double clear_mm = kHardwareClearMm;
    if (is_in_cavity(arguments)) clear_mm = -(surface_mm - field.centre_mm()).norm();
    if (arguments.inside == kPericardium) clear_mm = arguments.effusion_mm / 2;
    options.workspace_from_device =
        device::workspace_from_hardware(manifest.workspace_from_lps, surface_mm, outward, clear_mm);
    options.seconds = seconds;
  } else {
    device = make_device(arguments, outward, field, manifest, seconds);
  }
  if (!(seconds <= 36000)) throw_invalid("a session longer than 10 hours is not played");
  // A device of 4 kHz is the quickest there is.
  options.expected_ticks =
      static_cast<std::size_t>(seconds * (is_hardware(arguments.device) ? 4000 : 1000)) + 2;
  return device;
}

}  // namespace beatlas::app
