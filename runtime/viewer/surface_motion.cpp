#include "runtime/viewer/surface_motion.h"

#include <array>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "runtime/base/error.h"

namespace beatlas::viewer {

SurfaceMotion::SurfaceMotion(std::shared_ptr<const atlas::SurfacePayload> surface)
    : surface_(std::move(surface)) {
  if (!surface_ || surface_->positions.empty()) throw_invalid("there is no surface to draw");
  const auto phases = static_cast<Eigen::Index>(surface_->positions.size());
  Eigen::MatrixXd samples_from_coefficients = Eigen::MatrixXd::Zero(phases, phases);
  for (Eigen::Index phase = 0; phase < phases; ++phase) {
    samples_from_coefficients(phase, phase) += 4.0 / 6;
    samples_from_coefficients(phase, (phase + 1) % phases) += 1.0 / 6;
    samples_from_coefficients(phase, (phase + phases - 1) % phases) += 1.0 / 6;
  }
  const Eigen::MatrixXf weights = samples_from_coefficients.inverse().cast<float>();
  coefficients_.assign(static_cast<std::size_t>(phases),
                       std::vector<Vec3f>(vertex_count(), Vec3f::Zero()));
  for (Eigen::Index phase = 0; phase < phases; ++phase) {
    std::vector<Vec3f>& to = coefficients_[static_cast<std::size_t>(phase)];
    for (Eigen::Index from = 0; from < phases; ++from) {
      const std::vector<Vec3f>& positions = surface_->positions[static_cast<std::size_t>(from)];
      for (std::size_t v = 0; v < to.size(); ++v) to[v] += weights(phase, from) * positions[v];
    }
  }
}

std::size_t SurfaceMotion::vertex_count() const noexcept {
  return surface_->positions.front().size();
}

void SurfaceMotion::positions_at(double beats, std::span<Vec3f> to) const noexcept {
  const std::size_t phases = coefficients_.size();
  const double whole = std::isfinite(beats) ? beats - std::floor(beats) : 0;
  const double at = whole * static_cast<double>(phases);
  const double floor = std::floor(at);
  const auto u = static_cast<float>(at - floor);
  const std::size_t first = (static_cast<std::size_t>(floor) + phases - 1) % phases;
  const float left = 1 - u;
  const std::array<float, 4> weights{left * left * left / 6, (3 * u * u * u - 6 * u * u + 4) / 6,
                                     (3 * left * left * left - 6 * left * left + 4) / 6,
                                     u * u * u / 6};
  const auto at_phase = [&](std::size_t n) { return coefficients_[(first + n) % phases].data(); };
  const Vec3f* a = at_phase(0);
  const Vec3f* b = at_phase(1);
  const Vec3f* c = at_phase(2);
  const Vec3f* d = at_phase(3);
  for (std::size_t v = 0; v < to.size(); ++v) {
    to[v] = weights[0] * a[v] + weights[1] * b[v] + weights[2] * c[v] + weights[3] * d[v];
  }
}

void SurfaceMotion::normals_of(std::span<const Vec3f> positions,
                               std::span<Vec3f> to) const noexcept {
  for (Vec3f& normal : to) normal.setZero();
  for (const auto& [a, b, c] : surface_->triangles) {
    const Vec3f area = (positions[b] - positions[a]).cross(positions[c] - positions[a]);
    to[a] += area;
    to[b] += area;
    to[c] += area;
  }
  for (Vec3f& normal : to) {
    const float length = normal.norm();
    if (length > 0) normal /= length;
  }
}

std::vector<CutSegment> cut_surface(std::span<const std::array<std::uint32_t, 3>> triangles,
                                    std::span<const Vec3f> positions, const Vec3& point_mm,
                                    const Vec3& normal) {
  std::vector<float> heights(positions.size());
  const Vec3f n = normal.normalized().cast<float>();
  const Vec3f origin = point_mm.cast<float>();
  for (std::size_t v = 0; v < heights.size(); ++v) heights[v] = n.dot(positions[v] - origin);
  std::vector<CutSegment> segments;
  for (const auto& triangle : triangles) {
    // A vertex on the plane counts as above it, so that every crossing has two ends.
    int above = 0;
    for (const std::uint32_t v : triangle) above += heights[v] >= 0 ? 1 : 0;
    if (above == 0 || above == 3) continue;
    CutSegment segment;
    for (std::size_t edge = 0; edge < 3; ++edge) {
      const std::uint32_t a = triangle[edge];
      const std::uint32_t b = triangle[(edge + 1) % 3];
      if ((heights[a] >= 0) == (heights[b] >= 0)) continue;
      // From the lower vertex to the upper one, so that neighbours find the same point.
      const bool rises = heights[b] >= 0;
      const std::uint32_t low = rises ? a : b;
      const std::uint32_t high = rises ? b : a;
      const float share = heights[low] / (heights[low] - heights[high]);
      (rises ? segment.from_mm : segment.to_mm) =
          positions[low] + share * (positions[high] - positions[low]);
    }
    segments.push_back(segment);
  }
  return segments;
}

}  // namespace beatlas::viewer
