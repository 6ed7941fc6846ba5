#include "runtime/app/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iomanip>
#include <span>
#include <sstream>

#include "runtime/app/press.h"
#include "runtime/app/text.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/palpation/fit.h"
#include "runtime/palpation/trainer.h"

namespace beatlas::app {
namespace {

using palpation::Beat;
using palpation::PalpationParameters;

constexpr double kDepthMm = 8;
constexpr long kBeats = 60;  // until the Windkessel has forgotten the finger's coming

SensitivityFigures figures_of(PalpationParameters parameters) {
  SensitivityFigures out;
  out.natural = palpation::natural_beat(parameters.whole_circulation());
  parameters.circulation.reference_volume_ml = out.natural.edv_ml;
  palpation::Trainer trainer(parameters, 1);
  const palpation::Finger finger{.depth_m = kDepthMm / 1000, .long_axis = 0.5, .segment = 7};
  // Ticks divide the beat, so that a mean over it is one.
  const double period_s = 60 / parameters.circulation.heart_rate_per_min;
  const double ticks = std::ceil(period_s / kTickS);
  const long first = static_cast<long>(trainer.signals().beats);
  double sum_n = 0;
  for (long beat = first; beat < first + kBeats;) {
    const double force_n = trainer.tick(period_s / ticks, std::span(&finger, 1))[0];
    const palpation::Signals& now = trainer.signals();
    sum_n += force_n;
    out.largest_n = std::max(out.largest_n, force_n);
    if (static_cast<long>(now.beats) == beat) continue;
    beat = static_cast<long>(now.beats);
    out.pressed = now.beat;
    out.mean_n = sum_n / ticks;
    out.diastole_n = force_n;
    if (beat < first + kBeats) sum_n = out.largest_n = 0;
  }
  return out;
}

/// A number of the parameters: how to read it, how to change it, where it may lie.
struct Constant {
  std::string symbol;
  std::string meaning;
  double value;
  std::function<void(PalpationParameters&, double factor)> multiply;
  double least = 0;
  double most = 1e9;
};

Constant of_table(const char* symbol, const char* meaning,
                  double palpation::MuscleConstants::*member,
                  const PalpationParameters& parameters) {
  return {symbol, meaning, parameters.muscle.middle.*member,
          [member](PalpationParameters& p, double factor) {
            for (palpation::MuscleConstants* place :
                 {&p.muscle.base, &p.muscle.middle, &p.muscle.apex}) {
              place->*member *= factor;
            }
          }};
}

Constant of_circulation(const char* symbol, const char* meaning,
                        double palpation::CirculationParameters::*member, double least, double most,
                        const PalpationParameters& parameters) {
  return {symbol,
          meaning,
          parameters.circulation.*member,
          [member](PalpationParameters& p, double factor) { p.circulation.*member *= factor; },
          least,
          most};
}

std::vector<Constant> constants_of(const PalpationParameters& parameters, const Beat& natural) {
  using M = palpation::MuscleConstants;
  using C = palpation::CirculationParameters;
  const double beat_area_cm2 =
      palpation::shortening_area_cm2(natural.contracting_ml, natural.edv_ml);
  const double told_area_cm2 = parameters.contractile.shortening_area_cm2;
  const double area_cm2 = told_area_cm2 > 0 ? told_area_cm2 : beat_area_cm2;
  std::vector<Constant> out{
      of_table("K_h1", "horizontal spring in series with C_h, middle [N/m]", &M::k_h1_n_per_m,
               parameters),
      of_table("K_h2", "horizontal spring beside both, middle [N/m]", &M::k_h2_n_per_m, parameters),
      of_table("C_h", "horizontal damper, middle [N s/m]", &M::c_h_n_s_per_m, parameters),
      of_table("K_v", "vertical spring, middle [N/m]", &M::k_v_n_per_m, parameters),
      of_table("C_v", "vertical damper, middle [N s/m]", &M::c_v_n_s_per_m, parameters)};
  out.push_back({"S_n", "of (5): V_e / L_0, a mean over T_s [cm2]", area_cm2,
                 [area_cm2](PalpationParameters& p, double factor) {
                   p.contractile.shortening_area_cm2 = factor * area_cm2;
                 },
                 1e-3, 100});
  out.push_back(
      {"S", "fingertip's area of (6) [cm2]", parameters.contractile.finger_area_cm2,
       [](PalpationParameters& p, double factor) { p.contractile.finger_area_cm2 *= factor; }, 0,
       100});
  out.push_back({"alpha", "contraction left, of the whole wall, of (6)", 1,
                 [](PalpationParameters& p, double factor) {
                   for (palpation::Tissue& tissue : p.segments) tissue.alpha *= factor;
                 },
                 0, 1});
  out.push_back(of_circulation("E", "largest elastance, of (6) [mmHg/ml]", &C::emax,
                               parameters.circulation.emin, 1e3, parameters));
  out.push_back(of_circulation("LAP", "left atrium's pressure [mmHg]", &C::left_atrial_mmhg, 0, 40,
                               parameters));
  out.push_back(of_circulation("RAP", "right atrium's pressure [mmHg]", &C::right_atrial_mmhg, 0,
                               40, parameters));
  const double aortic_mmhg = natural.aortic_mean_mmhg;
  out.push_back({"MAP", "mean aortic pressure, held by the resistance [mmHg]", aortic_mmhg,
                 [aortic_mmhg](PalpationParameters& p, double factor) {
                   p.circulation = palpation::fit_circulation(
                       p.circulation, {.aortic_mean_mmhg = factor * aortic_mmhg});
                 },
                 20, 150});
  const double weight_kg = parameters.circulation.weight_kg;
  out.push_back({"W", "weight of the animal [kg]", weight_kg,
                 [weight_kg](PalpationParameters& p, double factor) {
                   p.circulation = palpation::at_weight(p.circulation, factor * weight_kg);
                 },
                 1, 500});
  out.push_back(
      of_circulation("HR", "beats a minute", &C::heart_rate_per_min, 30, 220, parameters));
  return out;
}

struct Column {
  const char* name;
  double (*of)(const SensitivityFigures&);
};
constexpr Column kTableColumns[] = {
    {"mean force", [](const SensitivityFigures& f) { return f.mean_n; }},
    {"force at end-diastole", [](const SensitivityFigures& f) { return f.diastole_n; }},
    {"EDV", [](const SensitivityFigures& f) { return f.natural.edv_ml; }},
    {"ESV", [](const SensitivityFigures& f) { return f.natural.esv_ml; }},
    {"stroke", [](const SensitivityFigures& f) { return f.natural.stroke_ml; }},
    {"output", [](const SensitivityFigures& f) { return f.natural.output_l_per_min; }},
    {"mean aortic", [](const SensitivityFigures& f) { return f.natural.aortic_mean_mmhg; }},
    {"peak LVP", [](const SensitivityFigures& f) { return f.natural.peak_lv_mmhg; }},
    {"output pressed", [](const SensitivityFigures& f) { return f.pressed.output_l_per_min; }}};

nlohmann::json figures_json(const SensitivityFigures& figures) {
  const auto beat = [](const Beat& b) {
    return nlohmann::json{{"edv_ml", b.edv_ml},
                          {"esv_ml", b.esv_ml},
                          {"stroke_ml", b.stroke_ml},
                          {"output_l_per_min", b.output_l_per_min},
                          {"peak_lv_mmhg", b.peak_lv_mmhg},
                          {"aortic_mean_mmhg", b.aortic_mean_mmhg}};
  };
  return {{"natural", beat(figures.natural)},
          {"pressed", beat(figures.pressed)},
          {"mean_n", figures.mean_n},
          {"largest_n", figures.largest_n},
          {"diastole_n", figures.diastole_n}};
}

}  // namespace

Sensitivity sensitivity_of(const PalpationParameters& parameters) {
  parameters.check();
  Sensitivity out;
  out.depth_mm = kDepthMm;
  out.as_it_is = figures_of(parameters);
  for (const Constant& constant : constants_of(parameters, out.as_it_is.natural)) {
    const auto changed = [&](double to) {
      PalpationParameters other = parameters;
      // A constant that is 0 has no half and no twice; both columns show it as it is.
      if (constant.value != 0) constant.multiply(other, to / constant.value);
      return figures_of(other);
    };
    SensitivityRow row{
        .symbol = constant.symbol,
        .meaning = constant.meaning,
        .value = constant.value,
        .low = constant.value == 0 ? 0 : std::max(0.5 * constant.value, constant.least),
        .high = std::min(2 * constant.value, constant.most),
        .at_low = {},
        .at_high = {}};
    row.at_low = changed(row.low);
    row.at_high = changed(row.high);
    out.rows.push_back(std::move(row));
  }
  return out;
}

nlohmann::json sensitivity_json(const Sensitivity& sensitivity) {
  nlohmann::json rows = nlohmann::json::array();
  for (const SensitivityRow& row : sensitivity.rows) {
    rows.push_back({{"symbol", row.symbol},
                    {"meaning", row.meaning},
                    {"value", row.value},
                    {"low", row.low},
                    {"high", row.high},
                    {"at_low", figures_json(row.at_low)},
                    {"at_high", figures_json(row.at_high)}});
  }
  return {{"depth_mm", sensitivity.depth_mm},
          {"as_it_is", figures_json(sensitivity.as_it_is)},
          {"rows", std::move(rows)}};
}

std::string sensitivity_markdown(const Sensitivity& sensitivity) {
  std::ostringstream text;
  text << "Changes in per cent at half / at twice the constant (or the nearest that is in range), "
          "of a finger "
       << sensitivity.depth_mm << " mm deep and of the natural beat.\n\n| | as it is | tried |";
  for (const Column& column : kTableColumns) text << ' ' << column.name << " |";
  text << "\n|---|---|---|";
  for (std::size_t n = 0; n < std::size(kTableColumns); ++n) text << "---|";
  text << '\n' << std::setprecision(3);
  for (const SensitivityRow& row : sensitivity.rows) {
    text << "| " << row.symbol << " | " << row.value << " | " << row.low << ", " << row.high
         << " |";
    for (const Column& column : kTableColumns) {
      const double before = column.of(sensitivity.as_it_is);
      const auto change = [&](const SensitivityFigures& figures) {
        const double percent = 100 * (column.of(figures) / before - 1);
        std::ostringstream number;
        number << std::showpos << std::fixed << std::setprecision(std::abs(percent) < 1 ? 2 : 1)
               << percent;
        return number.str();
      };
      text << ' ' << change(row.at_low) << " / " << change(row.at_high) << " |";
    }
    text << '\n';
  }
  return text.str();
}

void write_sensitivity(const Sensitivity& sensitivity, const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) {
    throw Error(ErrorCode::Machine, folder.string() + " cannot be made; check its name and rights");
  }
  write_file(folder / "sensitivity.json", json_text(sensitivity_json(sensitivity), 2) + "\n");
  write_file(folder / "sensitivity.md", sensitivity_markdown(sensitivity));
}

}  // namespace beatlas::app
