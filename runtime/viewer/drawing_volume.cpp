#include <algorithm>
#include <array>
#include <cmath>

#include <vtkCellArray.h>
#include <vtkOpenGLRenderWindow.h>
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
constexpr double kAroundVoxels = 2;  ///< of the images, around the heart's box
constexpr double kMovingHz = 30;     ///< pictures that are turned or cut
constexpr double kRestingHz = 1e-3;  ///< as fine as they get

struct Ramp {
  double at;  ///< 0 muscle, 1 blood
  double opacity;
  Vec3 colour;
};

/// Over voxels of the images.
struct ByteSum {
  int sum = 0;
  int count = 0;
};

/// Over what there is of the images' voxels from `first` on, `step` of them along each axis.
ByteSum sum_from(const std::array<int, 3>& first, const std::array<int, 3>& step,
                 const std::vector<std::uint8_t>& samples, const std::array<int, 3>& size) {
  ByteSum out;
  for (int k = first[2]; k < std::min(first[2] + step[2], size[2]); ++k) {
    for (int j = first[1]; j < std::min(first[1] + step[1], size[1]); ++j) {
      const std::size_t row = (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) +
                               static_cast<std::size_t>(j)) *
                              static_cast<std::size_t>(size[0]);
      for (int i = first[0]; i < std::min(first[0] + step[0], size[0]); ++i) {
        out.sum += samples[row + static_cast<std::size_t>(i)];
        ++out.count;
      }
    }
  }
  return out;
}

/// Which bytes of the images are seen, and how.
void set_looks(VolumePreset preset, const VolumeParts& volume) {
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
}

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
  std::vector<std::shared_ptr<const field::FieldQuery>> fields;
  if (BetweenSlices::far_apart(payload)) {
    for (const Structure structure : kAllStructures) {
      if (auto distances = atlas->field(structure)) {
        fields.push_back(std::make_shared<const field::FieldQuery>(
            std::move(distances), atlas->manifest().rr_interval_s));
      }
    }
  }
  volume.between.emplace(payload, std::move(fields), frame.low_mm, frame.high_mm);
  volume.shape = volume.between->shape();
  volume.slices.resize(volume.between->needed() ? payload.sample_count() : 0);
  volume.samples.resize(volume.shape.sample_count());
  volume.plane = vtkSmartPointer<vtkPlane>::New();

  // Halved along the axes whose voxels are small: slices that lie far apart stay.
  const Vec3 edges = volume.shape.workspace_from_index.linear().colwise().norm();
  std::array<int, 3> step{};
  for (int axis = 0; axis < 3; ++axis) {
    step[static_cast<std::size_t>(axis)] = edges[axis] < 1.6 * edges.minCoeff() ? 2 : 1;
  }
  volume.fine = make_level({1, 1, 1});
  volume.coarse = make_level(step);

  volume.mapper = vtkSmartPointer<vtkSmartVolumeMapper>::New();
  volume.mapper->SetInputData(volume.fine.image);
  volume.mapper->SetBlendModeToComposite();
  volume.volume = vtkSmartPointer<vtkVolume>::New();
  volume.volume->SetMapper(volume.mapper);
  volume.volume->SetUserMatrix(volume.fine.matrix);
  volume.volume->VisibilityOff();
  vtkVolumeProperty* property = volume.volume->GetProperty();
  property->SetInterpolationTypeToLinear();
  property->ShadeOn();
  property->SetAmbient(0.4);
  property->SetDiffuse(0.75);
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

