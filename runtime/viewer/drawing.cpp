#include "runtime/viewer/drawing.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>

#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkLight.h>
#include <vtkPNGWriter.h>
#include <vtkPointData.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include "runtime/atlas/structure_colours.h"
#include "runtime/base/error.h"
#include "runtime/base/replace_file.h"
#include "runtime/viewer/drawing_parts.h"

namespace beatlas::viewer {
namespace {

constexpr int kLeastPixels = 16;
constexpr int kMostPixels = 16384;
constexpr double kEyeAngleDeg = 5;
constexpr int kSmoothSamples = 4;        ///< a pixel, at edges
constexpr double kRoomAround = 1.2;      ///< of a picture that fits, over what it shows
constexpr double kUsualShape = 4.0 / 3;  ///< width over height, before there is a picture

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

/// A light that goes with the camera: it comes from `from`, in the camera's right, up and back.
void add_light(vtkRenderer* renderer, const Vec3& from, double intensity) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(from.x(), from.y(), from.z());
  light->SetFocalPoint(0, 0, 0);
  light->SetIntensity(intensity);
  renderer->AddLight(light);
}

}  // namespace

Look default_look(Structure structure) {
  const Colour colour = structure_colour(structure);
  return {.colour = Vec3(colour[0], colour[1], colour[2]) / 255,
          .opacity = structure == Structure::Heart ? 0.32 : 1};
}

std::string structure_title(Structure structure) {
  switch (structure) {
    case Structure::Heart:
      return "Heart";
    case Structure::LvBlood:
      return "Left ventricle, blood";
    case Structure::RvBlood:
      return "Right ventricle, blood";
    case Structure::LvMyocardium:
      return "Left ventricle, muscle";
    case Structure::LaBlood:
      return "Left atrium, blood";
    case Structure::RaBlood:
      return "Right atrium, blood";
    case Structure::Aorta:
      return "Aorta, lumen";
  }
  return {};
}

void write_png(const Picture& picture, const std::filesystem::path& file) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(picture.width, picture.height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const std::size_t row = 3 * static_cast<std::size_t>(picture.width);
  for (int y = 0; y < picture.height; ++y) {
    const auto* from = picture.rgb.data() + row * static_cast<std::size_t>(picture.height - 1 - y);
    std::copy(from, from + row, static_cast<std::uint8_t*>(image->GetScalarPointer(0, y, 0)));
  }
  vtkNew<vtkPNGWriter> writer;
  writer->WriteToMemoryOn();
  writer->SetInputData(image);
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  const auto* first = reinterpret_cast<const std::byte*>(bytes->GetPointer(0));
  replace_file(file, std::span(first, static_cast<std::size_t>(bytes->GetNumberOfTuples())));
}

HeartDrawing::HeartDrawing(std::shared_ptr<const atlas::Atlas> atlas,
                           std::shared_ptr<const field::FieldQuery> field,
                           const DrawingOptions& options)
    : parts_(std::make_unique<Parts>()) {
  Parts& parts = *parts_;
  parts.frame = heart_frame(*atlas);
  parts.atlas = std::move(atlas);
  parts.field = std::move(field);
  parts.options = options;
  parts.renderer = vtkSmartPointer<vtkRenderer>::New();
  parts.renderer->SetBackground(0.055, 0.065, 0.085);
  parts.renderer->SetBackground2(0.16, 0.18, 0.22);
  parts.renderer->GradientBackgroundOn();
  // Surfaces come in the right order, their far sides left out: nothing need be sorted.
  parts.renderer->SetUseDepthPeeling(0);
  // From over the viewer's left shoulder, a weaker one from the right, and one along the picture
  // from the lower left, so that no rim is as dark as the ground. Every further light is paid for
  // in each pixel where OpenGL is drawn by software.
  add_light(parts.renderer, Vec3(-0.4, 0.5, 1), 1.0);
  add_light(parts.renderer, Vec3(0.9, 0, 0.6), 0.6);
  add_light(parts.renderer, Vec3(-0.6, -0.8, 0), 0.6);
  parts.make_surfaces();
  parts.make_volume();
  parts.make_overlay();
  parts.make_legend();
  fit_camera(standard_view(parts.frame, "anterior"));
  if (options.offscreen) {
    auto window = vtkSmartPointer<vtkRenderWindow>::New();
    window->SetOffScreenRendering(1);
    parts.make_window(window.Get());
    window->SetSize(kLeastPixels, kLeastPixels);
    if (window->SupportsOpenGL() == 0) {
      throw Error(ErrorCode::Machine,
                  "nothing can be drawn: OpenGL 3.2 is not there; install libgl1-mesa-dri");
    }
  }
}

