#include "pipeline/mesh/carry.h"

#include <algorithm>
#include <cmath>

namespace beatlas::mesh {
namespace {

constexpr double kStiffness = 10;       // of the surface against the membrane
constexpr double kLeastGradient = 0.3;  // below it the field is clamped or at its ridge

}  // namespace

Carrier::Carrier(const TriangleMesh& reference)
    : reference_(reference.points),
      triangles_(reference.triangles),
      neighbours_(cotangent_neighbours(reference)),
      total_(reference.points.size(), 0.0) {
  for (std::size_t v = 0; v < total_.size(); ++v) {
    for (std::uint32_t n = neighbours_.first[v]; n < neighbours_.first[v + 1]; ++n) {
      total_[v] += neighbours_.weight[n];
    }
  }
}

void Carrier::laplacian(const Columns& x, Columns& out) const {
  for (std::size_t v = 0; v < total_.size(); ++v) {
    const auto column = static_cast<Eigen::Index>(v);
    Vec3 sum = total_[v] * x.col(column);
    for (std::uint32_t n = neighbours_.first[v]; n < neighbours_.first[v + 1]; ++n) {
      sum -= neighbours_.weight[n] * x.col(static_cast<Eigen::Index>(neighbours_.at[n]));
    }
    out.col(column) = sum;
  }
}

double Carrier::step(std::vector<Vec3>& points, const field::Interpolant& phase) const {
  const auto count = static_cast<Eigen::Index>(points.size());
  const std::vector<Vec3> own_normals = vertex_normals(points, triangles_);
  Columns normal(3, count);
  Columns displacement(3, count);
  Eigen::VectorXd pull(count);
  Columns residual(3, count);
  for (Eigen::Index v = 0; v < count; ++v) {
    const auto n = static_cast<std::size_t>(v);
    const field::Interpolant::Sample here = phase.sample(points[n]);
    const double steep = here.gradient.norm();
    displacement.col(v) = points[n] - reference_[n];
    pull[v] = 0;
    normal.col(v).setZero();
    if (steep > kLeastGradient) {
      normal.col(v) = here.gradient / steep;
      const double agreement = std::max(0.0, normal.col(v).dot(own_normals[n]));
      pull[v] = kStiffness * agreement * agreement;
    }
    residual.col(v) =
        -pull[v] * total_[n] * here.value / std::max(steep, kLeastGradient) * normal.col(v);
  }
  Columns image(3, count);
  laplacian(displacement, image);
  residual -= image;

  // The system times `direction`, and the energy of that.
  Columns direction(3, count);
  const auto apply = [&] {
    laplacian(direction, image);
    double sum = 0;
    for (Eigen::Index v = 0; v < count; ++v) {
      const Vec3 x = direction.col(v);
      const double pulled = pull[v] * total_[static_cast<std::size_t>(v)] * normal.col(v).dot(x);
      const Vec3 y = image.col(v) + pulled * normal.col(v);
      image.col(v) = y;
      sum += x.dot(y);
    }
    return sum;
  };
  // The inverse of the blocks total (I + pull n n^T) on the diagonal.
  const auto preconditioned = [&](Eigen::Index v, const Vec3& x) -> Vec3 {
    const double share = pull[v] / (1.0 + pull[v]);
    return (x - share * normal.col(v).dot(x) * normal.col(v)) / total_[static_cast<std::size_t>(v)];
  };

  constexpr int kMaxRounds = 200;
  constexpr double kTolerance = 1e-3;
  Columns way = Columns::Zero(3, count);
  double energy = 0;
  for (Eigen::Index v = 0; v < count; ++v) {
    const Vec3 x = residual.col(v);
    direction.col(v) = preconditioned(v, x);
    energy += x.dot(direction.col(v));
  }
  const double done = kTolerance * kTolerance * energy;
  Columns scaled(3, count);
  for (int round = 0; round < kMaxRounds && energy > done && energy > 0; ++round) {
    const double length = energy / apply();
    double next = 0;
    for (Eigen::Index v = 0; v < count; ++v) {
      way.col(v) += length * direction.col(v);
      const Vec3 x = residual.col(v) - length * image.col(v);
      residual.col(v) = x;
      const Vec3 y = preconditioned(v, x);
      scaled.col(v) = y;
      next += x.dot(y);
    }
    direction = scaled + next / energy * direction;
    energy = next;
  }
  double longest = 0;
  for (Eigen::Index v = 0; v < count; ++v) {
    points[static_cast<std::size_t>(v)] += way.col(v);
    longest = std::max(longest, way.col(v).norm());
  }
  return longest;
}

std::vector<Vec3> Carrier::carry(std::vector<Vec3> start, const Grid& grid,
                                 const std::vector<float>& from,
                                 const std::vector<float>& to) const {
  constexpr int kSteps = 5;
  constexpr int kMaxParts = 8;
  constexpr double kDoneMm = 0.02;
  const field::Interpolant target(grid, to);
  double farthest_mm = 0;
  for (const Vec3& p : start) farthest_mm = std::max(farthest_mm, std::abs(target.value(p)));
  const int parts =
      std::clamp(static_cast<int>(std::ceil(farthest_mm / grid.spacing_mm().x())), 1, kMaxParts);
  std::vector<float> blend;
  for (int part = 1; part <= parts; ++part) {
    const std::vector<float>* samples = &to;
    if (part < parts) {
      const auto share = static_cast<float>(part) / static_cast<float>(parts);
      blend.resize(to.size());
      for (std::size_t n = 0; n < to.size(); ++n) blend[n] = from[n] + share * (to[n] - from[n]);
      samples = &blend;
    }
    const field::Interpolant between(grid, *samples);
    for (int n = 0; n < (part < parts ? 2 : kSteps); ++n) {
      if (step(start, between) < kDoneMm) break;
    }
  }
  return start;
}

}  // namespace beatlas::mesh
