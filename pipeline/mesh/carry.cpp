#include "pipeline/mesh/carry.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace beatlas::mesh {
namespace {

constexpr double kStiffness = 10;       // of the surface against the membrane
constexpr double kLeastGradient = 0.3;  // below it the field is clamped or at its ridge

}  // namespace

Carrier::Carrier(const TriangleMesh& reference)
    : reference_(reference.points),
      triangles_(reference.triangles),
      total_(reference.points.size(), 0.0F) {
  Neighbours neighbours = cotangent_neighbours(reference);
  links_.resize(neighbours.at.size());
  for (std::size_t v = 0; v < total_.size(); ++v) {
    double total = 0;
    for (std::uint32_t n = neighbours.first[v]; n < neighbours.first[v + 1]; ++n) {
      total += neighbours.weight[n];
      links_[n] = {neighbours.at[n], static_cast<float>(neighbours.weight[n])};
    }
    total_[v] = static_cast<float>(total);
  }
  first_ = std::move(neighbours.first);
}

Eigen::Vector4f Carrier::laplacian_at(std::size_t vertex, const Columns& x) const {
  Eigen::Vector4f sum = total_[vertex] * x.col(static_cast<Eigen::Index>(vertex));
  for (std::uint32_t n = first_[vertex]; n < first_[vertex + 1]; ++n) {
    sum -= links_[n].weight * x.col(static_cast<Eigen::Index>(links_[n].to));
  }
  return sum;
}

double Carrier::step(std::vector<Vec3>& points, const field::Interpolant& phase, double tolerance,
                     double& most_energy) const {
  using Column = Eigen::Vector4f;
  const auto count = static_cast<Eigen::Index>(points.size());
  const std::vector<Vec3> own_normals = vertex_normals(points, triangles_);
  Columns normal = Columns::Zero(4, count);
  Columns displacement = Columns::Zero(4, count);
  Eigen::VectorXf pull = Eigen::VectorXf::Zero(count);
  Columns residual = Columns::Zero(4, count);
  for (Eigen::Index v = 0; v < count; ++v) {
    const auto n = static_cast<std::size_t>(v);
    const field::Interpolant::Sample here = phase.sample(points[n]);
    const double steep = here.gradient.norm();
    displacement.col(v).head<3>() = (points[n] - reference_[n]).cast<float>();
    if (!(steep > kLeastGradient)) continue;
    const Vec3 out = here.gradient / steep;
    const double agreement = std::max(0.0, out.dot(own_normals[n]));
    normal.col(v).head<3>() = out.cast<float>();
    pull[v] = static_cast<float>(kStiffness * agreement * agreement);
    residual.col(v) = -pull[v] * total_[n] * static_cast<float>(here.value / steep) * normal.col(v);
  }
  for (Eigen::Index v = 0; v < count; ++v) {
    residual.col(v) -= laplacian_at(static_cast<std::size_t>(v), displacement);
  }

  // The system times `direction`, and the energy of that.
  Columns direction(4, count);
  Columns image(4, count);
  const auto apply = [&] {
    double sum = 0;
    for (Eigen::Index v = 0; v < count; ++v) {
      const auto n = static_cast<std::size_t>(v);
      const Column x = direction.col(v);
      const float pulled = pull[v] * total_[n] * normal.col(v).dot(x);
      const Column y = laplacian_at(n, direction) + pulled * normal.col(v);
      image.col(v) = y;
      sum += static_cast<double>(x.dot(y));
    }
    return sum;
  };
  // The inverse of the blocks total (I + pull n n^T) on the diagonal.
  const auto preconditioned = [&](Eigen::Index v, const Column& x) -> Column {
    const float share = pull[v] / (1 + pull[v]);
    return (x - share * normal.col(v).dot(x) * normal.col(v)) / total_[static_cast<std::size_t>(v)];
  };

  constexpr int kMaxRounds = 200;
  Columns way = Columns::Zero(4, count);
  double energy = 0;
  for (Eigen::Index v = 0; v < count; ++v) {
    const Column x = residual.col(v);
    direction.col(v) = preconditioned(v, x);
    energy += static_cast<double>(x.dot(direction.col(v)));
  }
  most_energy = std::max(most_energy, energy);
  const double done = tolerance * tolerance * most_energy;
  Columns scaled(4, count);
  for (int round = 0; round < kMaxRounds && energy > done && energy > 0; ++round) {
    const auto length = static_cast<float>(energy / apply());
    double next = 0;
    for (Eigen::Index v = 0; v < count; ++v) {
      way.col(v) += length * direction.col(v);
      const Column x = residual.col(v) - length * image.col(v);
      residual.col(v) = x;
      const Column y = preconditioned(v, x);
      scaled.col(v) = y;
      next += static_cast<double>(x.dot(y));
    }
    direction = scaled + static_cast<float>(next / energy) * direction;
    energy = next;
  }
  double longest = 0;
  for (Eigen::Index v = 0; v < count; ++v) {
    const Vec3 moved = way.col(v).head<3>().cast<double>();
    points[static_cast<std::size_t>(v)] += moved;
    longest = std::max(longest, moved.norm());
  }
  return longest;
}

std::vector<Vec3> Carrier::carry(std::vector<Vec3> start, const Grid& grid,
                                 const std::vector<float>& from,
                                 const std::vector<float>& to) const {
  constexpr int kSteps = 5;
  constexpr int kMaxParts = 8;
  constexpr double kDoneMm = 0.02;
  constexpr double kOnTheWay = 0.001;  // tolerances: at 0.01 the motion of a cup is a third worse
  constexpr double kAtTheEnd = 0.0003;
  const field::Interpolant target(grid, to);
  double farthest_mm = 0;
  for (const Vec3& p : start) farthest_mm = std::max(farthest_mm, std::abs(target.value(p)));
  const int parts =
      std::clamp(static_cast<int>(std::ceil(farthest_mm / grid.spacing_mm().x())), 1, kMaxParts);
  double most_energy = 0;
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
      if (step(start, between, part < parts ? kOnTheWay : kAtTheEnd, most_energy) < kDoneMm) break;
    }
  }
  return start;
}

}  // namespace beatlas::mesh
