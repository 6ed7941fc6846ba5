#include "runtime/base/triangle.h"

namespace beatlas {

Vec3 nearest_of_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const double d1 = ab.dot(p - a);
  const double d2 = ac.dot(p - a);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = ab.dot(p - b);
  const double d4 = ac.dot(p - b);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double d5 = ab.dot(p - c);
  const double d6 = ac.dot(p - c);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double over_c = d1 * d4 - d3 * d2;
  if (over_c <= 0 && d1 >= 0 && d3 <= 0) {
    const double share = d1 / (d1 - d3);
    return {1 - share, share, 0};
  }
  const double over_b = d5 * d2 - d1 * d6;
  if (over_b <= 0 && d2 >= 0 && d6 <= 0) {
    const double share = d2 / (d2 - d6);
    return {1 - share, 0, share};
  }
  const double over_a = d3 * d6 - d5 * d4;
  if (over_a <= 0 && d4 >= d3 && d5 >= d6) {
    const double share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - share, share};
  }
  const double whole = over_a + over_b + over_c;
  if (!(whole > 0)) return {1, 0, 0};  // a triangle without an area
  return Vec3(over_a, over_b, over_c) / whole;
}

}  // namespace beatlas
