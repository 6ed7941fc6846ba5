#pragma once
/// What may move the tool, as a list to choose from.

#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "runtime/atlas/manifest.h"
#include "runtime/field/field_query.h"
#include "runtime/viewer/live_touch.h"

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

/// Where a device's middle lies.
struct ToolPlace {
  bool in_cavity = false;
  double effusion_mm = 0;  ///< > 0: in the pericardium's fluid
};

/// Opens one; may take two seconds. A simulated hand palpates in `direction` from the heart's
/// middle (workspace), from the surface at end-diastole; hardware's middle lies 20 mm outside of
/// the surface there; in a cavity it palpates from within, and the middle is the cavity's, in the
/// pericardium that of the fluid.
/// @param field of what is touched  @pre `choice` is one of kDevices, not the mouse
/// @throws Error{Usage} if the detail is no such thing; Error{InvalidInput} for a recording that
/// cannot be read; Error{Machine} if the device is not there.
[[nodiscard]] ReadyDevice open_device(const DeviceChoice& choice, const std::string& detail,
                                      const atlas::Manifest& manifest,
                                      const field::FieldQuery& field, const Vec3& direction,
                                      const ToolPlace& place = {});

}  // namespace beatlas::viewer
