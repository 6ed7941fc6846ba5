#include "pipeline/study/long_axis_json.h"

#include <cmath>
#include <string>

#include "pipeline/study/json_values.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::study {
using nlohmann::json;
namespace {

constexpr int kVersion = 1;
constexpr double kFarMm = 1e5;
constexpr double kLeastOffAxisMm = 1;
constexpr double kUnit = 1e-6;  ///< how far from 1 a written direction's length may be by rounding

json vector_to_json(const Vec3& v) { return {v[0], v[1], v[2]}; }

Vec3 vector_from_json(const json& value, const std::string& path) {
  const std::vector<double> numbers = numbers_from_json(value, path);
  if (numbers.size() != 3) throw_invalid(path + " must be 3 numbers");
  return {numbers[0], numbers[1], numbers[2]};
}

}  // namespace

json long_axis_to_json(const LongAxis& axis) {
  json phases = json::array();
  for (std::size_t p = 0; p < axis.apex_mm.size(); ++p) {
    phases.push_back({{"apex_mm", axis.apex_mm[p]}, {"lv_base_mm", axis.lv_base_mm[p]}});
    if (!axis.rv_base_mm.empty()) phases.back()["rv_base_mm"] = axis.rv_base_mm[p];
  }
  json out{{"version", kVersion},
           {"origin_lps_mm", vector_to_json(axis.origin_mm)},
           {"towards_base_lps", vector_to_json(axis.towards_base)},
           {"atria", axis.atria},
           {"phases", phases}};
  if (axis.rv_centre_mm) out["rv_centre_lps_mm"] = vector_to_json(*axis.rv_centre_mm);
  return out;
}

LongAxis long_axis_from_json(const json& value) {
  JsonObject object(value, "");
  int version = 0;
  object.read("version", version, 0, 1 << 30);
  if (version != kVersion) {
    throw_invalid("/version is " + std::to_string(version) + ", this program reads " +
                  std::to_string(kVersion));
  }
  LongAxis axis;
  axis.origin_mm = vector_from_json(object.at("origin_lps_mm"), "/origin_lps_mm");
  axis.towards_base = vector_from_json(object.at("towards_base_lps"), "/towards_base_lps");
  const double length = axis.towards_base.norm();
  if (!(length > 1e-3) || !axis.origin_mm.allFinite() || !axis.towards_base.allFinite()) {
    throw_invalid("/towards_base_lps must be a direction and /origin_lps_mm a place");
  }
  if (std::abs(length - 1) > kUnit) axis.towards_base /= length;
  object.read("atria", axis.atria);
  if (object.has("rv_centre_lps_mm")) {
    axis.rv_centre_mm = vector_from_json(object.at("rv_centre_lps_mm"), "/rv_centre_lps_mm");
    const Vec3 off_axis = (*axis.rv_centre_mm - axis.origin_mm).cross(axis.towards_base);
    if (!(off_axis.norm() > kLeastOffAxisMm)) {
      throw_invalid("/rv_centre_lps_mm must lie beside the axis: it tells where the septum is");
    }
  }
  const json& phases = object.at("phases");
  if (!phases.is_array() || phases.empty()) throw_invalid("/phases must be a list");
  for (std::size_t p = 0; p < phases.size(); ++p) {
    const std::string here = "/phases/" + std::to_string(p);
    JsonObject phase(phases[p], here);
    double apex = kFarMm;
    double lv = -kFarMm;
    double rv = 0;
    phase.read("apex_mm", apex, -kFarMm, kFarMm);
    phase.read("lv_base_mm", lv, -kFarMm, kFarMm);
    if (!(lv > apex)) throw_invalid(here + " must have an lv_base_mm above its apex_mm");
    axis.apex_mm.push_back(apex);
    axis.lv_base_mm.push_back(lv);
    if (phase.has("rv_base_mm")) {
      phase.read("rv_base_mm", rv, -kFarMm, kFarMm);
      axis.rv_base_mm.push_back(rv);
    }
    phase.finish();
  }
  object.finish();
  if (!axis.rv_base_mm.empty() && axis.rv_base_mm.size() != axis.apex_mm.size()) {
    throw_invalid("/phases must have rv_base_mm in each or in none");
  }
  return axis;
}

}  // namespace beatlas::study
