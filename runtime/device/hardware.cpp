#include "runtime/device/hardware.h"

#include <functional>

#include "runtime/base/error.h"
#include "runtime/device/force_dimension.h"
#include "runtime/device/haply.h"
#include "runtime/device/lever.h"
#include "runtime/device/open_haptics.h"

namespace beatlas::device {

std::unique_ptr<Device> open_hardware(const HardwareOptions& options) {
  if (options.device == "haply") {
    HaplyOptions haply;
    haply.host = options.host;
    haply.port = options.port;
    haply.device_id = options.name;
    return std::make_unique<HaplyDevice>(haply);
  }
  if (options.device == "3ds") {
    return std::make_unique<OpenHapticsDevice>(
        OpenHapticsOptions{.library = options.library, .device_name = options.name});
  }
  if (options.device == "dhd") {
    return std::make_unique<ForceDimensionDevice>(
        ForceDimensionOptions{.library = options.library});
  }
  if (options.line.empty()) {
    throw Error(ErrorCode::Usage,
                "--device lever needs --lever-line, the file of its serial line (/dev/ttyACM0)");
  }
  LeverOptions lever;
  lever.geometry.arm_m = 1e-3 * options.arm_mm;
  lever.direction = Vec3::UnitZ();  // towards the user; pushing in is away
  return std::make_unique<LeverDevice>(std::make_unique<LineAxis>(options.line), lever);
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

Affine workspace_from_hardware(const Affine& workspace_from_lps, const Vec3& surface_mm,
                               const Vec3& outward, double clear_mm) {
  Eigen::Matrix3d lps_from_user;  // columns: right, up, towards the user
  lps_from_user << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  Affine out = Affine::Identity();
  out.linear() = workspace_from_lps.linear() * lps_from_user;
  out.translation() = surface_mm + clear_mm * outward.normalized();
  return out;
}

}  // namespace beatlas::device
