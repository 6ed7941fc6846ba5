/// VTK's growing and contouring.
#include <vtkCellArray.h>
#include <vtkDiscreteFlyingEdges3D.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageConnectivityFilter.h>
#include <vtkImageData.h>
#include <vtkImageThresholdConnectivity.h>
#include <vtkMarchingCubes.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowedSincPolyDataFilter.h>

#include "tests/bench/alternatives.h"

namespace beatlas::bench {
namespace {

/// A view of the voxels, nothing is copied; origin 0, points are index times spacing.
template <class Array, class T>
vtkSmartPointer<vtkImageData> image_of(const Grid& grid, const std::vector<T>& voxels) {
  vtkNew<Array> array;
  array->SetArray(const_cast<T*>(voxels.data()), static_cast<vtkIdType>(voxels.size()), 1);
  const Vec3 spacing = grid.spacing_mm();
  auto out = vtkSmartPointer<vtkImageData>::New();
  out->SetDimensions(grid.size[0], grid.size[1], grid.size[2]);
  out->SetSpacing(spacing.x(), spacing.y(), spacing.z());
  out->GetPointData()->SetScalars(array);
  return out;
}

vtkSmartPointer<vtkPoints> seeds_of(const Grid& grid, const Index3& seed) {
  const Vec3 spacing = grid.spacing_mm();
  auto out = vtkSmartPointer<vtkPoints>::New();
  out->InsertNextPoint(seed[0] * spacing.x(), seed[1] * spacing.y(), seed[2] * spacing.z());
  return out;
}

field::TriangleSoup soup_of(const Grid& grid, vtkPolyData& surface) {
  const Vec3 spacing = grid.spacing_mm();
  field::TriangleSoup out;
  out.points.resize(static_cast<std::size_t>(surface.GetNumberOfPoints()));
  for (std::size_t n = 0; n < out.points.size(); ++n) {
    Vec3 x;
    surface.GetPoint(static_cast<vtkIdType>(n), x.data());
    const Vec3 index = x.cwiseQuotient(spacing);
    out.points[n] = grid.mm(index.x(), index.y(), index.z());
  }
  vtkIdType corners = 0;
  const vtkIdType* ids = nullptr;
  vtkCellArray* cells = surface.GetPolys();
  out.triangles.reserve(static_cast<std::size_t>(cells->GetNumberOfCells()));
  for (cells->InitTraversal(); cells->GetNextCell(corners, ids) != 0;) {
    out.triangles.push_back({static_cast<std::uint32_t>(ids[0]), static_cast<std::uint32_t>(ids[1]),
                             static_cast<std::uint32_t>(ids[2])});
  }
  return out;
}

template <class Filter>
field::TriangleSoup contoured(const Grid& grid, const std::vector<float>& level) {
  vtkNew<Filter> filter;
  const auto image = image_of<vtkFloatArray>(grid, level);
  filter->SetInputData(image);
  filter->SetValue(0, 0);
  filter->ComputeNormalsOff();
  filter->ComputeGradientsOff();
  filter->ComputeScalarsOff();
  filter->Update();
  return soup_of(grid, *filter->GetOutput());
}

}  // namespace

Mask vtk_threshold_connectivity(const Grid& grid, const std::vector<float>& image,
                                const Growing& growing) {
  vtkNew<vtkImageThresholdConnectivity> filter;
  const auto input = image_of<vtkFloatArray>(grid, image);
  filter->SetInputData(input);
  filter->SetSeedPoints(seeds_of(grid, growing.seed));
  filter->ThresholdBetween(growing.lower, growing.upper);
  filter->SetInValue(1);
  filter->SetOutValue(0);
  filter->ReplaceInOn();
  filter->ReplaceOutOn();
  filter->Update();
  const auto* first = static_cast<const float*>(filter->GetOutput()->GetScalarPointer());
  return {first, first + image.size()};
}

Mask vtk_connectivity(const Grid& grid, const std::vector<float>& image, const Growing& growing) {
  vtkNew<vtkImageConnectivityFilter> filter;
  const auto input = image_of<vtkFloatArray>(grid, image);
  vtkNew<vtkPolyData> seeds;
  seeds->SetPoints(seeds_of(grid, growing.seed));
  filter->SetInputData(input);
  filter->SetSeedData(seeds);
  filter->SetScalarRange(growing.lower, growing.upper);
  filter->SetExtractionModeToSeededRegions();
  filter->SetLabelModeToConstantValue();
  filter->SetLabelConstantValue(1);
  filter->SetLabelScalarTypeToUnsignedChar();
  filter->Update();
  const auto* first = static_cast<const std::uint8_t*>(filter->GetOutput()->GetScalarPointer());
  return {first, first + image.size()};
}

field::TriangleSoup vtk_flying_edges(const Grid& grid, const std::vector<float>& level) {
  return contoured<vtkFlyingEdges3D>(grid, level);
}

field::TriangleSoup vtk_marching_cubes(const Grid& grid, const std::vector<float>& level) {
  return contoured<vtkMarchingCubes>(grid, level);
}

field::TriangleSoup vtk_discrete_surface(const Grid& grid, const Mask& mask, bool smooth) {
  vtkNew<vtkDiscreteFlyingEdges3D> contour;
  const auto image = image_of<vtkUnsignedCharArray>(grid, mask);
  contour->SetInputData(image);
  contour->SetValue(0, 1);
  contour->ComputeNormalsOff();
  contour->ComputeGradientsOff();
  contour->ComputeScalarsOff();
  if (!smooth) {
    contour->Update();
    return soup_of(grid, *contour->GetOutput());
  }
  vtkNew<vtkWindowedSincPolyDataFilter> sinc;
  sinc->SetInputConnection(contour->GetOutputPort());
  sinc->SetPassBand(0.01);
  sinc->SetNumberOfIterations(40);
  sinc->BoundarySmoothingOff();
  sinc->FeatureEdgeSmoothingOff();
  sinc->NonManifoldSmoothingOn();
  sinc->NormalizeCoordinatesOn();
  sinc->Update();
  return soup_of(grid, *sinc->GetOutput());
}

}  // namespace beatlas::bench
