#include "pipeline/mesh/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace beatlas::mesh {
namespace {

Vec3 doubled_area(std::span<const Vec3> points, const Triangle& t) {
  return (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
}

// A triangle (v, from, to) seen from its corner v.
struct Corner {
  std::uint32_t v, from, to;
};

}  // namespace

OffSurface off_surface(std::span<const Vec3> points, std::span<const Triangle> triangles,
                       const field::Interpolant& surface) {
  OffSurface out;
  for (const Triangle& t : triangles) {
    const Vec3& a = points[t[0]];
    const Vec3& b = points[t[1]];
    const Vec3& c = points[t[2]];
    const double share = (b - a).cross(c - a).norm() / 8;  // a quarter of the area
    const Vec3 middle = (a + b + c) / 3;
    for (const Vec3& x :
         {middle, Vec3((middle + a) / 2), Vec3((middle + b) / 2), Vec3((middle + c) / 2)}) {
      const double off = surface.value(x);
      out.area += share;
      out.off += share * std::abs(off);
      out.signed_off += share * off;
    }
  }
  return out;
}

Topology inspect(std::size_t vertex_count, std::span<const Triangle> triangles) {
  std::vector<Corner> corners;
  corners.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) {
    for (std::size_t n = 0; n < 3; ++n) {
      if (t[n] >= vertex_count || t[n] == t[(n + 1) % 3]) return {};
      corners.push_back({t[n], t[(n + 1) % 3], t[(n + 2) % 3]});
    }
  }
  std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
    return a.v != b.v ? a.v < b.v : a.from < b.from;
  });
  std::size_t rings = 0;
  for (auto first = corners.begin(); first != corners.end(); ++rings) {
    const auto last =
        std::find_if(first, corners.end(), [&](const Corner& c) { return c.v != first->v; });
    const auto at = [&](std::uint32_t from) {
      return std::lower_bound(first, last, from,
                              [](const Corner& c, std::uint32_t f) { return c.from < f; });
    };
    if (std::adjacent_find(first, last, [](const Corner& a, const Corner& b) {
          return a.from == b.from;
        }) != last) {
      return {};  // an edge that runs the same way twice
    }
    // Around the vertex from face to face: back at the start after all of them, or no ring.
    std::uint32_t next = first->to;
    std::ptrdiff_t seen = 1;
    while (next != first->from) {
      const auto face = at(next);
      if (face == last || face->from != next || seen > last - first) return {};
      next = face->to;
      ++seen;
    }
    if (seen != last - first) return {};
    first = last;
  }
  if (triangles.empty() || rings != vertex_count) return {};
  const auto count = static_cast<std::ptrdiff_t>(triangles.size());
  return {true,
          static_cast<int>(static_cast<std::ptrdiff_t>(vertex_count) - 3 * count / 2 + count)};
}

double enclosed_ml(std::span<const Vec3> points, std::span<const Triangle> triangles) {
  if (points.empty()) return 0;
  const Vec3& pivot = points.front();
  double six_volumes = 0;
  for (const Triangle& t : triangles) {
    six_volumes += (points[t[0]] - pivot).dot((points[t[1]] - pivot).cross(points[t[2]] - pivot));
  }
  return six_volumes / 6.0 * 1e-3;
}

std::vector<Vec3> vertex_normals(std::span<const Vec3> points,
                                 std::span<const Triangle> triangles) {
  std::vector<Vec3> out(points.size(), Vec3::Zero());
  for (const Triangle& t : triangles) {
    const Vec3 normal = doubled_area(points, t);
    for (std::uint32_t v : t) out[v] += normal;
  }
  for (Vec3& normal : out) normal.normalize();
  return out;
}

std::vector<bool> flipped_triangles(std::span<const Vec3> points,
                                    std::span<const Triangle> triangles) {
  const std::vector<Vec3> normals = vertex_normals(points, triangles);
  std::vector<bool> out;
  out.reserve(triangles.size());
  for (const Triangle& t : triangles) {
    const Vec3 mean = normals[t[0]] + normals[t[1]] + normals[t[2]];
    out.push_back(doubled_area(points, t).dot(mean) <= 0);
  }
  return out;
}

double least_angle_deg(const Vec3& a, const Vec3& b, const Vec3& c) {
  const std::array<Vec3, 3> corner{a, b, c};
  double least = std::numbers::pi;
  for (std::size_t n = 0; n < 3; ++n) {
    const Vec3 u = corner[(n + 1) % 3] - corner[n];
    const Vec3 v = corner[(n + 2) % 3] - corner[n];
    least = std::min(least, std::atan2(u.cross(v).norm(), u.dot(v)));
  }
  return least * 180.0 / std::numbers::pi;
}

}  // namespace beatlas::mesh
