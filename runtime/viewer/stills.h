#pragma once
/// Pictures without a window.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/app/play_options.h"
#include "runtime/app/ventricle.h"
#include "runtime/atlas/structures.h"
#include "runtime/viewer/drawing.h"
#include "runtime/viewer/touch.h"

namespace beatlas::viewer {

/// What is opened, and how it is looked at first; a window begins with it, too.
struct ViewOptions {
  std::filesystem::path package;
  double phase = 0;  ///< 0..1
  std::string view;  ///< one of kViews
  double zoom = 1;
  std::string cut;  ///< one of kCuts; empty: none
  double cut_offset_mm = 0;
  std::optional<CutPlane> free_cut;
  bool image_on_cut = true;
  VolumePreset volume = VolumePreset::Off;
  ColourBy colour = ColourBy::Structure;
  std::string preset = "healthy";       ///< of palpation_presets(): what is felt and coloured
  std::optional<app::ToldMuscle> told;  ///< instead of the preset, in a window
  std::string told_name;                ///< for people
  double heart_rate_per_min = 0;        ///< of a window; 0: the atlas's
  std::string model;  ///< of TouchSettings; empty: patch for a disease, else proxy
  std::map<Structure, double> opacity;  ///< 0: hidden
  double press_mm = 0;                  ///< > 0: a tool presses so deep
  std::optional<Vec3> press_lps;        ///< from the heart's centre; none: the LV's free wall
  bool plots = false;
  bool caption = true;
  bool anaglyph = false;
  double text_scale = 1;      ///< of all words
  double tool_radius_mm = 0;  ///< 0: 3, in a cavity 1
  /// Cavity that the tool is in, or the pericardium; empty: the heart from outside
  std::string inside;
  double effusion_mm = 0;  ///< inside the pericardium
  bool valve = false;      ///< inside lv_blood: the way through its valve is open
  /// Of a window: what moves each of several fingers; empty: one, of `device`
  std::vector<app::PlayArguments> fingers;
  std::optional<app::PlayArguments> exercise;  ///< of a window: what is played in it
  std::string device = "mouse";                ///< of a window: one of kDevices
  std::string device_detail;                   ///< what it needs besides; empty: what is usual
  int width = 800;
  int height = 600;
};

/// The phase that a word says: "ed", "es" of the package, or 0..1. @throws Error{Usage}
[[nodiscard]] double phase_of(const std::string& word, const atlas::Manifest& manifest);

/// Opens all that is drawn and felt of a package; its field may be missing.
struct OpenedHeart {
  std::shared_ptr<const atlas::Atlas> atlas;
  std::shared_ptr<const field::FieldQuery> field;    ///< of the heart, or null
  std::shared_ptr<const field::FieldQuery> touched;  ///< the same, or of the cavity
  std::string inside;                                ///< of the cavity; empty: none
  std::shared_ptr<const haptics::TubeField> valve;   ///< the way out of it; null: closed
};
/// @param inside, valve as ViewOptions
/// @throws Error{InvalidInput} as atlas::Atlas::open does, if there is no surface, or not the
/// cavity or valve that is asked for.
[[nodiscard]] OpenedHeart open_heart(const std::filesystem::path& package,
                                     const std::string& inside = "", bool valve = false);

/// The force model that is meant.
[[nodiscard]] std::string model_of(const ViewOptions& options);

/// What the muscle was told to be, on the heart's own wall.
/// @throws Error{InvalidInput} as app::read_region_maps, or if regions need a map and there is none
[[nodiscard]] Disease disease_of(const OpenedHeart& heart, const app::ToldMuscle& told);

/// What can be touched of a package, with the muscle of its own wall. Takes some time.
/// @throws Error{InvalidInput} as Touch does; there must be a field.
[[nodiscard]] std::unique_ptr<Touch> touch_of(const OpenedHeart& heart,
                                              const TouchSettings& settings);

/// Looks as `options` say; without the tool. Where the LV's wall is coloured, what hides it is not
/// drawn, but for what has an opacity of its own.
void apply(const ViewOptions& options, HeartDrawing& drawing);

/// One PNG. Needs a display and a QGuiApplication (for the plots' text).
void write_screenshot(const ViewOptions& options, const OpenedHeart& heart,
                      const std::filesystem::path& file);

/// frame_0000.png, ... of one beat from `options.phase` on; makes the folder.
/// @param frames 1..10000
void write_recording(const ViewOptions& options, const OpenedHeart& heart,
                     const std::filesystem::path& folder, int frames);

}  // namespace beatlas::viewer
