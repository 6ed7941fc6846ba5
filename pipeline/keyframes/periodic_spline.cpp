#include "pipeline/keyframes/periodic_spline.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "runtime/base/error.h"

namespace beatlas::keyframes {
namespace {

Eigen::Index at_index(std::size_t n) { return static_cast<Eigen::Index>(n); }

}  // namespace

PeriodicSpline::PeriodicSpline(std::vector<double> at) : at_(std::move(at)) {
  const std::size_t count = at_.size();
  if (count < 3) throw_invalid("a cycle needs three keys or more");
  for (std::size_t n = 0; n < count; ++n) {
    if (!(at_[n] >= 0 && at_[n] < 1) || (n > 0 && !(at_[n] > at_[n - 1]))) {
      throw_invalid("keys must stand in ascending order at shares of the cycle from 0 to below 1");
    }
  }
  // Equal slopes from both sides at every key.
  const auto size = at_index(count);
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(size, size);
  const auto gap = [&](std::size_t n) {
    return n + 1 < count ? at_[n + 1] - at_[n] : at_[0] + 1 - at_[n];
  };
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t before = (n + count - 1) % count;
    const std::size_t after = (n + 1) % count;
    const double left = gap(before);
    const double right = gap(n);
    slopes(at_index(n), at_index(before)) += left / 6;
    slopes(at_index(n), at_index(n)) += (left + right) / 3;
    slopes(at_index(n), at_index(after)) += right / 6;
    values(at_index(n), at_index(before)) += 1 / left;
    values(at_index(n), at_index(n)) -= 1 / left + 1 / right;
    values(at_index(n), at_index(after)) += 1 / right;
  }
  bend_ = slopes.partialPivLu().solve(values);
}

Eigen::VectorXd PeriodicSpline::weights(double share) const {
  const std::size_t count = at_.size();
  double u = share - std::floor(share);
  if (u < at_.front()) u += 1;
  const auto above = std::upper_bound(at_.begin(), at_.end(), u);
  const auto n = static_cast<std::size_t>(above - at_.begin()) - 1;
  const std::size_t after = (n + 1) % count;
  const double gap = n + 1 < count ? at_[n + 1] - at_[n] : at_[0] + 1 - at_[n];
  const double b = (u - at_[n]) / gap;
  const double a = 1 - b;
  Eigen::VectorXd out =
      gap * gap / 6 *
      ((a * a * a - a) * bend_.row(at_index(n)) + (b * b * b - b) * bend_.row(at_index(after)))
          .transpose();
  out[at_index(n)] += a;
  out[at_index(after)] += b;
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
