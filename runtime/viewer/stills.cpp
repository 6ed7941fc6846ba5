#include "runtime/viewer/stills.h"

#include <QImage>
#include <QPainter>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "runtime/app/region_maps.h"
#include "runtime/app/touched_heart.h"
#include "runtime/base/error.h"
#include "runtime/viewer/plots.h"
#include "runtime/viewer/touch.h"
#include "runtime/viewer/volume_plot.h"

namespace beatlas::viewer {
namespace {

/// Of what lies around a tool in a cavity.
constexpr double kAroundToolOpacity = 0.3;
// The plots' share of the picture's width.
constexpr double kPlotShare = 0.36;
const QColor kForceColour(90, 220, 120);
const QColor kDepthColour(250, 200, 80);
const QColor kNaturalColour(120, 180, 255);
const QColor kPressedColour(255, 120, 110);

std::vector<Panel> press_panels(const PressRun& run, double beat_s) {
  std::vector<PressRow> recent(run.rows);
  const double begin = recent.back().time_s - 4 * beat_s;
  std::erase_if(recent, [&](const PressRow& row) { return row.time_s < begin; });
  return {{.title = "Force [N]",
           .x_title = "Time [s]",
           .curves = {curve(recent, &PressRow::time_s, &PressRow::force_n, "", kForceColour)},
           .from_zero = true},
          {.title = "Depth [mm]",
           .x_title = "Time [s]",
           .curves = {curve(recent, &PressRow::time_s, &PressRow::depth_mm, "", kDepthColour)},
           .from_zero = true},
          {.title = "LV pressure [mmHg]",
           .x_title = "LV volume [ml]",
           .curves = {curve(run.natural, &PressRow::volume_ml, &PressRow::lv_mmhg, "natural",
                            kNaturalColour),
                      curve(run.pressed, &PressRow::volume_ml, &PressRow::lv_mmhg, "pressed",
                            kPressedColour)},
           .from_zero = true}};
}

Picture with_plots(const Picture& left, const std::vector<Panel>& panels, int plot_width,
                   double text_scale) {
  QImage image(left.width + plot_width, left.height, QImage::Format_RGB888);
  for (int y = 0; y < left.height; ++y) {
    const std::size_t row = 3 * static_cast<std::size_t>(left.width);
    std::copy_n(left.rgb.data() + row * static_cast<std::size_t>(y), row, image.scanLine(y));
  }
  QPainter painter(&image);
  QFont font = painter.font();
  font.setPixelSize(static_cast<int>(std::lround(text_scale * std::max(13, left.height / 46))));
  painter.setFont(font);
  paint_panels(painter, QRect(left.width, 0, plot_width, left.height), panels);
  painter.end();
  Picture whole{.width = image.width(), .height = image.height(), .rgb = {}};
  for (int y = 0; y < whole.height; ++y) {
    const uchar* from = image.constScanLine(y);
    whole.rgb.insert(whole.rgb.end(), from, from + 3 * whole.width);
  }
  return whole;
}

}  // namespace

double phase_of(const std::string& word, const atlas::Manifest& manifest) {
  const double phases = std::max(1, manifest.phase_count());
  if (word == "ed") return manifest.end_diastole / phases;
  if (word == "es") return manifest.end_systole / phases;
  std::size_t used = 0;
  double phase = -1;
  try {
    phase = std::stod(word, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used != word.size() || word.empty() || !(phase >= 0 && phase <= 1)) {
    throw Error(ErrorCode::Usage, "--phase must be ed, es or a number from 0 to 1");
  }
  return phase;
}

OpenedHeart open_heart(const std::filesystem::path& package, const std::string& inside,
                       bool valve) {
  const atlas::Atlas looked_at = atlas::Atlas::open(package, atlas::Needs{});
  atlas::Needs needs = atlas::everything_in(looked_at.manifest());
  needs.levels = {0};
  const Structure touched = app::touched_structure(inside);
  std::erase_if(needs.fields, [touched](Structure structure) {
    return structure != Structure::Heart && structure != touched;
  });
  if (!inside.empty()) needs.fields.insert(touched);
  OpenedHeart heart;
  heart.atlas = std::make_shared<const atlas::Atlas>(atlas::Atlas::open(package, needs));
  if (needs.surfaces.empty()) {
    throw_invalid(package.string() +
                  " has no surfaces to draw; build it with --scene anatomy or full");
  }
  if (const auto field = heart.atlas->field(Structure::Heart)) {
    heart.field =
        std::make_shared<const field::FieldQuery>(field, heart.atlas->manifest().rr_interval_s);
  }
  heart.touched = heart.field;
  heart.inside = inside;
  if (!inside.empty()) {
    heart.touched = std::make_shared<const field::FieldQuery>(
        heart.atlas->field(touched), heart.atlas->manifest().rr_interval_s);
    if (valve) heart.valve = app::valve_of(*heart.atlas, package.string());
  }
  return heart;
}

std::string model_of(const ViewOptions& options) {
  if (!options.model.empty()) return options.model;
  return options.preset == "healthy" && !options.told ? "proxy" : "patch";
}

Disease disease_of(const OpenedHeart& heart, const app::ToldMuscle& told) {
  Disease out{.parameters = told.parameters, .regions = told.regions};
  if (told.regions.empty()) return out;
  const auto wall = palpation::lv_wall_of(*heart.atlas);
  if (!wall) {
    throw_invalid("the package has no map of the LV's wall, which the regions of " +
                  told.file.string() + " are found on; build it again from images");
  }
  out.maps = app::read_region_maps(told.regions, told.file.parent_path(), *wall,
                                   heart.atlas->manifest().workspace_from_lps);
  return out;
}

std::unique_ptr<Touch> touch_of(const OpenedHeart& heart, const TouchSettings& settings) {
  return std::make_unique<Touch>(heart.atlas->manifest(), heart.touched, settings,
                                 palpation::lv_wall_of(*heart.atlas), heart.valve);
}

void apply(const ViewOptions& options, HeartDrawing& drawing) {
  if (options.volume != VolumePreset::Off && !drawing.has_volume()) {
    throw_invalid("the package has no images to draw; build it from images with --scene full");
  }
  drawing.fit_camera(standard_view(drawing.frame(), options.view), options.zoom);
  for (const Structure structure : kAllStructures) {
    Look look = drawing.look(structure);
    // Surfaces would hide the volume; their lines on a cut stay.
    if (options.volume != VolumePreset::Off) look.opacity = 0;
    if (options.colour != ColourBy::Structure)
      look.opacity = coloured_opacity(options.colour, structure);
    // A tool in a cavity is seen through all that lies around it.
    if (!options.inside.empty()) look.opacity = std::min(look.opacity, kAroundToolOpacity);
    const auto wished = options.opacity.find(structure);
    if (wished != options.opacity.end()) {
      look.opacity = wished->second;
      look.visible = wished->second > 0;
    }
    drawing.set_look(structure, look);
  }
  drawing.set_colouring(options.colour, options.told ? options.told->parameters
                                                     : palpation::palpation_preset(options.preset));
  drawing.set_volume(options.volume);
  if (options.free_cut) {
    drawing.set_cut(options.free_cut);
  } else if (!options.cut.empty()) {
    drawing.set_cut(standard_cut(drawing.frame(), options.cut, options.cut_offset_mm));
  } else {
    drawing.set_cut(std::nullopt);
  }
  drawing.set_image_on_cut(options.image_on_cut);
  drawing.set_beats(options.phase);
}

namespace {

// The drawing, the tool in it, and what lies beside it.
struct Stage {
  std::unique_ptr<HeartDrawing> drawing;
  std::vector<Panel> panels;
  int plot_width = 0;
  int width = 0;
  int height = 0;
  double text_scale = 1;
  std::unique_ptr<Touch> touch;  // null without a press
  PressRun press;

  // The heart, the tool and its dent as they were in one tick of the press.
  void show(const Felt& felt) {
    drawing->set_beats(felt.servo.phase);
    ToolPicture tool = touch->tool_picture(felt);
    tool.taxels = touch->taxels(felt, drawing->camera().right());
    drawing->set_tool(tool);
    std::array<char, 64> note{};
    std::snprintf(note.data(), note.size(), "%.1f mm deep", press_row(felt).depth_mm);
    drawing->set_note(note.data());
  }

  [[nodiscard]] Picture picture() const {
    const Picture left = drawing->picture(width, height);
    return panels.empty() ? left : with_plots(left, panels, plot_width, text_scale);
  }
};

// The arrow and its number are what a press is shown for: where they would be cut off, all becomes
// smaller.
void keep_arrow_inside(const Stage& stage) {
  constexpr double kBesidePx = 90;  // the number
  constexpr double kAbovePx = 30;
  (void)stage.picture();
  const std::optional<Vec3> tip = stage.drawing->arrow_tip_mm();
  if (!tip) return;
  const Vec2 away = stage.drawing->pixel_of(*tip) - 0.5 * Vec2(stage.width, stage.height);
  const double across = std::max(0.25 * stage.width, 0.5 * stage.width - kBesidePx);
  const double upright = std::max(0.25 * stage.height, 0.5 * stage.height - kAbovePx);
  const double larger = std::max(std::abs(away.x()) / across, std::abs(away.y()) / upright);
  if (larger <= 1) return;
  CameraPose pose = stage.drawing->camera();
  pose.height_mm *= larger;
  stage.drawing->set_camera(pose);
}

Stage make_stage(const ViewOptions& options, const OpenedHeart& heart) {
  Stage stage;
  stage.width = options.width;
  stage.height = options.height;
  stage.text_scale = options.text_scale;
  stage.drawing = std::make_unique<HeartDrawing>(heart.atlas, heart.field,
                                                 DrawingOptions{.caption = options.caption,
                                                                .anaglyph = options.anaglyph,
                                                                .text_scale = options.text_scale});
  apply(options, *stage.drawing);
  const atlas::Manifest& manifest = heart.atlas->manifest();
  if (options.plots) {
    stage.plot_width = std::max(16, static_cast<int>(kPlotShare * options.width));
    stage.width = std::max(16, options.width - stage.plot_width);
    stage.panels = {volume_panel(manifest)};
  }
  if (!(options.press_mm > 0)) return stage;
  if (!heart.field) {
    throw_invalid("the package has no field of the heart to press on; build it with --scene full");
  }
  stage.touch = touch_of(heart, {.model = model_of(options), .preset = options.preset});
  const HeartFrame& frame = stage.drawing->frame();
  const Vec3 direction = options.press_lps
                             ? Vec3(frame.workspace_from_lps.linear() * *options.press_lps)
                             : free_wall_direction(frame, heart.field->centre_mm());
  stage.press = run_press(*stage.touch, *heart.field, direction, options.press_mm, options.phase);
  stage.show(stage.press.last);
  if (options.plots) {
    stage.panels = press_panels(stage.press, 60 / stage.touch->settings().heart_rate_per_min);
  }
  keep_arrow_inside(stage);
  return stage;
}

}  // namespace

void write_screenshot(const ViewOptions& options, const OpenedHeart& heart,
                      const std::filesystem::path& file) {
  write_png(make_stage(options, heart).picture(), file);
}

void write_recording(const ViewOptions& options, const OpenedHeart& heart,
                     const std::filesystem::path& folder, int frames) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed || !std::filesystem::is_directory(folder)) {
    throw Error(ErrorCode::Machine, folder.string() + " cannot be made: " + failed.message());
  }
  Stage stage = make_stage(options, heart);
  if (stage.touch) {
    // The longest arrow of all tells how large every frame is.
    stage.show(stage.press.hardest());
    keep_arrow_inside(stage);
  }
  for (int n = 0; n < frames; ++n) {
    const double phase = options.phase + static_cast<double>(n) / frames;
    if (stage.touch) {
      stage.show(stage.press.at_phase(phase));
    } else {
      stage.drawing->set_beats(phase);
    }
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "frame_%04d.png", n);
    write_png(stage.picture(), folder / name.data());
  }
}

}  // namespace beatlas::viewer
