#include "pipeline/report/coarse_surface.h"

#include <map>

#include <vtkCellArray.h>
#include <vtkDecimatePro.h>
#include <vtkIdList.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

namespace beatlas::report {
namespace {

vtkNew<vtkPolyData> as_vtk(const SurfaceCycle& surface, std::size_t phase) {
  vtkNew<vtkPolyData> out;
  vtkNew<vtkPoints> points;
  for (const Vec3f& x : surface.positions[phase]) points->InsertNextPoint(x.x(), x.y(), x.z());
  vtkNew<vtkCellArray> cells;
  for (const auto& triangle : surface.triangles) {
    const std::array<vtkIdType, 3> ids{triangle[0], triangle[1], triangle[2]};
    cells->InsertNextCell(3, ids.data());
  }
  out->SetPoints(points);
  out->SetPolys(cells);
  return out;
}

}  // namespace

CoarseSurface coarse_surface(const SurfaceCycle& surface, std::size_t vertices, int phase) {
  const auto p = static_cast<std::size_t>(phase);
  CoarseSurface out{surface.structure, surface.triangles, surface.positions};
  const std::size_t all = surface.positions.at(p).size();
  if (all <= vertices) return out;
  vtkNew<vtkDecimatePro> decimate;
  decimate->SetInputData(as_vtk(surface, p));
  decimate->SetTargetReduction(1 - double(vertices) / double(all));
  decimate->PreserveTopologyOn();
  decimate->SplittingOff();
  decimate->Update();
  vtkPolyData* coarse = decimate->GetOutput();

  // Its points are some of the surface's, in another order.
  std::map<std::array<float, 3>, std::uint32_t> vertex_at;
  for (std::size_t v = all; v-- > 0;) {
    const Vec3f& x = surface.positions[p][v];
    vertex_at[{x.x(), x.y(), x.z()}] = static_cast<std::uint32_t>(v);
  }
  std::vector<std::uint32_t> kept;
  for (vtkIdType v = 0; v < coarse->GetNumberOfPoints(); ++v) {
    std::array<double, 3> x{};
    coarse->GetPoint(v, x.data());
    kept.push_back(vertex_at.at({float(x[0]), float(x[1]), float(x[2])}));
  }
  out.triangles.clear();
  vtkNew<vtkIdList> ids;
  for (coarse->GetPolys()->InitTraversal(); coarse->GetPolys()->GetNextCell(ids) != 0;) {
    out.triangles.push_back({static_cast<std::uint32_t>(ids->GetId(0)),
                             static_cast<std::uint32_t>(ids->GetId(1)),
                             static_cast<std::uint32_t>(ids->GetId(2))});
  }
  for (std::size_t q = 0; q < surface.positions.size(); ++q) {
    out.positions[q].clear();
    for (const std::uint32_t v : kept) out.positions[q].push_back(surface.positions[q][v]);
  }
  return out;
}

}  // namespace beatlas::report
