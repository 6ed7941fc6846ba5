/// The whole build, as a program embeds it.
#include "pipeline/build/build_atlas.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "pipeline/build/report_facts.h"
#include "pipeline/phantom/render.h"
#include "runtime/atlas/atlas.h"
#include "runtime/base/error.h"

namespace beatlas::build {
namespace {
namespace fs = std::filesystem;

/// Notes what a build says.
class Noted : public Listener {
 public:
  std::atomic<bool> stop{false};
  std::string stop_in;  ///< the stage in which it is told to stop
  std::vector<std::string> stages;

  void stage(const std::string& name, const std::function<void(StageContext&)>& body) override {
    stages.push_back(name);
    if (name == stop_in) stop = true;
    StageContext context;
    context.cancel = &stop;
    body(context);
    times_.push_back({name, 0, 0});
  }
  void warn(std::string_view /*line*/) override {}
  void tell(std::string_view /*line*/) override {}
  void log(std::string_view /*line*/) override {}
  [[nodiscard]] const std::vector<report::StageTime>& times() const override { return times_; }

 private:
  std::vector<report::StageTime> times_;
};

Exam small_exam() {
  phantom::PhantomSpec spec = phantom::preset("small");
  spec.phases = 4;
  spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  StageContext context;
  Exam exam;
  exam.stack = phantom::render(phantom::Phantom(spec), context).cine;
  exam.source_format = "nifti";
  return exam;
}

/// Coarse, so that it does not take long, and from a prior in one view.
Recipe coarse() {
  Recipe recipe;
  recipe.segment.prior = BEATLAS_ONE_VIEW_PRIOR;
  recipe.registration.shape_mm = 2;
  recipe.field.voxel_mm = 3;
  recipe.mesh.edge_mm = 5;
  recipe.quality.max_volume_gap_percent = 100;
  return recipe;
}

/// Of this test alone: others run beside it.
struct Folder {
  fs::path path =
      fs::path(testing::TempDir()) /
      (std::string("build_atlas_") + testing::UnitTest::GetInstance()->current_test_info()->name() +
       "_" + std::to_string(getpid()));
  Folder() {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

Scene scene_of(const std::string& content) {
  Scene scene;
  scene.content = content;
  return scene;
}

std::shared_ptr<const atlas::SurfacePayload> endocardium_in(const fs::path& file) {
  atlas::Needs needs;
  needs.surfaces = {Structure::LvBlood};
  return atlas::Atlas::open(file, needs).surface(Structure::LvBlood);
}

/// That of a scene without the muscle is the one beside the muscle, but for what makes room there:
/// what a flat triangle cuts off a round wall, e^2 / (8 R) of edges of 5 mm and a radius of 20 mm,
/// and the gap between both.
void expect_same_place(const atlas::SurfacePayload& alone, const atlas::SurfacePayload& beside) {
  ASSERT_EQ(alone.triangles, beside.triangles);
  double sum_mm = 0;
  std::size_t count = 0;
  for (std::size_t p = 0; p < alone.positions.size(); ++p) {
    for (std::size_t v = 0; v < alone.positions[p].size(); ++v, ++count) {
      sum_mm += (alone.positions[p][v] - beside.positions[p][v]).norm();
    }
  }
  std::cout << "endocardium moves by " << sum_mm / static_cast<double>(count) << " mm\n";
  EXPECT_GT(sum_mm, 0);
  EXPECT_LT(sum_mm / static_cast<double>(count), 0.17);
}

/// By tetrahedra from the first vertex, unlike the library, which takes them from the origin.
double volume_ml(const atlas::SurfacePayload& surface, std::size_t phase) {
  const std::vector<Vec3f>& at = surface.positions[phase];
  double mm3 = 0;
  for (const auto& triangle : surface.triangles) {
    const Eigen::Vector3d a = (at[triangle[0]] - at[0]).cast<double>();
    const Eigen::Vector3d b = (at[triangle[1]] - at[0]).cast<double>();
    const Eigen::Vector3d c = (at[triangle[2]] - at[0]).cast<double>();
    mm3 += a.dot(b.cross(c)) / 6;
  }
  return mm3 / 1000;
}

TEST(BuildAtlas, MakesWhatTheSceneNeedsAndNoMore) {
  const Folder folder;
  const fs::path file = folder.path / "heart.beatlas";
  const Scene scene = scene_of("palpation");
  Noted listener;
  const Exam exam = small_exam();
  build_atlas(small_exam(), coarse(), scene, file, listener);
  EXPECT_EQ(listener.stages,
            (std::vector<std::string>{"segment", "register", "field", "mesh", "pack"}));
  const atlas::Manifest manifest = atlas::Atlas::open(file, {}).manifest();
  EXPECT_EQ(manifest.rr_interval_s, exam.stack.rr_interval_s);
  EXPECT_EQ(manifest.source_size, exam.stack.grid().size);
  std::set<std::string> kinds;
  for (const atlas::Item& item : manifest.items) kinds.insert(item.kind);
  EXPECT_EQ(kinds.count("field"), 1U);
  EXPECT_EQ(kinds.count("volume"), 0U) << "nobody looks at the images";
  // What the report compares with the labels is of the package's own surfaces.
  const auto endocardium = endocardium_in(file);
  ASSERT_NE(endocardium, nullptr);
  const report::ReportPackage told =
      package_facts(pack_contents(manifest, 1, {},
                                  enclosed_volumes(atlas::Atlas::open(
                                      file, {.fields = {}, .surfaces = {Structure::LvBlood}}))),
                    "");
  ASSERT_EQ(told.enclosed.size(), 1U);
  EXPECT_EQ(told.enclosed[0].structure, Structure::LvBlood);
  ASSERT_EQ(told.enclosed[0].volume_ml.size(), endocardium->positions.size());
  for (std::size_t p = 0; p < endocardium->positions.size(); ++p) {
    EXPECT_NEAR(told.enclosed[0].volume_ml[p], volume_ml(*endocardium, p), 1e-3);
  }
  double least = 1e9;
  double most = 0;
  for (const atlas::StructureEntry& structure : manifest.structures) {
    if (structure.name != "lv_blood") continue;
    for (const double ml : structure.volume_ml) {
      least = std::min(least, ml);
      most = std::max(most, ml);
    }
  }
  EXPECT_GT(most, 1.3 * least) << "the heart beats";

  const fs::path whole = folder.path / "whole.beatlas";
  build_atlas(small_exam(), coarse(), scene_of("anatomy"), whole, listener);
  expect_same_place(*endocardium_in(file), *endocardium_in(whole));
}

TEST(BuildAtlas, LeavesTheFileAloneWhereThereIsNoHeartOrItIsStopped) {
  const Folder folder;
  const fs::path file = folder.path / "heart.beatlas";
  std::ofstream(file) << "the old one";
  Exam nothing = small_exam();
  for (std::vector<float>& phase : nothing.stack.images.phases) {
    std::fill(phase.begin(), phase.end(), 100.F);
  }
  Noted listener;
  try {
    build_atlas(std::move(nothing), coarse(), {}, file, listener);
    ADD_FAILURE() << "an exam without a heart was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput) << error.what();
    // Of an exam that was made no place is known.
    EXPECT_EQ(std::string(error.what()).rfind("no heart found", 0), 0U) << error.what();
  }
  Noted stopped;
  stopped.stop_in = "field";
  try {
    build_atlas(small_exam(), coarse(), {}, file, stopped);
    ADD_FAILURE() << "it was told to stop";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Machine) << error.what();
  }
  EXPECT_EQ(stopped.stages.back(), "field");
  std::string text;
  std::getline(std::ifstream(file), text);
  EXPECT_EQ(text, "the old one");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()), 1);
}

}  // namespace
}  // namespace beatlas::build