HeartDrawing::~HeartDrawing() = default;

void HeartDrawing::Parts::make_window(vtkRenderWindow* made) {
  window = made;
  window->SetNumberOfLayers(2);
  window->SetMultiSamples(kSmoothSamples);
  window->AddRenderer(renderer);
  if (options.caption) window->AddRenderer(overlay.marker);
  // VTK 9.1 leaves the width to height of a new renderer as 1 until its viewport or size differs
  // from what it finds in memory that it never set: an earlier window's of the same size would do.
  for (const double right : {0.5, 1.0}) {
    renderer->SetViewport(0, 0, right, 1);
    renderer->ComputeAspect();
  }
  if (options.anaglyph) {
    window->SetStereoTypeToAnaglyph();
    window->StereoRenderOn();
    // Between the eyes' lines of sight, as of a heart at arm's length.
    renderer->GetActiveCamera()->SetEyeAngle(kEyeAngleDeg);
  }
}

const HeartFrame& HeartDrawing::frame() const { return parts_->frame; }

bool HeartDrawing::has(Structure structure) const {
  return std::any_of(parts_->surfaces.begin(), parts_->surfaces.end(),
                     [&](const SurfaceParts& part) { return part.structure == structure; });
}

bool HeartDrawing::has_volume() const { return parts_->volume.payload != nullptr; }

void HeartDrawing::set_beats(double beats) {
  const double whole = std::isfinite(beats) ? beats - std::floor(beats) : 0;
  parts_->stale = parts_->stale || whole != parts_->beats;
  parts_->beats = whole;
}

void HeartDrawing::set_look(Structure structure, const Look& look) {
  for (SurfaceParts& part : parts_->surfaces) {
    if (part.structure == structure) part.look = look;
  }
  parts_->stale = true;
}

Look HeartDrawing::look(Structure structure) const {
  for (const SurfaceParts& part : parts_->surfaces) {
    if (part.structure == structure) return part.look;
  }
  return default_look(structure);
}

void HeartDrawing::set_volume(VolumePreset preset) {
  parts_->preset = preset;
  parts_->stale = true;
}

void HeartDrawing::set_cut(const std::optional<CutPlane>& cut) {
  parts_->cut = cut;
  parts_->stale = true;
}

std::optional<CutPlane> HeartDrawing::cut() const { return parts_->cut; }

void HeartDrawing::set_image_on_cut(bool on) {
  parts_->image_on_cut = on;
  parts_->stale = true;
}

bool HeartDrawing::image_on_cut() const { return parts_->image_on_cut; }

void HeartDrawing::set_tools(std::vector<ToolPicture> tools) {
  if (tools.size() > kMostTools) tools.resize(kMostTools);
  parts_->stale = parts_->stale || !tools.empty() || !parts_->tools.empty();
  parts_->tools = std::move(tools);
}

void HeartDrawing::set_moving(bool moving) {
  parts_->stale = parts_->stale || parts_->moving != moving;
  parts_->moving = moving;
  // Smooth edges are dear where software draws, and hardly seen while they turn.
  if (parts_->window) parts_->window->SetMultiSamples(moving ? 0 : kSmoothSamples);
}

