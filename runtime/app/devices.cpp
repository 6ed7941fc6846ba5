#include "runtime/app/devices.h"

#include <functional>

#include "runtime/base/error.h"
#include "runtime/device/force_dimension.h"
#include "runtime/device/haply.h"
#include "runtime/device/lever.h"
#include "runtime/device/open_haptics.h"

namespace beatlas::app {

std::unique_ptr<device::Device> open_hardware(const HardwareOptions& options) {
  if (options.device == "haply") {
    device::HaplyOptions haply;
    haply.host = options.host;
    haply.port = options.port;
    haply.device_id = options.name;
    return std::make_unique<device::HaplyDevice>(haply);
  }
  if (options.device == "3ds") {
    return std::make_unique<device::OpenHapticsDevice>(
        device::OpenHapticsOptions{.library = options.library, .device_name = options.name});
  }
  if (options.device == "dhd") {
    return std::make_unique<device::ForceDimensionDevice>(
        device::ForceDimensionOptions{.library = options.library});
  }
  if (options.line.empty()) {
    throw Error(ErrorCode::Usage,
                "--device lever needs --lever-line, the file of its serial line (/dev/ttyACM0)");
  }
  device::LeverOptions lever;
  lever.geometry.arm_m = 1e-3 * options.arm_mm;
  lever.direction = Vec3::UnitZ();  // towards the user; pushing in is away
  return std::make_unique<device::LeverDevice>(std::make_unique<device::LineAxis>(options.line),
                                               lever);
}

std::string list_devices(const HardwareOptions& options) {
  std::string text =
      "simulated  always there: a hand that is still or palpates (--hand, --side, --mass-kg)\n"
      "replay     always there: a recorded path (--recording)\n";
  const auto add = [&](const std::string& device, const std::string& what) {
    HardwareOptions one = options;
    one.device = device;
    std::string line = device;
    line.resize(11, ' ');
    try {
      (void)open_hardware(one);
      text += line + "there: " + what + "\n";
    } catch (const Error& error) {
      text += line + "not there: " + error.what() + "\n";
    }
  };
  add("haply", "Haply Inverse3, by Haply's local service");
  add("3ds", "3D Systems Touch or PHANToM, by libHD");
  add("dhd", "Force Dimension or Falcon, by libdhd");
  if (options.line.empty()) {
    text += "lever      not looked for: name its serial line with --lever-line\n";
  } else {
    add("lever", "one-axis lever at " + options.line);
  }
  return text;
}

}  // namespace beatlas::app
