#include "runtime/haptics/shell.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/haptics/servo.h"

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

/// Adds a point's force to the taxels that a square of `side` about it lies on, all in pitches from
/// the map's middle. What of the square is beside the map comes to the part that is not.
void spread(double force, const Eigen::Vector2d& place, double side,
            std::array<double, TaxelMap::kTaxels>& to) noexcept {
  constexpr double kHalf = TaxelMap::kSide / 2.0;
  if (!(place.cwiseAbs().maxCoeff() <= kHalf)) return;
  const double half = std::max(side, 1e-6) / 2;
  const Eigen::Array2d low = (place.array() + kHalf - half).max(0.0);
  const Eigen::Array2d high = (place.array() + kHalf + half).min(2 * kHalf);
  const double density = force / (high - low).prod();
  const auto last = [](double end) { return std::min(static_cast<int>(end), TaxelMap::kSide - 1); };
  constexpr std::size_t kSide = TaxelMap::kSide;
  for (int row = static_cast<int>(low.y()); row <= last(high.y()); ++row) {
    const double tall = std::min(row + 1.0, high.y()) - std::max<double>(row, low.y());
    for (int column = static_cast<int>(low.x()); column <= last(high.x()); ++column) {
      const double wide = std::min(column + 1.0, high.x()) - std::max<double>(column, low.x());
      to[static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(column)] +=
          density * tall * wide;
    }
  }
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
    shell.normals.emplace_back(shell.points_mm.back() / radius_mm);
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
  if (!shell.normals.empty() && shell.normals.size() != count) {
    throw_invalid("a shell must have a normal for each of its points, or none");
  }
  for (std::size_t n = 0; n < count; ++n) {
    if (!shell.normals.empty() && !(std::abs(shell.normals[n].norm() - 1) < 1e-6)) {
      throw_invalid("the normal of point " + std::to_string(n) + " of a shell is no unit vector");
    }
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
    if (!shell.normals.empty()) normals_.push_back(shell.normals[n]);
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
  reset();
  position_mm_ = x;
  turn_ = turn;
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
  asked_ = asked;

  Vec3 force = Vec3::Zero();
  Vec3 torque = Vec3::Zero();
  for (std::size_t n = 0; n < asked; ++n) {
    const FieldSample& answer = answers_[n];
    nearest_mm = std::min(nearest_mm, answer.distance_mm);
    if (!(answer.distance_mm < 0)) continue;
    const Vec3 push = areas_mm2_[asked_point_[n]] * -answer.distance_mm * outward_of(n);
    force += push;
    torque += (asked_mm_[n] - x).cross(push);
    if (-answer.distance_mm > contact.depth_mm) {
      const double length = answer.gradient.norm();
      contact.depth_mm = -answer.distance_mm;
      contact.surface_velocity_mm_s =
          length >= kShortest ? -moment.speed * answer.rate_mm_s / length : 0;
    }
  }
  contact.distance_mm = contact.depth_mm > 0 ? -contact.depth_mm : std::max(0.0, nearest_mm);
  contact.touching = contact.depth_mm > 0;
  contact.force_n = foundation_n_per_mm3_ * force;
  contact.torque_n_mm = foundation_n_per_mm3_ * torque;
  force_n_ = contact.force_n;
  const double size = contact.force_n.norm();
  if (size > 0) contact.normal = contact.force_n / size;
  contact.proxy_mm = x + contact.depth_mm * contact.normal;
  return contact;
}

void ShellModel::reset() noexcept {
  asked_ = 0;
  force_n_.setZero();
}

Vec3 ShellModel::outward_of(std::size_t asked) const noexcept {
  const Vec3& gradient = answers_[asked].gradient;
  const double length = gradient.norm();
  return length >= kShortest ? Vec3(gradient / length) : field_->outward(asked_mm_[asked]);
}

TaxelMap ShellModel::taxels(const Vec3& right, double pitch_mm) const noexcept {
  TaxelMap out;
  out.pitch_mm = pitch_mm == 0 ? 2 * bound_mm_ / TaxelMap::kSide : pitch_mm;
  const double force_n = force_n_.norm();
  if (!(force_n > 0 && std::isfinite(force_n) && out.pitch_mm >= TaxelOptions::kLeastPitchMm &&
        out.pitch_mm <= TaxelOptions::kMostPitchMm)) {
    return out;
  }
  const Vec3 n = force_n_ / force_n;
  out.right = across(n, right);
  out.up = n.cross(out.right);
  std::array<double, TaxelMap::kTaxels> force{};
  double whole = 0;  // of all points [N]
  double depth_mm = 0;
  double height_mm = 0;  // of the plane of contact over the tool's centre
  for (std::size_t at = 0; at < asked_; ++at) {
    const double depth = -answers_[at].distance_mm;
    if (!(depth > 0)) continue;
    const std::size_t point = asked_point_[at];
    const Vec3 arm = asked_mm_[at] - position_mm_;
    const double area_mm2 = areas_mm2_[point];
    out.area_mm2 +=
        normals_.empty() ? area_mm2 : area_mm2 * std::max(0.0, -n.dot(turn_ * normals_[point]));
    if (depth > depth_mm) {
      depth_mm = depth;
      height_mm = arm.dot(n) + depth;
    }
    // What would pull, as the far side of a thin wall does, is no pressure.
    const double push =
        foundation_n_per_mm3_ * area_mm2 * depth * std::max(0.0, n.dot(outward_of(at)));
    whole += push;
    spread(push, Eigen::Vector2d(arm.dot(out.right), arm.dot(out.up)) / out.pitch_mm,
           std::sqrt(area_mm2) / out.pitch_mm, force);
  }
  out.centre_mm = position_mm_ + height_mm * n;
  out.peak_kpa = TaxelMap::kKpaPerNMm2 * foundation_n_per_mm3_ * depth_mm;
  const double per_force = TaxelMap::kKpaPerNMm2 * force_n / (whole * out.pitch_mm * out.pitch_mm);
  for (std::size_t at = 0; at < force.size(); ++at) {
    out.pressure_kpa[at] = static_cast<float>(force[at] * per_force);
  }
  return out;
}

TaxelMap taxels_of(ShellModel& model, const Published& seen, double t, const Vec3& right,
                   double pitch_mm) noexcept {
  double share = 0;  // of the model's force that is felt
  if (seen.touching) {
    const auto& q = seen.orientation;
    const Contact contact =
        model.evaluate({.time_s = seen.time_s,
                        .position_mm = Vec3(seen.position_mm.data()),
                        .orientation = Eigen::Quaterniond(q[3], q[0], q[1], q[2])},
                       {.field_time_s = t});
    const double force_n = contact.force_n.norm();
    if (force_n > 0) share = Vec3(seen.force_n.data()).dot(contact.normal) / force_n;
  }
  if (!(share > 0)) model.reset();
  TaxelMap out = model.taxels(right, pitch_mm);
  for (float& pressure : out.pressure_kpa) {
    pressure = static_cast<float>(share * static_cast<double>(pressure));
  }
  out.peak_kpa *= share;
  return out;
}

}  // namespace beatlas::haptics