void HeartDrawing::set_note(const std::string& note) {
  parts_->note = note;
  parts_->stale = true;
}

void HeartDrawing::set_camera(const CameraPose& pose) {
  vtkCamera* camera = parts_->renderer->GetActiveCamera();
  camera->ParallelProjectionOn();
  const double away = 2 * pose.height_mm + 500;
  const Vec3 position = pose.focus_mm + away * pose.towards_viewer;
  camera->SetFocalPoint(pose.focus_mm.x(), pose.focus_mm.y(), pose.focus_mm.z());
  camera->SetPosition(position.x(), position.y(), position.z());
  camera->SetViewUp(pose.up.x(), pose.up.y(), pose.up.z());
  camera->SetParallelScale(pose.height_mm / 2);
  parts_->fitted_mm.reset();
  parts_->turned = true;
}

void HeartDrawing::fit_camera(const CameraPose& pose, double zoom) {
  const Vec3f right = pose.up.cross(pose.towards_viewer).cast<float>();
  const Vec3f up = pose.up.cast<float>();
  constexpr float kFar = std::numeric_limits<float>::max();
  Eigen::Array2f low(kFar, kFar);
  Eigen::Array2f high = -low;
  for (const SurfaceParts& part : parts_->surfaces) {
    for (const std::vector<Vec3f>& phase : part.motion->surface().positions) {
      for (const Vec3f& x : phase) {
        const Eigen::Array2f at(right.dot(x), up.dot(x));
        low = low.min(at);
        high = high.max(at);
      }
    }
  }
  const Vec2 middle = (0.5F * (low + high)).matrix().cast<double>();
  CameraPose fitted = pose;
  fitted.focus_mm +=
      (middle.x() - fitted.focus_mm.dot(right.cast<double>())) * right.cast<double>() +
      (middle.y() - fitted.focus_mm.dot(pose.up)) * pose.up;
  set_camera(fitted);
  parts_->fitted_mm = (kRoomAround / zoom) * (high - low).matrix().cast<double>();
  parts_->fit_height();
}

void HeartDrawing::Parts::fit_height() const {
  if (!fitted_mm) return;
  const double width_to_height = width > 0 && height > 0 ? double(width) / height : kUsualShape;
  const double height_mm = std::max(fitted_mm->y(), fitted_mm->x() / width_to_height);
  renderer->GetActiveCamera()->SetParallelScale(height_mm / 2);
}

bool HeartDrawing::changed() const {
  const int* size = parts_->window->GetSize();
  return parts_->stale || parts_->turned || size[0] != parts_->width || size[1] != parts_->height;
}

CameraPose HeartDrawing::camera() const {
  vtkCamera* camera = parts_->renderer->GetActiveCamera();
  camera->OrthogonalizeViewUp();
  CameraPose pose;
  camera->GetFocalPoint(pose.focus_mm.data());
  camera->GetViewPlaneNormal(pose.towards_viewer.data());
  camera->GetViewUp(pose.up.data());
  pose.height_mm = 2 * camera->GetParallelScale();
  return pose;
}

void HeartDrawing::Parts::update() {
  const auto start = std::chrono::steady_clock::now();
  if (stale) {
    for (SurfaceParts& part : surfaces) {
      update_surface(part);
      update_cut(part);
    }
    update_order();
    update_volume();
    stale = false;
  }
  update_layers();
  update_tools();
  update_overlay();
  update_legend();
  update_taxels();
  fit_clip();
  times.update_ms = milliseconds_since(start);
}

// The near and far ends of what is seen: the box of all, not the scene's, which changes as it
// beats.
void HeartDrawing::Parts::fit_clip() const {
  vtkCamera* camera = renderer->GetActiveCamera();
  const double away = camera->GetDistance();
  const double reach = (frame.high_mm - frame.low_mm).norm() + 200;
  camera->SetClippingRange(std::max(1.0, away - reach), away + reach);
}

