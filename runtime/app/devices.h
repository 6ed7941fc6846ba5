#pragma once
#include <memory>
#include <string>

#include "runtime/device/device.h"

namespace beatlas::app {

/// Which hardware, and where it is found.
struct HardwareOptions {
  std::string device;              ///< haply, 3ds, dhd or lever
  std::string library;             ///< 3ds, dhd: file to load instead of the vendor's usual one
  std::string name;                ///< 3ds, haply: which device of several
  std::string host = "localhost";  ///< haply
  int port = 10001;                ///< haply
  std::string line;                ///< lever: its serial line
  double arm_mm = 60;              ///< lever
};

/// @throws Error{Usage} for a lever without a line; Error{Machine} if the device is not there.
[[nodiscard]] std::unique_ptr<device::Device> open_hardware(const HardwareOptions& options);

/// What there is, each with what it needs and whether it is there now; ends with a newline. Nothing
/// is moved, and a device in use stays so.
[[nodiscard]] std::string list_devices(const HardwareOptions& options);

}  // namespace beatlas::app
