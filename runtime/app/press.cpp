#include "runtime/app/press.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <system_error>

#include "runtime/app/text.h"
#include "runtime/base/error.h"
#include "runtime/palpation/fit.h"
#include "runtime/palpation/trainer.h"
#include "runtime/plot/plot.h"

namespace beatlas::app {
namespace {

using nlohmann::json;
using palpation::Beat;
using plot::Plot;
using plot::plots_svg;
using plot::PlotSeries;

// A slow heart is given time: at least one beat from end-diastole to end-diastole before the press,
// and as many while it is held as a heart of 60 a minute has in the time that was asked for.
PressScript with_whole_beats(PressScript script, double beat_s) {
  script.natural_s = std::max(script.natural_s, 2.5 * beat_s);
  script.held_s *= std::max(1.0, beat_s);
  return script;
}

PressRow row_of(const palpation::Signals& now, double t, double displacement_mm) {
  return {t,
          displacement_mm,
          kMmPerM * now.depth_m[0],
          kMmPerM * now.dent_m[0],
          now.force_n[0],
          now.volume_ml,
          now.lv_mmhg,
          now.aortic_mmhg,
          now.mitral_flow_ml_s,
          now.aortic_flow_ml_s,
          now.beat.output_l_per_min};
}

void append_row(std::string& text, std::initializer_list<double> numbers) {
  bool first = true;
  for (const double number : numbers) {
    if (!first) text += ',';
    append_number(text, number);
    first = false;
  }
}

std::string press_csv(const Press& press) {
  std::string text =
      "t_s,displacement_mm,depth_mm,dent_mm,force_n,volume_ml,lv_mmhg,aortic_mmhg,mitral_ml_s,"
      "aortic_ml_s,output_l_per_min\n";
  for (const PressRow& r : press.rows) {
    append_row(text, {r.time_s, r.displacement_mm, r.depth_mm, r.dent_mm, r.force_n, r.volume_ml,
                      r.lv_mmhg, r.aortic_mmhg, r.mitral_ml_s, r.aortic_ml_s, r.output_l_per_min});
    text += '\n';
  }
  return text;
}

std::string loops_csv(const Press& press) {
  std::string text = "loop,t_s,volume_ml,lv_mmhg\n";
  for (const auto* loop : {&press.natural, &press.pressed}) {
    for (const PressRow& r : *loop) {
      text += loop == &press.natural ? "natural," : "pressed,";
      append_row(text, {r.time_s, r.volume_ml, r.lv_mmhg});
      text += '\n';
    }
  }
  return text;
}

std::string tissues_csv(const std::vector<TissueForce>& tissues) {
  std::string text = "tissue,finger,diastole_n,systole_n,diastole_jnd,systole_jnd\n";
  for (const TissueForce& tissue : tissues) {
    for (const FeltBeat* beat : {&tissue.in_space, &tissue.with_wall}) {
      text += tissue.name + (beat == &tissue.in_space ? ",in space," : ",with the wall,");
      append_row(text, {beat->diastole_n, beat->systole_n, beat->diastole_jnd, beat->systole_jnd});
      text += '\n';
    }
  }
  return text;
}

template <class Get>
PlotSeries series(const std::string& name, const std::vector<PressRow>& rows, Get x, Get y) {
  PlotSeries out;
  out.name = name;
  for (const PressRow& row : rows) {
    out.x.push_back(row.*x);
    out.y.push_back(row.*y);
  }
  return out;
}

std::string press_svg(const Press& press) {
  // The seconds around the way in, as figure 8; then what became of the circulation.
  std::vector<PressRow> near;
  const PressScript& script = press.script;
  for (const PressRow& row : press.rows) {
    if (row.time_s >= script.natural_s - 1 && row.time_s <= script.natural_s + 4) {
      near.push_back(row);
    }
  }
  const auto t = &PressRow::time_s;
  return plots_svg({{.title = "Displacement of the finger",
                     .x_title = "time [s]",
                     .y_title = "displacement [mm]",
                     .series = {series("finger", near, t, &PressRow::displacement_mm),
                                series("below moving wall", near, t, &PressRow::depth_mm)}},
                    {.title = "Force on the finger",
                     .x_title = "time [s]",
                     .y_title = "force [N]",
                     .series = {series("", near, t, &PressRow::force_n)},
                     .from_zero = true},
                    {.title = "Pressures",
                     .x_title = "time [s]",
                     .y_title = "pressure [mmHg]",
                     .series = {series("left ventricle", near, t, &PressRow::lv_mmhg),
                                series("aorta", near, t, &PressRow::aortic_mmhg)},
                     .from_zero = true},
                    {.title = "Cardiac output, of the last beat",
                     .x_title = "time [s]",
                     .y_title = "output [l/min]",
                     .series = {series("", press.rows, t, &PressRow::output_l_per_min)},
                     .from_zero = true}});
}

std::string loops_svg(const Press& press) {
  Plot figure{
      .title = "Pressure-volume loop of the left ventricle",
      .x_title = "volume [ml]",
      .y_title = "pressure [mmHg]",
      .series = {series("natural", press.natural, &PressRow::volume_ml, &PressRow::lv_mmhg),
                 series("pressed", press.pressed, &PressRow::volume_ml, &PressRow::lv_mmhg)},
      .from_zero = true};
  for (PlotSeries& loop : figure.series) {  // closed
    if (loop.x.empty()) continue;
    loop.x.push_back(loop.x.front());
    loop.y.push_back(loop.y.front());
  }
  return plots_svg({figure});
}

std::string tissues_svg(const std::vector<TissueForce>& tissues) {
  const auto panel = [&](const std::string& title, FeltBeat TissueForce::*which) {
    Plot figure{.title = title,
                .x_title = "time since end-diastole [s]",
                .y_title = "force [N]",
                .series = {},
                .from_zero = true};
    for (const TissueForce& tissue : tissues) {
      const FeltBeat& beat = tissue.*which;
      std::ostringstream name;
      name << std::fixed;
      name.precision(1);
      name << tissue.name;
      if (&tissue != &tissues.front()) {
        name << ": " << beat.diastole_jnd << " / " << beat.systole_jnd << " JND";
      }
      figure.series.push_back({.name = name.str(), .x = beat.time_s, .y = beat.force_n});
    }
    return figure;
  };
  return plots_svg(
      {panel("A finger that stands in space (JND in diastole / systole)", &TissueForce::in_space),
       panel("A finger that goes with the wall, half as deep", &TissueForce::with_wall)});
}

json beat_json(const Beat& beat) {
  return {{"edv_ml", beat.edv_ml},
          {"esv_ml", beat.esv_ml},
          {"stroke_ml", beat.stroke_ml},
          {"ejection_fraction", beat.ejection_fraction},
          {"output_l_per_min", beat.output_l_per_min},
          {"peak_lv_mmhg", beat.peak_lv_mmhg},
          {"aortic_high_mmhg", beat.aortic_high_mmhg},
          {"aortic_low_mmhg", beat.aortic_low_mmhg},
          {"aortic_mean_mmhg", beat.aortic_mean_mmhg}};
}

double largest_force_n(const Press& press) {
  double largest = 0;
  for (const PressRow& row : press.rows) largest = std::max(largest, row.force_n);
  return largest;
}

// Force where the contraction is strongest: `activation` runs with the beat.
void set_ends(FeltBeat& beat, const std::vector<double>& activation) {
  const auto strongest = std::max_element(activation.begin(), activation.end());
  beat.systole_n = beat.force_n[static_cast<std::size_t>(strongest - activation.begin())];
  beat.diastole_n = beat.force_n.back();
}

FeltBeat feel_in_space(const palpation::PalpationParameters& parameters,
                       const PressScript& script) {
  const Press press = run_press(parameters, script);
  FeltBeat out;
  std::vector<double> lv;
  for (const PressRow& row : press.pressed) {
    out.time_s.push_back(row.time_s - press.pressed.front().time_s);
    out.force_n.push_back(row.force_n);
    lv.push_back(row.lv_mmhg);
  }
  set_ends(out, lv);
  return out;
}

FeltBeat feel_with_wall(const palpation::PalpationParameters& parameters,
                        const PressScript& script) {
  constexpr long kBeats = 8;  // the patch forgets the first touch
  palpation::Circulation circulation(parameters.whole_circulation());
  circulation.settle();
  const long first = circulation.beats();
  const palpation::MuscleConstants muscle = parameters.at(script.long_axis, script.segment);
  palpation::VerticalPatch patch({.mass_kg = parameters.wall_mass_kg,
                                  .damping_n_s_per_m = muscle.c_v_n_s_per_m,
                                  .contact_n_per_m = parameters.contact_n_per_m});
  const double alpha = parameters.segments[static_cast<std::size_t>(script.segment - 1)].alpha;
  FeltBeat out;
  std::vector<double> activation;
  while (circulation.beats() < first + kBeats) {
    circulation.tick(kTickS, -1);
    const double stiffness = muscle.k_v_n_per_m +
                             palpation::contractile_n_per_m(parameters, alpha, circulation) +
                             palpation::pressure_n_per_m(circulation);
    const double force = patch.advance(0.5 * script.depth_mm / kMmPerM, stiffness, kTickS);
    if (circulation.beats() < first + kBeats - 1) continue;
    out.time_s.push_back(kTickS * static_cast<double>(out.time_s.size()));
    out.force_n.push_back(force);
    activation.push_back(circulation.activation());
  }
  set_ends(out, activation);
  return out;
}

TissueForce feel(const std::string& name, const palpation::PalpationParameters& parameters,
                 const PressScript& script, int segment) {
  PressScript held = script;
  held.segment = segment;
  return {name, feel_in_space(parameters, held), feel_with_wall(parameters, held)};
}

void compare(FeltBeat& beat, const FeltBeat& healthy) {
  beat.diastole_jnd = palpation::force_jnds(beat.diastole_n, healthy.diastole_n);
  beat.systole_jnd = palpation::force_jnds(beat.systole_n, healthy.systole_n);
}

json felt_json(const FeltBeat& beat) {
  return {{"diastole_n", beat.diastole_n},
          {"systole_n", beat.systole_n},
          {"diastole_jnd", beat.diastole_jnd},
          {"systole_jnd", beat.systole_jnd}};
}

}  // namespace

double finger_displacement_mm(const PressScript& script, double t) {
  const auto rise = [&](double since) {
    const double share = std::clamp(since / script.moving_s, 0.0, 1.0);
    return 0.5 * (1 - std::cos(std::numbers::pi * share));
  };
  const double in = script.natural_s;
  const double out = in + script.moving_s + script.held_s;
  return script.depth_mm * (rise(t - in) - rise(t - out));
}

Press run_press(const palpation::PalpationParameters& parameters, const PressScript& wanted) {
  if (!(wanted.depth_mm >= 0 && wanted.depth_mm <= 10)) {
    throw_invalid("a press must be from 0 to 10 mm deep");
  }
  palpation::Trainer trainer(parameters, 1);
  Press press;
  press.script = with_whole_beats(wanted, 60 / parameters.circulation.heart_rate_per_min);
  const PressScript& script = press.script;
  const double let_go_s = script.natural_s + script.moving_s + script.held_s;
  const auto ticks =
      static_cast<std::size_t>(std::lround((let_go_s + script.moving_s + script.after_s) / kTickS));
  press.rows.reserve(ticks);
  std::vector<PressRow> beat;
  std::uint64_t beats = trainer.signals().beats;
  for (std::size_t n = 1; n <= ticks; ++n) {
    const double t = kTickS * static_cast<double>(n);
    const double displacement_mm = finger_displacement_mm(script, t);
    const palpation::Finger finger{.depth_m = displacement_mm / kMmPerM,
                                   .long_axis = script.long_axis,
                                   .segment = script.segment};
    trainer.tick(kTickS, std::span(&finger, 1));
    const palpation::Signals& now = trainer.signals();
    press.rows.push_back(row_of(now, t, displacement_mm));
    beat.push_back(press.rows.back());
    if (now.beats == beats) continue;
    beats = now.beats;
    if (t <= script.natural_s) {
      press.natural = beat;
      press.natural_beat = now.beat;
    } else if (t <= let_go_s) {
      press.pressed = beat;
      press.pressed_beat = now.beat;
    }
    beat.clear();
  }
  return press;
}

std::vector<TissueForce> compare_tissues(const PressScript& script) {
  constexpr int kMidAnterior = 7;
  constexpr int kMidInferior = 10;
  const auto infarct = palpation::palpation_preset("anterior_infarct");
  std::vector<TissueForce> out{
      feel("healthy", {}, script, kMidAnterior), feel("infarct", infarct, script, kMidAnterior),
      feel("beside infarct", infarct, script, kMidInferior),
      feel("dilated", palpation::palpation_preset("dilated_cardiomyopathy"), script, kMidAnterior),
      feel("low pressure", palpation::palpation_preset("low_pressure"), script, kMidAnterior)};
  compare_with_first(out);
  return out;
}

void write_press(const Press& press, const std::vector<TissueForce>& tissues,
                 const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) {
    throw Error(ErrorCode::Machine, folder.string() + " cannot be made; check its name and rights");
  }
  write_file(folder / "press.csv", press_csv(press));
  write_file(folder / "press.svg", press_svg(press));
  write_file(folder / "loops.csv", loops_csv(press));
  write_file(folder / "loops.svg", loops_svg(press));
  write_file(folder / "tissues.csv", tissues_csv(tissues));
  write_file(folder / "tissues.svg", tissues_svg(tissues));
}

