#include "pipeline/field/surface_rows.h"

#include <algorithm>
#include <cmath>

namespace beatlas::field {

std::vector<std::vector<double>> row_crossings(const TriangleSoup& surface, const Grid& grid) {
  constexpr double kBesideJ = 1.03e-5;
  constexpr double kBesideK = 1.71e-5;
  const auto at = [](int n) { return static_cast<std::size_t>(n); };
  const Affine index_from_mm = grid.mm_from_index.inverse();
  std::vector<std::vector<double>> rows(at(grid.size[1]) * at(grid.size[2]));
  std::vector<Vec3> points;
  points.reserve(surface.points.size());
  for (const Vec3& point : surface.points) {
    points.emplace_back(index_from_mm * point - Vec3(0, kBesideJ, kBesideK));
  }
  for (const auto& triangle : surface.triangles) {
    const Vec3& a = points[triangle[0]];
    const Vec3 ab = points[triangle[1]] - a;
    const Vec3 ac = points[triangle[2]] - a;
    const double area = ab.y() * ac.z() - ab.z() * ac.y();
    if (area == 0) continue;
    // Rows of the grid that the triangle can meet, which may itself lie anywhere.
    const auto first = [&](Eigen::Index n) {
      const double low = std::ceil(a[n] + std::min({0.0, ab[n], ac[n]}));
      return static_cast<int>(std::clamp(low, 0.0, double(grid.size[static_cast<std::size_t>(n)])));
    };
    const auto last = [&](Eigen::Index n) {
      const double high = std::floor(a[n] + std::max({0.0, ab[n], ac[n]}));
      return static_cast<int>(std::clamp(high, -1.0, grid.size[static_cast<std::size_t>(n)] - 1.0));
    };
    for (int k = first(2); k <= last(2); ++k) {
      for (int j = first(1); j <= last(1); ++j) {
        const double y = j - a.y();
        const double z = k - a.z();
        const double u = (y * ac.z() - z * ac.y()) / area;
        const double v = (ab.y() * z - ab.z() * y) / area;
        if (u < 0 || v < 0 || u + v > 1) continue;
        rows[at(j) + at(grid.size[1]) * at(k)].push_back(a.x() + u * ab.x() + v * ac.x());
      }
    }
  }
  for (auto& row : rows) std::sort(row.begin(), row.end());
  return rows;
}

}  // namespace beatlas::field
