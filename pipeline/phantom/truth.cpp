#include "pipeline/phantom/truth.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "pipeline/core/parallel.h"
#include "pipeline/phantom/acquisition.h"
#include "pipeline/phantom/drawn_exam.h"
#include "pipeline/phantom/motion.h"
#include "runtime/base/json_object.h"

namespace beatlas::phantom {
namespace {

constexpr int kVersion = 2;
constexpr const char* kFormat = "beatlas-phantom-truth";

using Curves = std::map<Part, std::vector<double>>;

/// [ml] of every part the heart has, in every phase.
Curves volume_curves(const Phantom& phantom) {
  const auto phases = static_cast<std::size_t>(phantom.spec().phases);
  Curves out;
  for (Part part : kAllParts) {
    if (phantom.frame(0.0)->has(part)) out[part].resize(phases);
  }
  parallel_for(phases, [&](std::size_t p) {
    const auto frame = phantom.frame(phantom.phase_time_s(static_cast<int>(p)));
    for (auto& [part, curve] : out) curve[p] = frame->volume_ml(part);
  });
  return out;
}

double ejection_fraction(const std::vector<double>& curve) {
  const auto [low, high] = std::minmax_element(curve.begin(), curve.end());
  return 1.0 - *low / *high;
}

}  // namespace

nlohmann::json truth_json(const Phantom& phantom) {
  nlohmann::json times = nlohmann::json::array();
  nlohmann::json loss = nlohmann::json::array();
  for (int p = 0; p < phantom.spec().phases; ++p) {
    times.push_back(phantom.phase_time_s(p));
    loss.push_back(volume_loss(phantom.phase_time_s(p), phantom.spec().rr_interval_s));
  }
  const Curves curves = volume_curves(phantom);
  nlohmann::json structures = nlohmann::json::array();
  for (const auto& [part, curve] : curves) {
    structures.push_back({{"name", std::string(part_name(part))}, {"volume_ml", curve}});
  }
  return {{"format", kFormat},
          {"version", kVersion},
          {"identity", phantom.identity()},
          {"spec", spec_to_json(phantom.spec())},
          {"rr_interval_s", phantom.spec().rr_interval_s},
          {"times_s", times},
          {"volume_loss", loss},
          {"volume_loss_definition", volume_loss_description()},
          {"ejection_fraction",
           {{"lv_blood", ejection_fraction(curves.at(Part::LvBlood))},
            {"rv_blood", ejection_fraction(curves.at(Part::RvBlood))}}},
          {"acquisition", acquisition_json(phantom.spec())},
          {"structures", structures}};
}

Phantom phantom_from_truth(const nlohmann::json& truth) {
  JsonObject object(truth, "");
  std::string format;
  object.read("format", format);
  if (format == kDrawnTruthFormat) {
    throw_invalid(
        "this is the truth of a drawn exam, which is no closed form: only 'beatlas validate "
        "--truth' "
        "takes it");
  }
  if (format != kFormat)
    throw_invalid("/format must be \"beatlas-phantom-truth\": this is no truth of a phantom");
  int version = 0;
  object.read("version", version, 1, 1000000);
  if (version != kVersion) {
    throw_invalid("/version must be " + std::to_string(kVersion) +
                  ": this truth was written by another version of beatlas");
  }
  Phantom phantom = [&] {
    try {
      return Phantom(spec_from_json(object.at("spec")));
    } catch (const Error& error) {
      throw error.with_context("/spec");
    }
  }();
  std::string identity;
  object.read("identity", identity);
  if (identity != phantom.identity()) {
    throw_invalid("/identity is not that of /spec: the truth was changed after it was written");
  }
  // The constants of the motion are in the program, so ask whether it is still the same phantom.
  const nlohmann::json again = truth_json(phantom);
  const nlohmann::json& structures = object.at("structures");
  bool same = structures.is_array() && structures.size() == again["structures"].size();
  for (std::size_t n = 0; same && n < structures.size(); ++n) {
    const nlohmann::json& mine = again["structures"][n];
    const nlohmann::json& theirs = structures[n];
    same = theirs.is_object() && theirs.contains("name") && theirs["name"] == mine["name"] &&
           theirs.contains("volume_ml") && theirs["volume_ml"].is_array() &&
           theirs["volume_ml"].size() == mine["volume_ml"].size();
    for (std::size_t p = 0; same && p < mine["volume_ml"].size(); ++p) {
      const nlohmann::json& volume = theirs["volume_ml"][p];
      same = volume.is_number() &&
             std::abs(volume.get<double>() - mine["volume_ml"][p].get<double>()) < 1e-4;
    }
  }
  if (!same) {
    throw_invalid(
        "/structures differ from the phantom of /spec: the truth was changed, or written "
        "by a version of beatlas with another heart");
  }
  return phantom;
}

}  // namespace beatlas::phantom
