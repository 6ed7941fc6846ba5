#include "runtime/palpation/patch_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::palpation {
namespace {

constexpr double kMPerMm = 1e-3;
constexpr double kShortest = 0.05;  // of a gradient that is a direction
constexpr int kLooks = 2;           // until the lowest point of a ball is found
constexpr double kAwayM = -0.05;    // above the wall, wherever the others have moved it

const haptics::ContactField& checked(const std::shared_ptr<const haptics::ContactField>& field) {
  if (!field) throw_invalid("there is no distance field to touch; open the atlas with it");
  return *field;
}

Tissue tissue_of(const PatchModelOptions& options) {
  if (options.tissue) return *options.tissue;
  if (options.segment < 1 || options.segment > kSegments) return {};
  return options.parameters.segments[static_cast<std::size_t>(options.segment - 1)];
}

// What was written as a double, and may come from a file.
std::uint32_t index_of(double number) noexcept {
  return number >= 0 && number < 4e9 ? static_cast<std::uint32_t>(number) : 0;
}

VerticalPatch patch_of(const PatchModelOptions& options) {
  const PalpationParameters& parameters = options.parameters;
  parameters.check();
  return VerticalPatch(
      {.mass_kg = parameters.wall_mass_kg,
       .damping_n_s_per_m = parameters.at(options.long_axis, tissue_of(options)).c_v_n_s_per_m,
       .contact_n_per_m = parameters.contact_n_per_m});
}

}  // namespace

PatchModel::PatchModel(std::shared_ptr<const haptics::ContactField> field,
                       const PatchModelOptions& options)
    : field_(std::move(field)),
      patch_(patch_of(options)),
      whole_(patch_),
      curve_(checked(field_).period_s(),
             options.parameters.whole_circulation().relaxation_rate_per_s),
      end_diastole_s_(options.end_diastole_s),
      radius_mm_(options.radius_mm),
      natural_(options.muscle ? options.muscle->natural() : natural_wall(options.parameters)),
      constants_(patch_constants(options.parameters, natural_.shortening_area_cm2,
                                 options.long_axis, tissue_of(options))),
      muscle_(options.muscle),
      circulation_(options.circulation),
      finger_(options.finger),
      told_shortening_(options.parameters.contractile.shortening_area_cm2 > 0) {
  if (!(options.long_axis >= 0 && options.long_axis <= 1)) {
    throw_invalid("a patch's place on the long axis must be from 0 to 1");
  }
  if (!std::isfinite(end_diastole_s_)) throw_invalid("a patch's end-diastole must be a time");
  if (!(radius_mm_ >= 0 && radius_mm_ <= 20)) {
    throw_invalid("a fingertip's radius must be from 0 to 20 mm");
  }
}

haptics::Contact PatchModel::evaluate(const haptics::ServoState& state,
                                      const haptics::Moment& moment) noexcept {
  const Vec3& x = state.position_mm;
  haptics::FieldSample sample = field_->sample(x, moment.field_time_s);
  double slope = sample.gradient.norm();
  Vec3 at = x;  // where it was sampled
  // Beyond the field's band a ball is touched where it is lowest, not by what its middle knows.
  const bool beyond = slope < kShortest && sample.distance_mm > 0;
  Vec3 lowest = beyond ? field_->outward(x) : Vec3(Vec3::Zero());
  for (int look = 0; look < kLooks && beyond && radius_mm_ > 0; ++look) {
    at = x - radius_mm_ * lowest;
    sample = field_->sample(at, moment.field_time_s);
    slope = sample.gradient.norm();
    if (slope < kShortest) break;
    lowest = sample.gradient / slope;
  }
  const bool away = beyond && slope < kShortest && sample.distance_mm > 0;
  const double beats = (moment.field_time_s - end_diastole_s_) / curve_.period_s();
  const double e = curve_.at((beats - std::floor(beats)) * curve_.period_s()).value;

  haptics::Contact contact;
  contact.normal = slope >= kShortest ? Vec3(sample.gradient / slope) : field_->outward(x);
  contact.distance_mm = sample.distance_mm - (radius_mm_ - (x - at).norm());
  contact.depth_mm = std::max(0.0, -contact.distance_mm);
  contact.surface_velocity_mm_s = slope >= kShortest ? -moment.speed * sample.rate_mm_s / slope : 0;
  const PatchConstants& here = muscle_
                                   ? muscle_->under(at - sample.distance_mm * contact.normal,
                                                    moment.field_time_s / curve_.period_s(), trail_)
                                   : constants_;
  // The finger's force goes on where it slides to other muscle: that gives way from there on.
  patch_.set_damping(here.c_v_n_s_per_m);
  const CommonCirculation::Felt felt =
      circulation_ ? circulation_->felt(finger_)
                   : CommonCirculation::Felt{.pressure_n_per_m = natural_.pressure_at(beats)};
  const double shortening = told_shortening_ ? 1 : felt.shortening_ratio;
  const double force_n = patch_.advance(
      away ? kAwayM : -kMPerMm * contact.distance_mm + felt.wall_m - felt.given_m,
      here.k_v_n_per_m + here.contracted_n_per_m(e) * shortening + felt.pressure_n_per_m,
      moment.elapsed_s);
  contact.touching = force_n > 0;
  contact.force_n = force_n * contact.normal;
  contact.proxy_mm = x + contact.depth_mm * contact.normal;
  return contact;
}

void PatchModel::reset() noexcept { patch_ = whole_; }

haptics::ModelMemory PatchModel::memory() const noexcept {
  const VerticalPatch::State state = patch_.state();
  return {state.wall.place_m,
          state.wall.speed_m_s,
          state.depth_m,
          state.stiffness_n_per_m,
          state.touching ? 1.0 : 0.0,
          static_cast<double>(trail_.vertex),
          static_cast<double>(trail_.looked)};
}

void PatchModel::restore(const haptics::ModelMemory& memory) noexcept {
  patch_.restore({.wall = {memory[0], memory[1]},
                  .depth_m = memory[2],
                  .stiffness_n_per_m = memory[3],
                  .touching = memory[4] != 0});
  trail_ = {.vertex = index_of(memory[5]), .looked = index_of(memory[6])};
}

bool PatchModel::take_over(const haptics::ForceModel& before) noexcept {
  const auto* const other = dynamic_cast<const PatchModel*>(&before);
  if (other == nullptr || other->field_ != field_ || other->radius_mm_ != radius_mm_ ||
      other->circulation_ != circulation_ || other->finger_ != finger_) {
    return false;
  }
  restore(other->memory());
  return true;
}

}  // namespace beatlas::palpation
