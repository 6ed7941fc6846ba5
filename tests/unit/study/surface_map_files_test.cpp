#include <fstream>

#include <gtest/gtest.h>

#include "pipeline/study/files.h"
#include "pipeline/study/stage_files.h"
#include "runtime/base/error.h"
#include "tests/unit/study/temporary_folder.h"

namespace beatlas::study {
namespace {

namespace fs = std::filesystem;

SurfaceCycle surface_of(Structure structure) {
  SurfaceCycle surface{structure, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, {}};
  surface.positions.assign(2, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  return surface;
}

/// In steps of the file.
SurfaceMap made() {
  return {Structure::LvBlood,
          {0, 1, 0.3333F, 0.0001F},
          {0, 6.2831F, 3.1416F, 1.2345F},
          {17, 1, 12, 9},
          {{0, 9.87F, 12.34F, 0.01F}, {7.77F, 0, 100, 55.5F}}};
}

class SurfaceMapFiles : public ::testing::Test {
 protected:
  SurfaceMapFiles() {
    make_folder(folder_.path() / "mesh");
    EXPECT_EQ(write_surface_maps(folder_.path(), {made()}), FileList{"mesh/map_lv_blood.csv"});
    std::ifstream stream(file_, std::ios::binary);
    text_ = {std::istreambuf_iterator<char>(stream), {}};
  }

  std::vector<SurfaceMap> read() {
    return read_surface_maps(folder_.path(),
                             {surface_of(Structure::Heart), surface_of(Structure::LvBlood)});
  }

  /// What is said of the file with `from` once replaced by `to`.
  std::string refusal(const std::string& from, const std::string& to) {
    std::string text = text_;
    text.replace(text.find(from), from.size(), to);
    std::ofstream(file_, std::ios::binary) << text;
    try {
      (void)read();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      return error.what();
    }
    return "accepted";
  }

  TemporaryFolder folder_;
  fs::path file_ = folder_.path() / "mesh" / "map_lv_blood.csv";
  std::string text_;
};

TEST_F(SurfaceMapFiles, ComeBackBitByBit) {
  const std::vector<SurfaceMap> maps = read();
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0].structure, Structure::LvBlood);
  EXPECT_EQ(maps[0].long_axis, made().long_axis);
  EXPECT_EQ(maps[0].angle_rad, made().angle_rad);
  EXPECT_EQ(maps[0].segment, made().segment);
  EXPECT_EQ(maps[0].thickness_mm, made().thickness_mm);
}

TEST_F(SurfaceMapFiles, OfTheRvHaveNoSegments) {
  SurfaceMap map = made();
  map.structure = Structure::RvBlood;
  map.segment = {0, 0, 0, 0};
  EXPECT_EQ(write_surface_maps(folder_.path(), {map}), FileList{"mesh/map_rv_blood.csv"});
  const auto read_rv = [&] {
    return read_surface_maps(folder_.path(), {surface_of(Structure::RvBlood)});
  };
  ASSERT_EQ(read_rv().size(), 1U);
  EXPECT_EQ(read_rv()[0].segment, map.segment);
  EXPECT_EQ(read_rv()[0].thickness_mm, map.thickness_mm);
  map.segment[2] = 3;
  (void)write_surface_maps(folder_.path(), {map});
  EXPECT_THROW((void)read_rv(), Error);
}

TEST_F(SurfaceMapFiles, MayBePaintedOverAndSavedByAnOfficeProgram) {
  EXPECT_EQ(refusal("2,0.3333,3.1416,12,", "2,0.3333,3.1416,7,"), "accepted");
  EXPECT_EQ(read()[0].segment[2], 7);
  std::string text;
  for (const char letter : text_) {
    if (letter == '\n') text += '\r';
    text += letter;
  }
  std::ofstream(file_, std::ios::binary) << text;
  EXPECT_EQ(read()[0].thickness_mm, made().thickness_mm);
}

TEST_F(SurfaceMapFiles, ThatFitNoSurfaceAreRefusedByLine) {
  EXPECT_NE(refusal("1,1.0000", "1,1.5000").find("map_lv_blood.csv: line 3: "), std::string::npos);
  EXPECT_NE(refusal("1,1.0000", "1,1.5000").find("long_axis"), std::string::npos);
  EXPECT_NE(refusal("6.2831", "6.2832").find("angle_rad"), std::string::npos);
  EXPECT_NE(refusal(",17,", ",18,").find("segment"), std::string::npos);
  EXPECT_NE(refusal(",17,", ",1.7,").find("segment"), std::string::npos);
  EXPECT_NE(refusal("9.87", "-9.87").find("thicknesses"), std::string::npos);
  EXPECT_NE(refusal("9.87", "nan").find("thicknesses"), std::string::npos);
  EXPECT_NE(refusal("9.87", "thick").find("6 numbers"), std::string::npos);
  EXPECT_NE(refusal("9.87", "9.87,1").find("6 numbers"), std::string::npos);
  EXPECT_NE(refusal("\n3,", "\n2,").find("vertex 3"), std::string::npos);
  EXPECT_NE(refusal("_001", "_002").find("line 1: "), std::string::npos);
  EXPECT_NE(refusal("55.50\n", "55.50\n4,0,0,1,1,1\n").find("one too many"), std::string::npos);
  const std::size_t last = text_.find("\n3,");
  EXPECT_NE(refusal(text_.substr(last + 1), "").find("line 5: is missing"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::study
