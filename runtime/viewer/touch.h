#pragma once
/// What is felt while the heart is looked at: a servo for each finger on the atlas's heart, or in
/// one of its cavities, and behind them all paper B's circulation of a ventricle as large as the
/// atlas's.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/atlas/manifest.h"
#include "runtime/atlas/surface_band.h"
#include "runtime/field/field_query.h"
#include "runtime/haptics/pericardial_field.h"
#include "runtime/haptics/seqlock.h"
#include "runtime/haptics/servo.h"
#include "runtime/haptics/tube_field.h"
#include "runtime/palpation/atlas_muscle.h"
#include "runtime/palpation/common_circulation.h"
#include "runtime/viewer/drawing.h"
#include "runtime/viewer/heart_frame.h"

namespace beatlas::viewer {

inline constexpr double kMPerMm = 1e-3;
inline constexpr double kTickS = 1e-3;  ///< of the mouse and of a scripted press

/// What of the muscle is ill, as a preset or a file has it, before it is made as large as the
/// heart.
struct Disease {
  palpation::PalpationParameters parameters;
  std::vector<palpation::Region> regions = {};
  palpation::RegionMaps maps = {};  ///< that the regions name
};

struct TouchSettings {
  /// proxy: a spring of the stiffness; patch: paper B's muscle, on an atlas with a map that of the
  /// place that is touched, as the preset has it
  std::string model = "proxy";
  double tool_radius_mm = 3;                         ///< 0..20
  double stiffness_n_per_m = 0;                      ///< proxy; 0: the atlas's
  double heart_rate_per_min = 0;                     ///< 0: the atlas's
  std::string preset = "healthy";                    ///< of palpation_presets()
  std::shared_ptr<const Disease> disease = nullptr;  ///< instead of the preset's
  /// Of each finger, 1 to palpation::kMostFingers of them, in place of tool_radius_mm; none: one.
  std::vector<double> radii_mm = {};
  bool inside = false;     ///< the field is a cavity's, whose wall is felt from within; proxy
  double effusion_mm = 0;  ///< > 0: the tool is in the pericardium's fluid, so thick; proxy
};

/// One tick as a whole, for graphics.
struct Felt {
  haptics::Published servo;
  palpation::Signals circulation;
  std::int64_t clock_ns = 0;  ///< of std::chrono::steady_clock, when the tick ended
  std::uint64_t wishes = 0;   ///< how often the parameters were changed until then
};

/// What plots and tables show of a tick.
struct PressRow {
  double time_s;
  double force_n;
  double depth_mm;
  double volume_ml;
  double lv_mmhg;
  std::uint64_t beat;        ///< of the circulation
  bool touching;             ///< of any finger
  std::uint64_t wishes = 0;  ///< as of Felt
};
[[nodiscard]] PressRow press_row(const Felt& felt) noexcept;

/// The same for the picture; on a wall that gives way as `dent_radius_mm` says.
[[nodiscard]] ToolPicture tool_picture_of(const haptics::Published& servo, double radius_mm,
                                          double dent_radius_mm = 25) noexcept;

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

/// Servos and circulation in step: the first finger's heart leads, the others' follow it, and so
/// does the circulation's beat. A cavity's wall that is felt from within displaces nothing.
class Touch {
 public:
  /// @throws Error{InvalidInput} as its parts do; without volumes of lv_blood the circulation is
  /// that of the dog of 25 kg.
  /// @param field of what is touched
  /// @param wall of the same package; null without a map: then disease has no place in the muscle
  /// @param valve the way out of the cavity; null: closed
  Touch(const atlas::Manifest& manifest, std::shared_ptr<const field::FieldQuery> field,
        const TouchSettings& settings, std::shared_ptr<const palpation::LvWall> wall = nullptr,
        std::shared_ptr<const haptics::TubeField> valve = nullptr);

  /// Null unless the tool is in it.
  [[nodiscard]] const haptics::PericardialField* pericardium() const noexcept {
    return pericardium_.get();
  }
  [[nodiscard]] std::size_t fingers() const noexcept { return fingers_.size(); }
  /// The device's thread, each finger its own; no allocation, lock, log or file.
  /// @return the force to send [N]
  Vec3 tick(const haptics::ServoState& state, std::size_t finger = 0) noexcept;
  /// The same thread: the finger's device is gone, it touches nothing.
  void lift(std::size_t finger) noexcept;

