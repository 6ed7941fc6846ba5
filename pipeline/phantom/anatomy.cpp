#include "pipeline/phantom/anatomy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "pipeline/phantom/heart_shape.h"
#include "pipeline/phantom/json_vector.h"
#include "runtime/base/json_numbers.h"

namespace beatlas::phantom {
namespace {

nlohmann::json lv_to_json(const LvState& lv) {
  return {{"radius_mm", lv.radius_mm},
          {"length_mm", lv.length_mm},
          {"base_mm", lv.base_mm},
          {"apex_wall_mm", lv.apex_wall_mm}};
}

nlohmann::json rv_to_json(const RvState& rv) {
  return {{"centre_x_mm", rv.centre_x_mm},
          {"centre_z_mm", rv.centre_z_mm},
          {"semi_axes_mm", to_json(rv.semi_axes_mm)},
          {"cut_mm", rv.cut_mm}};
}

void read_lv(JsonObject& parent, const std::string& key, LvState& lv) {
  if (!parent.has(key)) return;
  JsonObject object(parent.at(key), parent.path() + "/" + key);
  object.read("radius_mm", lv.radius_mm, 3.0, 80.0);
  object.read("length_mm", lv.length_mm, 5.0, 120.0);
  object.read("base_mm", lv.base_mm, -100.0, 100.0);
  object.read("apex_wall_mm", lv.apex_wall_mm, 0.5, 40.0);
  object.finish();
}

void read_rv(JsonObject& parent, const std::string& key, RvState& rv) {
  if (!parent.has(key)) return;
  JsonObject object(parent.at(key), parent.path() + "/" + key);
  object.read("centre_x_mm", rv.centre_x_mm, -100.0, 100.0);
  object.read("centre_z_mm", rv.centre_z_mm, -100.0, 100.0);
  read_vector(object, "semi_axes_mm", rv.semi_axes_mm, 3.0, 120.0);
  object.read("cut_mm", rv.cut_mm, -150.0, 150.0);
  object.finish();
}

constexpr std::array kAtriumNumbers{
    JsonNumber<Atrium>{"radius_end_diastole_mm", &Atrium::radius_end_diastole_mm, 5.0, 80.0},
    JsonNumber<Atrium>{"radius_end_systole_mm", &Atrium::radius_end_systole_mm, 5.0, 80.0},
    JsonNumber<Atrium>{"x_mm", &Atrium::x_mm, -100.0, 100.0},
    JsonNumber<Atrium>{"y_mm", &Atrium::y_mm, -100.0, 100.0}};
constexpr std::array kAtriaNumbers{
    JsonNumber<Atria>{"valve_radius_mm", &Atria::valve_radius_mm, 1.0, 30.0},
    JsonNumber<Atria>{"wall_mm", &Atria::wall_mm, 0.5, 10.0}};
constexpr std::array kAortaNumbers{
    JsonNumber<AortaRoot>{"radius_mm", &AortaRoot::radius_mm, 3.0, 40.0},
    JsonNumber<AortaRoot>{"wall_mm", &AortaRoot::wall_mm, 0.5, 10.0},
    JsonNumber<AortaRoot>{"x_mm", &AortaRoot::x_mm, -100.0, 100.0},
    JsonNumber<AortaRoot>{"y_mm", &AortaRoot::y_mm, -100.0, 100.0},
    JsonNumber<AortaRoot>{"length_mm", &AortaRoot::length_mm, 2.0, 150.0}};
constexpr std::array kPapillaryNumbers{
    JsonNumber<PapillaryMuscles>{"radius_end_diastole_mm",
                                 &PapillaryMuscles::radius_end_diastole_mm, 1.0, 15.0},
    JsonNumber<PapillaryMuscles>{"radius_end_systole_mm", &PapillaryMuscles::radius_end_systole_mm,
                                 1.0, 15.0},
    JsonNumber<PapillaryMuscles>{"half_length_end_diastole_mm",
                                 &PapillaryMuscles::half_length_end_diastole_mm, 2.0, 40.0},
    JsonNumber<PapillaryMuscles>{"half_length_end_systole_mm",
                                 &PapillaryMuscles::half_length_end_systole_mm, 2.0, 40.0},
    JsonNumber<PapillaryMuscles>{"off_axis", &PapillaryMuscles::off_axis, 0.2, 0.8}};
constexpr std::array kFatNumbers{
    JsonNumber<PericardialFat>{"front_mm", &PericardialFat::front_mm, 0.5, 20.0}};
constexpr std::array kInfarctNumbers{
    JsonNumber<Infarct>{"radius_mm", &Infarct::radius_mm, 8.0, 60.0},
    JsonNumber<Infarct>{"angle_deg", &Infarct::angle_deg, -360.0, 360.0},
    JsonNumber<Infarct>{"z_mm", &Infarct::z_mm, -80.0, 0.0},
    JsonNumber<Infarct>{"thinning_mm", &Infarct::thinning_mm, 0.1, 20.0},
    JsonNumber<Infarct>{"bulge_mm", &Infarct::bulge_mm, 0.1, 10.0}};

template <class T, std::size_t N>
nlohmann::json part_to_json(const T& part, const std::array<JsonNumber<T>, N>& numbers) {
  nlohmann::json out = numbers_to_json(part, numbers);
  out["present"] = part.present;
  return out;
}

template <class T, std::size_t N>
void read_part(JsonObject& parent, const std::string& key, T& part,
               const std::array<JsonNumber<T>, N>& numbers) {
  if (!parent.has(key)) return;
  JsonObject object(parent.at(key), parent.path() + "/" + key);
  object.read("present", part.present);
  read_numbers(object, part, numbers);
  object.finish();
}

void read_atria(JsonObject& parent, const std::string& key, Atria& atria) {
  if (!parent.has(key)) return;
  JsonObject object(parent.at(key), parent.path() + "/" + key);
  object.read("present", atria.present);
  read_numbers(object, atria, kAtriaNumbers);
  read_section(object, "left", atria.left, kAtriumNumbers);
  read_section(object, "right", atria.right, kAtriumNumbers);
  object.finish();
}

nlohmann::json atria_to_json(const Atria& atria) {
  nlohmann::json out = part_to_json(atria, kAtriaNumbers);
  out["left"] = numbers_to_json(atria.left, kAtriumNumbers);
  out["right"] = numbers_to_json(atria.right, kAtriumNumbers);
  return out;
}

constexpr const char* kAllOfThem = "all";

struct Removable {
  const char* name;
  bool& (*present)(Anatomy&);
};
constexpr std::array kRemovable{
    Removable{"atria", [](Anatomy& a) -> bool& { return a.atria.present; }},
    Removable{"aorta", [](Anatomy& a) -> bool& { return a.aorta.present; }},
    Removable{"papillary_muscles", [](Anatomy& a) -> bool& { return a.papillary_muscles.present; }},
    Removable{"pericardial_fat", [](Anatomy& a) -> bool& { return a.pericardial_fat.present; }}};

}  // namespace

std::vector<std::string> bodies_to_leave_out() {
  std::vector<std::string> names;
  for (const Removable& each : kRemovable) names.emplace_back(each.name);
  names.emplace_back(kAllOfThem);
  return names;
}

void leave_out(Anatomy& anatomy, const std::string& body) {
  if (body == kAllOfThem) {
    anatomy = ventricles_alone(anatomy);
    return;
  }
  std::string known;
  for (const Removable& each : kRemovable) {
    if (body == each.name) {
      each.present(anatomy) = false;
      return;
    }
    known += (known.empty() ? "" : ", ") + std::string(each.name);
  }
  throw Error(ErrorCode::Usage, "no phantom can do without '" + body + "'; choose of " + known);
}

Anatomy ventricles_alone(Anatomy anatomy) {
  for (const Removable& each : kRemovable) each.present(anatomy) = false;
  return anatomy;
}

Affine lps_from_heart(const Anatomy& anatomy) {
  const Vec3 z = -anatomy.apex_direction_lps.normalized();
  const Vec3 x = (anatomy.rv_direction_lps - anatomy.rv_direction_lps.dot(z) * z).normalized();
  Affine out = Affine::Identity();
  out.linear().col(0) = x;
  out.linear().col(1) = z.cross(x);
  out.linear().col(2) = z;
  out.translation() = anatomy.origin_lps_mm;
  return out;
}

void check_anatomy(const Anatomy& anatomy) {
  for (const auto& [lv, when] : {std::pair{&anatomy.lv_end_diastole, "lv_end_diastole"},
                                 std::pair{&anatomy.lv_end_systole, "lv_end_systole"}}) {
    if (std::abs(lv->base_mm) >= 0.95 * lv->length_mm) {
      throw_invalid(std::string("anatomy/") + when +
                    "/base_mm must cut the cavity: less than 0.95 of its length_mm");
    }
  }
  for (const auto& [rv, when] : {std::pair{&anatomy.rv_end_diastole, "rv_end_diastole"},
                                 std::pair{&anatomy.rv_end_systole, "rv_end_systole"}}) {
    if (std::abs(rv->cut_mm - rv->centre_z_mm) >= 0.95 * rv->semi_axes_mm.z()) {
      throw_invalid(std::string("anatomy/") + when +
                    "/cut_mm must cut the cavity: within 0.95 of its z semi-axis of its centre");
    }
  }
  for (const auto& [atrium, which] :
       {std::pair{&anatomy.atria.left, "left"}, std::pair{&anatomy.atria.right, "right"}}) {
    if (anatomy.atria.valve_radius_mm >=
        0.95 * std::min(atrium->radius_end_diastole_mm, atrium->radius_end_systole_mm)) {
      throw_invalid(std::string("anatomy/atria/valve_radius_mm must be less than 0.95 of both "
                                "radii of anatomy/atria/") +
                    which);
    }
  }
  const Vec3 z = anatomy.apex_direction_lps;
  if (!(z.norm() > 1e-3) || !(anatomy.rv_direction_lps.cross(z).norm() > 1e-3)) {
    throw_invalid("anatomy/apex_direction_lps and rv_direction_lps must be two directions");
  }
  check_walls(anatomy);
}

nlohmann::json anatomy_to_json(const Anatomy& a) {
  return {{"lv_end_diastole", lv_to_json(a.lv_end_diastole)},
          {"lv_end_systole", lv_to_json(a.lv_end_systole)},
          {"lv_wall_mm", a.lv_wall_mm},
          {"apex_mm", a.apex_mm},
          {"rv_end_diastole", rv_to_json(a.rv_end_diastole)},
          {"rv_end_systole", rv_to_json(a.rv_end_systole)},
          {"rv_wall_mm", a.rv_wall_mm},
          {"atria", atria_to_json(a.atria)},
          {"aorta", part_to_json(a.aorta, kAortaNumbers)},
          {"papillary_muscles", part_to_json(a.papillary_muscles, kPapillaryNumbers)},
          {"pericardial_fat", part_to_json(a.pericardial_fat, kFatNumbers)},
          {"infarct", part_to_json(a.infarct, kInfarctNumbers)},
          {"torsion_deg", a.torsion_deg},
          {"origin_lps_mm", to_json(a.origin_lps_mm)},
          {"apex_direction_lps", to_json(a.apex_direction_lps)},
          {"rv_direction_lps", to_json(a.rv_direction_lps)},
          {"scale", a.scale},
          {"liver_rise_mm", a.liver_rise_mm}};
}

Anatomy anatomy_from_json(const nlohmann::json& json, const std::string& path) {
  Anatomy a;
  JsonObject object(json, path);
  read_lv(object, "lv_end_diastole", a.lv_end_diastole);
  read_lv(object, "lv_end_systole", a.lv_end_systole);
  object.read("lv_wall_mm", a.lv_wall_mm, 1.0, 40.0);
  object.read("apex_mm", a.apex_mm, -150.0, 0.0);
  read_rv(object, "rv_end_diastole", a.rv_end_diastole);
  read_rv(object, "rv_end_systole", a.rv_end_systole);
  object.read("rv_wall_mm", a.rv_wall_mm, 0.5, 20.0);
  read_atria(object, "atria", a.atria);
  read_part(object, "aorta", a.aorta, kAortaNumbers);
  read_part(object, "papillary_muscles", a.papillary_muscles, kPapillaryNumbers);
  read_part(object, "pericardial_fat", a.pericardial_fat, kFatNumbers);
  read_part(object, "infarct", a.infarct, kInfarctNumbers);
  object.read("torsion_deg", a.torsion_deg, -45.0, 45.0);
  read_vector(object, "origin_lps_mm", a.origin_lps_mm, -2000.0, 2000.0);
  read_vector(object, "apex_direction_lps", a.apex_direction_lps, -1.0, 1.0);
  read_vector(object, "rv_direction_lps", a.rv_direction_lps, -1.0, 1.0);
  object.read("scale", a.scale, 0.3, 1.6);
  object.read("liver_rise_mm", a.liver_rise_mm, 0.0, 60.0);
  object.finish();
  return a;
}

}  // namespace beatlas::phantom
