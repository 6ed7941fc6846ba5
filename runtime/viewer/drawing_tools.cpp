#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

#include <vtkArrowSource.h>
#include <vtkCamera.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkSphereSource.h>
#include <vtkTextProperty.h>

#include "runtime/viewer/drawing_parts.h"

namespace beatlas::viewer {
namespace {

constexpr double kArrowMmPerN = 20;
constexpr double kLongestArrowMm = 80;
constexpr double kSacOpacity = 0.18;

std::string newtons(double force_n) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f N", force_n);
  return text.data();
}

}  // namespace

ToolParts HeartDrawing::Parts::make_tool() {
  ToolParts made;
  const auto ball = [&](const Vec3& colour, double opacity) {
    vtkNew<vtkSphereSource> source;
    source->SetRadius(1);
    source->SetThetaResolution(32);
    source->SetPhiResolution(24);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputConnection(source->GetOutputPort());
    auto actor = vtkSmartPointer<vtkActor>::New();
    actor->SetMapper(mapper);
    actor->GetProperty()->SetColor(colour.x(), colour.y(), colour.z());
    actor->GetProperty()->SetOpacity(opacity);
    actor->GetProperty()->SetSpecular(0.4);
    actor->VisibilityOff();
    renderer->AddActor(actor);
    return actor;
  };
  made.ball = ball({0.95, 0.85, 0.25}, 1);
  made.proxy = ball({0.35, 0.85, 0.95}, 0.45);
  vtkNew<vtkArrowSource> source;
  source->SetTipResolution(24);
  source->SetShaftResolution(24);
  source->SetTipLength(0.25);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(source->GetOutputPort());
  made.arrow = vtkSmartPointer<vtkActor>::New();
  made.arrow->SetMapper(mapper);
  made.arrow->GetProperty()->SetColor(0.97, 0.97, 0.97);  // as no structure
  made.arrow->VisibilityOff();
  renderer->AddActor(made.arrow);
  made.label = vtkSmartPointer<vtkBillboardTextActor3D>::New();
  made.label->GetTextProperty()->SetFontSize(18);
  made.label->GetTextProperty()->SetBold(1);
  made.label->GetTextProperty()->SetColor(0.97, 0.97, 0.97);
  made.label->GetTextProperty()->SetShadow(1);
  made.label->SetDisplayOffset(8, 6);
  made.label->VisibilityOff();
  if (options.caption) renderer->AddActor(made.label);
  return made;
}

void HeartDrawing::Parts::update_tools() {
  while (tool_parts.size() < tools.size()) tool_parts.push_back(make_tool());
  for (std::size_t n = 0; n < tool_parts.size(); ++n) update_tool(n);
}

void HeartDrawing::Parts::update_tool(std::size_t n) {
  const ToolParts& parts = tool_parts[n];
  const ToolPicture* const tool = n < tools.size() ? &tools[n] : nullptr;
  const bool shown = tool != nullptr && tool->shown;
  const bool pushes = shown && tool->force_n.norm() > 1e-3;
  parts.ball->SetVisibility(shown ? 1 : 0);
  parts.proxy->SetVisibility(shown && tool->touching ? 1 : 0);
  parts.arrow->SetVisibility(pushes ? 1 : 0);
  parts.label->SetVisibility(pushes ? 1 : 0);
  if (!shown) return;
  // As far towards the viewer as what lies on a cut (update_layers).
  Vec3 towards;
  renderer->GetActiveCamera()->GetViewPlaneNormal(towards.data());
  const Vec3 x = tool->position_mm + kOnTopMm * towards;
  const Vec3 proxy = tool->proxy_mm + kOnTopMm * towards;
  const double radius = std::max(tool->radius_mm, 1.5);
  parts.ball->SetPosition(x.x(), x.y(), x.z());
  parts.ball->SetScale(radius);
  parts.proxy->SetPosition(proxy.x(), proxy.y(), proxy.z());
  parts.proxy->SetScale(1.05 * radius);
  if (!pushes) return;
  const double force = tool->force_n.norm();
  const Vec3 along = tool->force_n / force;
  const double length = std::clamp(kArrowMmPerN * force, 8.0, kLongestArrowMm);
  const Vec3 side = along.unitOrthogonal();
  const Vec3 other = along.cross(side);
  const double thickness = 45;  // VTK's arrow is 0.1 in radius
  vtkNew<vtkMatrix4x4> matrix;
  for (int row = 0; row < 3; ++row) {
    matrix->SetElement(row, 0, length * along[row]);
    matrix->SetElement(row, 1, thickness * side[row]);
    matrix->SetElement(row, 2, thickness * other[row]);
    matrix->SetElement(row, 3, x[row] + radius * along[row]);
  }
  parts.arrow->SetUserMatrix(matrix);
  const Vec3 tip = x + (radius + length) * along;
  parts.label->SetPosition(tip.x(), tip.y(), tip.z());
  const std::string which = tools.size() > 1 ? std::to_string(n + 1) + ": " : "";
  parts.label->SetInput((which + newtons(force)).c_str());
}

void HeartDrawing::set_pericardium(const haptics::PericardialField::Lattice& lattice) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(lattice.size.data());
  image->SetSpacing(lattice.step_mm, lattice.step_mm, lattice.step_mm);
  image->SetOrigin(lattice.low_mm.x(), lattice.low_mm.y(), lattice.low_mm.z());
  image->AllocateScalars(VTK_FLOAT, 1);
  std::copy(lattice.values_mm.begin(), lattice.values_mm.end(),
            static_cast<float*>(image->GetScalarPointer()));
  vtkNew<vtkFlyingEdges3D> sac;
  sac->SetInputData(image);
  sac->SetValue(0, lattice.effusion_mm);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(sac->GetOutputPort());
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(0.80, 0.84, 0.90);
  actor->GetProperty()->SetOpacity(kSacOpacity);
  actor->GetProperty()->BackfaceCullingOn();
  parts_->renderer->AddActor(actor);
  parts_->stale = true;
}

std::optional<Vec3> HeartDrawing::arrow_tip_mm(std::size_t tool) const {
  if (tool >= parts_->tool_parts.size()) return std::nullopt;
  const ToolParts& parts = parts_->tool_parts[tool];
  if (parts.arrow->GetVisibility() == 0) return std::nullopt;
  return Vec3(parts.label->GetPosition());
}

}  // namespace beatlas::viewer
