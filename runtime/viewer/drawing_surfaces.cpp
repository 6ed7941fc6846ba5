#include <algorithm>
#include <array>
#include <map>

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkContourTriangulator.h>
#include <vtkPointData.h>
#include <vtkProperty.h>

#include "runtime/viewer/drawing_parts.h"

namespace beatlas::viewer {
namespace {

// What is drawn first lies innermost, so that transparency is right without sorting.
constexpr std::array kInsideOut{Structure::LvBlood, Structure::RvBlood, Structure::LvMyocardium,
                                Structure::Heart};

vtkSmartPointer<vtkActor> flat_actor(vtkPolyData* data) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  // In front of the images on the same plane.
  mapper->SetResolveCoincidentTopologyToPolygonOffset();
  mapper->SetRelativeCoincidentTopologyLineOffsetParameters(0, -8);
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->LightingOff();
  actor->PickableOff();
  return actor;
}

}  // namespace

void HeartDrawing::Parts::make_surfaces() {
  for (const Structure structure : kInsideOut) {
    const auto payload = atlas->surface(structure);
    if (!payload) continue;
    SurfaceParts part;
    part.structure = structure;
    part.look = default_look(structure);
    part.motion = std::make_unique<SurfaceMotion>(payload);
    part.positions.resize(part.motion->vertex_count());
    part.normals.resize(part.motion->vertex_count());
    const auto count = static_cast<vtkIdType>(part.positions.size());

    // VTK reads our arrays where they lie.
    vtkNew<vtkFloatArray> coordinates;
    coordinates->SetNumberOfComponents(3);
    coordinates->SetArray(part.positions.front().data(), 3 * count, 1);
    part.points = vtkSmartPointer<vtkPoints>::New();
    part.points->SetData(coordinates);
    part.point_normals = vtkSmartPointer<vtkFloatArray>::New();
    part.point_normals->SetNumberOfComponents(3);
    part.point_normals->SetName("normals");
    part.point_normals->SetArray(part.normals.front().data(), 3 * count, 1);
    vtkNew<vtkCellArray> triangles;
    triangles->AllocateExact(static_cast<vtkIdType>(payload->triangles.size()),
                             3 * static_cast<vtkIdType>(payload->triangles.size()));
    for (const auto& triangle : payload->triangles) {
      const std::array<vtkIdType, 3> ids{triangle[0], triangle[1], triangle[2]};
      triangles->InsertNextCell(3, ids.data());
    }
    part.mesh = vtkSmartPointer<vtkPolyData>::New();
    part.mesh->SetPoints(part.points);
    part.mesh->SetPolys(triangles);
    part.mesh->GetPointData()->SetNormals(part.point_normals);
    part.mapper = vtkSmartPointer<vtkPolyDataMapper>::New();
    part.mapper->SetInputData(part.mesh);
    part.actor = vtkSmartPointer<vtkActor>::New();
    part.actor->SetMapper(part.mapper);
    vtkProperty* property = part.actor->GetProperty();
    property->SetInterpolationToPhong();
    property->SetAmbient(0.12);
    property->SetDiffuse(0.85);
    property->SetSpecular(0.25);
    property->SetSpecularPower(25);
    renderer->AddActor(part.actor);

    part.line = vtkSmartPointer<vtkPolyData>::New();
    part.line_actor = flat_actor(part.line);
    part.line_actor->GetProperty()->SetLineWidth(2.5F);
    part.cap = vtkSmartPointer<vtkPolyData>::New();
    part.cap_actor = flat_actor(part.cap);
    renderer->AddActor(part.cap_actor);
    renderer->AddActor(part.line_actor);
    surfaces.push_back(std::move(part));
  }
}

