#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <vtkArrowSource.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkMatrix4x4.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty.h>
#include <vtkProperty2D.h>
#include <vtkSphereSource.h>
#include <vtkTextProperty.h>
#include <vtkTransform.h>

#include "runtime/viewer/drawing_parts.h"
#include "runtime/viewer/drawing_patches.h"

namespace beatlas::viewer {
namespace {

// The longest of 1, 2, 5, 10, 20, 50, ... mm that is no longer than `most_mm`.
double round_length_mm(double most_mm) {
  const double power = std::pow(10.0, std::floor(std::log10(most_mm)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= most_mm) return factor * power;
  }
  return power;
}

std::string number(const char* format, double value) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

}  // namespace

void HeartDrawing::Parts::make_overlay() {
  if (!options.caption) return;
  overlay.bar = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(overlay.bar);
  overlay.bar_actor = vtkSmartPointer<vtkActor2D>::New();
  overlay.bar_actor->SetMapper(mapper);
  overlay.bar_actor->GetProperty()->SetColor(0.93, 0.93, 0.93);
  overlay.bar_actor->GetProperty()->SetLineWidth(2);
  renderer->AddViewProp(overlay.bar_actor);
  overlay.swatches = vtkSmartPointer<vtkPolyData>::New();
  overlay.swatches_actor = patches_actor(*renderer, *overlay.swatches);
  overlay.swatches_actor->VisibilityOn();
  overlay.bar_text = text_actor(*renderer, 16);
  overlay.bar_text->GetTextProperty()->SetJustificationToCentered();
  overlay.title = text_actor(*renderer, 16);
  overlay.title->GetTextProperty()->SetVerticalJustificationToTop();
  for (SurfaceParts& part : surfaces) {
    part.name = text_actor(*renderer, 15);
    part.name->GetTextProperty()->SetVerticalJustificationToTop();
    part.name->SetInput(structure_title(part.structure).c_str());
  }

  overlay.marker = vtkSmartPointer<vtkRenderer>::New();
  overlay.marker->SetLayer(1);
  overlay.marker->InteractiveOff();
  overlay.cube = vtkSmartPointer<vtkAnnotatedCubeActor>::New();
  // The body's axes: left, posterior and superior are plus.
  overlay.cube->SetXPlusFaceText("L");
  overlay.cube->SetXMinusFaceText("R");
  overlay.cube->SetYPlusFaceText("P");
  overlay.cube->SetYMinusFaceText("A");
  overlay.cube->SetZPlusFaceText("S");
  overlay.cube->SetZMinusFaceText("I");
  overlay.cube->SetZFaceTextRotation(-90);
  overlay.cube->SetFaceTextScale(0.62);
  overlay.cube->GetTextEdgesProperty()->SetColor(0.1, 0.1, 0.1);
  for (vtkProperty* face :
       {overlay.cube->GetXPlusFaceProperty(), overlay.cube->GetXMinusFaceProperty(),
        overlay.cube->GetYPlusFaceProperty(), overlay.cube->GetYMinusFaceProperty(),
        overlay.cube->GetZPlusFaceProperty(), overlay.cube->GetZMinusFaceProperty()}) {
    face->SetColor(0.12, 0.14, 0.20);
    face->SetAmbient(0.7);
  }
  overlay.cube->GetCubeProperty()->SetColor(0.80, 0.84, 0.90);
  overlay.marker->AddActor(overlay.cube);
}

double HeartDrawing::Parts::text_scale() const {
  // Words grow with a large picture, and where pixels are fine.
  const double grown = std::clamp(std::min(width / 800.0, height / 600.0), 1.0, 4.0);
  return options.text_scale * std::max(grown, options.display_scale);
}

double HeartDrawing::Parts::marker_px() const {
  return std::min(0.2 * std::min(width, height), 110.0 * text_scale());
}

int HeartDrawing::Parts::font_size(double pixels) const {
  // VTK takes points, and enlarges them where its window has finer pixels.
  constexpr double kPointsPerInch = 72;
  return std::max(1, static_cast<int>(std::lround(pixels * kPointsPerInch / window->GetDPI())));
}

std::string HeartDrawing::Parts::caption() const {
  std::string words = number("%.0f", 100 * beats) + " % of the beat";
  const atlas::Manifest& manifest = atlas->manifest();
  const int phases = std::max(1, manifest.phase_count());
  // The phase that lies nearest.
  const int phase = static_cast<int>(std::lround(beats * phases)) % phases;
  if (phases > 1 && phase == manifest.end_diastole) words += ", end-diastole (ED)";
  if (phases > 1 && phase == manifest.end_systole) words += ", end-systole (ES)";
  if (!note.empty()) words += "   " + note;
  return words;
}

std::string HeartDrawing::caption() const { return parts_->caption(); }

void HeartDrawing::Parts::update_overlay() {
  if (!options.caption) return;
  vtkCamera* camera = renderer->GetActiveCamera();
  const double per_mm = height / (2 * camera->GetParallelScale());
  const double length_mm = round_length_mm(std::max(1e-3, 0.28 * width / per_mm));
  const double length = length_mm * per_mm;
  const double grown = text_scale();
  const auto pixels = [grown](double at_800_by_600) {
    return static_cast<int>(std::lround(grown * at_800_by_600));
  };
  const double right = width - pixels(18);
  const double low = pixels(18);
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> lines;
  const std::array<std::array<double, 2>, 4> ends{{{right - length, low + pixels(6)},
                                                   {right - length, low},
                                                   {right, low},
                                                   {right, low + pixels(6)}}};
  lines->InsertNextCell(4);
  for (const auto& end : ends) lines->InsertCellPoint(points->InsertNextPoint(end[0], end[1], 0));
  overlay.bar->SetPoints(points);
  overlay.bar->SetLines(lines);
  overlay.bar->Modified();
  overlay.bar_text->SetInput(number("%g mm", length_mm).c_str());
  overlay.bar_text->SetDisplayPosition(static_cast<int>(right - length / 2),
                                       static_cast<int>(low) + pixels(8));
  overlay.bar_text->GetTextProperty()->SetFontSize(font_size(grown * 16));
  overlay.bar_actor->GetProperty()->SetLineWidth(static_cast<float>(2 * grown));

  const bool roomy = width >= 320 && height >= 240;
  overlay.title->SetInput(caption().c_str());
  overlay.title->SetVisibility(roomy ? 1 : 0);
  overlay.title->SetDisplayPosition(pixels(14), height - pixels(10));
  overlay.title->GetTextProperty()->SetFontSize(font_size(grown * 16));
  for (ToolParts& part : tool_parts) {
    part.label->GetTextProperty()->SetFontSize(font_size(grown * 18));
  }
  int line = height - pixels(34);
  Patches swatches;
  for (SurfaceParts& part : surfaces) {
    // Outlines on a cut are seen whatever the opacity.
    const bool named = roomy && part.look.visible && (part.look.opacity > 0 || cut);
    part.name->SetVisibility(named ? 1 : 0);
    if (!named) continue;
    // The colour itself beside words that are read on any ground.
    const auto eight_bits = [](double share) {
      return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
    };
    const Vec3& colour = part.look.colour;
    swatches.add_box(Vec2(pixels(14), line - pixels(14)), Vec2(pixels(26), line - pixels(2)),
                     {eight_bits(colour.x()), eight_bits(colour.y()), eight_bits(colour.z())});
    part.name->GetTextProperty()->SetFontSize(font_size(grown * 15));
    part.name->SetDisplayPosition(pixels(33), line);
    line -= pixels(21);
  }
  swatches.give_to(*overlay.swatches);

  overlay.marker->SetDraw(roomy ? 1 : 0);
  const double marker = marker_px();
  overlay.marker->SetViewport(0, 0, marker / width, marker / height);
  // The body's axes as the scene is seen.
  const Affine& workspace_from_lps = frame.workspace_from_lps;
  const Eigen::Matrix3d lps_from_workspace = workspace_from_lps.linear().transpose();
  Vec3 towards;
  Vec3 up;
  camera->OrthogonalizeViewUp();
  camera->GetViewPlaneNormal(towards.data());
  camera->GetViewUp(up.data());
  towards = lps_from_workspace * towards;
  up = lps_from_workspace * up;
  vtkCamera* eye = overlay.marker->GetActiveCamera();
  eye->ParallelProjectionOn();
  eye->SetFocalPoint(0, 0, 0);
  eye->SetPosition(5 * towards.x(), 5 * towards.y(), 5 * towards.z());
  eye->SetViewUp(up.x(), up.y(), up.z());
  eye->SetParallelScale(0.95);
  eye->SetClippingRange(1, 10);
}

}  // namespace beatlas::viewer
