#pragma once
/// The device that a command line names, and where its point lies about a heart.

#include <memory>
#include <string>

#include "runtime/app/headless.h"
#include "runtime/app/play_options.h"
#include "runtime/atlas/manifest.h"
#include "runtime/device/device.h"
#include "runtime/field/field_query.h"

namespace beatlas::app {

/// Neither simulated, nor a recording, nor the window's mouse.
[[nodiscard]] bool is_hardware(const std::string& device);

/// Opens what `arguments.device` names, and sets in `options` where its point is, how long it plays
/// and how many ticks to expect. A hardware device's middle lies 20 mm outside of the side that is
/// told, or in the middle of the cavity that the tool is in; a simulated hand moves about the
/// surface on that side, in a cavity from within.
/// @param field of what is touched
/// @throws Error{InvalidInput} of a recording that cannot be played or is longer than 10 hours,
/// Error{Machine} as device::open_hardware
[[nodiscard]] std::unique_ptr<device::Device> open_device(const PlayArguments& arguments,
                                                          const field::FieldQuery& field,
                                                          const atlas::Manifest& manifest,
                                                          SessionOptions& options);
/// The same on the side of a direction from the middle of what is touched [workspace, any length],
/// whatever `arguments.side` says.
[[nodiscard]] std::unique_ptr<device::Device> open_device(const PlayArguments& arguments,
                                                          const Vec3& direction,
                                                          const field::FieldQuery& field,
                                                          const atlas::Manifest& manifest,
                                                          SessionOptions& options);

}  // namespace beatlas::app
