#include "runtime/haptics/half_spaces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

namespace beatlas::haptics {
namespace {

constexpr double kParallel = 0.999;   // cosine of 2.6 degrees
constexpr double kRoundingMm = 1e-9;  // coordinates are some hundreds of mm

std::size_t at(int n) { return static_cast<std::size_t>(n); }

// The point nearest to x on the edge of two planes; none where they are parallel or one of them
// would have to pull.
std::optional<Vec3> on_edge(const HalfSpace& one, const HalfSpace& two, const Vec3& x) noexcept {
  const double c = one.normal.dot(two.normal);
  const double det = 1 - c * c;
  if (det < 1e-6) return {};
  const double ea = -one.excess(x);
  const double eb = -two.excess(x);
  const double la = (ea - c * eb) / det;
  const double lb = (eb - c * ea) / det;
  if (la < 0 || lb < 0) return {};
  return x + la * one.normal + lb * two.normal;
}

// Where three planes meet; none where they do not, in one point.
std::optional<Vec3> in_corner(const std::array<HalfSpace, 3>& planes) noexcept {
  Eigen::Matrix3d normals;
  for (int n = 0; n < 3; ++n) normals.row(n) = planes[at(n)].normal;
  const double det = normals.determinant();
  if (!(std::abs(det) > 1e-6)) return {};
  const Vec3 offsets(planes[0].offset, planes[1].offset, planes[2].offset);
  const Vec3 q = normals.inverse() * offsets;
  if (!q.allFinite()) return {};
  return q;
}

}  // namespace

void HalfSpaces::add(const HalfSpace& half_space) noexcept {
  if (size_ == kMost) {
    std::rotate(all_.begin(), all_.begin() + 1, all_.end());
    --size_;
  }
  all_[at(size_++)] = half_space;
}

void HalfSpaces::drop_stale(const Vec3& point, const Vec3& from, double free_mm, const Vec3& normal,
                            double tolerance_mm) noexcept {
  int kept = 0;
  for (int n = 0; n < size_; ++n) {
    const HalfSpace& one = all_[at(n)];
    const double room = one.excess(from);
    const bool forbids = one.excess(point) < std::min(0.0, room) - tolerance_mm ||
                         (free_mm > 0 && room < free_mm - tolerance_mm);
    if (forbids || one.normal.dot(normal) > kParallel) continue;
    all_[at(kept++)] = one;
  }
  size_ = kept;
}

bool HalfSpaces::allows(const Vec3& q) const noexcept {
  return std::all_of(all_.begin(), all_.begin() + size_,
                     [&](const HalfSpace& one) { return one.excess(q) >= -kRoundingMm; });
}

Vec3 HalfSpaces::nearest(const Vec3& x, bool& held) const noexcept {
  held = false;
  if (allows(x)) return x;
  held = true;
  // One plane, newest first; then an edge of two; then the corner. Multipliers must push outward.
  for (int a = size_ - 1; a >= 0; --a) {
    const HalfSpace& one = all_[at(a)];
    const double push = -one.excess(x);
    if (push <= 0) continue;
    Vec3 q = x + push * one.normal;
    if (allows(q)) return q;
  }
  for (int a = size_ - 1; a > 0; --a) {
    for (int b = a - 1; b >= 0; --b) {
      const auto q = on_edge(all_[at(a)], all_[at(b)], x);
      if (q && allows(*q)) return *q;
    }
  }
  if (size_ == 3) {
    const auto q = in_corner(all_);
    if (q && allows(*q)) return *q;
  }
  const HalfSpace& newest = all_[at(size_ - 1)];
  return x - std::min(0.0, newest.excess(x)) * newest.normal;
}

}  // namespace beatlas::haptics