  [[nodiscard]] Felt felt(std::size_t finger = 0) const noexcept {
    return fingers_[finger]->felt.read();
  }
  /// Every fifth tick of the first finger since the last call, in order; of one thread. After 20 s
  /// without a call the later ones are left out.
  void take_rows(std::vector<PressRow>& to) { rows_.take(to); }
  [[nodiscard]] haptics::Servo& servo(std::size_t finger = 0) noexcept {
    return *fingers_[finger]->servo;
  }
  /// The caller's thread. @throws Error{InvalidInput} as its parts do.
  /// All fingers' heart: beat on, or stand still; hold_phase as haptics::Servo has it.
  void set_paused(bool paused) noexcept;
  void hold_phase(double phase) noexcept;
  void set_heart_rate(double per_min);
  void set_stiffness(double n_per_m);
  void set_preset(const std::string& name);
  void set_disease(const Disease& disease);
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
  /// [mm] How near the true surface lies to that under the tool, with 90 % (atlas::BandQuery); none
  /// while nothing is touched, or where it is not known.
  [[nodiscard]] std::optional<double> known_to_mm(const Felt& felt) const;
  /// What a picture shows of a tick.
  [[nodiscard]] ToolPicture tool_picture(const Felt& felt, std::size_t finger = 0) const;
  /// How the pressure of a tick is spread under the tool, columns along `right` (workspace); where
  /// the muscle is known, harder where it is stiffer; a point has none. One thread, the picture's.
  [[nodiscard]] haptics::TaxelMap taxels(const Felt& felt, const Vec3& right,
                                         std::size_t finger = 0);

 private:
  struct Finger {
    double radius_mm = 0;
    std::unique_ptr<haptics::Servo> servo;
    haptics::Seqlock<Felt> felt;
    Felt last;                                ///< of its own thread
    Felt led_by;                              ///< the first finger's, as its own thread saw it
    std::unique_ptr<haptics::Taxels> taxels;  ///< of the tool and the muscle; null: to be made
  };

  [[nodiscard]] haptics::Scene scene(std::size_t finger) const;
  [[nodiscard]] std::shared_ptr<const haptics::ContactField> make_body();
  /// No muscle gives way: from within a cavity, or in the pericardium.
  [[nodiscard]] bool within() const noexcept {
    return settings_.inside || settings_.effusion_mm > 0;
  }
  void offer_scenes();
  void forget_taxels();
  void keep_in_step(Finger& finger) noexcept;
  [[nodiscard]] palpation::TissueMap tissue_of(const palpation::PalpationParameters& parameters,
                                               const Disease& disease) const;
  [[nodiscard]] palpation::PalpationParameters scaled(const Disease& disease) const;
  void make_muscle();
  void wish(const palpation::PalpationParameters& parameters);

  /// [mm] The place of the surface over the first finger's tool.
  [[nodiscard]] Vec3 surface_under(const Felt& felt) const;

  std::shared_ptr<const field::FieldQuery> field_;
  std::optional<atlas::BandQuery> band_;  ///< of what is touched
  TouchSettings settings_;
  double end_diastole_ = 0;  // phase
  double rr_interval_s_ = 1;
  std::optional<std::array<double, 2>> volumes_ml_;
  Disease disease_;
  palpation::PalpationParameters wished_;
  std::shared_ptr<const palpation::LvWall> wall_;
  std::shared_ptr<const palpation::AtlasMuscle> muscle_;  ///< of the preset; null without a wall
  std::shared_ptr<const haptics::TubeField> valve_;
  std::shared_ptr<const haptics::PericardialField> pericardium_;
  std::shared_ptr<const haptics::ContactField> body_;
  std::shared_ptr<palpation::CommonCirculation> circulation_;
  std::vector<std::unique_ptr<Finger>> fingers_;
  std::atomic<std::uint64_t> wishes_{0};
  std::atomic<double> rate_hz_{1};
  std::atomic<bool> muscle_felt_{false};  ///< the model is the patch
  std::atomic<bool> beating_{true};       ///< not paused and no phase held
  RowQueue rows_;
};

/// A scripted press without a device or a clock: the same every time.
struct PressRun {
  std::vector<PressRow> rows;     ///< one a millisecond
  std::vector<PressRow> natural;  ///< the last whole beat before the tool comes
  std::vector<PressRow> pressed;  ///< the last whole beat
  std::vector<Felt> beat;         ///< every tick of the last cycle of the heart, until `last`
  Felt last;

  /// The tick of that cycle that is nearest to a phase.
  [[nodiscard]] const Felt& at_phase(double phase) const;
  /// The tick of that cycle with the largest force.
  [[nodiscard]] const Felt& hardest() const;
};

/// The tool comes from outside, goes to the place where it is `depth_mm` below the surface of
/// `phase`, stays there for eight beats and a little more, until it is `phase`.
/// @param direction from the heart's centre to where it is pressed
/// @throws Error{InvalidInput} if there is no surface in that direction.
[[nodiscard]] PressRun run_press(Touch& touch, const field::FieldQuery& field,
                                 const Vec3& direction, double depth_mm, double phase);

}  // namespace beatlas::viewer
