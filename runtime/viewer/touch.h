#pragma once
/// What is felt while the heart is looked at: the servo on the atlas's heart and, behind it, paper
/// B's circulation of a ventricle as large as the atlas's.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/atlas/manifest.h"
#include "runtime/field/field_query.h"
#include "runtime/haptics/seqlock.h"
#include "runtime/haptics/servo.h"
#include "runtime/palpation/atlas_muscle.h"
#include "runtime/palpation/trainer.h"
#include "runtime/viewer/drawing.h"
#include "runtime/viewer/heart_frame.h"

namespace beatlas::viewer {

struct TouchSettings {
  /// proxy: a spring of the stiffness; patch: paper B's muscle, on an atlas with a map that of the
  /// place that is touched, as the preset has it
  std::string model = "proxy";
  double tool_radius_mm = 3;       ///< 0..20
  double stiffness_n_per_m = 0;    ///< proxy; 0: the atlas's
  double heart_rate_per_min = 0;   ///< 0: the atlas's
  std::string preset = "healthy";  ///< of palpation_presets()
};

/// One tick as a whole, for graphics.
struct Felt {
  haptics::Published servo;
  palpation::Signals circulation;
  std::int64_t clock_ns = 0;  ///< of std::chrono::steady_clock, when the tick ended
};

/// What plots and tables show of a tick.
struct PressRow {
  double time_s;
  double force_n;
  double depth_mm;
  double volume_ml;
  double lv_mmhg;
  std::uint64_t beat;  ///< of the circulation
  bool touching;
};
[[nodiscard]] PressRow press_row(const Felt& felt) noexcept;

/// From one thread that adds to one that takes, without a lock; what finds no room is left out.
class RowQueue {
 public:
  void add(const PressRow& row) noexcept;
  /// All since the last call, in order.
  void take(std::vector<PressRow>& to);

 private:
  static constexpr std::size_t kRows = 4096;  // 20 s at 200 a second
  std::array<PressRow, kRows> rows_{};
  std::atomic<std::size_t> added_{0};
  std::atomic<std::size_t> taken_{0};
};

/// The LV's wall under the tool.
struct TouchedWall {
  int segment = 0;  ///< 1..17
  palpation::Tissue tissue;
};

/// Servo and circulation in step: the circulation's beat follows the heart's phase.
class Touch {
 public:
  /// @throws Error{InvalidInput} as its parts do; without volumes of lv_blood the circulation is
  /// that of the dog of 25 kg.
  /// @param wall of the same package; null without a map: then disease has no place in the muscle
  Touch(const atlas::Manifest& manifest, std::shared_ptr<const field::FieldQuery> field,
        const TouchSettings& settings, std::shared_ptr<const palpation::LvWall> wall = nullptr);

  /// The device's thread; no allocation, lock, log or file. @return the force to send [N]
  Vec3 tick(const haptics::ServoState& state) noexcept;

  [[nodiscard]] Felt felt() const noexcept { return felt_.read(); }
  /// Every fifth tick since the last call, in order; of one thread. After 20 s without a call the
  /// later ones are left out.
  void take_rows(std::vector<PressRow>& to) { rows_.take(to); }
  [[nodiscard]] haptics::Servo& servo() noexcept { return *servo_; }
  /// The caller's thread. @throws Error{InvalidInput} as its parts do.
  void set_heart_rate(double per_min);
  void set_stiffness(double n_per_m);
  void set_preset(const std::string& name);
  void set_left_atrial_mmhg(double mmhg);
  void set_right_atrial_mmhg(double mmhg);
  /// Every number of the parameters by its place in their JSON, as "muscle/middle/k_v_n_per_m";
  /// changed, it acts at once on the muscle under the tool and within a quarter of a second on the
  /// circulation. "circulation/weight_kg" scales all that goes with the size of the body.
  [[nodiscard]] std::vector<std::string> constants() const;
  /// @throws Error{InvalidInput} if there is none of that name
  [[nodiscard]] double constant(const std::string& name) const;
  /// @throws Error{InvalidInput} by the name and the range
  void set_constant(const std::string& name, double value);
  /// As settings.model.
  void set_model(const std::string& model);
  [[nodiscard]] const palpation::PalpationParameters& parameters() const { return wished_; }
  [[nodiscard]] const TouchSettings& settings() const { return settings_; }
  /// None while the tool is outside, or in another part of the heart.
  [[nodiscard]] std::optional<TouchedWall> touched_wall(const Felt& felt) const;
  /// What a picture shows of a tick.
  [[nodiscard]] ToolPicture tool_picture(const Felt& felt) const;
  /// How the pressure of a tick is spread under the tool, columns along `right` (workspace); where
  /// the muscle is known, harder where it is stiffer; a point has none. One thread, the picture's.
  [[nodiscard]] haptics::TaxelMap taxels(const Felt& felt, const Vec3& right);

 private:
  [[nodiscard]] haptics::Scene scene() const;
  [[nodiscard]] palpation::PalpationParameters scaled(const std::string& preset) const;
  void make_muscle();
  void wish(const palpation::PalpationParameters& parameters);

  std::shared_ptr<const field::FieldQuery> field_;
  TouchSettings settings_;
  double end_diastole_ = 0;  // phase
  double rr_interval_s_ = 1;
  std::optional<std::array<double, 2>> volumes_ml_;
  palpation::PalpationParameters wished_;
  std::shared_ptr<const palpation::LvWall> wall_;
  std::shared_ptr<const palpation::AtlasMuscle> muscle_;  ///< of the preset; null without a wall
  double dent_radius_mm_ = 25;
  std::unique_ptr<haptics::Taxels> taxels_;  ///< of the tool and the muscle; null: to be made
  std::unique_ptr<haptics::Servo> servo_;
  std::unique_ptr<palpation::Trainer> trainer_;
  double last_phase_ = 0;
  bool ticked_ = false;
  haptics::Seqlock<Felt> felt_;
  RowQueue rows_;
};

/// A scripted press without a device or a clock: the same every time.
struct PressRun {
  std::vector<PressRow> rows;     ///< one a millisecond
  std::vector<PressRow> natural;  ///< the last whole beat before the tool comes
  std::vector<PressRow> pressed;  ///< the last whole beat
  Felt last;
};

/// The tool comes from outside, goes to the place where it is `depth_mm` below the surface of
/// `phase`, stays there for eight beats and a little more, until it is `phase`.
/// @param direction from the heart's centre to where it is pressed
/// @throws Error{InvalidInput} if there is no surface in that direction.
[[nodiscard]] PressRun run_press(Touch& touch, const field::FieldQuery& field,
                                 const Vec3& direction, double depth_mm, double phase);

}  // namespace beatlas::viewer
