#pragma once
/// A beating heart as a picture. VTK stays behind this header.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/atlas/atlas.h"
#include "runtime/base/geometry.h"
#include "runtime/field/field_query.h"
#include "runtime/haptics/pericardial_field.h"
#include "runtime/haptics/taxels.h"
#include "runtime/palpation/dent.h"
#include "runtime/palpation/parameters.h"
#include "runtime/viewer/heart_frame.h"
#include "runtime/viewer/surface_colours.h"

namespace beatlas::viewer {

/// How a structure's surface is drawn.
struct Look {
  Vec3 colour = Vec3::Ones();  ///< red, green, blue, 0..1
  double opacity = 1;          ///< 0..1
  bool visible = true;
};

/// What a structure looks like before anybody chooses; the heart's outside lets the rest through.
[[nodiscard]] Look default_look(Structure structure);
/// "Left ventricle, muscle".
[[nodiscard]] std::string structure_title(Structure structure);

/// `Blood`: the bright cavities through the cycle (not measured flow). `Muscle`: what is as bright
/// as the left ventricle's wall.
enum class VolumePreset : std::uint8_t { Off, Muscle, Blood };

/// What touches the heart, and what comes of it. Workspace frame.
struct ToolPicture {
  Vec3 position_mm = Vec3::Zero();
  Vec3 proxy_mm = Vec3::Zero();
  Vec3 force_n = Vec3::Zero();  ///< on the user
  double radius_mm = 3;
  bool shown = true;  ///< false: it keeps its number, and is not drawn
  bool touching = false;
  /// The surface and what is under it give way against `dent_normal`: this much at the dent's place
  /// on the surface, elsewhere by the weight of palpation::DentField.
  double dent_mm = 0;
  Vec3 dent_place_mm = Vec3::Zero();
  Vec3 dent_normal = Vec3::UnitX();  ///< unit, outward
  double dent_radius_mm = 25;
  /// How the pressure is spread under the tool; drawn where it is touched.
  haptics::TaxelMap taxels = {};
};

/// Red, green, blue, 8 bit each; the upper row first.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

/// @throws Error{Machine} if it cannot be written whole; nothing half written stays.
void write_png(const Picture& picture, const std::filesystem::path& file);

/// What a picture's time went into [ms].
struct DrawTimes {
  double update_ms = 0;  ///< vertices, images, cut
  double render_ms = 0;
};

struct DrawingOptions {
  bool offscreen = true;  ///< without a window of its own
  bool caption = true;    ///< names, phase, scale bar, orientation
  /// Stereo pictures, the left eye's red, the right eye's cyan.
  bool anaglyph = false;
  double text_scale = 1;     ///< words and what is drawn with them, times as large
  double display_scale = 1;  ///< dots an inch over 96, of the display: words are no smaller there
};

/// Where the legend of colours was drawn, in pixels of the picture (y down).
struct LegendPlace {
  double x = 0;  ///< of its middle: the bar's, or the bull's eye's
  double y = 0;
  double half_height = 0;  ///< half of the bar's height; the bull's eye's radius
};

/// Beating surfaces, beating volume, a cut through both, a tool. One thread. Needs a display (see
/// display.h).
///
/// Setters are cheap; what has changed is made when a picture is.
class HeartDrawing {
 public:
  /// @param field of the heart, or none: the volume is then not freed from what lies around it
  /// @throws Error{InvalidInput} if the atlas has no surface; Error{Machine} without OpenGL.
  HeartDrawing(std::shared_ptr<const atlas::Atlas> atlas,
               std::shared_ptr<const field::FieldQuery> field, const DrawingOptions& options);
  ~HeartDrawing();
  HeartDrawing(const HeartDrawing&) = delete;
  HeartDrawing& operator=(const HeartDrawing&) = delete;

  [[nodiscard]] const HeartFrame& frame() const;
  [[nodiscard]] bool has(Structure structure) const;
  [[nodiscard]] bool has_volume() const;

  /// Time over the R-R interval, any number: the whole picture is of this moment.
  void set_beats(double beats);
  void set_look(Structure structure, const Look& look);
  [[nodiscard]] Look look(Structure structure) const;
  /// Colours of the LV's wall, or of how well each surface is known, with a legend, or the
  /// structures' own.
  /// @param parameters of the stiffness
  /// @throws Error{InvalidInput} if the package has no map of the wall, or tells no such band
  void set_colouring(ColourBy by, const palpation::PalpationParameters& parameters);
  [[nodiscard]] bool can_colour_by(ColourBy by) const;
  /// Null: the structures' own.
  [[nodiscard]] const SurfaceColours* colouring() const;
  /// Of the last picture, where there was one.
  [[nodiscard]] LegendPlace legend_place() const;
  void set_volume(VolumePreset preset);
  void set_cut(const std::optional<CutPlane>& cut);
  [[nodiscard]] std::optional<CutPlane> cut() const;
  /// The images on the cut; without a volume, or if not wished, structures' own colours.
  void set_image_on_cut(bool on);
  [[nodiscard]] bool image_on_cut() const;
  /// At most kMostTools; those after them are left out. Where there are several, each has its
  /// number beside its force.
  static constexpr std::size_t kMostTools = 16;
  void set_tools(std::vector<ToolPicture> tools);
  void set_tool(const ToolPicture& tool) { set_tools({tool}); }
  /// A pericardium around the heart, which is seen through; it stands still.
  void set_pericardium(const haptics::PericardialField::Lattice& lattice);
  void set_camera(const CameraPose& pose);
  /// Towards `pose`'s viewer: every surface at any moment of the beat is within the picture and
  /// fills it, whatever size it gets, until set_camera is called. @param zoom times as large
  void fit_camera(const CameraPose& pose, double zoom = 1);
  [[nodiscard]] CameraPose camera() const;
  /// Coarser volume and image: while the picture moves.
  void set_moving(bool moving);
  /// A line below the names, as "ES" or the device's name.
  void set_note(const std::string& note);

  /// The line above the names: the moment, named where it is end-diastole or end-systole, and the
  /// note.
  [[nodiscard]] std::string caption() const;

  /// Draws once. @param width, height 16..16384
  [[nodiscard]] Picture picture(int width, int height);
  /// Draws into the window.
  void render();
  /// Whether a picture would differ from the last one.
  [[nodiscard]] bool changed() const;
  [[nodiscard]] DrawTimes times() const;

  /// Pixel (x right, y down; whole numbers are centres of pixels) of a point in the last picture.
  [[nodiscard]] Vec2 pixel_of(const Vec3& workspace_mm) const;
  /// How far along the line of sight a point lies behind the focus [mm], and back again.
  [[nodiscard]] double depth_of(const Vec3& workspace_mm) const;
  [[nodiscard]] Vec3 point_at(const Vec2& pixel, double depth_mm) const;
  /// Where a tool's arrow of force ended in the last picture; none without an arrow.
  [[nodiscard]] std::optional<Vec3> arrow_tip_mm(std::size_t tool = 0) const;
  /// Pixels a millimetre.
  [[nodiscard]] double pixels_per_mm() const;
  /// The drawn vertices of a structure, the dent included. Empty if there is none.
  [[nodiscard]] std::vector<Vec3f> drawn_vertices(Structure structure);
  /// The renderer of GL, as "llvmpipe"; after the first picture.
  [[nodiscard]] std::string renderer() const;

 private:
  friend class HeartWidget;
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace beatlas::viewer
