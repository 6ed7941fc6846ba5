/// leak_draws PRESET|family COUNT [FIRST]: segments COUNT random draws, seeds from FIRST, and lists
/// every leak, whether the alarm rang for it, and every alarm where nothing leaked, each with its
/// seed. Fails if a leak had no alarm, if more than one in twenty of the draws that did not leak
/// had one, or if a heart was refused.
///
/// Of a preset's ventricles (FIRST is 1 if not said) a draw is of the degradations: heart scaled by
/// 0.8 to 1.2, R-R 0.6 to 1.1 s, view turned by up to 25 degrees about each axis (less where the
/// heart would leave it), SNR 10 to 40, bias up to 40 %, slices shifted by up to 2 mm (standard
/// deviation). `family` draws all that the family of random hearts does (FIRST is the first seed of
/// judges): heart or none, body, contrasts, scanner, stack and breath-holds, imported as import
/// does.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "pipeline/alarm/alarm.h"
#include "pipeline/core/segmented_volume.h"
#include "pipeline/motion/acquisition_faults.h"
#include "pipeline/phantom/drawn_exam.h"
#include "pipeline/phantom/render.h"
#include "pipeline/segment/segment.h"
#include "runtime/base/error.h"
#include "tests/learned.h"

namespace {

using namespace beatlas;

constexpr double kMostSpilled = 0.1;      ///< of the heart: labelled as it where it is not
constexpr double kMostVolumeShare = 0.2;  ///< of the structure's largest volume, too much

class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  double between(double low, double high) {
    return low +
           (high - low) * static_cast<double>(engine_()) / static_cast<double>(std::mt19937::max());
  }
  int seed() { return static_cast<int>(engine_() % 1000000U); }

 private:
  std::mt19937 engine_;
};

bool fits(const phantom::PhantomSpec& spec) {
  try {
    phantom::check_spec(spec);
    return true;
  } catch (const Error&) {
    return false;
  }
}

phantom::PhantomSpec drawn(const std::string& preset, unsigned seed) {
  Draw draw(seed);
  phantom::PhantomSpec spec = phantom::preset(preset);
  spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  spec.anatomy.scale = draw.between(0.8, 1.2);
  spec.rr_interval_s = draw.between(0.6, 1.1);
  spec.scanner.snr_blood = 10 * std::pow(4.0, draw.between(0, 1));
  spec.scanner.bias_share = draw.between(0, 0.4);
  spec.scanner.shift_sigma_mm = draw.between(0, 2);
  spec.scanner.noise_seed = draw.seed();
  spec.scanner.bias_seed = draw.seed();
  spec.scanner.shift_seed = draw.seed();
  spec.oblique_deg = {draw.between(-25, 25), draw.between(-25, 25), draw.between(-25, 25)};
  for (int tries = 0; tries < 4 && !fits(spec); ++tries) spec.oblique_deg *= 0.5;
  if (!fits(spec)) spec.oblique_deg.setZero();
  for (int tries = 0; tries < 20 && !fits(spec); ++tries) spec.anatomy.scale *= 0.98;
  return spec;
}

/// Images of a body, and what is true of the heart in it.
struct Known {
  Exam exam;
  LabelCycle labels;
  std::map<Structure, std::vector<double>> volume_ml;  ///< of each phase
};

Known of_preset(const std::string& preset, unsigned seed) {
  StageContext context;
  const phantom::PhantomSpec spec = drawn(preset, seed);
  const phantom::Phantom phantom(spec);
  phantom::Rendering rendering = phantom::render(phantom, context);
  Known out;
  out.exam.stack = std::move(rendering.cine);
  out.labels = std::move(rendering.labels);
  for (const Structure structure : kVentricular) {
    for (int p = 0; p < spec.phases; ++p) {
      out.volume_ml[structure].push_back(phantom.volume_ml(structure, phantom.phase_time_s(p)));
    }
  }
  return out;
}

bool is_of(Structure structure, std::uint8_t label) {
  switch (structure) {
    case Structure::Heart:
      return label != kLabelBackground;
    case Structure::LvBlood:
      return label == kLabelLvBlood;
    case Structure::RvBlood:
      return label == kLabelRvBlood;
    default:
      return label == kLabelLvMyocardium;
  }
}

/// Volumes are of what the stack shows: it need not show all of a heart.
Known of_family(unsigned seed) {
  StageContext context;
  phantom::DrawnExam drawn = phantom::drawn_exam(seed, {}, context);
  Known out;
  out.exam.stack = std::move(drawn.cine);
  out.exam = motion::without_acquisition_faults(std::move(out.exam), {});
  out.labels = out.exam.slice_shifts_mm.empty() ? drawn.source_labels : drawn.labels;
  for (const Structure structure : kVentricular) {
    for (const auto& phase : out.labels.phases) {
      const auto voxels = std::count_if(
          phase.begin(), phase.end(), [&](std::uint8_t label) { return is_of(structure, label); });
      out.volume_ml[structure].push_back(static_cast<double>(voxels) * out.labels.grid.voxel_ml());
    }
  }
  return out;
}

struct Outcome {
  std::string leak;     ///< what leaked; empty: nothing
  bool missed = false;  ///< a part of the heart: an alarm there is right, and none is no leak
  std::vector<LeakAlarm> alarms;
};

