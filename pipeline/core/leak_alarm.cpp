#include "pipeline/core/leak_alarm.h"

#include <array>
#include <cstddef>

namespace beatlas {
namespace {

constexpr std::array<std::string_view, 6> kNames{"volume-jump", "open-cycle",   "image-border",
                                                 "air",         "still-tissue", "no-edge"};

}  // namespace

std::string_view leak_kind_name(LeakKind kind) noexcept {
  return kNames[static_cast<std::size_t>(kind)];
}

std::optional<LeakKind> leak_kind_from_name(std::string_view name) noexcept {
  for (std::size_t at = 0; at < kNames.size(); ++at) {
    if (kNames[at] == name) return static_cast<LeakKind>(at);
  }
  return std::nullopt;
}

}  // namespace beatlas
