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

#include "runtime/viewer/drawing.h"
#include "runtime/viewer/heart_mask.h"
#include "runtime/viewer/image_cut.h"
#include "runtime/viewer/surface_motion.h"

namespace beatlas::viewer {

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
  vtkSmartPointer<vtkActor> actor;
  vtkSmartPointer<vtkPolyData> line;
  vtkSmartPointer<vtkActor> line_actor;
  vtkSmartPointer<vtkPolyData> cap;
  vtkSmartPointer<vtkActor> cap_actor;
  vtkSmartPointer<vtkTextActor> name;
};

struct VolumeParts {
  std::shared_ptr<const atlas::VolumePayload> payload;
  TissueIntensities tissue;
  atlas::IntensityWindow window;
  std::optional<HeartMask> mask;
  std::vector<std::uint8_t> samples;  ///< of now
  double samples_beats = -1;
  bool masked_current = false;
  bool caster_chosen = false;
  vtkSmartPointer<vtkImageData> image;
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

/// What the colours of the wall stand for.
struct LegendParts {
  vtkSmartPointer<vtkPolyData> patches;
  vtkSmartPointer<vtkActor2D> actor;
  std::vector<vtkSmartPointer<vtkTextActor>> texts;
  Vec2 centre = Vec2::Zero();  ///< pixels, y up
  double half_px = 0;
};

/// Scale bar, names, orientation marker.
struct OverlayParts {
  vtkSmartPointer<vtkPolyData> bar;
  vtkSmartPointer<vtkActor2D> bar_actor;
  vtkSmartPointer<vtkTextActor> bar_text;
  vtkSmartPointer<vtkTextActor> title;
  vtkSmartPointer<vtkRenderer> marker;
  vtkSmartPointer<vtkAnnotatedCubeActor> cube;
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
  std::optional<ToolPicture> tool;
  std::string note;
  bool moving = false;
  bool stale = true;
  DrawTimes times;
  int width = 0;  ///< of the last picture
  int height = 0;

  std::vector<SurfaceParts> surfaces;
  VolumeParts volume;
  ToolParts tool_parts;
  OverlayParts overlay;
  LegendParts legend;
  std::unique_ptr<const WallColours> colours;  ///< null: structures' own
  vtkSmartPointer<vtkPlane> plane;
  vtkSmartPointer<vtkRenderer> renderer;
  vtkSmartPointer<vtkRenderWindow> window;

  void make_surfaces();
  void make_volume();
  void make_tool();
  void make_overlay();
  void make_legend();
  void make_window(vtkRenderWindow* made);

  /// Everything as of `beats`, `cut`, `tool`.
  void update();
  void update_surface(SurfaceParts& part) const;
  void update_cut(SurfaceParts& part) const;
  void update_volume();
  void choose_caster();
  [[nodiscard]] std::string gl_renderer() const;
  void update_samples(bool masked);
  void update_slice();
  void update_tool();
  void update_overlay();
  void colour_surface(SurfaceParts& part) const;
  void update_legend();
  void update_bar();
  void update_bulls_eye();
  void set_legend_texts(std::size_t count);
  void put_legend_text(std::size_t n, const std::string& words, const Vec2& at, int size,
                       double grey);
  void fit_clip() const;
};

}  // namespace beatlas::viewer
