#include "runtime/atlas/surface_order.h"

#include <algorithm>
#include <cmath>
#include <ranges>

#include <Eigen/Cholesky>

namespace beatlas::atlas {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

constexpr std::size_t kFewLeft = 32;
constexpr std::size_t kLeastShare = 8;  // of those left, in a round

/// The graph of edges while it is thinned.
class Thinning {
 public:
  Thinning(const Triangles& triangles, std::size_t count)
      : neighbours(count), known(count), is_out_(count, 0), blocked_(count, 0) {
    for (auto& list : neighbours) list.reserve(2 * SurfaceOrder::kMostKnown);
    for (const auto& triangle : triangles) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t one = triangle[corner];
        const std::uint32_t other = triangle[(corner + 1) % 3];
        neighbours[one].push_back(other);
        neighbours[other].push_back(one);
      }
    }
    left_.resize(count);
    for (std::uint32_t v = 0; v < count; ++v) left_[v] = v;
  }

  /// All vertices, first out first.
  std::vector<std::uint32_t> run() {
    std::vector<std::uint32_t> out;
    out.reserve(neighbours.size());
    while (true) {
      for (const std::uint32_t v : left_) clean(neighbours[v]);
      if (left_.size() <= kFewLeft) break;
      const std::size_t before = out.size();
      choose(out);
      for (std::size_t n = before; n < out.size(); ++n) is_out_[out[n]] = 1;
      for (std::size_t n = before; n < out.size(); ++n) take_out(out[n]);
      std::erase_if(left_, [this](std::uint32_t v) { return is_out_[v] != 0; });
      if (kLeastShare * (out.size() - before) < left_.size()) {
        for (const std::uint32_t v : left_) clean(neighbours[v]);
        break;
      }
    }
    for (const std::uint32_t v : std::ranges::reverse_view(left_)) {
      known[v] = std::move(neighbours[v]);
      std::erase_if(known[v], [v](std::uint32_t other) { return other >= v; });
      out.push_back(v);
    }
    return out;
  }

  std::vector<std::vector<std::uint32_t>> neighbours;
  std::vector<std::vector<std::uint32_t>> known;

 private:
  void clean(std::vector<std::uint32_t>& list) const {
    std::erase_if(list, [this](std::uint32_t v) { return is_out_[v] != 0; });
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }

  void choose(std::vector<std::uint32_t>& out) {
    ++round_;
    for (const std::uint32_t v : left_) {
      if (blocked_[v] == round_ || neighbours[v].size() > SurfaceOrder::kMostKnown) continue;
      for (const std::uint32_t other : neighbours[v]) blocked_[other] = round_;
      out.push_back(v);
    }
  }

  void take_out(std::uint32_t v) {
    known[v] = std::move(neighbours[v]);
    if (known[v].empty()) return;
    const std::uint32_t hub = *std::min_element(
        known[v].begin(), known[v].end(),
        [this](auto one, auto other) { return neighbours[one].size() < neighbours[other].size(); });
    for (const std::uint32_t other : known[v]) {
      if (other == hub) continue;
      neighbours[hub].push_back(other);
      neighbours[other].push_back(hub);
    }
  }

  std::vector<std::uint8_t> is_out_;
  std::vector<std::uint32_t> blocked_;  ///< the last round in which a neighbour was taken
  std::vector<std::uint32_t> left_;
  std::uint32_t round_ = 0;
};

std::vector<Vec3> normals_of(const Triangles& triangles, const std::vector<Vec3f>& mean_mm) {
  std::vector<Vec3> normals(mean_mm.size(), Vec3::Zero());
  for (const auto& [a, b, c] : triangles) {
    const Vec3 from = mean_mm[a].cast<double>();
    const Vec3 area = (mean_mm[b].cast<double>() - from).cross(mean_mm[c].cast<double>() - from);
    for (const std::uint32_t v : {a, b, c}) normals[v] += area;
  }
  for (Vec3& normal : normals) {
    const double length = normal.norm();
    normal = length > 1e-12 ? Vec3(normal / length) : Vec3::UnitZ();
  }
  return normals;
}

}  // namespace

SurfaceOrder::SurfaceOrder(const Triangles& triangles, const std::vector<Vec3f>& mean_mm)
    : mean_mm_(mean_mm), normals_(normals_of(triangles, mean_mm)) {
  Thinning thinning(triangles, mean_mm.size());
  vertices_ = thinning.run();
  std::reverse(vertices_.begin(), vertices_.end());
  first_.resize(mean_mm.size() + 1, 0);
  for (std::size_t v = 0; v < mean_mm.size(); ++v) {
    known_.insert(known_.end(), thinning.known[v].begin(), thinning.known[v].end());
    first_[v + 1] = static_cast<std::uint32_t>(known_.size());
  }
}

std::vector<double> SurfaceOrder::weights(std::uint32_t vertex) const {
  // Known ones closer than this share of their mean distance count no more.
  constexpr double kNear = 0.2;
  constexpr double kRidge = 0.01 / 3;
  constexpr double kMostWeight = 3;  // sum of magnitudes: beyond it the fit is an extrapolation
  const std::span<const std::uint32_t> others = known(vertex);
  const auto count = static_cast<double>(others.size());
  std::vector<double> out(others.size(), others.empty() ? 0 : 1 / count);
  if (others.size() < 3) return out;

  const Vec3 here = mean_mm_[vertex].cast<double>();
  double squares = 0;
  for (const std::uint32_t v : others) squares += (mean_mm_[v].cast<double>() - here).squaredNorm();
  const double scale = std::sqrt(squares / count) + 1e-9;
  const auto term = [&](std::uint32_t v) {
    const Vec3 offset = (mean_mm_[v].cast<double>() - here) / scale;
    return Eigen::Vector4d(1, offset.x(), offset.y(), offset.z());
  };
  const auto share = [kNear](const Eigen::Vector4d& of) {
    return 1 / std::max(of.tail<3>().norm(), kNear);
  };
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  for (const std::uint32_t v : others) {
    const Eigen::Vector4d of = term(v);
    normal += share(of) * of * of.transpose();
  }
  const double ridge = kRidge * (normal(1, 1) + normal(2, 2) + normal(3, 3)) + 1e-9;
  for (int n = 1; n < 4; ++n) normal(n, n) += ridge;
  const Eigen::Vector4d fit = normal.ldlt().solve(Eigen::Vector4d::UnitX());
  double sum = 0;
  double magnitude = 0;
  std::vector<double> fitted(others.size());
  for (std::size_t n = 0; n < others.size(); ++n) {
    const Eigen::Vector4d of = term(others[n]);
    fitted[n] = share(of) * of.dot(fit);
    sum += fitted[n];
    magnitude += std::abs(fitted[n]);
  }
  if (!(sum > 0.1 && magnitude <= kMostWeight * sum)) return out;
  for (double& weight : fitted) weight /= sum;
  return fitted;
}

Eigen::Matrix3d SurfaceOrder::frame(std::uint32_t vertex) const {
  const Vec3& normal = normals_[vertex];
  Eigen::Index least = 0;
  normal.cwiseAbs().minCoeff(&least);
  const Vec3 across = normal.cross(Vec3::Unit(least)).normalized();
  Eigen::Matrix3d out;
  out.row(0) = normal;
  out.row(1) = across;
  out.row(2) = normal.cross(across);
  return out;
}

}  // namespace beatlas::atlas
