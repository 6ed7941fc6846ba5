#include "runtime/haptics/proxy.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/haptics/capsule_axis.h"

namespace beatlas::haptics {
namespace {

constexpr int kMostSlides = 10;  // samples in contact; each leaves depth / radius of the error
constexpr int kMostCarries = 8;
constexpr int kMostPlacings = 64;
constexpr double kSettledMm = 1e-3;  // what is left then is a tenth of it or less: 1e-4 N at most
constexpr double kStaleMm = 1e-5;    // how far a plane may forbid what is on the surface
constexpr double kShortest = 0.05;   // of a gradient that is a direction
constexpr double kSteepest = 1.2;    // of a gradient: ContactField's promise
constexpr double kNewtonShortest = 0.4;  // a shorter gradient must not throw the proxy far
constexpr double kLeapMm = 100;          // from tick to tick; a hand at 1 m/s moves 1 mm

void check(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  std::ostringstream text;
  text << "the proxy's " << name << " must be from " << low << " to " << high;
  throw_invalid(text.str());
}

}  // namespace

struct ProxyModel::Slide {
  Vec3 allowed;  // nearest point to the tool that the planes leave
  bool held = false;
  FieldSample sample;  // the last one, near `allowed`
};

ProxyModel::ProxyModel(std::shared_ptr<const ContactField> field, const ProxyOptions& options)
    : field_(std::move(field)),
      options_(options),
      half_axis_mm_(options.half_length_mm * Vec3::UnitZ()) {
  if (!field_) throw_invalid("there is no distance field to touch; open the atlas with it");
  check("stiffness_n_per_m", options.stiffness_n_per_m, kSoftestNPerM, kStiffestNPerM);
  check("radius_mm", options.radius_mm, 0, field_->reach_mm());
  check("half_length_mm", options.half_length_mm, 0, 100);
  check("damping_n_s_per_m", options.damping_n_s_per_m, 0, 100);
  check("damper_spring_n_per_m", options.damper_spring_n_per_m, kSoftestNPerM, kStiffestNPerM);
  check("friction_static", options.friction_static, 0, 1);
  check("friction_dynamic", options.friction_dynamic, 0, options.friction_static);
  // A third of the thinnest wall: a step into it cannot come near its other side.
  longest_step_mm_ = 0.5 * field_->resolution_mm();
}

void ProxyModel::reset() noexcept {
  placed_ = false;
  touching_ = false;
  direction_ = Vec3::Zero();
  depth_mm_ = 0;
  damper_n_ = 0;
  rubs_ = false;
  sticks_ = false;
}

FieldSample ProxyModel::tool_at(const Vec3& p, double t) noexcept {
  if (options_.half_length_mm == 0) return field_->sample(p, t);
  const NearestOnAxis nearest = nearest_on_axis(*field_, {p, half_axis_mm_}, t, kSteepest);
  share_ = nearest.share;
  return nearest.sample;
}

void ProxyModel::place(const Vec3& x, double t) noexcept {
  proxy_mm_ = x;
  touching_ = false;
  for (int n = 0; n < kMostPlacings; ++n) {
    const FieldSample sample = tool_at(proxy_mm_, t);
    const double missing = options_.radius_mm - sample.distance_mm;
    if (missing <= kSettledMm) {
      placed_ = true;
      return;
    }
    const double slope = sample.gradient.norm();
    const Vec3 out = slope >= kShortest ? Vec3(sample.gradient / slope)
                                        : field_->outward(proxy_mm_ + share_ * half_axis_mm_);
    // Short steps: past the middle of a wall the way out is another one.
    proxy_mm_ +=
        std::min(missing / std::clamp(slope, kNewtonShortest, 1.0), 4 * longest_step_mm_) * out;
  }
}

void ProxyModel::carry(const Vec3& x, double t) noexcept {
  if (!touching_) return;
  const double moved_mm = speed_mm_s_ * (t - time_s_);
  const int parts = static_cast<int>(
      std::min<double>(kMostCarries, std::ceil(std::abs(moved_mm) / (0.5 * longest_step_mm_))));
  for (int n = 1; n < parts; ++n) {
    const FieldSample sample = tool_at(proxy_mm_, time_s_ + (t - time_s_) * n / parts);
    const double slope = sample.gradient.norm();
    if (slope < kShortest) continue;
    const double gap = (sample.distance_mm - options_.radius_mm) / std::max(slope, kNewtonShortest);
    if (gap < 0) proxy_mm_ -= gap / slope * sample.gradient;
  }
  if (parts > 1 || !one_plane_) return;
  // A first step without a sample: on the plane of the tick before, moved as the surface did.
  const double excess = direction_.dot(x - proxy_mm_) - moved_mm;
  if (excess >= 0) return;
  const Vec3 step = x - excess * direction_ - proxy_mm_;
  if (step.norm() <= 0.5 * longest_step_mm_) proxy_mm_ += step;
}

ProxyModel::Slide ProxyModel::slide(const Vec3& x, double t) noexcept {
  HalfSpaces planes;
  Slide out{.allowed = proxy_mm_, .held = touching_, .sample = {}};
  double last_length = 0;
  one_plane_ = false;
  for (int n = 0; n < kMostSlides; ++n) {
    out.sample = tool_at(proxy_mm_, t);
    const double room = out.sample.distance_mm - options_.radius_mm;
    if (room >= kSteepest * (x - proxy_mm_).norm()) {  // nothing can lie in between
      proxy_mm_ = x;
      out.allowed = x;
      out.held = false;
      return out;
    }
    const double slope = out.sample.gradient.norm();
    if (slope >= kShortest) direction_ = out.sample.gradient / slope;
    if (slope >= kShortest || room < 0) {
      const double gap = room / std::max(slope, kNewtonShortest);
      planes.drop_stale(proxy_mm_ - gap * direction_, proxy_mm_, room / kSteepest, direction_,
                        kStaleMm);
      planes.add({.normal = direction_, .offset = direction_.dot(proxy_mm_) - gap});
      out.allowed = planes.nearest(x, out.held);
    } else {
      out.allowed = x;
      out.held = false;
    }
    const Vec3 step = out.allowed - proxy_mm_;
    const double length = step.norm();
    const double longest = std::max(longest_step_mm_, room / kSteepest);
    const bool is_cut = length > longest;
    proxy_mm_ += is_cut ? Vec3(longest / length * step) : step;
    one_plane_ = planes.size() == 1;
    // Steps shrink by the same share each: what is left is about the next one.
    const double share = n > 0 && one_plane_ ? std::min(1.0, length / last_length) : 1;
    if (out.held && length * share < kSettledMm) return out;
    last_length = length;
    // What lies farther has not been looked at, as where a valve opens before a tool far behind it:
    // the proxy goes on from here at the next tick.
    if (out.held && is_cut && n + 1 == kMostSlides) out.allowed = proxy_mm_;
  }
  return out;
}

Vec3 ProxyModel::friction_n(const Contact& contact, double stiffness, double t) noexcept {
  // Back onto the surface, which has moved since or curves away under a straight step.
  const auto onto_surface = [&] {
    const FieldSample sample = tool_at(stuck_mm_, t);
    const double slope = sample.gradient.norm();
    if (slope < kShortest) return;
    const double gap = (sample.distance_mm - options_.radius_mm) / std::max(slope, kNewtonShortest);
    stuck_mm_ -= std::clamp(gap, -longest_step_mm_, longest_step_mm_) / slope * sample.gradient;
  };
  const auto sideways = [&] {
    const Vec3 from_proxy = stuck_mm_ - contact.proxy_mm;
    return Vec3(from_proxy - from_proxy.dot(contact.normal) * contact.normal);
  };
  if (!rubs_) {
    stuck_mm_ = contact.proxy_mm;
    rubs_ = true;
    sticks_ = true;
    return Vec3::Zero();
  }
  onto_surface();
  const double mu = sticks_ ? options_.friction_static : options_.friction_dynamic;
  sticks_ = sideways().norm() <= mu * contact.depth_mm;
  const double most_mm = (sticks_ ? mu : options_.friction_dynamic) * contact.depth_mm;
  if (!sticks_) {
    const Vec3 aside = sideways();
    stuck_mm_ = contact.proxy_mm + most_mm / aside.norm() * aside;
    onto_surface();
  }
  Vec3 aside = sideways();
  const double length = aside.norm();
  if (length > most_mm) aside *= most_mm / length;
  return stiffness * 1e-3 * aside;
}

double ProxyModel::damped_force_n(double stiffness, double depth_mm, double elapsed_s) noexcept {
  double force = stiffness * 1e-3 * depth_mm;
  if (options_.damping_n_s_per_m > 0) {
    // f' = k e' - (k / C) f, solved exactly for a depth that is linear over the tick.
    const double k = options_.damper_spring_n_per_m;
    const double ticks = elapsed_s * k / options_.damping_n_s_per_m;
    const double kept = std::exp(-ticks);
    const double mean = ticks > 1e-9 ? (1 - kept) / ticks : 1;
    damper_n_ = kept * damper_n_ + mean * k * 1e-3 * (depth_mm - depth_mm_);
    damper_n_ = std::max(damper_n_, -force);  // a surface never pulls; the branch gives way
    force += damper_n_;
  }
  return force;
}

Contact ProxyModel::evaluate(const Vec3& x, double t, double elapsed_s) noexcept {
  // Where the distance is clamped the proxy walks some 25 mm a tick: the way from metres off would
  // take it seconds, without a contact until then. Who leaps so far begins anew instead.
  if (!touching_ && !((x - proxy_mm_).stableNorm() <= kLeapMm)) placed_ = false;
  const bool starts = !placed_;
  if (starts) place(x, t);
  Contact contact;
  if (!placed_) return contact;  // no way out was found: no force, and another try at the next tick
  carry(x, t);
  const Slide slid = slide(x, t);
  const double slope = slid.sample.gradient.norm();
  speed_mm_s_ = slope >= kShortest ? -slid.sample.rate_mm_s / slope : 0;
  touching_ = slid.held;
  time_s_ = t;
  contact.touching = slid.held;
  contact.proxy_mm = slid.allowed;
  if (slid.held) {
    contact.surface_velocity_mm_s = speed_mm_s_;
    const Vec3 push = slid.allowed - x;
    contact.depth_mm = push.norm();
    contact.distance_mm = -contact.depth_mm;
    if (starts) depth_mm_ = contact.depth_mm;  // a start inside is no movement
    contact.normal = contact.depth_mm > 0 ? Vec3(push / contact.depth_mm) : direction_;
    const Vec3 touched_mm =
        slid.allowed + share_ * half_axis_mm_ - options_.radius_mm * contact.normal;
    const double stiffness = options_.map ? std::clamp(options_.map->n_per_m(touched_mm, t),
                                                       kSoftestNPerM, kStiffestNPerM)
                                          : options_.stiffness_n_per_m;
    contact.force_n = damped_force_n(stiffness, contact.depth_mm, elapsed_s) * contact.normal;
    if (options_.friction_static > 0) contact.force_n += friction_n(contact, stiffness, t);
    if (options_.half_length_mm > 0) {
      const double share = pressed_share(*field_, {slid.allowed, half_axis_mm_}, options_.radius_mm,
                                         contact.depth_mm, t);
      const Vec3 lever_mm = share * half_axis_mm_ - options_.radius_mm * contact.normal;
      contact.torque_n_mm = lever_mm.cross(contact.force_n);
    }
  } else {
    const FieldSample at_tool = tool_at(x, t);
    const double tool_slope = at_tool.gradient.norm();
    const bool directed = tool_slope >= kShortest;
    contact.normal = directed ? Vec3(at_tool.gradient / tool_slope)
                              : field_->outward(x + share_ * half_axis_mm_);
    contact.surface_velocity_mm_s = directed ? -at_tool.rate_mm_s / tool_slope : 0;
    contact.distance_mm = std::max(0.0, at_tool.distance_mm - options_.radius_mm);
    damper_n_ = 0;
    rubs_ = false;
  }
  depth_mm_ = contact.depth_mm;
  return contact;
}

Contact ProxyModel::evaluate(const ServoState& state, const Moment& moment) noexcept {
  half_axis_mm_ = options_.half_length_mm * (state.orientation.normalized() * Vec3::UnitZ());
  Contact contact = evaluate(state.position_mm, moment.field_time_s, moment.elapsed_s);
  contact.surface_velocity_mm_s *= moment.speed;
  return contact;
}

ModelMemory ProxyModel::memory() const noexcept {
  return {placed_ ? 1.0 : 0.0,
          touching_ ? 1.0 : 0.0,
          proxy_mm_.x(),
          proxy_mm_.y(),
          proxy_mm_.z(),
          direction_.x(),
          direction_.y(),
          direction_.z(),
          time_s_,
          speed_mm_s_,
          depth_mm_,
          damper_n_,
          (one_plane_ ? 1.0 : 0.0) + (rubs_ ? 2.0 : 0.0) + (sticks_ ? 4.0 : 0.0),
          stuck_mm_.x(),
          stuck_mm_.y(),
          stuck_mm_.z()};
}

void ProxyModel::restore(const ModelMemory& memory) noexcept {
  placed_ = memory[0] != 0;
  touching_ = memory[1] != 0;
  proxy_mm_ = Vec3(memory[2], memory[3], memory[4]);
  direction_ = Vec3(memory[5], memory[6], memory[7]);
  time_s_ = memory[8];
  speed_mm_s_ = memory[9];
  depth_mm_ = memory[10];
  damper_n_ = memory[11];
  const int flags = static_cast<int>(memory[12]);
  one_plane_ = (flags & 1) != 0;
  rubs_ = (flags & 2) != 0;
  sticks_ = (flags & 4) != 0;
  stuck_mm_ = Vec3(memory[13], memory[14], memory[15]);
}

bool ProxyModel::take_over(const ForceModel& before) noexcept {
  const auto* const other = dynamic_cast<const ProxyModel*>(&before);
  if (other == nullptr || other->field_ != field_ ||
      other->options_.radius_mm != options_.radius_mm ||
      other->options_.half_length_mm != options_.half_length_mm) {
    return false;
  }
  restore(other->memory());
  return true;
}

}  // namespace beatlas::haptics