void HeartDrawing::Parts::update_surface(SurfaceParts& part) const {
  part.motion->positions_at(beats, part.positions);
  part.motion->normals_of(part.positions, part.normals);
  if (tool && tool->dent_mm > 0) {
    palpation::DentField dent(tool->dent_radius_mm);
    const palpation::DentSource source{.place_mm = tool->dent_place_mm, .depth_mm = tool->dent_mm};
    dent.set(std::span(&source, 1));
    // Everything gives way in one direction, the deeper it lies the less: no triangle turns over.
    const Vec3f outward = tool->dent_normal.cast<float>();
    for (Vec3f& position : part.positions) {
      const auto depth = static_cast<float>(dent.depression_mm(position.cast<double>()));
      if (depth > 0) position -= depth * outward;
    }
    part.motion->normals_of(part.positions, part.normals);
  }
  part.points->Modified();
  part.point_normals->Modified();
  part.mesh->Modified();

  const Look& look = part.look;
  part.actor->SetVisibility(look.visible && look.opacity > 0 ? 1 : 0);
  vtkProperty* property = part.actor->GetProperty();
  property->SetColor(look.colour.x(), look.colour.y(), look.colour.z());
  property->SetOpacity(look.opacity);
  property->SetBackfaceCulling(look.opacity < 1 && !cut ? 1 : 0);
  colour_surface(part);
  part.mapper->RemoveAllClippingPlanes();
  if (cut) part.mapper->AddClippingPlane(plane);
}

void HeartDrawing::Parts::update_cut(SurfaceParts& part) const {
  const bool shown = cut && part.look.visible;
  part.line_actor->SetVisibility(shown ? 1 : 0);
  const bool images = image_on_cut && volume.payload;
  const bool filled = shown && !images && part.look.opacity > 0;
  part.cap_actor->SetVisibility(filled ? 1 : 0);
  if (!shown) return;
  const std::vector<CutSegment> segments =
      cut_surface(part.motion->surface().triangles, part.positions, cut->point_mm, cut->normal);
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> lines;
  for (const CutSegment& segment : segments) {
    const std::array<vtkIdType, 2> ends{
        points->InsertNextPoint(segment.from_mm.cast<double>().eval().data()),
        points->InsertNextPoint(segment.to_mm.cast<double>().eval().data())};
    lines->InsertNextCell(2, ends.data());
  }
  part.line->SetPoints(points);
  part.line->SetLines(lines);
  part.line->Modified();
  const Vec3 bright = 0.55 * part.look.colour + Vec3::Constant(0.45);
  part.line_actor->GetProperty()->SetColor(bright.x(), bright.y(), bright.z());
  if (!filled) return;
  // The same points for both ends that meet, so that the pieces close to loops.
  vtkNew<vtkContourTriangulator> triangulator;
  triangulator->TriangulationErrorDisplayOff();
  vtkNew<vtkPolyData> welded;
  vtkNew<vtkPoints> welded_points;
  vtkNew<vtkCellArray> welded_lines;
  std::map<std::array<float, 3>, vtkIdType> known;
  const auto id_of = [&](const Vec3f& x) {
    const auto [at, added] = known.try_emplace({x.x(), x.y(), x.z()}, 0);
    if (added) at->second = welded_points->InsertNextPoint(x.x(), x.y(), x.z());
    return at->second;
  };
  for (const CutSegment& segment : segments) {
    const std::array<vtkIdType, 2> ends{id_of(segment.from_mm), id_of(segment.to_mm)};
    if (ends[0] != ends[1]) welded_lines->InsertNextCell(2, ends.data());
  }
  welded->SetPoints(welded_points);
  welded->SetLines(welded_lines);
  triangulator->SetInputData(welded);
  triangulator->Update();
  part.cap->ShallowCopy(triangulator->GetOutput());
  const Vec3 dark = 0.8 * part.look.colour;
  part.cap_actor->GetProperty()->SetColor(dark.x(), dark.y(), dark.z());
  // The innermost on top.
  const auto at = std::find(kInsideOut.begin(), kInsideOut.end(), part.structure);
  const auto inner = static_cast<double>(kInsideOut.end() - at);
  auto* mapper = vtkPolyDataMapper::SafeDownCast(part.cap_actor->GetMapper());
  mapper->SetRelativeCoincidentTopologyPolygonOffsetParameters(0, -2 * inner);
  mapper->Modified();
}

}  // namespace beatlas::viewer
