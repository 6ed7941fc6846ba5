#pragma once
/// What is asked of the leak alarm.

namespace beatlas::alarm {

/// What a leak alarm does.
enum class LeakAction { Warn, Error };

/// Limits: what clean segmentations of phantoms stay below; see tests/soak.
struct LeakOptions {
  LeakAction action = LeakAction::Warn;
  /// [%] 2..100: how far a phase's volume may leave what the phases beside it foretell, of the
  /// structure's largest.
  double volume_percent = 6;
  /// [mm2] 10..10000: patch of the heart's surface along the border of the slices, or with lung or
  /// air under it.
  double contact_mm2 = 200;
  /// [mm2] 10..10000: patch of the heart's surface along an edge that does not move. An apex hardly
  /// does.
  double still_mm2 = 1500;
  /// [mm2] 10..10000: patch of a structure's surface without an edge in the image.
  double edgeless_mm2 = 200;
};

}  // namespace beatlas::alarm
