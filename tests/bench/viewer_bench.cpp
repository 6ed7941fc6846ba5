/// Frame time of a package's beating surfaces and volume, beside plain VTK that draws the same
/// triangles, or the same samples by the same mapper, standing still.
///
///   viewer_bench PACKAGE [FRAMES]
///
/// Prints medians [ms] of wall time, 800 x 600, without captions. Then the servo's ticks for ten
/// seconds without a picture and ten beside a window of 1180 x 760 that draws as often as it can,
/// and how old a tick is when its picture is there.

#include <QApplication>
#include <QSurfaceFormat>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include <QVTKOpenGLNativeWidget.h>
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include "runtime/viewer/display.h"
#include "runtime/viewer/drawing.h"
#include "runtime/viewer/heart_window.h"
#include "runtime/viewer/stills.h"
#include "runtime/viewer/surface_motion.h"

using namespace beatlas;

namespace {

double median_ms(int frames, const std::function<void(int)>& draw) {
  for (int n = 0; n < 3; ++n) draw(n);
  std::vector<double> times;
  for (int n = 0; n < frames; ++n) {
    const auto start = std::chrono::steady_clock::now();
    draw(n);
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
            .count());
  }
  std::nth_element(times.begin(), times.begin() + frames / 2, times.end());
  return times[static_cast<std::size_t>(frames / 2)];
}

void aim(vtkRenderer* renderer, const viewer::CameraPose& pose) {
  vtkCamera* camera = renderer->GetActiveCamera();
  const Vec3 at = pose.focus_mm + 500 * pose.towards_viewer;
  camera->ParallelProjectionOn();
  camera->SetFocalPoint(pose.focus_mm.x(), pose.focus_mm.y(), pose.focus_mm.z());
  camera->SetPosition(at.x(), at.y(), at.z());
  camera->SetViewUp(pose.up.x(), pose.up.y(), pose.up.z());
  camera->SetParallelScale(pose.height_mm / 2);
  camera->SetClippingRange(1, 1000);
}

// Opaque in both, so that what is compared is the same work.
double plain_surfaces_ms(viewer::HeartDrawing& drawing, const atlas::Atlas& atlas, int frames) {
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetSize(800, 600);
  window->SetMultiSamples(4);
  vtkNew<vtkRenderer> renderer;
  window->AddRenderer(renderer);
  for (const Structure structure : kAllStructures) {
    const auto surface = atlas.surface(structure);
    if (!surface) continue;
    const viewer::SurfaceMotion motion(surface);
    const std::vector<Vec3f> vertices = drawing.drawn_vertices(structure);
    std::vector<Vec3f> normals(vertices.size());
    motion.normals_of(vertices, normals);
    vtkNew<vtkPoints> points;
    vtkNew<vtkFloatArray> point_normals;
    point_normals->SetNumberOfComponents(3);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      points->InsertNextPoint(vertices[v].x(), vertices[v].y(), vertices[v].z());
      point_normals->InsertNextTuple3(normals[v].x(), normals[v].y(), normals[v].z());
    }
    vtkNew<vtkCellArray> cells;
    for (const auto& triangle : surface->triangles) {
      const std::array<vtkIdType, 3> ids{triangle[0], triangle[1], triangle[2]};
      cells->InsertNextCell(3, ids.data());
    }
    vtkNew<vtkPolyData> mesh;
    mesh->SetPoints(points);
    mesh->SetPolys(cells);
    mesh->GetPointData()->SetNormals(point_normals);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(mesh);
    vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    actor->GetProperty()->SetInterpolationToPhong();
    renderer->AddActor(actor);
  }
  aim(renderer, drawing.camera());
  return median_ms(frames, [&](int) { window->Render(); });
}

// Beating and turned by 3 degrees a picture, as under the mouse; whole, and cut in half.
void measure_turning(viewer::HeartDrawing& drawing, int frames) {
  const viewer::CameraPose before = drawing.camera();
  drawing.set_moving(true);
  const auto turn = [&](int n) {
    viewer::CameraPose pose = drawing.camera();
    pose.towards_viewer = Eigen::AngleAxisd(0.05, pose.up) * pose.towards_viewer;
    drawing.set_camera(pose);
    drawing.set_beats(0.031 * n);
    drawing.render();
  };
  const double whole = median_ms(frames, turn);
  const auto cut = [&](int n) {
    drawing.set_cut(viewer::standard_cut(drawing.frame(), "four-chamber", n % 21 - 10));
    turn(n);
  };
  const double halved = median_ms(frames, cut);
  drawing.set_cut(std::nullopt);
  drawing.set_camera(before);
  drawing.set_moving(false);
  std::printf(
      "turned while they beat: surfaces %.1f ms; cut, with the image, the plane moved %.1f\n",
      whole, halved);
  (void)std::fflush(stdout);
}

