#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include "pipeline/field/field.h"
#include "runtime/base/error.h"
#include "tests/unit/field/closed_form.h"

namespace beatlas::field {
namespace {

class VdbFile : public ::testing::Test {
 protected:
  VdbFile() {
    folder_ = std::filesystem::temp_directory_path() /
              ("vdb_file_test_" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  ~VdbFile() override { std::filesystem::remove_all(folder_); }

  static FieldCycle twelve_phases() {
    ShapeCycle shape;
    shape.structure = Structure::LvMyocardium;
    shape.level.grid = closed_form::lattice({-14, -14, -14}, {15, 14, 14}, 1.0);
    for (int p = 0; p < 12; ++p) {
      shape.level.phases.push_back(closed_form::sampled(
          shape.level.grid, [&](const Vec3& x) { return x.norm() - 8.0 - 0.1 * p; }));
    }
    FieldOptions options;
    options.inner_mm = 4.3;
    options.outer_mm = 3.1;
    StageContext context;
    return build_field(shape, options, context);
  }

  static std::string bytes(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }

  std::filesystem::path folder_;
};

TEST_F(VdbFile, RoundTripIsExact) {
  const FieldCycle field = twelve_phases();
  write_vdb(folder_ / "f.vdb", field);
  const FieldCycle back = read_vdb(folder_ / "f.vdb");
  EXPECT_EQ(back.structure, field.structure);
  EXPECT_TRUE(back.distance_mm.grid == field.distance_mm.grid);
  EXPECT_EQ(back.distance_mm.phases, field.distance_mm.phases);
  EXPECT_EQ(back.volume_ml, field.volume_ml);
  EXPECT_EQ(back.voxel_mm, field.voxel_mm);
  EXPECT_EQ(back.inner_mm, field.inner_mm);
  EXPECT_EQ(back.outer_mm, field.outer_mm);
}

TEST_F(VdbFile, OpenVdbReadsAGridAPhaseThatIsActiveInTheBandOnly) {
  const FieldCycle field = twelve_phases();
  write_vdb(folder_ / "f.vdb", field);
  openvdb::initialize();
  openvdb::io::File file((folder_ / "f.vdb").string());
  file.open(false);
  EXPECT_EQ(file.getGrids()->size(), 12U);
  const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("lv_myocardium_11"));
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->background(), 3.1F);
  EXPECT_EQ(grid->getGridClass(), openvdb::GRID_LEVEL_SET);
  // The ball of phase 11 has a radius of 9.1 mm; world coordinates are workspace [mm].
  openvdb::FloatGrid::ConstAccessor accessor = grid->getConstAccessor();
  const auto at = [&](double mm) {
    return openvdb::Coord::round(grid->worldToIndex(openvdb::Vec3d(mm, 0, 0)));
  };
  EXPECT_TRUE(accessor.isValueOn(at(9)));
  EXPECT_FALSE(accessor.isValueOn(at(0)));
  EXPECT_FLOAT_EQ(accessor.getValue(at(0)), -4.3F);
  EXPECT_FALSE(accessor.isValueOn(at(15)));
  std::size_t in_band = 0;
  for (float v : field.distance_mm.phases[11]) in_band += v > -4.3F && v < 3.1F ? 1 : 0;
  EXPECT_EQ(grid->activeVoxelCount(), in_band);
}

TEST_F(VdbFile, TheSameFieldGivesTheSameBytesAndLeavesNothingElse) {
  const FieldCycle field = twelve_phases();
  write_vdb(folder_ / "a.vdb", field);
  write_vdb(folder_ / "b.vdb", field);
  EXPECT_EQ(bytes(folder_ / "a.vdb"), bytes(folder_ / "b.vdb"));
  int files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_)) ++files;
  EXPECT_EQ(files, 2);
}

TEST_F(VdbFile, DamagedAndForeignFilesAreRefused) {
  const auto code = [&](const std::filesystem::path& file) {
    try {
      (void)read_vdb(file);
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(file.filename().string()), std::string::npos);
      return error.code();
    }
    ADD_FAILURE() << "no error";
    return ErrorCode::Usage;
  };
  EXPECT_EQ(code(folder_ / "missing.vdb"), ErrorCode::InvalidInput);
  std::ofstream(folder_ / "text.vdb") << "not a volume";
  EXPECT_EQ(code(folder_ / "text.vdb"), ErrorCode::InvalidInput);
  write_vdb(folder_ / "good.vdb", twelve_phases());
  const std::string good = bytes(folder_ / "good.vdb");
  std::ofstream(folder_ / "short.vdb", std::ios::binary) << good.substr(0, good.size() / 2);
  EXPECT_EQ(code(folder_ / "short.vdb"), ErrorCode::InvalidInput);
}

TEST_F(VdbFile, AnUnwritablePlaceIsMachineTrouble) {
  try {
    write_vdb(folder_ / "no" / "such" / "folder.vdb", twelve_phases());
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Machine);
  }
}

}  // namespace
}  // namespace beatlas::field
