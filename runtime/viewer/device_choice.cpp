#include "runtime/viewer/device_choice.h"

#include <algorithm>

#include "runtime/app/play_device.h"
#include "runtime/base/error.h"

namespace beatlas::viewer {
namespace {

constexpr double kLongS = 36000;  ///< as long as a session may be, app::open_device

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

app::PlayArguments device_arguments(const DeviceChoice& choice, const std::string& detail) {
  app::PlayArguments out;
  out.device = choice.name;
  out.seconds = kLongS;
  if (choice.name == "replay") out.recording = detail;
  if (app::is_hardware(out.device)) out.hardware = hardware_options(choice, detail);
  return out;
}

}  // namespace beatlas::viewer
