#include <algorithm>
#include <array>
#include <cmath>

#include <vtkCellArray.h>
#include <vtkMatrix4x4.h>
#include <vtkPointData.h>
#include <vtkProperty.h>
#include <vtkVolumeProperty.h>

#include "runtime/viewer/drawing_parts.h"

namespace beatlas::viewer {
namespace {

constexpr double kSlicePixelMm = 0.5;
// The ray caster knows depths to a voxel or so: it begins this far behind the images on the cut, so
// that it does not tint them.
constexpr double kBehindCutMm = 2;
constexpr double kMovingHz = 12;     ///< pictures that are turned or cut
constexpr double kRestingHz = 1e-3;  ///< as fine as they get

struct Ramp {
  double at;  ///< 0 muscle, 1 blood
  double opacity;
  Vec3 colour;
};

}  // namespace

void HeartDrawing::Parts::make_volume() {
  volume.payload = atlas->volume();
  if (!volume.payload) return;
  const atlas::VolumePayload& payload = *volume.payload;
  volume.tissue = tissue_intensities(payload, atlas->manifest().end_diastole,
                                     atlas->surface(Structure::LvBlood).get(),
                                     atlas->surface(Structure::LvMyocardium).get());
  const double span = volume.tissue.blood - volume.tissue.muscle;
  volume.window = {
      .low = std::max(atlas::whole_window(payload).low, volume.tissue.muscle - 2 * span),
      .high = volume.tissue.blood + 0.6 * span};
  volume.samples.resize(payload.sample_count());
  volume.plane = vtkSmartPointer<vtkPlane>::New();

  Vec3 spacing;
  vtkNew<vtkMatrix4x4> matrix;
  for (int column = 0; column < 3; ++column) {
    spacing[column] = payload.workspace_from_index.linear().col(column).norm();
    for (int row = 0; row < 3; ++row) {
      matrix->SetElement(row, column, payload.workspace_from_index(row, column) / spacing[column]);
    }
  }
  for (int row = 0; row < 3; ++row)
    matrix->SetElement(row, 3, payload.workspace_from_index(row, 3));
  volume.image = vtkSmartPointer<vtkImageData>::New();
  volume.image->SetDimensions(payload.size.data());
  volume.image->SetSpacing(spacing.data());
  volume.image->AllocateScalars(VTK_UNSIGNED_CHAR, 1);

  volume.mapper = vtkSmartPointer<vtkSmartVolumeMapper>::New();
  volume.mapper->SetInputData(volume.image);
  volume.mapper->SetBlendModeToComposite();
  volume.volume = vtkSmartPointer<vtkVolume>::New();
  volume.volume->SetMapper(volume.mapper);
  volume.volume->SetUserMatrix(matrix);
  volume.volume->VisibilityOff();
  vtkVolumeProperty* property = volume.volume->GetProperty();
  property->SetInterpolationTypeToLinear();
  property->ShadeOn();
  property->SetAmbient(0.25);
  property->SetDiffuse(0.85);
  property->SetSpecular(0.15);
  property->SetSpecularPower(12);
  renderer->AddVolume(volume.volume);

  volume.slice = vtkSmartPointer<vtkImageData>::New();
  volume.texture = vtkSmartPointer<vtkTexture>::New();
  volume.texture->SetInputData(volume.slice);
  volume.texture->InterpolateOn();
  volume.texture->RepeatOff();
  volume.texture->SetColorModeToDirectScalars();
  volume.slice_quad = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(volume.slice_quad);
  volume.slice_actor = vtkSmartPointer<vtkActor>::New();
  volume.slice_actor->SetMapper(mapper);
  volume.slice_actor->SetTexture(volume.texture);
  volume.slice_actor->GetProperty()->LightingOff();
  volume.slice_actor->GetProperty()->SetOpacity(1);
  volume.slice_actor->ForceOpaqueOn();
  volume.slice_actor->VisibilityOff();
  renderer->AddActor(volume.slice_actor);
}

// The images of now, as bytes; `masked` for the ray caster.
void HeartDrawing::Parts::update_samples(bool masked) {
  if (volume.samples_beats != beats) {
    atlas::volume_8bit(*volume.payload, beats, volume.window, volume.samples);
    volume.samples_beats = beats;
    volume.masked_current = false;
  }
  if (!masked || volume.masked_current) return;
  if (!volume.mask && field) volume.mask.emplace(*volume.payload, field);
  auto* to = static_cast<std::uint8_t*>(volume.image->GetScalarPointer());
  if (volume.mask) {
    const std::vector<std::uint8_t>& mask = volume.mask->at(beats);
    for (std::size_t n = 0; n < volume.samples.size(); ++n) {
      to[n] = static_cast<std::uint8_t>(volume.samples[n] * mask[n] / 255);
    }
  } else {
    std::copy(volume.samples.begin(), volume.samples.end(), to);
  }
  volume.image->GetPointData()->GetScalars()->Modified();
  volume.image->Modified();
  volume.masked_current = true;
}

// Without a graphics card VTK's own ray caster is many times quicker than its shaders on Mesa.
void HeartDrawing::Parts::choose_caster() {
  if (volume.caster_chosen || !window) return;
  volume.caster_chosen = true;
  const std::string told = gl_renderer();
  for (const char* software : {"llvmpipe", "softpipe", "Software", "SWR"}) {
    if (told.find(software) != std::string::npos) volume.mapper->SetRequestedRenderModeToRayCast();
  }
}

void HeartDrawing::Parts::update_volume() {
  if (!volume.payload) return;
  if (preset != VolumePreset::Off) choose_caster();
  const bool rays = preset != VolumePreset::Off;
  volume.volume->SetVisibility(rays ? 1 : 0);
  volume.mapper->RemoveAllClippingPlanes();
  if (cut) {
    const Vec3 begin = cut->point_mm - (image_on_cut ? kBehindCutMm : 0) * cut->normal;
    volume.plane->SetOrigin(begin.x(), begin.y(), begin.z());
    volume.plane->SetNormal(-cut->normal.x(), -cut->normal.y(), -cut->normal.z());
    volume.mapper->AddClippingPlane(volume.plane);
  }
  if (rays) {
    update_samples(true);
    const Vec3 red(0.74, 0.11, 0.10);
    const Vec3 flesh(0.78, 0.45, 0.36);
    const Vec3 pale(0.96, 0.80, 0.70);
    const std::array<Ramp, 6> muscle{{{-0.75, 0, flesh * 0.6},
                                      {-0.35, 0.22, flesh * 0.8},
                                      {0.1, 0.30, flesh},
                                      {0.45, 0.05, flesh},
                                      {0.8, 0.02, pale},
                                      {1.6, 0.04, pale}}};
    const std::array<Ramp, 6> blood{{{0.0, 0, red * 0.5},
                                     {0.45, 0, red * 0.6},
                                     {0.6, 0.10, red * 0.85},
                                     {0.85, 0.40, red},
                                     {1.1, 0.55, Vec3(0.84, 0.22, 0.18)},
                                     {1.6, 0.60, pale}}};
    vtkNew<vtkPiecewiseFunction> opacity;
    vtkNew<vtkColorTransferFunction> colour;
    const double per_intensity = 255 / (volume.window.high - volume.window.low);
    opacity->AddPoint(0, 0);
    for (const Ramp& ramp : preset == VolumePreset::Blood ? blood : muscle) {
      const double intensity =
          volume.tissue.muscle + ramp.at * (volume.tissue.blood - volume.tissue.muscle);
      const double byte = per_intensity * (intensity - volume.window.low);
      if (byte > 0.5) opacity->AddPoint(byte, ramp.opacity);
      colour->AddRGBPoint(byte, ramp.colour.x(), ramp.colour.y(), ramp.colour.z());
    }
    vtkVolumeProperty* property = volume.volume->GetProperty();
    property->SetScalarOpacity(opacity);
    property->SetColor(colour);
    property->SetScalarOpacityUnitDistance(1.0);
    // A coarser grid of rays and steps while it moves; every pixel at rest.
    volume.mapper->SetAutoAdjustSampleDistances(moving ? 1 : 0);
    volume.mapper->SetSampleDistance(moving ? 2.5F : 0.8F);
    volume.mapper->SetInteractiveUpdateRate(kMovingHz);
    // VTK's own ray caster thins its rays out until a picture takes no longer than this.
    if (window) window->SetDesiredUpdateRate(moving ? kMovingHz : kRestingHz);
  }
  update_slice();
}

void HeartDrawing::Parts::update_slice() {
  const bool shown = cut && image_on_cut;
  volume.slice_actor->SetVisibility(shown ? 1 : 0);
  if (!shown) return;
  update_samples(false);
  const PlaneGrid grid = cut_grid(*volume.payload, cut->point_mm, cut->normal,
                                  moving ? 2 * kSlicePixelMm : kSlicePixelMm);
  volume.slice_grid = grid;
  if (grid.pixels() == 0) {
    volume.slice_actor->VisibilityOff();
    return;
  }
  volume.slice->SetDimensions(grid.width, grid.height, 1);
  volume.slice->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
  auto* to = static_cast<std::uint8_t*>(volume.slice->GetScalarPointer());
  std::vector<std::uint8_t> grey_alpha(2 * grid.pixels());
  sample_cut(*volume.payload, volume.samples, grid, grey_alpha);
  for (std::size_t n = 0; n < grid.pixels(); ++n) {
    std::fill(to + 4 * n, to + 4 * n + 3, grey_alpha[2 * n]);
    to[4 * n + 3] = grey_alpha[2 * n + 1];
  }
  volume.slice->Modified();

  const Vec3 x = grid.width * grid.x_mm;
  const Vec3 y = grid.height * grid.y_mm;
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> where;
  where->SetNumberOfComponents(2);
  const std::array<Vec2, 4> corners{Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
  vtkNew<vtkCellArray> quad;
  quad->InsertNextCell(4);
  for (const Vec2& corner : corners) {
    const Vec3 place = grid.corner_mm + corner.x() * x + corner.y() * y;
    quad->InsertCellPoint(points->InsertNextPoint(place.data()));
    where->InsertNextTuple(corner.data());
  }
  volume.slice_quad->SetPoints(points);
  volume.slice_quad->SetPolys(quad);
  volume.slice_quad->GetPointData()->SetTCoords(where);
  volume.slice_quad->Modified();
}

}  // namespace beatlas::viewer
