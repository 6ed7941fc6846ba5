#include "runtime/palpation/parameters.h"

#include <algorithm>
#include <array>
#include <sstream>

#include "runtime/base/error.h"
#include "runtime/base/json_numbers.h"
#include "runtime/base/json_object.h"
#include "runtime/palpation/fit.h"
#include "runtime/palpation/patch.h"
#include "runtime/palpation/regions.h"

namespace beatlas::palpation {
namespace {

using nlohmann::json;

constexpr int kVersion = 1;

constexpr std::array<JsonNumber<MuscleConstants>, 5> kMuscle{{
    {"k_h1_n_per_m", &MuscleConstants::k_h1_n_per_m, 1e-3, 1e5},
    {"k_h2_n_per_m", &MuscleConstants::k_h2_n_per_m, 1e-3, 1e5},
    {"c_h_n_s_per_m", &MuscleConstants::c_h_n_s_per_m, 1e-3, 1e5},
    {"k_v_n_per_m", &MuscleConstants::k_v_n_per_m, 1e-3, 1e5},
    {"c_v_n_s_per_m", &MuscleConstants::c_v_n_s_per_m, 1e-3, 1e5},
}};

constexpr std::array<JsonNumber<Tissue>, 4> kTissue{{
    {"scar", &Tissue::scar, 0, 1},
    {"thickness_ratio", &Tissue::thickness_ratio, 0.3, 2},
    {"alpha", &Tissue::alpha, 0, 1},
    {"stiffness_ratio", &Tissue::stiffness_ratio, kSoftestRatio, kStiffestRatio},
}};

constexpr std::array<JsonNumber<Contractile>, 2> kContractile{{
    {"shortening_area_cm2", &Contractile::shortening_area_cm2, 0, 100},
    {"finger_area_cm2", &Contractile::finger_area_cm2, 0, 100},
}};

using C = CirculationParameters;
constexpr std::array<JsonNumber<C>, 18> kCirculation{{
    {"weight_kg", &C::weight_kg, 1, 500},
    {"heart_rate_per_min", &C::heart_rate_per_min, C::kSlowestPerMin, C::kQuickestPerMin},
    {"left_atrial_mmhg", &C::left_atrial_mmhg, 0, 40},
    {"right_atrial_mmhg", &C::right_atrial_mmhg, 0, 40},
    {"resistance_mmhg_s_per_ml", &C::resistance, 1e-3, 1e3},
    {"impedance_mmhg_s_per_ml", &C::impedance, 1e-4, 1e2},
    {"compliance_ml_per_mmhg", &C::compliance, 1e-3, 1e2},
    {"aortic_valve_mmhg_s_per_ml", &C::aortic_valve, 1e-4, 1},
    {"mitral_valve_mmhg_s_per_ml", &C::mitral_valve, 1e-4, 1},
    {"emin_mmhg_per_ml", &C::emin, 1e-4, 1e2},
    {"emax_mmhg_per_ml", &C::emax, 1e-4, 1e3},
    {"v0_ml", &C::v0_ml, 0, 1e3},
    {"contractility", &C::contractility, 0.1, 3},
    {"reference_volume_ml", &C::reference_volume_ml, 0, 1e4},
    {"contact_area_cm2", &C::contact_area_cm2, 0.1, 1e3},
    {"stop_n_per_m", &C::stop_n_per_m, 1, 1e6},
    {"finger_k_n_per_m", &C::finger_k_n_per_m, 0, 1e5},
    {"finger_c_n_s_per_m", &C::finger_c_n_s_per_m, 1e-3, 1e5},
}};

void read_segments(JsonObject& object, SegmentTissue& segments) {
  if (!object.has("segments")) return;
  const json& given = object.at("segments");
  JsonObject shape(given, "/segments");  // refuses what is no object
  for (const auto& item : given.items()) {
    const auto segment = segment_from_name(item.key());
    if (!segment) {
      throw_invalid("/segments/" + item.key() + " is no segment; there are " + segment_names());
    }
    read_section(shape, item.key(), segments[static_cast<std::size_t>(*segment - 1)], kTissue);
  }
}

void read_circulation(JsonObject& object, PalpationParameters& parameters) {
  if (!object.has("circulation")) return;
  JsonObject circulation(object.at("circulation"), "/circulation");
  C& c = parameters.circulation;
  read_numbers(circulation, c, kCirculation);
  std::string contact = c.contact == Contact::Kinematic ? "kinematic" : "viscoelastic";
  circulation.read("contact", contact);
  if (contact != "kinematic" && contact != "viscoelastic") {
    throw_invalid("/circulation/contact must be kinematic or viscoelastic");
  }
  c.contact = contact == "kinematic" ? Contact::Kinematic : Contact::Viscoelastic;
  circulation.read("aortic_target_mmhg", parameters.aortic_target_mmhg, 0, 250);
  circulation.read("relaxation_rate_per_s", parameters.relaxation_rate_per_s, 0, 1e3);
  circulation.finish();
  std::ostringstream range;
  if (c.emin > c.emax) {
    range << "/circulation/emin_mmhg_per_ml must be from 0.0001 to emax_mmhg_per_ml, " << c.emax;
    throw_invalid(range.str());
  }
  if (c.reference_volume_ml < c.v0_ml) {
    range << "/circulation/reference_volume_ml must be from v0_ml, " << c.v0_ml << ", to 10000";
    throw_invalid(range.str());
  }
  const double rate = parameters.relaxation_rate_per_s;
  if (rate > 0 && rate < 1) {
    throw_invalid("/circulation/relaxation_rate_per_s must be 0 (of the muscle) or from 1 to 1000");
  }
  const double target = parameters.aortic_target_mmhg;
  if (target > 0 && target < 20) {
    throw_invalid("/circulation/aortic_target_mmhg must be 0 (none) or from 20 to 250");
  }
}

void read_muscle(JsonObject& object, PalpationParameters& parameters) {
  if (!object.has("muscle")) return;
  JsonObject muscle(object.at("muscle"), "/muscle");
  read_section(muscle, "base", parameters.muscle.base, kMuscle);
  read_section(muscle, "middle", parameters.muscle.middle, kMuscle);
  read_section(muscle, "apex", parameters.muscle.apex, kMuscle);
  read_section(muscle, "contractile", parameters.contractile, kContractile);
  muscle.read("wall_mass_kg", parameters.wall_mass_kg, 0, 10);
  muscle.read("contact_n_per_m", parameters.contact_n_per_m, 100, 1e6);
  muscle.finish();
}

// A spring in series is softer than each: the wall's may not be stiffer than the contact's.
void check_contact(const PalpationParameters& parameters, const std::vector<Region>& regions) {
  double stiffest = 0;
  for (const MuscleConstants* place :
       {&parameters.muscle.base, &parameters.muscle.middle, &parameters.muscle.apex}) {
    stiffest = std::max(stiffest, place->k_v_n_per_m);
    for (const Tissue& tissue : parameters.segments) {
      stiffest = std::max(stiffest, in_tissue(*place, tissue).k_v_n_per_m);
    }
    for (const Region& region : regions) {
      stiffest = std::max(stiffest, in_tissue(*place, region.tissue).k_v_n_per_m);
    }
  }
  const C& c = parameters.circulation;
  // No beat's mean volume is above that of end-diastole, no filling's pressure above the atrium's.
  stiffest += parameters.contractile.stiffness_n_per_m(
                  1, shortening_area_cm2(c.reference_volume_ml, c.reference_volume_ml),
                  std::max(c.emin, c.contractility * c.emax)) +
              pressure_n_per_m(c.left_atrial_mmhg, c.reference_volume_ml);
  const double least = stiffest / VerticalPatch::kStiffestShare;
  if (parameters.contact_n_per_m >= least) return;
  std::ostringstream range;
  range << "/muscle/contact_n_per_m must be from " << least
        << " to 1e+06: the wall with its contraction may be as stiff as " << stiffest << " N/m";
  throw_invalid(range.str());
}

void set_tissue(SegmentTissue& segments, std::initializer_list<int> which, const Tissue& tissue) {
  for (const int segment : which) segments[static_cast<std::size_t>(segment - 1)] = tissue;
}

}  // namespace

void PalpationParameters::check() const {
  (void)palpation_from_json(palpation_to_json(*this));
  whole_circulation().check();
}

MuscleConstants PalpationParameters::at(double long_axis, int segment) const noexcept {
  const MuscleConstants healthy = blend(muscle, long_axis);
  if (segment < 1 || segment > kSegments) return healthy;
  return in_tissue(healthy, segments[static_cast<std::size_t>(segment - 1)]);
}

CirculationParameters PalpationParameters::whole_circulation() const noexcept {
  CirculationParameters out = circulation;
  const Infarct whole = infarct ? *infarct : infarct_of(segments);
  out.infarct_fraction = whole.fraction;
  out.infarct_alpha = whole.alpha;
  const MuscleTable printed;
  out.emin *= muscle.mean_k_h2_n_per_m() / printed.mean_k_h2_n_per_m();
  out.branch_elastance =
      circulation.emin * muscle.mean_k_h1_n_per_m() / printed.mean_k_h2_n_per_m();
  out.relaxation_rate_per_s =
      relaxation_rate_per_s > 0 ? relaxation_rate_per_s : muscle.relaxation_rate_per_s();
  return out;
}

double contractile_n_per_m(const PalpationParameters& parameters, double alpha,
                           const Circulation& circulation) noexcept {
  const double area_cm2 = shortening_area_cm2(circulation.last_beat().contracting_ml,
                                              circulation.parameters().reference_volume_ml);
  return parameters.contractile.stiffness_n_per_m(alpha, area_cm2,
                                                  circulation.elastance_mmhg_per_ml());
}

double pressure_n_per_m(const Circulation& circulation) noexcept {
  return pressure_n_per_m(circulation.filling_mmhg(), circulation.parameters().reference_volume_ml);
}

std::vector<std::string> palpation_presets() {
  return {"healthy", "anterior_infarct", "dilated_cardiomyopathy", "low_pressure", "by_74_percent"};
}

PalpationParameters palpation_preset(const std::string& name) {
  PalpationParameters out;
  if (name == "healthy") return out;
  if (name == "by_74_percent") {
    out.circulation.contact_area_cm2 = kContactAreaFallsBy74Cm2;
    return out;
  }
  if (name == "anterior_infarct") {  // of the left anterior descending artery, weeks old
    set_tissue(out.segments, {1, 2, 7, 8, 13, 14, 17}, infarct_tissue());
  } else if (name == "dilated_cardiomyopathy") {  // wide, thin, weak, under pressure
    out.circulation.contractility = 0.45;
    out.circulation.emin *= 0.7;
    out.circulation.v0_ml *= 3;
    out.circulation.left_atrial_mmhg = 15;
    for (Tissue& tissue : out.segments) tissue = {.scar = 0.15, .thickness_ratio = 0.75};
  } else if (name == "low_pressure") {
    out.circulation.left_atrial_mmhg = 3;
  } else {
    std::string names;
    for (const std::string& preset : palpation_presets()) {
      names += (names.empty() ? "" : ", ") + preset;
    }
    throw_invalid("there is no palpation preset " + name + "; there are " + names);
  }
  out.circulation.reference_volume_ml = natural_beat(out.whole_circulation()).edv_ml;
  return out;
}

PalpationParameters palpation_from_json(const json& document) {
  PalpationParameters out;
  JsonObject object(document, "");
  int version = kVersion;
  object.read("version", version, kVersion, kVersion);
  read_muscle(object, out);
  read_circulation(object, out);
  read_segments(object, out.segments);
  std::vector<Region> regions;
  if (object.has("regions")) regions = regions_from_json(object.at("regions"));
  object.finish();
  check_contact(out, regions);
  return out;
}

json palpation_to_json(const PalpationParameters& parameters) {
  json muscle = {{"base", numbers_to_json(parameters.muscle.base, kMuscle)},
                 {"middle", numbers_to_json(parameters.muscle.middle, kMuscle)},
                 {"apex", numbers_to_json(parameters.muscle.apex, kMuscle)},
                 {"contractile", numbers_to_json(parameters.contractile, kContractile)},
                 {"wall_mass_kg", parameters.wall_mass_kg},
                 {"contact_n_per_m", parameters.contact_n_per_m}};
  json circulation = numbers_to_json(parameters.circulation, kCirculation);
  circulation["contact"] =
      parameters.circulation.contact == Contact::Kinematic ? "kinematic" : "viscoelastic";
  circulation["aortic_target_mmhg"] = parameters.aortic_target_mmhg;
  circulation["relaxation_rate_per_s"] = parameters.relaxation_rate_per_s;
  json segments = json::object();
  for (int segment = 1; segment <= kSegments; ++segment) {
    const Tissue& tissue = parameters.segments[static_cast<std::size_t>(segment - 1)];
    if (tissue == Tissue{}) continue;
    segments[std::string(segment_name(segment))] = numbers_to_json(tissue, kTissue);
  }
  return {{"version", kVersion},
          {"muscle", std::move(muscle)},
          {"circulation", std::move(circulation)},
          {"segments", std::move(segments)}};
}

}  // namespace beatlas::palpation
