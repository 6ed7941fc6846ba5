#pragma once
/// Flat areas over the picture. Within this room alone: here are VTK's types.

#include <vector>

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnsignedCharArray.h>

#include "runtime/base/geometry.h"
#include "runtime/viewer/wall_colours.h"

namespace beatlas::viewer {

/// Triangles and quads of one colour each, in pixels (y up).
class Patches {
 public:
  Patches() {
    colours_->SetNumberOfComponents(3);
    colours_->SetName("colours");
  }

  void add(const std::vector<Vec2>& corners, const Rgb& colour) {
    cells_->InsertNextCell(static_cast<int>(corners.size()));
    for (const Vec2& corner : corners) {
      cells_->InsertCellPoint(points_->InsertNextPoint(corner.x(), corner.y(), 0));
    }
    colours_->InsertNextTypedTuple(colour.data());
  }

  void add_box(const Vec2& low, const Vec2& high, const Rgb& colour) {
    add({low, {high.x(), low.y()}, high, {low.x(), high.y()}}, colour);
  }

  void give_to(vtkPolyData& data) {
    data.SetPoints(points_);
    data.SetPolys(cells_);
    data.GetCellData()->SetScalars(colours_);
    data.Modified();
  }

 private:
  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> cells_;
  vtkNew<vtkUnsignedCharArray> colours_;
};

}  // namespace beatlas::viewer
