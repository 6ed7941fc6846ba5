#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "pipeline/field/surface.h"

namespace beatlas::field {
namespace {

// Corner c of a cube is at (c & 1, c >> 1 & 1, c >> 2 & 1). Each tetrahedron is a path from corner
// 0 to corner 7 along the axes; shared faces agree between cubes because all cubes are cut alike.
constexpr std::array<std::array<int, 4>, 6> kTetrahedra{
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

class Marcher {
 public:
  Marcher(const Grid& grid, const std::vector<float>& samples)
      : grid_(grid),
        samples_(samples),
        // Keeps every vertex off the lattice's nodes, where triangles would have no area.
        least_(0.05 * grid.spacing_mm().x()) {}

  TriangleSoup run() {
    for (int k = 0; k + 1 < grid_.size[2]; ++k) {
      for (int j = 0; j + 1 < grid_.size[1]; ++j) {
        for (int i = 0; i + 1 < grid_.size[0]; ++i) cube(i, j, k);
      }
    }
    return std::move(out_);
  }

 private:
  double value(std::size_t node) const {
    const double v = samples_[node];
    return v < 0 ? std::min(v, -least_) : std::max(v, least_);
  }

  void cube(int i, int j, int k) {
    int inside = 0;
    for (int c = 0; c < 8; ++c) {
      corner_[static_cast<std::size_t>(c)] =
          grid_.offset(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1));
      inside += samples_[corner_[static_cast<std::size_t>(c)]] < 0 ? 1 : 0;
    }
    if (inside == 0 || inside == 8) return;
    cell_ = {i, j, k};
    for (const std::array<int, 4>& tetrahedron : kTetrahedra) cut(tetrahedron);
  }

  // Six times the signed volume of corners a, b, c, d.
  static int orientation(int a, int b, int c, int d) {
    const auto edge = [&](int to, int bit) { return (to >> bit & 1) - (a >> bit & 1); };
    return edge(b, 0) * (edge(c, 1) * edge(d, 2) - edge(c, 2) * edge(d, 1)) -
           edge(b, 1) * (edge(c, 0) * edge(d, 2) - edge(c, 2) * edge(d, 0)) +
           edge(b, 2) * (edge(c, 0) * edge(d, 1) - edge(c, 1) * edge(d, 0));
  }

  void cut(const std::array<int, 4>& tetrahedron) {
    std::array<int, 4> in{};
    std::array<int, 4> out{};
    std::size_t in_count = 0;
    std::size_t out_count = 0;
    for (int c : tetrahedron) {
      if (samples_[corner_[static_cast<std::size_t>(c)]] < 0) {
        in[in_count++] = c;
      } else {
        out[out_count++] = c;
      }
    }
    if (in_count == 1) {
      add(vertex(in[0], out[0]), vertex(in[0], out[1]), vertex(in[0], out[2]),
          orientation(in[0], out[0], out[1], out[2]) > 0);
    } else if (in_count == 3) {
      add(vertex(out[0], in[0]), vertex(out[0], in[1]), vertex(out[0], in[2]),
          orientation(out[0], in[0], in[1], in[2]) < 0);
    } else if (in_count == 2) {
      const bool ahead = orientation(in[0], in[1], out[0], out[1]) > 0;
      const std::uint32_t a = vertex(in[0], out[0]);
      const std::uint32_t b = vertex(in[0], out[1]);
      const std::uint32_t c = vertex(in[1], out[1]);
      const std::uint32_t d = vertex(in[1], out[0]);
      add(a, b, c, ahead);
      add(a, c, d, ahead);
    }
  }

  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c, bool ahead) {
    if (ahead) {
      out_.triangles.push_back({a, b, c});
    } else {
      out_.triangles.push_back({a, c, b});
    }
  }

  // The vertex on the edge between two corners; along a path the lower corner's bits are a subset
  // of the upper's, so the lower node and the bits between name the edge.
  std::uint32_t vertex(int a, int b) {
    const int low = std::min(a, b);
    const int high = std::max(a, b);
    const std::size_t low_node = corner_[static_cast<std::size_t>(low)];
    const std::size_t high_node = corner_[static_cast<std::size_t>(high)];
    const std::uint64_t key = low_node * 8 + static_cast<std::uint64_t>(high ^ low);
    const auto [found, is_new] =
        vertices_.try_emplace(key, static_cast<std::uint32_t>(out_.points.size()));
    if (is_new) {
      const double from = value(low_node);
      const double to = value(high_node);
      const double share = from / (from - to);
      const auto along = [&](int axis) {
        const int start = low >> axis & 1;
        return cell_[static_cast<std::size_t>(axis)] + start + share * ((high >> axis & 1) - start);
      };
      out_.points.push_back(grid_.mm(along(0), along(1), along(2)));
    }
    return found->second;
  }

  const Grid& grid_;
  const std::vector<float>& samples_;
  double least_;
  std::array<std::size_t, 8> corner_{};
  Index3 cell_{};
  std::unordered_map<std::uint64_t, std::uint32_t> vertices_;
  TriangleSoup out_;
};

}  // namespace

TriangleSoup extract_surface(const FieldCycle& field, int phase) {
  return Marcher(field.distance_mm.grid,
                 field.distance_mm.phases.at(static_cast<std::size_t>(phase)))
      .run();
}

double enclosed_ml(const TriangleSoup& surface) {
  if (surface.points.empty()) return 0;
  // About a point of the surface rather than a far origin, for the sake of digits.
  const Vec3 pivot = surface.points.front();
  double six_volumes = 0;
  for (const auto& t : surface.triangles) {
    const Vec3 a = surface.points[t[0]] - pivot;
    const Vec3 b = surface.points[t[1]] - pivot;
    const Vec3 c = surface.points[t[2]] - pivot;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6.0 * 1e-3;
}

}  // namespace beatlas::field
