#include "runtime/viewer/touch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/field/surface_point.h"
#include "runtime/haptics/cavity_field.h"
#include "runtime/haptics/contact_field.h"
#include "runtime/haptics/pericardial_field.h"
#include "runtime/haptics/proxy.h"
#include "runtime/palpation/dent.h"
#include "runtime/palpation/on_heart.h"
#include "runtime/palpation/patch_model.h"
#include "runtime/palpation/patch_stiffness.h"
#include "runtime/viewer/tick_times.h"

namespace beatlas::viewer {
namespace {

double wrapped(double phase) { return phase - std::floor(phase); }

}  // namespace

PressRow press_row(const Felt& felt) noexcept {
  const haptics::Published& servo = felt.servo;
  const Vec3 force(servo.force_n[0], servo.force_n[1], servo.force_n[2]);
  return {.time_s = servo.time_s,
          .force_n = force.norm(),
          .depth_mm = std::max(0.0, -servo.distance_mm),
          .volume_ml = felt.circulation.volume_ml,
          .lv_mmhg = felt.circulation.lv_mmhg,
          .beat = felt.circulation.beats,
          .touching = servo.touching || *std::max_element(felt.circulation.force_n.begin(),
                                                          felt.circulation.force_n.end()) > 0,
          .wishes = felt.wishes};
}

ToolPicture tool_picture_of(const haptics::Published& servo, double radius_mm,
                            double dent_radius_mm) noexcept {
  const auto vector = [](const std::array<double, 3>& v) { return Vec3(v[0], v[1], v[2]); };
  ToolPicture picture;
  picture.position_mm = vector(servo.position_mm);
  picture.proxy_mm = vector(servo.proxy_mm);
  picture.force_n = vector(servo.force_n);
  picture.radius_mm = radius_mm;
  picture.touching = servo.touching;
  picture.dent_radius_mm = dent_radius_mm;
  // Under the finger the wall lies where the finger is: the patch's depth below the moving surface.
  picture.dent_mm = std::max(0.0, -servo.distance_mm);
  const Vec3 normal = vector(servo.normal);
  if (normal.norm() > 0.5) picture.dent_normal = normal.normalized();
  picture.dent_place_mm = picture.proxy_mm - radius_mm * picture.dent_normal;
  if (!servo.touching) picture.dent_mm = 0;
  return picture;
}

void RowQueue::add(const PressRow& row) noexcept {
  const std::size_t added = added_.load(std::memory_order_relaxed);
  if (added - taken_.load(std::memory_order_acquire) >= kRows) return;
  rows_[added % kRows] = row;
  added_.store(added + 1, std::memory_order_release);
}

void RowQueue::take(std::vector<PressRow>& to) {
  to.clear();
  const std::size_t added = added_.load(std::memory_order_acquire);
  std::size_t taken = taken_.load(std::memory_order_relaxed);
  for (; taken != added; ++taken) to.push_back(rows_[taken % kRows]);
  taken_.store(taken, std::memory_order_release);
}

Touch::Touch(const atlas::Manifest& manifest, std::shared_ptr<const field::FieldQuery> field,
             const TouchSettings& settings, std::shared_ptr<const palpation::LvWall> wall,
             std::shared_ptr<const haptics::TubeField> valve)
    : field_(std::move(field)),
      settings_(settings),
      rr_interval_s_(manifest.rr_interval_s),
      wall_(std::move(wall)),
      valve_(std::move(valve)) {
  if (!field_) throw_invalid("there is no distance field to touch; open the atlas with it");
  band_ = atlas::band_query(manifest, field_->payload().structure);
  if (settings_.stiffness_n_per_m <= 0) settings_.stiffness_n_per_m = manifest.stiffness_n_per_m;
  if (settings_.heart_rate_per_min <= 0) settings_.heart_rate_per_min = 60 / rr_interval_s_;
  end_diastole_ = static_cast<double>(manifest.end_diastole) / std::max(1, manifest.phase_count());
  for (const atlas::StructureEntry& structure : manifest.structures) {
    if (structure.name != structure_name(Structure::LvBlood)) continue;
    const auto [least, most] =
        std::minmax_element(structure.volume_ml.begin(), structure.volume_ml.end());
    if (*least > 0 && *most > *least) volumes_ml_ = {*least, *most};
  }
  body_ = make_body();
  if (settings_.radii_mm.empty()) settings_.radii_mm = {settings_.tool_radius_mm};
  haptics::ServoOptions options;
  options.heart.rate_per_min = settings_.heart_rate_per_min;
  rate_hz_.store(settings_.heart_rate_per_min / 60);
  disease_ = settings_.disease ? *settings_.disease
                               : Disease{palpation::palpation_preset(settings_.preset)};
  wished_ = scaled(disease_);
  muscle_felt_.store(settings_.model == "patch");
  make_muscle();
  circulation_ = std::make_shared<palpation::CommonCirculation>(wished_, end_diastole_,
                                                                settings_.radii_mm.size());
  for (const double radius_mm : settings_.radii_mm) {
    fingers_.push_back(std::make_unique<Finger>());
    fingers_.back()->radius_mm = radius_mm;
    fingers_.back()->servo = std::make_unique<haptics::Servo>(scene(fingers_.size() - 1), options);
  }
}

std::shared_ptr<const haptics::ContactField> Touch::make_body() {
  if (settings_.effusion_mm > 0) {
    pericardium_ = haptics::pericardial_space_of(field_, settings_.effusion_mm);
    return pericardium_;
  }
  if (settings_.inside) return haptics::cavity_of(field_, valve_);
  return std::make_shared<haptics::AtlasField>(field_);
}

haptics::Scene Touch::scene(std::size_t finger) const {
  haptics::Scene scene;
  scene.period_s = field_->rr_interval_s();
  if (settings_.model == "patch" && !within()) {
    palpation::PatchModelOptions model;
    model.parameters = wished_;
    model.end_diastole_s = end_diastole_ * scene.period_s;
    model.radius_mm = settings_.radii_mm[finger];
    model.muscle = muscle_;
    // A single finger feels the natural beat, as it does without a picture.
    if (settings_.radii_mm.size() > 1) model.circulation = circulation_;
    model.finger = finger;
    scene.model = std::make_unique<palpation::PatchModel>(body_, model);
  } else if (settings_.model == "proxy") {
    haptics::ProxyOptions model;
    model.stiffness_n_per_m = settings_.stiffness_n_per_m;
    model.radius_mm = settings_.radii_mm[finger];
    scene.model = std::make_unique<haptics::ProxyModel>(body_, model);
  } else if (within()) {
    throw_invalid("a cavity and the pericardium are felt as a spring; choose the proxy model");
  } else {
    throw_invalid("there is no force model " + settings_.model + "; there are proxy and patch");
  }
  return scene;
}

void Touch::offer_scenes() {
  muscle_felt_.store(settings_.model == "patch");
  std::vector<haptics::Scene> scenes;
  for (std::size_t n = 0; n < fingers_.size(); ++n) scenes.push_back(scene(n));
  for (std::size_t n = 0; n < fingers_.size(); ++n) fingers_[n]->servo->offer(std::move(scenes[n]));
}

void Touch::forget_taxels() {
  for (const auto& finger : fingers_) finger->taxels.reset();
}

// Of what is wished now.
void Touch::make_muscle() {
  if (!wall_) return;
  muscle_ = std::make_shared<palpation::AtlasMuscle>(wall_, tissue_of(wished_, disease_), wished_);
}

// There must be a wall.
palpation::TissueMap Touch::tissue_of(const palpation::PalpationParameters& parameters,
                                      const Disease& disease) const {
  return palpation::tissue_of_wall(*wall_, parameters.segments, disease.regions, disease.maps);
}

palpation::PalpationParameters Touch::scaled(const Disease& disease) const {
  palpation::PalpationParameters parameters = disease.parameters;
  if (wall_) parameters.infarct = tissue_of(parameters, disease).infarct;
  if (volumes_ml_) {
    parameters = palpation::on_heart(parameters, {.edv_ml = (*volumes_ml_)[1],
                                                  .esv_ml = (*volumes_ml_)[0],
                                                  .heart_rate_per_min = 60 / rr_interval_s_});
  }
  parameters.circulation.heart_rate_per_min = std::clamp(settings_.heart_rate_per_min, 30.0, 220.0);
  return parameters;
}

// A device's clock may run otherwise than the first finger's, and may have begun later: as much of
// a beat as the heart is behind it beats faster, so that it comes to the same without a jump.
void Touch::keep_in_step(Finger& finger) noexcept {
  constexpr double kMostOff = 0.3;  // of the rate, and of a beat
  (void)fingers_.front()->felt.try_read(finger.led_by);
  const double rate_hz = rate_hz_.load(std::memory_order_relaxed);
  double off = 0;
  if (finger.led_by.servo.ticks > 0 && beating_.load(std::memory_order_relaxed)) {
    off = std::remainder(finger.led_by.servo.phase - finger.servo->phase(), 1.0);
  }
  finger.servo->set_rate_hz(rate_hz * (1 + std::clamp(off, -kMostOff, kMostOff)));
}

Vec3 Touch::tick(const haptics::ServoState& state, std::size_t finger) noexcept {
  Finger& one = *fingers_[finger];
  if (finger > 0) keep_in_step(one);
  const haptics::Tick felt = one.servo->tick(state);
  // A spring lies at the surface of the images, muscle where the circulation has moved it.
  const bool untouched = !muscle_felt_.load(std::memory_order_relaxed) && !felt.contact.touching;
  const bool away = within() || untouched || felt.status == haptics::TickStatus::Fault;
  circulation_->tell(finger, felt.contact.proxy_mm, away ? -1 : -kMPerMm * felt.contact.distance_mm,
                     one.servo->phase());
  circulation_->advance();
  (void)circulation_->latest(one.last.circulation);
  one.last.servo = one.servo->published();
  one.last.clock_ns = clock_ns();
  one.last.wishes = wishes_.load(std::memory_order_relaxed);
  one.felt.write(one.last);
  constexpr std::uint64_t kEvery = 5;
  if (finger == 0 && one.last.servo.ticks % kEvery == 0) rows_.add(press_row(one.last));
  return felt.force_n;
}

void Touch::lift(std::size_t finger) noexcept {
  circulation_->lift(finger);
  Finger& one = *fingers_[finger];
  one.last.servo = {};
  one.felt.write(one.last);
}

void Touch::set_paused(bool paused) noexcept {
  beating_.store(!paused);
  for (const auto& finger : fingers_) finger->servo->set_paused(paused);
}

void Touch::hold_phase(double phase) noexcept {
  beating_.store(phase < 0);
  for (const auto& finger : fingers_) finger->servo->hold_phase(phase);
}

void Touch::set_heart_rate(double per_min) {
  if (!(per_min >= 30 && per_min <= 220)) throw_invalid("a heart rate must be from 30 to 220");
  settings_.heart_rate_per_min = per_min;
  palpation::PalpationParameters parameters = wished_;
  parameters.circulation.heart_rate_per_min = per_min;
  wish(parameters);
  rate_hz_.store(per_min / 60);
  fingers_.front()->servo->set_rate_hz(per_min / 60);  // the others follow
}

void Touch::set_stiffness(double n_per_m) {
  settings_.stiffness_n_per_m = n_per_m;
  offer_scenes();
}

void Touch::set_preset(const std::string& name) {
  set_disease({palpation::palpation_preset(name)});
  settings_.preset = name;
}

void Touch::set_disease(const Disease& disease) {
  const palpation::PalpationParameters parameters = scaled(disease);
  disease_ = disease;
  wish(parameters);
}

void Touch::set_model(const std::string& model) {
  const std::string before = std::exchange(settings_.model, model);
  try {
    offer_scenes();
  } catch (...) {
    settings_.model = before;
    throw;
  }
  forget_taxels();
}

// Circulation and the muscle under the tool alike.
void Touch::wish(const palpation::PalpationParameters& parameters) {
  circulation_->wish(parameters);
  wishes_.fetch_add(1, std::memory_order_relaxed);
  wished_ = parameters;
  make_muscle();
  forget_taxels();
  if (settings_.model == "patch") offer_scenes();
}

void Touch::set_left_atrial_mmhg(double mmhg) {
  palpation::PalpationParameters parameters = wished_;
  parameters.circulation.left_atrial_mmhg = mmhg;
  wish(parameters);
}

void Touch::set_right_atrial_mmhg(double mmhg) {
  palpation::PalpationParameters parameters = wished_;
  parameters.circulation.right_atrial_mmhg = mmhg;
  wish(parameters);
}

std::vector<std::string> Touch::constants() const {
  std::vector<std::string> names;
  const nlohmann::json flat = palpation::palpation_to_json(wished_).flatten();
  for (const auto& [pointer, value] : flat.items()) {
    if (value.is_number() && pointer != "/version") names.push_back(pointer.substr(1));
  }
  return names;
}

double Touch::constant(const std::string& name) const {
  const nlohmann::json all = palpation::palpation_to_json(wished_);
  const nlohmann::json::json_pointer place("/" + name);
  if (!all.contains(place) || !all[place].is_number()) {
    throw_invalid("the trainer has no constant " + name);
  }
  return all[place].get<double>();
}

void Touch::set_constant(const std::string& name, double value) {
  if (name == "circulation/heart_rate_per_min") {
    set_heart_rate(value);
    return;
  }
  palpation::PalpationParameters parameters = wished_;
  if (name == "circulation/weight_kg") {
    if (!(value >= 1 && value <= 500)) throw_invalid(name + " must be from 1 to 500");
    parameters.circulation = palpation::at_weight(wished_.circulation, value);
  } else {
    (void)constant(name);
    nlohmann::json all = palpation::palpation_to_json(wished_);
    all[nlohmann::json::json_pointer("/" + name)] = value;
    parameters = palpation::palpation_from_json(all);
    parameters.infarct = wished_.infarct;
    if (wall_) {
      parameters.infarct = tissue_of(parameters, disease_).infarct;
    }
  }
  wish(parameters);
}

Vec3 Touch::surface_under(const Felt& felt) const {
  const auto& [x, y, z] = felt.servo.position_mm;
  const auto& [nx, ny, nz] = felt.servo.normal;
  return Vec3(x, y, z) - (felt.servo.distance_mm + fingers_.front()->radius_mm) * Vec3(nx, ny, nz);
}

std::optional<double> Touch::known_to_mm(const Felt& felt) const {
  if (!band_ || !felt.servo.touching) return std::nullopt;
  const auto& [nx, ny, nz] = felt.servo.normal;
  return band_->half_width_mm(surface_under(felt), Vec3(nx, ny, nz), felt.servo.phase);
}

std::optional<TouchedWall> Touch::touched_wall(const Felt& felt) const {
  if (!muscle_ || within() || felt.servo.distance_mm >= 0) return std::nullopt;
  const palpation::WallPlace place = wall_->nearest(surface_under(felt), felt.servo.phase);
  if (!muscle_->reaches(place, felt.servo.phase)) return std::nullopt;
  return TouchedWall{place.segment, muscle_->tissue().at(place)};
}

ToolPicture Touch::tool_picture(const Felt& felt, std::size_t finger) const {
  return tool_picture_of(felt.servo, fingers_[finger]->radius_mm,
                         palpation::dent_radius_mm(wished_.circulation.contact_area_cm2));
}

haptics::TaxelMap Touch::taxels(const Felt& felt, const Vec3& right, std::size_t finger) {
  Finger& one = *fingers_[finger];
  if (one.radius_mm < haptics::TaxelOptions::kLeastRadiusMm) return {};
  if (!one.taxels) {
    haptics::TaxelOptions options;
    options.radius_mm = one.radius_mm;
    if (settings_.model == "patch" && muscle_) {
      options.map = std::make_shared<const palpation::PatchStiffness>(
          muscle_, wished_, rr_interval_s_, end_diastole_ * rr_interval_s_);
    }
    one.taxels = std::make_unique<haptics::Taxels>(body_, options);
  }
  return one.taxels->under(haptics::ball_contact(felt.servo, right),
                           felt.servo.phase * rr_interval_s_);
}

const Felt& PressRun::at_phase(double phase) const {
  return *std::min_element(beat.begin(), beat.end(), [phase](const Felt& a, const Felt& b) {
    return std::abs(std::remainder(a.servo.phase - phase, 1.0)) <
           std::abs(std::remainder(b.servo.phase - phase, 1.0));
  });
}

const Felt& PressRun::hardest() const {
  return *std::max_element(beat.begin(), beat.end(), [](const Felt& a, const Felt& b) {
    return press_row(a).force_n < press_row(b).force_n;
  });
}

PressRun run_press(Touch& touch, const field::FieldQuery& field, const Vec3& direction,
                   double depth_mm, double phase) {
  const double period_s = field.rr_interval_s();
  const double t = wrapped(phase) * period_s;
  const Vec3 surface = surface_point_mm(field, direction, t);
  const Vec3 normal = field.normal(field.sample(surface, t), surface);
  const double radius = touch.settings().radii_mm.front();
  const auto place = [&](double above_mm) { return Vec3(surface + (radius + above_mm) * normal); };

  constexpr double kAwayMm = 30;
  constexpr int kNaturalBeats = 4;
  constexpr int kHeldBeats = 8;
  constexpr double kMovingS = 0.3;
  const double beat_s = 60 / touch.settings().heart_rate_per_min;
  const double begin_s = kNaturalBeats * beat_s;
  const double held_s = begin_s + kMovingS + kHeldBeats * beat_s;
  PressRun run;
  double before = 0;
  for (int n = 0; n < 10'000'000; ++n) {
    const double time_s = kTickS * n;
    const double share = std::clamp((time_s - begin_s) / kMovingS, 0.0, 1.0);
    const double smooth = (1 - std::cos(std::numbers::pi * share)) / 2;
    (void)touch.tick({.time_s = time_s,
                      .position_mm = place(kAwayMm + smooth * (-depth_mm - kAwayMm)),
                      .valid = true});
    run.last = touch.felt();
    const haptics::Published& servo = run.last.servo;
    run.rows.push_back(press_row(run.last));
    if (time_s > held_s - beat_s) run.beat.push_back(run.last);
    const double ahead = wrapped(servo.phase - phase);
    if (time_s > held_s && ahead < before) break;
    before = ahead;
  }
  std::erase_if(run.beat, [begin_s = run.last.servo.time_s - beat_s](const Felt& felt) {
    return felt.servo.time_s <= begin_s;
  });
  // The last whole beat of the circulation until then, closed.
  const auto beat = [&](double end_s) {
    std::uint64_t wished = 0;
    for (const PressRow& row : run.rows) {
      if (row.time_s <= end_s) wished = row.beat;
    }
    std::vector<PressRow> rows;
    for (const PressRow& row : run.rows) {
      if (row.beat + 1 == wished) rows.push_back(row);
    }
    if (!rows.empty()) rows.push_back(rows.front());
    return rows;
  };
  run.natural = beat(begin_s);
  run.pressed = beat(run.rows.back().time_s);
  return run;
}

}  // namespace beatlas::viewer
