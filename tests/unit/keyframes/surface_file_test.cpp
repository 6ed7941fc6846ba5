#include "pipeline/formats/surface_file.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

class Folder {
 public:
  Folder() { std::filesystem::create_directories(path_); }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::filesystem::path write(const std::string& bytes) const {
    std::ofstream(path_ / "a.mesh", std::ios::binary) << bytes;
    return path_ / "a.mesh";
  }

 private:
  std::filesystem::path path_ = std::filesystem::temp_directory_path() /
                                ("beatlas_surface_file_test_" + std::to_string(::getpid()));
};

// A tetrahedron's corners and faces.
const std::vector<Vec3> kCorners{{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0, 0, 4.5}};
const std::vector<std::array<std::uint32_t, 3>> kFaces{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

std::string binary_stl(std::uint32_t told) {
  std::string out(80, ' ');
  out.replace(0, 5, "solid");  // though binary
  const auto add = [&out](const auto* from, std::size_t bytes) {
    const auto* begin = reinterpret_cast<const char*>(from);
    out.insert(out.end(), begin, begin + bytes);
  };
  add(&told, 4);
  for (const auto& face : kFaces) {
    const std::array<char, 12> normal{};
    add(normal.data(), normal.size());
    for (const std::uint32_t corner : face) {
      const Vec3f at = kCorners[corner].cast<float>();
      add(at.data(), 12);
    }
    add(normal.data(), 2);
  }
  return out;
}

void expect_tetrahedron(const SurfaceMesh& mesh) {
  ASSERT_EQ(mesh.points.size(), 4U);
  ASSERT_EQ(mesh.triangles.size(), 4U);
  for (std::size_t n = 0; n < 4; ++n) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(mesh.points[mesh.triangles[n][c]], kCorners[kFaces[n][c]]);
    }
  }
}

TEST(SurfaceFile, ReadsObjWithWhatEditorsAdd) {
  const Folder folder;
  expect_tetrahedron(
      read_obj(folder.write("# made by hand\r\nmtllib a.mtl\r\nv 0 0 0\r\n"
                            "v +2 0 0 1\nv 0 3e0 0\nv 0 0 4.5\nvn 0 0 1\n"
                            "f 1/1/1 3/2/1 2/3/1\nf 1//1 2//1 4//1\ns off\n"
                            "f 1 4 3\nf -3 -2 -1\n")));
  const SurfaceMesh fan = read_obj(folder.write("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4"));
  EXPECT_EQ(fan.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(SurfaceFile, WeldsBothKindsOfStl) {
  const Folder folder;
  expect_tetrahedron(read_stl(folder.write(binary_stl(4))));
  std::string text = "solid a\n";
  for (const auto& face : kFaces) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (const std::uint32_t corner : face) {
      text += "   vertex";
      for (const double value : kCorners[corner]) {
        text += ' ';
        text += std::to_string(value);
      }
      text += "\n";
    }
    text += "  endloop\n endfacet\n";
  }
  expect_tetrahedron(read_stl(folder.write(text + "endsolid a\n")));
}

TEST(SurfaceFile, NamesTheFileAndWhatIsWrong) {
  const Folder folder;
  const auto said = [&](const auto& read, const std::string& bytes) -> std::string {
    try {
      (void)read(folder.write(bytes));
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      EXPECT_NE(std::string(error.what()).find("a.mesh: "), std::string::npos);
      return error.what();
    }
    return "";
  };
  EXPECT_NE(said(read_obj, "v 0 0 0\n").find("no triangles"), std::string::npos);
  EXPECT_NE(said(read_obj, "v 0 0 nan\n").find("line 1"), std::string::npos);
  EXPECT_NE(said(read_obj, "v 0 0 0\nv 1 0 0\nf 1 2 7\n").find("point 7 of 2"), std::string::npos);
  EXPECT_NE(said(read_obj, "v 0 0 0\nf 1 1 -2\n").find("line 2"), std::string::npos);
  EXPECT_NE(said(read_obj, "f 1 2\n").find("line 1"), std::string::npos);
  EXPECT_NE(said(read_stl, "ply\n").find("no STL"), std::string::npos);
  EXPECT_NE(said(read_stl, binary_stl(4000000000)).find("triangles"), std::string::npos);
  EXPECT_NE(said(read_stl, "solid\nvertex 0 0 0\n").find("within a facet"), std::string::npos);
  EXPECT_NE(said(read_stl, "").find("cut short"), std::string::npos);
  EXPECT_THROW((void)read_obj("/nowhere/a.obj"), Error);
}

}  // namespace
}  // namespace beatlas::formats
