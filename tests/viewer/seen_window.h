#pragma once
#include <string>

namespace beatlas::test {

/// Waits until a window is seen on that X server (":7"), twenty seconds at most, and a second more,
/// in which it is drawn. @return whether one is seen
[[nodiscard]] bool window_is_seen(const std::string& display);

}  // namespace beatlas::test
