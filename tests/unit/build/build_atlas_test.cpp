/// The whole build, as a program embeds it.
#include "pipeline/build/build_atlas.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

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

/// Coarse, so that it does not take long.
Recipe coarse() {
  Recipe recipe;
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

TEST(BuildAtlas, MakesWhatTheSceneNeedsAndNoMore) {
  const Folder folder;
  const fs::path file = folder.path / "heart.beatlas";
  Scene scene;
  scene.content = "palpation";
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
