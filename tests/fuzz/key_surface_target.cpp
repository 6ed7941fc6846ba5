// Surfaces of other programs. The first byte says which kind: o OBJ, s STL.
#include "pipeline/formats/surface_file.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
namespace {

template <class Number>
void append(std::string& bytes, Number value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string binary_stl(const std::string& head) {
  constexpr float kCorners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  constexpr int kTriangles[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  std::string out = head + std::string(80 - head.size(), ' ');
  append(out, std::uint32_t{4});
  for (const auto& triangle : kTriangles) {
    for (int n = 0; n < 3; ++n) append(out, 0.0F);
    for (const int corner : triangle) {
      for (const float value : kCorners[corner]) append(out, value);
    }
    append(out, std::uint16_t{0});
  }
  return out;
}

}  // namespace

std::vector<std::string> seeds() {
  return {
      "o# made\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 +1e0\nf 1 3 2\nf 1/1/1 2//2 4/4\n"
      "f -3 -2 -1\nf 1 4 3\n",
      "ov 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nf 1 2 3 4\r\n", "s" + binary_stl("made"),
      "s" + binary_stl("solid made"),
      "ssolid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
      "endloop\nendfacet\nendsolid a\n"};
}
std::vector<std::string> tokens() {
  return {
      "v 1 2 3\n", "f 1 2 3\n", "f -1 -2 -3\n", "vertex 1 2 3\n", "endfacet\n",          "solid",
      "1e308",     "nan",       "inf",          "2147483648",     "-9223372036854775808"};
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  if (size == 0) return 0;
  static const fuzz::MemoryFolder folder;
  const auto file = folder.write("a", fuzz::text(data + 1, size - 1));
  fuzz::only_errors([&] {
    const auto mesh = data[0] == 's' ? formats::read_stl(file) : formats::read_obj(file);
    fuzz::require(!mesh.triangles.empty());
    for (const auto& point : mesh.points) fuzz::require(point.allFinite());
    for (const auto& triangle : mesh.triangles) {
      for (const auto corner : triangle) fuzz::require(corner < mesh.points.size());
    }
  });
  return 0;
}
