#pragma once
/// Hardware by name: for programs that let their user choose.

#include <memory>
#include <string>

#include "runtime/device/device.h"

namespace beatlas::device {

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

/// Haply is waited for, two seconds at most. @throws Error{Usage} for a lever without a line;
/// Error{Machine} if the device is not there.
[[nodiscard]] std::unique_ptr<Device> open_hardware(const HardwareOptions& options);

/// What there is, each with what it needs and whether it is there now; ends with a newline. Nothing
/// is moved, and a device in use stays so.
[[nodiscard]] std::string list_devices(const HardwareOptions& options);

/// Where a hardware device's point goes: its middle `clear_mm` outside of `surface_mm`. The user
/// looks at a patient who faces them and stands upright: right is the patient's left, up superior,
/// towards the user anterior. @param workspace_from_lps rigid
[[nodiscard]] Affine workspace_from_hardware(const Affine& workspace_from_lps,
                                             const Vec3& surface_mm, const Vec3& outward,
                                             double clear_mm);

}  // namespace beatlas::device
