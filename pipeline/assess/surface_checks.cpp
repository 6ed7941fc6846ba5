#include "pipeline/assess/surface_checks.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

namespace beatlas::assess {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

struct Box {
  Vec3 low;
  Vec3 high;
};

using Corners = std::array<Vec3, 3>;

Corners corners_of(const std::array<std::uint32_t, 3>& triangle,
                   const std::vector<Vec3f>& positions) {
  return {positions[triangle[0]].cast<double>(), positions[triangle[1]].cast<double>(),
          positions[triangle[2]].cast<double>()};
}

/// Whether the open segment a-b passes through the inside of a triangle.
bool pierces(const Vec3& a, const Vec3& b, const Corners& t) {
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double above = normal.dot(a - t[0]);
  const double below = normal.dot(b - t[0]);
  if (above * below >= 0.0) return false;
  const Vec3 x = a + (b - a) * (above / (above - below));
  for (int n = 0; n < 3; ++n) {
    const Vec3& from = t[static_cast<std::size_t>(n)];
    const Vec3& to = t[static_cast<std::size_t>((n + 1) % 3)];
    if (normal.dot((to - from).cross(x - from)) <= 0.0) return false;
  }
  return true;
}

bool cut(const Corners& a, const Corners& b) {
  for (std::size_t n = 0; n < 3; ++n) {
    if (pierces(a[n], a[(n + 1) % 3], b) || pierces(b[n], b[(n + 1) % 3], a)) return true;
  }
  return false;
}

bool share_a_vertex(const std::array<std::uint32_t, 3>& a, const std::array<std::uint32_t, 3>& b) {
  return std::any_of(a.begin(), a.end(), [&](std::uint32_t vertex) {
    return std::find(b.begin(), b.end(), vertex) != b.end();
  });
}

std::uint64_t cell_key(const Eigen::Vector3i& cell) {
  constexpr int kHalf = 1 << 20;
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    key = (key << 21) | static_cast<std::uint64_t>((cell[axis] + kHalf) & (2 * kHalf - 1));
  }
  return key;
}

/// Corners and boxes of a surface's triangles.
class Faces {
 public:
  Faces(const Triangles& triangles, const std::vector<Vec3f>& positions) {
    for (const auto& triangle : triangles) {
      const Corners& t = corners_.emplace_back(corners_of(triangle, positions));
      boxes_.push_back({t[0].cwiseMin(t[1]).cwiseMin(t[2]), t[0].cwiseMax(t[1]).cwiseMax(t[2])});
      edge_mm_ += (t[1] - t[0]).norm();
    }
    edge_mm_ /= static_cast<double>(std::max<std::size_t>(1, triangles.size()));
  }
  [[nodiscard]] const Corners& corners(std::uint32_t n) const { return corners_[n]; }
  [[nodiscard]] const Box& box(std::uint32_t n) const { return boxes_[n]; }
  [[nodiscard]] double edge_mm() const { return edge_mm_; }

 private:
  std::vector<Corners> corners_;
  std::vector<Box> boxes_;
  double edge_mm_ = 0;  // mean
};

/// Which triangles lie in the cells of a lattice twice as wide as an edge.
class CellsOfFaces {
 public:
  explicit CellsOfFaces(double edge_mm) : cell_mm_(std::max(1e-3, 2.0 * edge_mm)) {}

  void add(std::uint32_t face, const Box& box) {
    each_cell(box, [&](const Eigen::Vector3i& cell) { cells_[cell_key(cell)].push_back(face); });
  }
  /// Calls visit(n) once for each of `faces`, as were added, whose box meets this one.
  template <class Visit>
  void near(const Box& box, const Faces& faces, const Visit& visit) const {
    each_cell(box, [&](const Eigen::Vector3i& cell) {
      const auto here = cells_.find(cell_key(cell));
      if (here == cells_.end()) return;
      for (const std::uint32_t other : here->second) {
        const Vec3 low = box.low.cwiseMax(faces.box(other).low);
        const Vec3 high = box.high.cwiseMin(faces.box(other).high);
        if ((low.array() > high.array()).any()) continue;
        // Once: in the cell of the lowest corner that both boxes have.
        if (cell_of(low) == cell) visit(other);
      }
    });
  }

 private:
  [[nodiscard]] Eigen::Vector3i cell_of(const Vec3& x) const {
    return (x / cell_mm_).array().floor().max(-1e6).min(1e6).cast<int>();
  }
  template <class Visit>
  void each_cell(const Box& box, const Visit& visit) const {
    const Eigen::Vector3i low = cell_of(box.low);
    const Eigen::Vector3i high = cell_of(box.high);
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) visit(Eigen::Vector3i(x, y, z));
      }
    }
  }

  double cell_mm_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

