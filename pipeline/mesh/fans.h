#pragma once
#include <span>
#include <vector>

#include "pipeline/mesh/triangle_mesh.h"

namespace beatlas::mesh {

/// Ascending, each once.
void sort_unique(std::vector<std::uint32_t>& all);

/// Where a vertex's triangles are.
class Fans {
 public:
  /// @param triangles must outlive it
  Fans(std::size_t vertices, std::span<const Triangle> triangles);

  /// The triangles of some vertices, ascending.
  [[nodiscard]] std::vector<std::uint32_t> around(const std::vector<std::uint32_t>& vertices) const;

  /// Moves a vertex as far of the way, all, half or a quarter, as turns no triangle far from where
  /// it was at the start and makes none thin.
  void move(std::vector<Vec3>& points, const std::vector<Vec3>& start, std::uint32_t v,
            const Vec3& way, double thin_deg) const;

 private:
  std::span<const Triangle> triangles_;
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> at_;
};

}  // namespace beatlas::mesh