json press_json(const Press& press, const std::vector<TissueForce>& tissues) {
  json out = {
      {"depth_mm", press.script.depth_mm},
      {"natural", beat_json(press.natural_beat)},
      {"pressed", beat_json(press.pressed_beat)},
      {"output_share", press.pressed_beat.output_l_per_min / press.natural_beat.output_l_per_min},
      {"largest_force_n", largest_force_n(press)},
      {"tissues", tissues_json(tissues)}};
  return out;
}

json tissues_json(const std::vector<TissueForce>& tissues) {
  json out = json::array();
  for (const TissueForce& tissue : tissues) {
    out.push_back({{"name", tissue.name},
                   {"in_space", felt_json(tissue.in_space)},
                   {"with_wall", felt_json(tissue.with_wall)}});
  }
  return out;
}

void compare_with_first(std::vector<TissueForce>& tissues) {
  for (TissueForce& tissue : tissues) {
    compare(tissue.in_space, tissues.front().in_space);
    compare(tissue.with_wall, tissues.front().with_wall);
  }
}

std::string press_text(const Press& press, const std::vector<TissueForce>& tissues) {
  std::ostringstream text;
  text.precision(3);
  const auto beat = [&](const char* name, const Beat& b) {
    text << name << ": EDV " << b.edv_ml << " ml, ESV " << b.esv_ml << " ml, EF "
         << 100 * b.ejection_fraction << " %, output " << b.output_l_per_min
         << " l/min, mean aortic pressure " << b.aortic_mean_mmhg << " mmHg\n";
  };
  beat("natural", press.natural_beat);
  beat("pressed", press.pressed_beat);
  text << press.script.depth_mm << " mm take the cardiac output to "
       << 100 * press.pressed_beat.output_l_per_min / press.natural_beat.output_l_per_min
       << " % of natural; largest force " << largest_force_n(press) << " N\n";
  for (const TissueForce& tissue : tissues) {
    text << tissue.name << ": " << tissue.in_space.diastole_n << " N at end-diastole ("
         << tissue.in_space.diastole_jnd << " JND from healthy); with the wall "
         << tissue.with_wall.diastole_n << " to " << tissue.with_wall.systole_n << " N ("
         << tissue.with_wall.diastole_jnd << ", " << tissue.with_wall.systole_jnd << " JND)\n";
  }
  return text.str();
}

}  // namespace beatlas::app
