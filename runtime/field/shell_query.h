#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "runtime/field/field_query.h"

namespace beatlas::field {

/// Asks a field for the many points of one shell (a fingertip) at one time: the four phases around
/// the time are summed once for the box of samples that the shell needs, then each point takes a
/// spline in space alone. The answers are those of FieldQuery::sample, bit for bit.
///
/// Holds scratch memory, so it serves one thread at a time; make one a thread.
class ShellQuery {
 public:
  /// Scratch for shells up to 40 mm wide at voxels of 1.5 mm.
  static constexpr std::size_t kUsualSamples = std::size_t{32} * 32 * 32;

  /// `most_samples` for points that lie within a cube of `width_mm` [mm] > 0, its axes the
  /// workspace's; no more than a box of 64 x 64 x 64.
  [[nodiscard]] static std::size_t samples_for(double width_mm, double voxel_mm);

  /// @param field kept alive
  /// @param most_samples of the lattice in a box, 8 bytes each; taken here and never again
  /// @throws Error{InvalidInput} if there is no field.
  explicit ShellQuery(std::shared_ptr<const FieldQuery> field,
                      std::size_t most_samples = kUsualSamples);

  /// Allocates nothing. Points so few or so far apart that a box would cost more than it saves, or
  /// would not fit, are asked one by one.
  /// @param x workspace [mm], any points; t [s], any time
  /// @param out the answers, in the order of x; as many as the shorter of both
  void sample(std::span<const Vec3> x, double t, std::span<FieldSample> out) noexcept;

  [[nodiscard]] const FieldQuery& field() const noexcept { return *field_; }

 private:
  struct Box;

  [[nodiscard]] Box box_of(std::span<const Vec3> x) const noexcept;
  void collapse(const Box& box, const FieldQuery::Moment& moment) noexcept;

  std::shared_ptr<const FieldQuery> field_;
  std::vector<float> values_;  ///< [z][y][x] of the box, counts of the payload's step
  std::vector<float> rates_;   ///< per phase
};

}  // namespace beatlas::field
