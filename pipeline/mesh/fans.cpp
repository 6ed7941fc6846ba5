#include "pipeline/mesh/fans.h"

#include <algorithm>

namespace beatlas::mesh {
namespace {

bool is_sound(const Triangle& t, const std::vector<Vec3>& points, const std::vector<Vec3>& start,
              double thin_deg) {
  constexpr double kTurned = 0.7;  // cosine
  const auto area = [&](const std::vector<Vec3>& of) -> Vec3 {
    return (of[t[1]] - of[t[0]]).cross(of[t[2]] - of[t[0]]);
  };
  const auto least_deg = [&](const std::vector<Vec3>& of) {
    return least_angle_deg(of[t[0]], of[t[1]], of[t[2]]);
  };
  const Vec3 before = area(start);
  const Vec3 after = area(points);
  if (before.dot(after) < kTurned * before.norm() * after.norm()) return false;
  const double now_deg = least_deg(points);
  return now_deg > thin_deg || now_deg >= least_deg(start);
}

}  // namespace

void sort_unique(std::vector<std::uint32_t>& all) {
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
}

Fans::Fans(std::size_t vertices, std::span<const Triangle> triangles)
    : triangles_(triangles), first_(vertices + 1, 0), at_(3 * triangles.size()) {
  for (const Triangle& t : triangles) {
    for (const std::uint32_t v : t) ++first_[v + 1];
  }
  for (std::size_t v = 0; v < vertices; ++v) first_[v + 1] += first_[v];
  std::vector<std::uint32_t> filled(first_.begin(), first_.end() - 1);
  for (std::uint32_t n = 0; n < triangles.size(); ++n) {
    for (const std::uint32_t v : triangles[n]) at_[filled[v]++] = n;
  }
}

std::vector<std::uint32_t> Fans::around(const std::vector<std::uint32_t>& vertices) const {
  std::vector<std::uint32_t> out;
  for (const std::uint32_t v : vertices) {
    out.insert(out.end(), at_.begin() + first_[v], at_.begin() + first_[v + 1]);
  }
  sort_unique(out);
  return out;
}

void Fans::move(std::vector<Vec3>& points, const std::vector<Vec3>& start, std::uint32_t v,
                const Vec3& way, double thin_deg) const {
  const Vec3 from = points[v];
  for (const double share : {1.0, 0.5, 0.25}) {
    points[v] = from + share * way;
    const bool sound = std::all_of(
        at_.begin() + first_[v], at_.begin() + first_[v + 1],
        [&](std::uint32_t n) { return is_sound(triangles_[n], points, start, thin_deg); });
    if (sound) return;
  }
  points[v] = from;
}

}  // namespace beatlas::mesh
