#include "pipeline/study/ply.h"

#include <gtest/gtest.h>

#include "pipeline/study/files.h"
#include "runtime/base/error.h"
#include "tests/unit/study/temporary_folder.h"

namespace beatlas::study {
namespace {

const TriangleMesh kTetrahedron{
    {{0.1F, 0, 0}, {1, 1.0F / 3, 0}, {0, 1, -2e-7F}, {0, 0, 12345.678F}},
    {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};

TriangleMesh read_text(const std::string& text) {
  const TemporaryFolder folder;
  write_text(folder.path() / "a.ply", text);
  return read_ply(folder.path() / "a.ply");
}

TEST(Ply, ReadsBackEveryBit) {
  const TemporaryFolder folder;
  write_ply(folder.path() / "a.ply", kTetrahedron);
  const TriangleMesh mesh = read_ply(folder.path() / "a.ply");
  EXPECT_EQ(mesh.vertices, kTetrahedron.vertices);
  EXPECT_EQ(mesh.triangles, kTetrahedron.triangles);
}

TEST(Ply, PassesOverWhatMeshEditorsAdd) {
  const TriangleMesh mesh = read_text(
      "ply\r\nformat ascii 1.0\ncomment made elsewhere\nelement vertex 3\nproperty double x\n"
      "property double y\nproperty double z\nproperty float nx\nproperty uchar red\n"
      "element face 1\nproperty uchar quality\nproperty list uchar int vertex_index\n"
      "element edge 1\nproperty int a\nproperty int b\nend_header\n"
      "0 0 0 1 255\n1 0 0 1 255\n0 1.5 0 1 255\n7 3 0 1 2\n0 1\n");
  ASSERT_EQ(mesh.vertices.size(), 3U);
  EXPECT_EQ(mesh.vertices[2], Vec3f(0, 1.5F, 0));
  ASSERT_EQ(mesh.triangles.size(), 1U);
  EXPECT_EQ(mesh.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
}

TEST(Ply, RefusesWhatIsNoTriangleMesh) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string vertices = "0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_NO_THROW((void)read_text(head + vertices + "3 0 1 2\n"));
  for (const std::string& text :
       {std::string(), std::string("ply\n"), head, head + vertices, head + vertices + "4 0 1 2 0\n",
        head + vertices + "3 0 1 3\n", head + vertices + "3 0 1 -1\n",
        head + vertices + "3 0 1 .5\n", head + "0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n",
        std::string("ply\nformat binary_big_endian 1.0\nend_header\n"),
        std::string("ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\n"
                    "end_header\n")}) {
    EXPECT_THROW((void)read_text(text), Error) << text;
  }
}

TEST(Ply, RefusesEveryCut) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.ply";
  write_ply(file, kTetrahedron);
  const std::vector<std::byte> whole = read_bytes(file);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write_bytes(file, std::span(whole).first(size));
    EXPECT_THROW((void)read_ply(file), Error) << size;
  }
}

}  // namespace
}  // namespace beatlas::study