/// Voxels labelled as heart that are none, of those that are, in the worst phase.
double most_spilled(const LabelCycle& truth, const LabelCycle& found) {
  double most = 0;
  for (std::size_t p = 0; p < truth.phases.size(); ++p) {
    double outside = 0;
    double heart = 0;
    for (std::size_t v = 0; v < truth.phases[p].size(); ++v) {
      heart += truth.phases[p][v] != 0 ? 1 : 0;
      outside += truth.phases[p][v] == 0 && found.phases[p][v] != 0 ? 1 : 0;
    }
    most = std::max(most, outside / heart);
  }
  return most;
}

bool is_there(const std::vector<double>& curve) {
  return std::any_of(curve.begin(), curve.end(), [](double ml) { return ml > 0; });
}

Outcome tried(const Known& known, const alarm::LeakOptions& options) {
  StageContext context;
  const bool has_heart = is_there(known.volume_ml.at(Structure::Heart));
  Outcome out;
  Segmentation found;
  try {
    const prior::PriorCycle prior = test::learned(known.exam);
    found = segment::segment_exam(known.exam, {}, {}, context, {}, &prior);
  } catch (const Error& error) {
    if (has_heart) out.leak = std::string("refused: ") + error.what();
    return out;
  }
  std::ostringstream leak;
  if (has_heart) {
    const double spilled = most_spilled(known.labels, found.labels);
    if (spilled > kMostSpilled) {
      leak << " heart too large by " << std::lround(100 * spilled) << " %";
    }
    out.missed = most_spilled(found.labels, known.labels) > kMostSpilled;
  } else if (is_there(segmented_volume_ml(found, Structure::Heart))) {
    leak << " a heart where there is none";
  }
  for (const Structure structure : kVentricular) {
    const std::vector<double> curve = segmented_volume_ml(found, structure);
    const std::vector<double>& truth = known.volume_ml.at(structure);
    if (!is_there(truth)) continue;  // what stands there counts in what the heart spilled
    const double full = *std::max_element(truth.begin(), truth.end());
    double worst = 0;
    double least = 0;
    for (std::size_t p = 0; p < curve.size(); ++p) {
      const double off = (curve[p] - truth[p]) / full;
      worst = std::max(worst, off);
      least = std::min(least, off);
    }
    out.missed = out.missed || curve.empty() || least < -kMostVolumeShare;
    if (worst > kMostVolumeShare) {
      leak << " " << structure_name(structure) << " " << std::lround(100 * worst) << " %";
    }
  }
  out.leak = leak.str();
  out.alarms = alarm::leak_alarms(known.exam.stack, found, options, context);
  return out;
}

constexpr const char* kFamily = "family";

int run(const std::string& preset, int count, unsigned first) {
  int leaks = 0;
  int rung = 0;
  int refused = 0;
  int false_alarms = 0;
  int missed = 0;
  std::map<std::string, int> kinds;
  for (unsigned seed = first; seed < first + static_cast<unsigned>(count); ++seed) {
    const Outcome outcome =
        tried(preset == kFamily ? of_family(seed) : of_preset(preset, seed), {});
    if (outcome.leak.starts_with("refused")) {
      ++refused;  // a clear error is no leak, but no segmentation either
      std::cout << "seed " << seed << " " << outcome.leak << "\n";
      continue;
    }
    const bool leaked = !outcome.leak.empty();
    const bool rang = !outcome.alarms.empty();
    leaks += leaked ? 1 : 0;
    rung += leaked && rang ? 1 : 0;
    missed += outcome.missed ? 1 : 0;
    const bool groundless = rang && !leaked && !outcome.missed;
    false_alarms += groundless ? 1 : 0;
    if (!leaked && !rang) continue;
    std::cout << "seed " << seed << (leaked ? " LEAK" + outcome.leak : " no leak")
              << (outcome.missed ? ", a part MISSED" : "") << (rang ? "" : ", NO ALARM") << "\n";
    for (const LeakAlarm& alarm : outcome.alarms) {
      std::cout << "    " << leak_kind_name(alarm.kind) << ": " << alarm.sentence << "\n";
      if (groundless) ++kinds[std::string(leak_kind_name(alarm.kind))];
    }
    std::cout.flush();
  }
  const int clean = count - leaks - refused;
  std::cout << preset << ": " << count << " draws, " << leaks << " leaks, alarm for " << rung
            << " of them; " << missed << " with a part missed; " << refused
            << " refused; false alarms on " << false_alarms << " of " << clean << " others";
  for (const auto& [kind, times] : kinds) std::cout << ", " << kind << " " << times;
  std::cout << "\n";
  return rung < leaks || 20 * false_alarms > clean || refused > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) {
    std::cerr << "usage: leak_draws PRESET|family COUNT [FIRST]\n";
    return 2;
  }
  const std::string preset = argv[1];
  const int count = std::atoi(argv[2]);
  if (count < 1) {
    std::cerr << "leak_draws: COUNT must be 1 or more, for of no draw nothing is known\n";
    return 2;
  }
  const unsigned first = preset == kFamily ? phantom::kFirstJudgingSeed : 1U;
  return run(preset, count, argc > 3 ? static_cast<unsigned>(std::atoi(argv[3])) : first);
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 1;
}
