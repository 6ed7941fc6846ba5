#pragma once
/// What may move the tool, as a list to choose from.

#include <array>
#include <string>
#include <string_view>

#include "runtime/app/play_options.h"

namespace beatlas::viewer {

struct DeviceChoice {
  std::string_view name;    ///< as `beatlas-play --device` calls it; "mouse"
  std::string_view title;   ///< for people
  std::string_view detail;  ///< what must or may be told besides; empty: nothing
  std::string_view usual;   ///< what is told if nobody says otherwise
  bool needs_detail = false;
  bool detail_is_file = false;
};

/// The mouse is the first.
inline constexpr std::array<DeviceChoice, 7> kDevices{
    {{.name = "mouse", .title = "Mouse", .detail = "", .usual = ""},
     {.name = "simulated", .title = "Simulated hand", .detail = "", .usual = ""},
     {.name = "replay",
      .title = "Recorded path",
      .detail = "its file (CSV: t_s, x_mm, y_mm, z_mm)",
      .usual = "",
      .needs_detail = true,
      .detail_is_file = true},
     {.name = "haply",
      .title = "Haply Inverse3",
      .detail = "host:port of Haply's service",
      .usual = "localhost:10001",
      .needs_detail = true},
     {.name = "3ds",
      .title = "3D Systems Touch, PHANToM",
      .detail = "libHD, if not where the system looks",
      .usual = "",
      .detail_is_file = true},
     {.name = "dhd",
      .title = "Force Dimension, Falcon",
      .detail = "libdhd, if not where the system looks",
      .usual = "",
      .detail_is_file = true},
     {.name = "lever",
      .title = "One-axis lever",
      .detail = "its serial line, as /dev/ttyACM0",
      .usual = "",
      .needs_detail = true,
      .detail_is_file = true}}};

/// What the command line says of a device that is chosen here, for app::open_device: a simulated
/// hand palpates for ten hours.
/// @pre `choice` is one of kDevices, not the mouse
/// @throws Error{Usage} if the detail is no such thing
[[nodiscard]] app::PlayArguments device_arguments(const DeviceChoice& choice,
                                                  const std::string& detail);

}  // namespace beatlas::viewer
