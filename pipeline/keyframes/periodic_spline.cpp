#include "pipeline/keyframes/periodic_spline.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "runtime/base/error.h"

namespace beatlas::keyframes {
PeriodicSpline::PeriodicSpline(std::vector<double> at,
                               const std::map<std::size_t, Eigen::VectorXd>& held)
    : at_(std::move(at)) {
  const std::size_t count = at_.size();
  if (count < 3) throw_invalid("a cycle needs three keys or more");
  for (std::size_t n = 0; n < count; ++n) {
    if (!(at_[n] >= 0 && at_[n] < 1) || (n > 0 && !(at_[n] > at_[n - 1]))) {
      throw_invalid("keys must stand in ascending order at shares of the cycle from 0 to below 1");
    }
  }
  // Equal second derivatives from both sides at every key whose slope is not held.
  const auto size = at_index(count);
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t n = 0; n < count; ++n) {
    const auto own = at_index(n);
    if (const auto given = held.find(n); given != held.end()) {
      slopes(own, own) = 1;
      values.row(own) = given->second;
      continue;
    }
    const auto before = at_index((n + count - 1) % count);
    const auto after = at_index((n + 1) % count);
    const double left = gap((n + count - 1) % count);
    const double right = gap(n);
    slopes(own, before) += 1 / left;
    slopes(own, own) += 2 * (1 / left + 1 / right);
    slopes(own, after) += 1 / right;
    values(own, before) -= 3 / (left * left);
    values(own, own) += 3 / (left * left) - 3 / (right * right);
    values(own, after) += 3 / (right * right);
  }
  slopes_ = slopes.partialPivLu().solve(values);
}

double PeriodicSpline::gap(std::size_t key) const noexcept {
  return key + 1 < at_.size() ? at_[key + 1] - at_[key] : at_[0] + 1 - at_[key];
}

Eigen::VectorXd PeriodicSpline::weights(double share) const {
  const std::size_t count = at_.size();
  double u = share - std::floor(share);
  if (u < at_.front()) u += 1;
  const auto above = std::upper_bound(at_.begin(), at_.end(), u);
  const auto n = static_cast<std::size_t>(above - at_.begin()) - 1;
  const std::size_t after = (n + 1) % count;
  const double b = (u - at_[n]) / gap(n);
  const double a = 1 - b;
  Eigen::VectorXd out =
      gap(n) * a * b *
      (a * slopes_.row(at_index(n)) - b * slopes_.row(at_index(after))).transpose();
  out[at_index(n)] += a * a * (1 + 2 * b);
  out[at_index(after)] += b * b * (1 + 2 * a);
  return out;
}

ThereAndBack there_and_back(int keys, double share) {
  if (keys < 2) throw_invalid("a contraction needs two keys or more");
  if (!(share > 0 && share < 1)) {
    throw_invalid("a contraction must take more than nothing and less than all of the cycle");
  }
  ThereAndBack out;
  const double last = keys - 1;
  for (int key = 0; key < keys; ++key) {
    out.at.push_back(share * key / last);
    out.key.push_back(key);
  }
  for (int key = keys - 2; key > 0; --key) {
    out.at.push_back(share + (1 - share) * (last - key) / last);
    out.key.push_back(key);
  }
  return out;
}

}  // namespace beatlas::keyframes
