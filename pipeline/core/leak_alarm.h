#pragma once
/// What makes a segmentation look as if a label had leaked.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/atlas/structures.h"
#include "runtime/base/geometry.h"

namespace beatlas {

enum class LeakKind {
  VolumeJump,   ///< a phase's volume is not what the phases beside it foretell
  OpenCycle,    ///< the volume steps from the last phase to the first
  ImageBorder,  ///< the structure runs along the border of the slices
  Air,          ///< the structure's surface holds what is as dark as lung
  StillTissue,  ///< the structure's surface follows an edge that does not move in the cycle
  NoEdge,       ///< the structure's surface runs where the image has no step
};

/// "volume-jump", "open-cycle", "image-border", "air", "still-tissue", "no-edge".
[[nodiscard]] std::string_view leak_kind_name(LeakKind kind) noexcept;
[[nodiscard]] std::optional<LeakKind> leak_kind_from_name(std::string_view name) noexcept;

/// A seed that pushes a leak back: what lies there in truth, and where.
struct LeakSeed {
  std::uint8_t label = 0;
  Vec3 lps_mm = Vec3::Zero();
  double radius_mm = 0;
  int phase = 0;  ///< -1: every phase
};

struct LeakAlarm {
  LeakKind kind{};
  Structure structure{};
  int phase = 0;               ///< the worst
  Vec3 lps_mm = Vec3::Zero();  ///< where to look
  double figure = 0;           ///< [% of the largest volume] or [mm2]
  double limit = 0;            ///< same unit; figure > limit
  std::string sentence;        ///< for the user: what, where, what to do
  /// That together push it back. None: labels do not tell what leaked, an eye must.
  std::vector<LeakSeed> seeds = {};
  int sign = 0;  ///< of a volume: 1 too much, -1 missing; else 0
};

}  // namespace beatlas
