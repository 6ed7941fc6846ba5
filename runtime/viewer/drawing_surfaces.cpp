#include <array>
#include <map>
#include <utility>
#include <vector>

#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkContourTriangulator.h>
#include <vtkPointData.h>
#include <vtkProperty.h>

#include "runtime/viewer/drawing_parts.h"

namespace beatlas::viewer {
namespace {

constexpr std::array kInsideOut{Structure::LvBlood, Structure::RvBlood, Structure::LaBlood,
                                Structure::RaBlood, Structure::Aorta,   Structure::LvMyocardium,
                                Structure::Heart};

// Surfaces are fitted each by itself: where one encloses another they lie on each other to a
// millimetre or two, now this one in front, now that. Seen in parallel, what is moved towards the
// viewer looks the same, so each is moved that far in front of what it encloses.
double towards_viewer_mm(Structure structure) {
  switch (structure) {
    case Structure::LvBlood:
    case Structure::LaBlood:
    case Structure::RaBlood:
    case Structure::Aorta:
      return 0;
    case Structure::RvBlood:
      return 0.5;
    case Structure::LvMyocardium:
      return 1;
    case Structure::Heart:
      return 4;
  }
  return 0;
}

vtkSmartPointer<vtkActor> flat_actor(vtkPolyData* data) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
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
    part.plane = vtkSmartPointer<vtkPlane>::New();
    vtkProperty* property = part.actor->GetProperty();
    property->SetInterpolationToPhong();
    property->SetAmbient(0.12);
    property->SetDiffuse(0.85);
    property->SetSpecular(0.25);
    property->SetSpecularPower(25);

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

// Around each tool everything gives way in one direction, the deeper it lies the less: no triangle
// turns over. Dents that meet are made together, so that two at one place are one.
bool HeartDrawing::Parts::dent_surface(std::vector<Vec3f>& positions) const {
  std::vector<palpation::DentSource> sources;
  std::vector<Vec3f> outward;
  double radius_mm = 0;
  for (const ToolPicture& tool : tools) {
    if (!(tool.dent_mm > 0) || sources.size() == palpation::kMostFingers) continue;
    sources.push_back({.place_mm = tool.dent_place_mm, .depth_mm = tool.dent_mm});
    outward.push_back(tool.dent_normal.cast<float>());
    radius_mm = tool.dent_radius_mm;
  }
  if (sources.empty()) return false;
  palpation::DentField dents(radius_mm);
  dents.set(sources);
  for (Vec3f& position : positions) {
    const Vec3 place = position.cast<double>();
    for (std::size_t n = 0; n < sources.size(); ++n) {
      const double depth = dents.amplitudes_mm()[n] * dents.weight(place, sources[n].place_mm);
      if (depth > 0) position -= static_cast<float>(depth) * outward[n];
    }
  }
  return true;
}

void HeartDrawing::Parts::update_surface(SurfaceParts& part) const {
  part.motion->positions_at(beats, part.positions);
  part.motion->normals_of(part.positions, part.normals);
  if (dent_surface(part.positions)) part.motion->normals_of(part.positions, part.normals);
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
  if (cut) part.mapper->AddClippingPlane(part.plane);
}

// VTK draws what is opaque first, and then what is not, each in the order in which actors were
// added. Opaque surfaces come from the outside in, so that what they hide costs little; the others
// from the inside out, so that each is mixed with all that lies behind.
void HeartDrawing::Parts::update_order() {
  std::vector<vtkActor*> wished;
  for (std::size_t n = surfaces.size(); n-- > 0;) {
    if (!(surfaces[n].look.opacity < 1)) wished.push_back(surfaces[n].actor);
  }
  for (const SurfaceParts& part : surfaces) {
    if (part.look.opacity < 1) wished.push_back(part.actor);
  }
  if (wished == drawn_order) return;
  for (vtkActor* actor : wished) renderer->RemoveActor(actor);
  for (vtkActor* actor : wished) renderer->AddActor(actor);
  drawn_order = std::move(wished);
}

void HeartDrawing::Parts::update_layers() {
  Vec3 towards;
  renderer->GetActiveCamera()->GetViewPlaneNormal(towards.data());
  const auto move = [&](vtkProp3D* prop, double mm) {
    const Vec3 by = mm * towards;
    prop->SetPosition(by.x(), by.y(), by.z());
  };
  // The images on the cut, then areas, the innermost on top, then lines, likewise.
  double on_cut_mm = kOnTopMm;
  if (volume.slice_actor) move(volume.slice_actor, on_cut_mm);
  for (std::size_t n = surfaces.size(); n-- > 0;) {
    const SurfaceParts& part = surfaces[n];
    const double mm = towards_viewer_mm(part.structure);
    move(part.actor, mm);
    on_cut_mm += kBetweenMm;
    move(part.cap_actor, on_cut_mm);
    // Where two lines are one, the inner's is seen.
    const double inwards = static_cast<double>(surfaces.size() - n) / surfaces.size();
    move(part.line_actor, kOnTopMm + (surfaces.size() + 1 + inwards) * kBetweenMm);
    if (!cut) continue;
    const Vec3 point = cut->point_mm + mm * towards;
    part.plane->SetOrigin(point.x(), point.y(), point.z());
    part.plane->SetNormal(-cut->normal.x(), -cut->normal.y(), -cut->normal.z());
  }
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
  const Vec3& colour = part.look.colour;
  part.line_actor->GetProperty()->SetColor(colour.x(), colour.y(), colour.z());
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
  const Vec3 dark = 0.8 * colour;
  part.cap_actor->GetProperty()->SetColor(dark.x(), dark.y(), dark.z());
}

}  // namespace beatlas::viewer
