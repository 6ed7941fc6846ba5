#pragma once
/// Images between slices that lie far apart. Blended straight across, a wall that leans from slice
/// to slice becomes streaks; the atlas knows where it runs.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/atlas/payloads.h"
#include "runtime/base/geometry.h"
#include "runtime/field/field_query.h"

namespace beatlas::viewer {

/// Shape-based interpolation of grey levels (after Grevera and Udupa, IEEE Trans. Med. Imaging
/// 1996): a place between two slices shows what they show at the same distance from the nearest
/// surfaces. Slices themselves stay as they are.
class BetweenSlices {
 public:
  /// Slices nearer than this [mm], or than twice a pixel's edge, are blended straight.
  static constexpr double kLeastGapMm = 5;

  /// Whether anything lies between that the fields would have to tell.
  [[nodiscard]] static bool far_apart(const atlas::VolumePayload& volume);

  /// @param fields signed distances of structures [mm], of the volume's workspace; none: straight
  /// @param low_mm, high_mm box of the heart through the cycle, workspace; straight beyond it
  BetweenSlices(const atlas::VolumePayload& volume,
                std::vector<std::shared_ptr<const field::FieldQuery>> fields, const Vec3& low_mm,
                const Vec3& high_mm);

  /// Size and placing of the images with what lies between, from half a gap before the first slice
  /// to half a gap beyond the last; without samples. The volume's own where slices are near.
  [[nodiscard]] const atlas::VolumePayload& shape() const noexcept { return shape_; }
  [[nodiscard]] bool needed() const noexcept { return parts_ > 1; }

  /// @param beats time over the R-R interval, any number
  /// @param slices the volume at that time, 8 bit
  /// @param to shape().sample_count()
  void fill(double beats, std::span<const std::uint8_t> slices, std::span<std::uint8_t> to);

 private:
  static constexpr int kKept = 16;      ///< moments of the beat; between them straight
  static constexpr int kNodePx = 3;     ///< pixels between places that are looked at
  static constexpr double kUnits = 64;  ///< of a pixel

  /// From a place to the slices before and after it.
  struct Way {
    std::array<std::array<std::int16_t, 2>, 2> px{};  ///< [side][axis], 1 / kUnits pixels
    std::array<std::uint8_t, 2> trust{255, 255};      ///< 0: that slice shows nothing of the kind
  };
  struct Blend;

  [[nodiscard]] const std::vector<Way>& kept_at(int moment);
  [[nodiscard]] Way way_at(const Vec3& index, double t) const;
  void fill_slice(int k, const std::array<const Way*, 2>& ways, double between,
                  std::span<const std::uint8_t> slices, std::span<std::uint8_t> to) const;

  std::array<int, 3> size_{};  ///< of the volume
  atlas::VolumePayload shape_;
  std::vector<std::shared_ptr<const field::FieldQuery>> fields_;
  double rr_interval_s_ = 1;
  int parts_ = 1;                  ///< steps from slice to slice
  int beyond_ = 0;                 ///< steps before the first
  std::array<int, 2> first_px_{};  ///< of the nodes
  std::array<int, 2> node_count_{};
  std::array<std::vector<Way>, kKept> kept_;  ///< [node], as they are asked for
};

}  // namespace beatlas::viewer
