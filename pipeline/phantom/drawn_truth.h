#pragma once
/// Where the surfaces of a drawn exam's heart lie, between slices too: the truth of its whole body.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/phantom/drawn_heart.h"
#include "runtime/atlas/structures.h"
#include "runtime/base/geometry.h"

namespace beatlas::phantom {

/// Whether it says that it is the truth of a drawn exam.
[[nodiscard]] bool is_drawn_truth(const nlohmann::json& truth);

/// The body lies where the slices show it in the mean: a breath-hold moves each within its plane,
/// and no image knows where the heart lies with none.
class DrawnTruth {
 public:
  /// @param truth what drawn_exam left as DrawnExam::truth
  /// @throws Error{InvalidInput} if it is no such object, of another version, of a body without a
  /// heart, or does not hold what this program draws from its seed
  explicit DrawnTruth(const nlohmann::json& truth);

  [[nodiscard]] const std::string& identity() const noexcept { return identity_; }
  [[nodiscard]] double rr_interval_s() const noexcept { return rr_interval_s_; }
  [[nodiscard]] int phases() const noexcept { return static_cast<int>(contraction_.size()); }

  /// [ml] See drawn_volumes_ml. @param phase 0..phases() - 1
  [[nodiscard]] double volume_ml(Structure structure, int phase) const;

  /// The heart in one phase. Places are LPS [mm]. Stands while the truth does.
  class Frame {
   public:
    [[nodiscard]] bool contains(Structure structure, const Vec3& lps) const;
    /// Whether a place lies toward the apex from the mitral plane's middle, across the LV's axis:
    /// beyond it the outside of a heart is that of atria and vessels, which no stack shows whole.
    [[nodiscard]] bool below_base(const Vec3& lps) const;

    struct Point {
      Vec3 lps = Vec3::Zero();
      Vec3 normal = Vec3::UnitZ();  ///< outward
      double area_mm2 = 0;          ///< the piece of surface that it stands for
    };
    /// One on each edge of the lattice whose ends differ, found by halving to 0.01 mm: as
    /// assess/zero_level.h has it, edges along three axes cross a piece of surface of area A and
    /// normal n (|nx| + |ny| + |nz|) A / spacing^2 times. A normal is that of what the lattice has
    /// inside within two spacings.
    [[nodiscard]] std::vector<Point> surface(Structure structure) const;

   private:
    friend class DrawnTruth;
    Frame(const DrawnTruth& truth, float contraction, double spacing_mm);
    [[nodiscard]] Vec3F in_heart(const Vec3& lps) const;
    [[nodiscard]] std::uint8_t label_at(const Vec3F& place) const;
    [[nodiscard]] Vec3F place(const Index3& index) const;
    [[nodiscard]] bool holds(Structure structure, const Index3& index) const;
    [[nodiscard]] Point crossing(Structure structure, const Index3& inside,
                                 const Index3& outside) const;

    const DrawnTruth& truth_;
    DrawnHeart::Moment moment_;
    double spacing_mm_;
    int across_ = 0;  ///< points along an edge of the lattice
    Vec3F corner_ = Vec3F::Zero();
    std::vector<std::uint8_t> labels_;
  };
  /// @param phase 0..phases() - 1  @param spacing_mm of the lattice from which surfaces are found
  [[nodiscard]] Frame frame(int phase, double spacing_mm) const;

 private:
  std::string identity_;
  double rr_interval_s_ = 0;
  std::vector<double> contraction_;                     ///< [phase]
  std::map<Structure, std::vector<double>> volume_ml_;  ///< [phase]
  std::optional<DrawnHeart> heart_;
  Eigen::Matrix3f axes_ = Eigen::Matrix3f::Identity();  ///< see heart_axes
  Vec3F moved_mm_ = Vec3F::Zero();                      ///< by breath-holds, in the mean
};

}  // namespace beatlas::phantom