void print_ticks(const char* what, const viewer::LiveTouch& live) {
  const viewer::TickTimes& compute = live.compute_times();
  const viewer::TickTimes& late = live.late_times();
  std::printf(
      "servo %s: %zu ticks; a tick takes p50 %.1f, p99 %.1f, p99.9 %.1f us; begins late by p50 "
      "%.0f, p99 %.0f, p99.9 %.0f us\n",
      what, static_cast<std::size_t>(compute.count()), compute.quantile_us(0.5),
      compute.quantile_us(0.99), compute.quantile_us(0.999), late.quantile_us(0.5),
      late.quantile_us(0.99), late.quantile_us(0.999));
  (void)std::fflush(stdout);
}

// The simulated hand palpates: ticks in touch and out of it.
void measure_servo(const viewer::OpenedHeart& heart) {
  constexpr auto kMeasured = std::chrono::seconds(10);
  constexpr auto kStart = std::chrono::seconds(1);
  int count = 1;
  std::string name = "viewer_bench";
  char* names[] = {name.data(), nullptr};
  QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
  QApplication application(count, names);
  viewer::ViewOptions options;
  options.view = "left";
  viewer::HeartWindow window(options);
  window.resize(1180, 760);
  window.show_heart(viewer::loaded_heart(heart, "", viewer::ViewOptions{}));
  window.use_device("simulated", "");
  while (window.live()->device() == "mouse") QApplication::processEvents();
  std::this_thread::sleep_for(kStart);
  window.live()->forget_times();
  std::this_thread::sleep_for(kMeasured);
  print_ticks("alone", *window.live());

  window.show();
  std::vector<double> lags;
  const auto draw_for = [&](std::chrono::seconds time) {
    const auto end = std::chrono::steady_clock::now() + time;
    while (std::chrono::steady_clock::now() < end) {
      QApplication::processEvents();  // the window's timer draws
      if (lags.empty() || lags.back() != window.lag_ms()) lags.push_back(window.lag_ms());
    }
  };
  draw_for(kStart);
  window.live()->forget_times();
  lags.clear();
  draw_for(kMeasured);
  print_ticks("beside the window", *window.live());
  std::sort(lags.begin(), lags.end());
  std::printf("window: %zu pictures in 10 s; a tick is p50 %.0f, p99 %.0f ms old in its picture\n",
              lags.size(), lags[lags.size() / 2], lags[lags.size() * 99 / 100]);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::cerr << "usage: viewer_bench PACKAGE [FRAMES]\n";
    return 2;
  }
  const int frames = argc > 2 ? std::max(1, std::stoi(argv[2])) : 31;
  const viewer::Display display;
  const viewer::OpenedHeart heart = viewer::open_heart(argv[1]);
  viewer::HeartDrawing drawing(heart.atlas, heart.field, {.caption = false});
  std::size_t vertices = 0;
  for (const Structure structure : kAllStructures) {
    vertices += drawing.drawn_vertices(structure).size();
    viewer::Look look = drawing.look(structure);
    look.opacity = 1;
    drawing.set_look(structure, look);
  }
  drawing.set_camera(viewer::standard_view(drawing.frame(), "anterior"));
  (void)drawing.picture(800, 600);
  std::printf("%zu vertices, drawn by %s\n", vertices, drawing.renderer().c_str());
  const auto beat = [&](int n) {
    drawing.set_beats(0.031 * n);
    drawing.render();
  };
  const double still = median_ms(frames, [&](int) { drawing.render(); });
  const double beating = median_ms(frames, beat);
  const double plain = plain_surfaces_ms(drawing, *heart.atlas, frames);
  std::printf(
      "surfaces: beating %.1f ms, standing still %.1f, plain VTK standing still %.1f: %.2fx\n",
      beating, still, plain, beating / plain);
  (void)std::fflush(stdout);
  measure_turning(drawing, frames);
  if (heart.field) measure_servo(heart);
  if (!drawing.has_volume()) return 0;
  for (const Structure structure : kAllStructures) {
    viewer::Look look = drawing.look(structure);
    look.visible = false;
    drawing.set_look(structure, look);
  }
  drawing.set_volume(viewer::VolumePreset::Muscle);
  const double volume_still = median_ms(frames, [&](int) { drawing.render(); });
  const double volume_beating = median_ms(frames, beat);
  drawing.set_moving(true);
  const double volume_moving = median_ms(frames, beat);
  const viewer::DrawTimes moving = drawing.times();
  // Standing still the mapper is VTK's own at these settings; what beating adds is ours.
  std::printf(
      "volume: beating %.1f ms, VTK's mapper standing still %.1f: %.2fx; coarse while it moves "
      "%.1f (the last: %.1f to update, %.1f to draw)\n",
      volume_beating, volume_still, volume_beating / volume_still, volume_moving, moving.update_ms,
      moving.render_ms);
  return 0;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