double rms_step_mm(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
  double squares = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    squares += (b[n] - a[n]).cast<double>().squaredNorm();
  }
  return a.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(a.size()));
}

}  // namespace

double enclosed_volume_ml(const Triangles& triangles, const std::vector<Vec3f>& positions) {
  double six_volumes = 0;
  for (const auto& [a, b, c] : triangles) {
    const Vec3 first = positions[a].cast<double>();
    six_volumes += first.dot(positions[b].cast<double>().cross(positions[c].cast<double>()));
  }
  return six_volumes / 6e3;
}

std::size_t open_edges(const Triangles& triangles) {
  std::vector<Edge> edges;
  for (const auto& [a, b, c] : triangles) {
    edges.insert(edges.end(), {Edge{a, b}, Edge{b, c}, Edge{c, a}});
  }
  std::sort(edges.begin(), edges.end());
  std::size_t open = 0;
  for (const Edge& edge : edges) {
    const auto [first, last] =
        std::equal_range(edges.begin(), edges.end(), Edge{edge.second, edge.first});
    const auto [same, end] = std::equal_range(edges.begin(), edges.end(), edge);
    if (last - first != 1 || end - same != 1) ++open;
  }
  return open;
}

std::size_t pinched_vertices(const Triangles& triangles) {
  // Around a vertex each triangle leads from one neighbour to the next: a fan is one round.
  std::vector<std::pair<std::uint32_t, Edge>> links;
  for (const auto& [a, b, c] : triangles) {
    links.insert(links.end(), {{a, {b, c}}, {b, {c, a}}, {c, {a, b}}});
  }
  std::sort(links.begin(), links.end());
  std::size_t pinched = 0;
  for (auto first = links.begin(); first != links.end();) {
    const std::uint32_t vertex = first->first;
    const auto end =
        std::find_if(first, links.end(), [&](const auto& link) { return link.first != vertex; });
    std::uint32_t at = first->second.second;
    std::ptrdiff_t steps = 1;
    while (at != first->second.first && steps <= end - first) {
      const auto next = std::lower_bound(first, end, std::pair{vertex, Edge{at, 0}});
      if (next == end || next->second.first != at) break;
      at = next->second.second;
      ++steps;
    }
    if (at != first->second.first || steps != end - first) ++pinched;
    first = end;
  }
  return pinched;
}

std::size_t crossing_triangles(const Triangles& triangles, const std::vector<Vec3f>& positions) {
  const Faces faces(triangles, positions);
  CellsOfFaces cells(faces.edge_mm());
  std::size_t count = 0;
  for (std::uint32_t n = 0; n < triangles.size(); ++n) {
    cells.near(faces.box(n), faces, [&](std::uint32_t other) {
      if (share_a_vertex(triangles[n], triangles[other])) return;
      if (cut(faces.corners(n), faces.corners(other))) ++count;
    });
    cells.add(n, faces.box(n));
  }
  return count;
}

std::size_t crossing_triangles(const Triangles& triangles, const std::vector<Vec3f>& positions,
                               const Triangles& other_triangles,
                               const std::vector<Vec3f>& other_positions) {
  const Faces faces(triangles, positions);
  const Faces others(other_triangles, other_positions);
  CellsOfFaces cells(std::max(faces.edge_mm(), others.edge_mm()));
  for (std::uint32_t n = 0; n < other_triangles.size(); ++n) cells.add(n, others.box(n));
  std::size_t count = 0;
  for (std::uint32_t n = 0; n < triangles.size(); ++n) {
    cells.near(faces.box(n), others, [&](std::uint32_t other) {
      if (cut(faces.corners(n), others.corners(other))) ++count;
    });
  }
  return count;
}

double wrap_step_ratio(const std::vector<std::vector<Vec3f>>& positions) {
  if (positions.size() < 3) return 0.0;
  double largest = 0.0;
  for (std::size_t p = 1; p < positions.size(); ++p) {
    largest = std::max(largest, rms_step_mm(positions[p - 1], positions[p]));
  }
  const double wrap = rms_step_mm(positions.back(), positions.front());
  if (largest > 0.0) return wrap / largest;
  return wrap > 0.0 ? HUGE_VAL : 0.0;
}

}  // namespace beatlas::assess
