#include "runtime/haptics/shell.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::haptics {
namespace {

constexpr std::size_t kClusterPoints = 64;
constexpr double kSteepest = 1.2;   // of a gradient: ContactField's promise
constexpr double kShortest = 0.05;  // of a gradient that is a direction

// Halves the widest extent until the parts are small: points that follow each other are neighbours.
void sort_by_place(const std::vector<Vec3>& points, std::span<std::size_t> order) {
  if (order.size() <= kClusterPoints) return;
  Eigen::AlignedBox3d box;
  for (std::size_t n : order) box.extend(points[n]);
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  // Whole clusters on the left, so that all but the last are full.
  const std::size_t clusters = (order.size() + kClusterPoints - 1) / kClusterPoints;
  const std::size_t left = (clusters + 1) / 2 * kClusterPoints;
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(left), order.end(),
                   [&](std::size_t a, std::size_t b) {
                     return std::pair(points[a][axis], a) < std::pair(points[b][axis], b);
                   });
  sort_by_place(points, order.first(left));
  sort_by_place(points, order.subspan(left));
}

}  // namespace

Shell fingertip(double radius_mm, std::size_t points) {
  if (!(radius_mm >= 0.1 && radius_mm <= 50)) {
    throw_invalid("a fingertip's radius must be from 0.1 to 50 mm");
  }
  if (points < 1 || points > Shell::kMostPoints) {
    throw_invalid("a fingertip must have from 1 to 10000 points");
  }
  Shell shell;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  const double area_mm2 =
      2 * std::numbers::pi * radius_mm * radius_mm / static_cast<double>(points);
  for (std::size_t n = 0; n < points; ++n) {
    // Equal heights cut equal areas off a sphere (Archimedes); turns by the golden angle.
    const double z = -(static_cast<double>(n) + 0.5) / static_cast<double>(points);
    const double r = std::sqrt(1 - z * z);
    const double turn = golden * static_cast<double>(n);
    shell.points_mm.emplace_back(radius_mm * Vec3(r * std::cos(turn), r * std::sin(turn), z));
    shell.areas_mm2.push_back(area_mm2);
  }
  return shell;
}

ShellModel::ShellModel(std::shared_ptr<const ContactField> field, const Shell& shell,
                       const ShellOptions& options)
    : field_(std::move(field)), foundation_n_per_mm3_(1e-9 * options.foundation_n_per_m3) {
  if (!field_) throw_invalid("there is no distance field to touch; open the atlas with it");
  if (!(options.foundation_n_per_m3 >= 1e3 && options.foundation_n_per_m3 <= 1e9)) {
    throw_invalid("a shell's foundation must be from 1e3 to 1e9 N/m^3");
  }
  const std::size_t count = shell.points_mm.size();
  if (count < 1 || count > Shell::kMostPoints || shell.areas_mm2.size() != count) {
    throw_invalid("a shell must have from 1 to 10000 points, each with its area");
  }
  for (std::size_t n = 0; n < count; ++n) {
    if (!shell.points_mm[n].allFinite() || !(shell.areas_mm2[n] >= 0 && shell.areas_mm2[n] < 1e6)) {
      throw_invalid("point " + std::to_string(n) + " of a shell has no place or no area");
    }
  }
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  sort_by_place(shell.points_mm, order);
  for (std::size_t n : order) {
    points_mm_.push_back(shell.points_mm[n]);
    areas_mm2_.push_back(shell.areas_mm2[n]);
    bound_mm_ = std::max(bound_mm_, shell.points_mm[n].norm());
  }
  for (std::size_t first = 0; first < count; first += kClusterPoints) {
    Cluster cluster{Vec3::Zero(), 0, first, std::min(kClusterPoints, count - first)};
    Eigen::AlignedBox3d box;
    for (std::size_t n = 0; n < cluster.count; ++n) box.extend(points_mm_[first + n]);
    cluster.centre_mm = box.center();
    for (std::size_t n = 0; n < cluster.count; ++n) {
      cluster.radius_mm =
          std::max(cluster.radius_mm, (points_mm_[first + n] - cluster.centre_mm).norm());
    }
    clusters_.push_back(cluster);
  }
  asked_mm_.resize(count);
  asked_point_.resize(count);
  answers_.resize(count);
  batch_ = field_->batch(2 * bound_mm_);
}

Contact ShellModel::evaluate(const ServoState& state, const Moment& moment) noexcept {
  const Vec3& x = state.position_mm;
  const double t = moment.field_time_s;
  const Eigen::Matrix3d turn = state.orientation.normalized().toRotationMatrix();
  Contact contact;
  contact.proxy_mm = x;
  const FieldSample middle = field_->sample(x, t);
  samples_ = 1;
  const double slope = middle.gradient.norm();
  contact.normal = slope >= kShortest ? Vec3(middle.gradient / slope) : field_->outward(x);
  contact.distance_mm = std::max(0.0, middle.distance_mm - kSteepest * bound_mm_);
  if (middle.distance_mm > kSteepest * bound_mm_) return contact;

  // Clusters that may touch, by the distance at their middle.
  for (std::size_t n = 0; n < clusters_.size(); ++n) {
    asked_mm_[n] = x + turn * clusters_[n].centre_mm;
  }
  const std::span<FieldSample> answers(answers_);
  batch_->sample(std::span<const Vec3>(asked_mm_).first(clusters_.size()), t,
                 answers.first(clusters_.size()));
  samples_ += clusters_.size();
  double nearest_mm = middle.distance_mm;
  std::size_t asked = 0;
  for (std::size_t c = 0; c < clusters_.size(); ++c) {
    const Cluster& cluster = clusters_[c];
    const double room = answers_[c].distance_mm - kSteepest * cluster.radius_mm;
    nearest_mm = std::min(nearest_mm, std::max(room, 0.0));
    if (room > 0) continue;
    for (std::size_t n = 0; n < cluster.count; ++n) asked_point_[asked++] = cluster.first + n;
  }
  for (std::size_t n = 0; n < asked; ++n) asked_mm_[n] = x + turn * points_mm_[asked_point_[n]];
  batch_->sample(std::span<const Vec3>(asked_mm_).first(asked), t, answers.first(asked));
  samples_ += asked;

  Vec3 force = Vec3::Zero();
  Vec3 torque = Vec3::Zero();
  for (std::size_t n = 0; n < asked; ++n) {
    const FieldSample& answer = answers_[n];
    nearest_mm = std::min(nearest_mm, answer.distance_mm);
    if (!(answer.distance_mm < 0)) continue;
    const double length = answer.gradient.norm();
    const Vec3 out =
        length >= kShortest ? Vec3(answer.gradient / length) : field_->outward(asked_mm_[n]);
    const Vec3 push = areas_mm2_[asked_point_[n]] * -answer.distance_mm * out;
    force += push;
    torque += (asked_mm_[n] - x).cross(push);
    if (-answer.distance_mm > contact.depth_mm) {
      contact.depth_mm = -answer.distance_mm;
      contact.surface_velocity_mm_s =
          length >= kShortest ? -moment.speed * answer.rate_mm_s / length : 0;
    }
  }
  contact.distance_mm = contact.depth_mm > 0 ? -contact.depth_mm : std::max(0.0, nearest_mm);
  contact.touching = contact.depth_mm > 0;
  contact.force_n = foundation_n_per_mm3_ * force;
  contact.torque_n_mm = foundation_n_per_mm3_ * torque;
  const double size = contact.force_n.norm();
  if (size > 0) contact.normal = contact.force_n / size;
  contact.proxy_mm = x + contact.depth_mm * contact.normal;
  return contact;
}

}  // namespace beatlas::haptics
