#pragma once
/// Flat areas over the picture. Within this room alone: here are VTK's types.

#include <vector>

#include <vtkActor2D.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

#include "runtime/base/geometry.h"
#include "runtime/viewer/surface_colours.h"

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

/// Draws what Patches give to `data`, over the picture, unseen at first.
inline vtkSmartPointer<vtkActor2D> patches_actor(vtkRenderer& renderer, vtkPolyData& data) {
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(&data);
  auto actor = vtkSmartPointer<vtkActor2D>::New();
  actor->SetMapper(mapper);
  actor->VisibilityOff();
  renderer.AddViewProp(actor);
  return actor;
}

/// Words over the picture.
inline vtkSmartPointer<vtkTextActor> text_actor(vtkRenderer& renderer, int size) {
  auto text = vtkSmartPointer<vtkTextActor>::New();
  text->GetTextProperty()->SetFontSize(size);
  text->GetTextProperty()->SetFontFamilyToArial();
  text->GetTextProperty()->SetColor(0.93, 0.93, 0.93);
  text->GetTextProperty()->SetShadow(1);  // images beneath are of any grey
  renderer.AddViewProp(text);
  return text;
}

}  // namespace beatlas::viewer
