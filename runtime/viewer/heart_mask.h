#pragma once
/// How much of each voxel of the images is the heart's, at any moment: fat and lung around it are
/// as bright as what is to be seen.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "runtime/base/geometry.h"
#include "runtime/field/field_query.h"

namespace beatlas::viewer {

class HeartMask {
 public:
  /// @param workspace_from_index of voxels' centres [mm]
  /// @param heart signed distance [mm], of the same workspace
  HeartMask(const Affine& workspace_from_index, const std::array<int, 3>& size,
            std::shared_ptr<const field::FieldQuery> heart);

  /// 0 outside .. 255 inside, the first axis quickest: it falls over a voxel's largest edge (from
  /// 1.5 to 4 mm), so that what is drawn between voxels has no steps. Good until the next call.
  [[nodiscard]] const std::vector<std::uint8_t>& at(double beats);

 private:
  static constexpr int kKept = 24;  ///< moments of the beat; between them a cubic runs

  [[nodiscard]] std::uint8_t share(double distance_mm) const;
  [[nodiscard]] const std::vector<std::int16_t>& kept_at(int moment);

  std::shared_ptr<const field::FieldQuery> heart_;
  double half_mm_;
  std::vector<std::uint8_t> mask_;
  std::vector<std::uint32_t> edge_;  ///< voxels that the heart's edge passes in some phase
  std::vector<Vec3> places_mm_;      ///< of those
  std::array<std::vector<std::int16_t>, kKept> kept_;  ///< their distances, as they are asked for
};

}  // namespace beatlas::viewer
