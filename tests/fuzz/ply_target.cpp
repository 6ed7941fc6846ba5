// Meshes that an editor may have saved.
#include "pipeline/study/ply.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  const MemoryFolder folder;
  study::TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  study::write_ply(folder.path() / "a.ply", mesh);
  return {read_file(folder.path() / "a.ply"),
          "ply\nformat ascii 1.0\ncomment x\nelement vertex 3\nproperty double x\nproperty double "
          "y\nproperty double z\nproperty uchar red\nelement face 1\nproperty list uchar int "
          "vertex_index\nend_header\n0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2\n"};
}
std::vector<std::string> tokens() {
  return {"element vertex ",
          "element face ",
          "property list double double vertex_indices\n",
          "property float x\n",
          "property double x\n",
          "end_header\n",
          "format ascii 1.0\n",
          "element other 1000000\n"};
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  static const fuzz::MemoryFolder folder;
  const auto file = folder.write("a.ply", fuzz::text(data, size));
  fuzz::only_errors([&] {
    const auto mesh = study::read_ply(file);
    for (const auto& triangle : mesh.triangles) {
      for (const auto corner : triangle) fuzz::require(corner < mesh.vertices.size());
    }
  });
  return 0;
}