Picture HeartDrawing::picture(int width, int height) {
  if (width < kLeastPixels || height < kLeastPixels || width > kMostPixels ||
      height > kMostPixels) {
    throw_invalid("a picture is 16 to 16384 pixels wide and high");
  }
  Parts& parts = *parts_;
  parts.window->SetSize(width, height);
  render();
  Picture picture{.width = width, .height = height, .rgb = {}};
  vtkNew<vtkUnsignedCharArray> pixels;
  parts.window->GetPixelData(0, 0, width - 1, height - 1, 0, pixels, 0);
  const std::size_t row = 3 * static_cast<std::size_t>(width);
  picture.rgb.resize(row * static_cast<std::size_t>(height));
  if (static_cast<std::size_t>(pixels->GetNumberOfValues()) != picture.rgb.size()) {
    throw Error(ErrorCode::Machine, "nothing was drawn; is OpenGL there?");
  }
  for (int y = 0; y < height; ++y) {
    const auto* from = pixels->GetPointer(0) + row * static_cast<std::size_t>(height - 1 - y);
    std::copy(from, from + row, picture.rgb.data() + row * static_cast<std::size_t>(y));
  }
  return picture;
}

void HeartDrawing::render() {
  Parts& parts = *parts_;
  const int* size = parts.window->GetSize();
  parts.width = size[0];
  parts.height = size[1];
  parts.fit_height();
  parts.update();
  parts.turned = false;
  const auto start = std::chrono::steady_clock::now();
  parts.window->Render();
  parts.times.render_ms = milliseconds_since(start);
}

DrawTimes HeartDrawing::times() const { return parts_->times; }

double HeartDrawing::pixels_per_mm() const { return parts_->height / camera().height_mm; }

Vec2 HeartDrawing::pixel_of(const Vec3& workspace_mm) const {
  const CameraPose pose = camera();
  const Vec3 right = pose.up.cross(pose.towards_viewer);
  const Vec3 from_focus = workspace_mm - pose.focus_mm;
  const double scale = pixels_per_mm();
  return {parts_->width / 2.0 - 0.5 + scale * right.dot(from_focus),
          parts_->height / 2.0 - 0.5 - scale * pose.up.dot(from_focus)};
}

double HeartDrawing::depth_of(const Vec3& workspace_mm) const {
  const CameraPose pose = camera();
  return -pose.towards_viewer.dot(workspace_mm - pose.focus_mm);
}

Vec3 HeartDrawing::point_at(const Vec2& pixel, double depth_mm) const {
  const CameraPose pose = camera();
  const Vec3 right = pose.up.cross(pose.towards_viewer);
  const double scale = pixels_per_mm();
  return pose.focus_mm + (pixel.x() - parts_->width / 2.0 + 0.5) / scale * right -
         (pixel.y() - parts_->height / 2.0 + 0.5) / scale * pose.up -
         depth_mm * pose.towards_viewer;
}

std::vector<Vec3f> HeartDrawing::drawn_vertices(Structure structure) {
  parts_->update();
  for (const SurfaceParts& part : parts_->surfaces) {
    if (part.structure == structure) return part.positions;
  }
  return {};
}

std::string HeartDrawing::renderer() const { return parts_->gl_renderer(); }

std::string HeartDrawing::Parts::gl_renderer() const {
  if (!window) return "unknown";
  const char* text = window->ReportCapabilities();
  const std::string told = text == nullptr ? "" : text;
  const std::string key = "OpenGL renderer string:";
  const std::size_t at = told.find(key);
  if (at == std::string::npos) return "unknown";
  const std::size_t begin = told.find_first_not_of(' ', at + key.size());
  return told.substr(begin, told.find('\n', begin) - begin);
}

}  // namespace beatlas::viewer
