#pragma once
/// What HeartDrawing is made of. Within this room alone: here are VTK's types.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <vtkActor.h>
#include <vtkActor2D.h>
#include <vtkAnnotatedCubeActor.h>
#include <vtkBillboardTextActor3D.h>
#include <vtkColorTransferFunction.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPlane.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkSmartVolumeMapper.h>
#include <vtkTextActor.h>
#include <vtkTexture.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolume.h>

#include "runtime/viewer/between_slices.h"
#include "runtime/viewer/drawing.h"
#include "runtime/viewer/heart_mask.h"
#include "runtime/viewer/image_cut.h"
#include "runtime/viewer/surface_colours.h"
#include "runtime/viewer/surface_motion.h"

namespace beatlas::viewer {

/// What lies on a cut, and the tool, is drawn so far in front of the surfaces [mm].
inline constexpr double kOnTopMm = 4.5;
/// Between the images on a cut, the areas and lines on them.
inline constexpr double kBetweenMm = 0.2;

/// A structure's surface, its line on the cut and the area within that line.
struct SurfaceParts {
  Structure structure{};
  std::unique_ptr<SurfaceMotion> motion;
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;
  Look look;
  std::vector<Rgb> colours;  ///< of the vertices, where they have their own
  vtkSmartPointer<vtkUnsignedCharArray> point_colours;
  vtkSmartPointer<vtkPoints> points;
  vtkSmartPointer<vtkFloatArray> point_normals;
  vtkSmartPointer<vtkPolyData> mesh;
  vtkSmartPointer<vtkPolyDataMapper> mapper;
  vtkSmartPointer<vtkPlane> plane;  ///< of the cut, as far towards the viewer as the surface
  vtkSmartPointer<vtkActor> actor;
  vtkSmartPointer<vtkPolyData> line;
  vtkSmartPointer<vtkActor> line_actor;
  vtkSmartPointer<vtkPolyData> cap;
  vtkSmartPointer<vtkActor> cap_actor;
  vtkSmartPointer<vtkTextActor> name;
};

/// What rays are cast through: the images around the heart, every voxel or means of several.
struct VolumeLevel {
  std::array<int, 3> step{1, 1, 1};  ///< voxels of the images a voxel, along each axis
  std::array<int, 3> low{};          ///< where it begins, voxels of the images
  std::array<int, 3> size{};
  Affine workspace_from_index = Affine::Identity();
  std::optional<HeartMask> mask;
  double beats = -1;  ///< of what is in `image`
  vtkSmartPointer<vtkImageData> image;
  vtkSmartPointer<vtkMatrix4x4> matrix;
};

struct VolumeParts {
  std::shared_ptr<const atlas::VolumePayload> payload;
  std::optional<BetweenSlices> between;
  atlas::VolumePayload shape;        ///< of `samples`: the images and what lies between slices
  std::vector<std::uint8_t> slices;  ///< of now, where something lies between
  TissueIntensities tissue;
  atlas::IntensityWindow window;
  std::vector<std::uint8_t> samples;  ///< of now, for `heart_beats` those around the heart alone
  double samples_beats = -1;
  double heart_beats = -1;
  bool caster_chosen = false;
  VolumeLevel fine;
  VolumeLevel coarse;  ///< while it moves
  vtkSmartPointer<vtkSmartVolumeMapper> mapper;
  vtkSmartPointer<vtkVolume> volume;
  vtkSmartPointer<vtkPlane> plane;
  vtkSmartPointer<vtkImageData> slice;
  vtkSmartPointer<vtkTexture> texture;
  vtkSmartPointer<vtkPolyData> slice_quad;
  vtkSmartPointer<vtkActor> slice_actor;
  PlaneGrid slice_grid;
};

struct ToolParts {
  vtkSmartPointer<vtkActor> ball;
  vtkSmartPointer<vtkActor> proxy;
  vtkSmartPointer<vtkActor> arrow;
  vtkSmartPointer<vtkBillboardTextActor3D> label;
};

/// What the colours stand for.
struct LegendParts {
  vtkSmartPointer<vtkPolyData> patches;
  vtkSmartPointer<vtkActor2D> actor;
  std::vector<vtkSmartPointer<vtkTextActor>> texts;
  Vec2 centre = Vec2::Zero();  ///< pixels, y up
  double half_px = 0;
};

/// Scale bar, names with their colours, orientation marker.
struct OverlayParts {
  vtkSmartPointer<vtkPolyData> swatches;
  vtkSmartPointer<vtkActor2D> swatches_actor;
  vtkSmartPointer<vtkPolyData> bar;
  vtkSmartPointer<vtkActor2D> bar_actor;
  vtkSmartPointer<vtkTextActor> bar_text;
  vtkSmartPointer<vtkTextActor> title;
  vtkSmartPointer<vtkRenderer> marker;
  vtkSmartPointer<vtkAnnotatedCubeActor> cube;
};

/// What a fingertip feels: 8 x 8 taxels and what they say in words.
struct TaxelParts {
  vtkSmartPointer<vtkPolyData> patches;
  vtkSmartPointer<vtkActor2D> actor;
  vtkSmartPointer<vtkTextActor> text;
};

struct HeartDrawing::Parts {
  std::shared_ptr<const atlas::Atlas> atlas;
  std::shared_ptr<const field::FieldQuery> field;
  DrawingOptions options;
  HeartFrame frame;
  double beats = 0;
  VolumePreset preset = VolumePreset::Off;
  std::optional<CutPlane> cut;
  bool image_on_cut = true;
  std::vector<ToolPicture> tools;
  std::string note;
  bool moving = false;
  bool stale = true;
  bool turned = true;  ///< the camera has moved since the last picture
  DrawTimes times;
  int width = 0;  ///< of the last picture
  int height = 0;
  std::optional<Vec2> fitted_mm;  ///< width and height that the picture shall show, of its size