// The part of the images around the heart, or all without a field.
VolumeLevel HeartDrawing::Parts::make_level(const std::array<int, 3>& step) const {
  const atlas::VolumePayload& payload = volume.shape;
  VolumeLevel level;
  level.step = step;
  Vec3 low = Vec3::Zero();
  Vec3 high(payload.size[0] - 1, payload.size[1] - 1, payload.size[2] - 1);
  if (field) {
    const Affine index_from_workspace = payload.workspace_from_index.inverse();
    Vec3 least = high;
    Vec3 most = low;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 place((corner & 1) != 0 ? frame.high_mm.x() : frame.low_mm.x(),
                       (corner & 2) != 0 ? frame.high_mm.y() : frame.low_mm.y(),
                       (corner & 4) != 0 ? frame.high_mm.z() : frame.low_mm.z());
      const Vec3 index = index_from_workspace * place;
      least = least.cwiseMin(index);
      most = most.cwiseMax(index);
    }
    low = low.cwiseMax(least - Vec3::Constant(kAroundVoxels));
    high = high.cwiseMin(most + Vec3::Constant(kAroundVoxels));
  }
  Vec3 middle;
  for (int axis = 0; axis < 3; ++axis) {
    const auto n = static_cast<std::size_t>(axis);
    level.low[n] = std::clamp(static_cast<int>(low[axis]), 0, payload.size[n] - 1);
    const int count = static_cast<int>(std::ceil(high[axis])) - level.low[n] + 1;
    level.size[n] =
        std::max(1, (std::min(count, payload.size[n] - level.low[n]) + step[n] - 1) / step[n]);
    middle[axis] = level.low[n] + 0.5 * (step[n] - 1);
  }
  level.workspace_from_index = payload.workspace_from_index * Eigen::Translation3d(middle) *
                               Eigen::Scaling(Vec3(step[0], step[1], step[2]));
  Vec3 spacing;
  level.matrix = vtkSmartPointer<vtkMatrix4x4>::New();
  for (int column = 0; column < 3; ++column) {
    spacing[column] = level.workspace_from_index.linear().col(column).norm();
    for (int row = 0; row < 3; ++row) {
      level.matrix->SetElement(row, column,
                               level.workspace_from_index(row, column) / spacing[column]);
    }
  }
  for (int row = 0; row < 3; ++row) {
    level.matrix->SetElement(row, 3, level.workspace_from_index(row, 3));
  }
  level.image = vtkSmartPointer<vtkImageData>::New();
  level.image->SetDimensions(level.size.data());
  level.image->SetSpacing(spacing.data());
  level.image->AllocateScalars(VTK_UNSIGNED_CHAR, 1);
  return level;
}

// The images of now, as bytes.
void HeartDrawing::Parts::update_samples() {
  if (volume.samples_beats == beats) return;
  if (volume.between->needed()) {
    atlas::volume_8bit(*volume.payload, beats, volume.window, volume.slices);
    volume.between->fill(beats, volume.slices, volume.samples);
  } else {
    atlas::volume_8bit(*volume.payload, beats, volume.window, volume.samples);
  }
  volume.samples_beats = beats;
  volume.heart_beats = beats;
}

// Those that any level takes: most of a chest is not the heart.
void HeartDrawing::Parts::update_samples_around_heart() {
  if (volume.samples_beats == beats || volume.heart_beats == beats) return;
  if (volume.between->needed()) {
    update_samples();
    return;
  }
  const VolumeLevel& fine = volume.fine;
  std::array<int, 3> high{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    high[axis] = std::min(fine.low[axis] + fine.size[axis] + 1, volume.payload->size[axis]) - 1;
  }
  atlas::volume_8bit(*volume.payload, beats, volume.window, volume.samples, fine.low, high);
  volume.heart_beats = beats;
  volume.samples_beats = -1;
}

void HeartDrawing::Parts::update_level(VolumeLevel& level) {
  update_samples_around_heart();
  if (level.beats == beats) return;
  level.beats = beats;
  if (field && !level.mask) level.mask.emplace(level.workspace_from_index, level.size, field);
  const std::uint8_t* mask = level.mask ? level.mask->at(beats).data() : nullptr;
  auto* to = static_cast<std::uint8_t*>(level.image->GetScalarPointer());
  for (int z = 0; z < level.size[2]; ++z) {
    for (int y = 0; y < level.size[1]; ++y) {
      for (int x = 0; x < level.size[0]; ++x, ++to) {
        const int share = mask != nullptr ? *mask++ : 255;
        if (share == 0) {
          *to = 0;
          continue;
        }
        // A mean over what there is of the images' voxels in this one.
        const ByteSum all =
            sum_from({level.low[0] + x * level.step[0], level.low[1] + y * level.step[1],
                      level.low[2] + z * level.step[2]},
                     level.step, volume.samples, volume.shape.size);
        *to = static_cast<std::uint8_t>(all.sum * share / (255 * all.count));
      }
    }
  }
  level.image->GetPointData()->GetScalars()->Modified();
  level.image->Modified();
}

// Without a graphics card VTK's own ray caster is many times quicker than its shaders on Mesa.
void HeartDrawing::Parts::choose_caster() {
  if (volume.caster_chosen || !window) return;
  std::string told = gl_renderer();
  if (told == "unknown") {  // nothing was drawn yet
    auto* const opengl = vtkOpenGLRenderWindow::SafeDownCast(window);
    if (opengl != nullptr) opengl->Initialize();
    told = gl_renderer();
  }
  volume.caster_chosen = told != "unknown";
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
    VolumeLevel& level = moving ? volume.coarse : volume.fine;
    update_level(level);
    volume.mapper->SetInputData(level.image);
    volume.volume->SetUserMatrix(level.matrix);
    set_looks(preset, volume);
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
  update_samples();
  const PlaneGrid grid = cut_grid(volume.shape, cut->point_mm, cut->normal,
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
  sample_cut(volume.shape, volume.samples, grid, grey_alpha);
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