  std::vector<SurfaceParts> surfaces;  ///< from the inside out
  std::vector<vtkActor*> drawn_order;  ///< of their actors
  VolumeParts volume;
  std::vector<ToolParts> tool_parts;  ///< as many as there ever were tools
  OverlayParts overlay;
  LegendParts legend;
  std::vector<TaxelParts> taxel_parts;            ///< the same
  std::unique_ptr<const SurfaceColours> colours;  ///< null: structures' own
  vtkSmartPointer<vtkRenderer> renderer;
  vtkSmartPointer<vtkRenderWindow> window;

  void make_surfaces();
  void make_volume();
  [[nodiscard]] ToolParts make_tool();
  void make_overlay();
  void make_legend();
  [[nodiscard]] TaxelParts make_taxels();
  void make_window(vtkRenderWindow* made);

  /// Everything as of `beats`, `cut`, `tool`.
  void update();
  void update_order();
  /// What coincides is drawn in order: each a little nearer to the viewer than what it encloses.
  void update_layers();
  void update_surface(SurfaceParts& part) const;
  void update_cut(SurfaceParts& part) const;
  void update_volume();
  void choose_caster();
  [[nodiscard]] std::string gl_renderer() const;
  [[nodiscard]] VolumeLevel make_level(const std::array<int, 3>& step) const;
  void update_samples();
  void update_samples_around_heart();
  void update_level(VolumeLevel& level);
  void update_slice();
  void update_tools();
  void update_tool(std::size_t n);
  void update_overlay();
  /// Of the square at the lower left in which the marker of the body's axes stands.
  [[nodiscard]] double marker_px() const;
  /// How much larger words are than in a picture of 800 x 600.
  [[nodiscard]] double text_scale() const;
  /// As VTK counts it in this window.
  [[nodiscard]] int font_size(double pixels) const;
  /// "50 % of the beat, end-systole (ES)   8.0 mm deep".
  [[nodiscard]] std::string caption() const;
  void fit_height() const;
  void colour_surface(SurfaceParts& part) const;
  /// By how well each surface that has a band is known.
  [[nodiscard]] std::unique_ptr<const SurfaceColours> band_colours() const;
  void update_legend();
  void update_taxels();
  /// @param left_px where the map begins  @return where the next one may; 0 where none is shown
  double update_taxels(std::size_t n, double left_px);
  /// @return whether there was a dent
  bool dent_surface(std::vector<Vec3f>& positions) const;
  void update_bar();
  void update_bulls_eye();
  void set_legend_texts(std::size_t count);
  void put_legend_text(std::size_t n, const std::string& words, const Vec2& at, int size,
                       double grey);
  void fit_clip() const;
};

}  // namespace beatlas::viewer
