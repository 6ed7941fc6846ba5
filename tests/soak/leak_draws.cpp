/// leak_draws PRESET COUNT [FIRST]: segments COUNT random draws of the degradations of a phantom's
/// ventricles, seeds from FIRST (1), and lists every leak, whether the alarm rang for it, and every
/// alarm where nothing leaked, each with its seed. Fails if a leak had no alarm, or if more than
/// one in twenty of the draws that did not leak had one.
///
/// A draw: heart scaled by 0.8 to 1.2, R-R 0.6 to 1.1 s, view turned by up to 25 degrees about each
/// axis (less where the heart would leave it), SNR 10 to 40, bias up to 40 %, slices shifted by up
/// to 2 mm (standard deviation).
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "pipeline/core/segmented_volume.h"
#include "pipeline/phantom/render.h"
#include "pipeline/segment/alarm.h"
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

Outcome tried(const phantom::PhantomSpec& spec, const segment::LeakOptions& options) {
  StageContext context;
  const phantom::Phantom phantom(spec);
  phantom::Rendering rendering = phantom::render(phantom, context);
  Exam exam;
  exam.stack = std::move(rendering.cine);
  Outcome out;
  Segmentation found;
  try {
    const prior::PriorCycle prior = test::learned(exam);
    found = segment::segment_exam(exam, {}, {}, context, {}, &prior);
  } catch (const Error& error) {
    out.leak = std::string("refused: ") + error.what();
    return out;
  }
  std::ostringstream leak;
  const double spilled = most_spilled(rendering.labels, found.labels);
  if (spilled > kMostSpilled) leak << " heart too large by " << std::lround(100 * spilled) << " %";
  out.missed = most_spilled(found.labels, rendering.labels) > kMostSpilled;
  for (const Structure structure : kVentricular) {
    const std::vector<double> curve = segmented_volume_ml(found, structure);
    std::vector<double> truth;
    for (int p = 0; p < spec.phases; ++p) {
      truth.push_back(phantom.volume_ml(structure, phantom.phase_time_s(p)));
    }
    const double full = *std::max_element(truth.begin(), truth.end());
    double worst = 0;
    double least = 0;
    for (std::size_t p = 0; p < curve.size(); ++p) {
      const double off = (curve[p] - truth[p]) / full;
      worst = std::max(worst, off);
      least = std::min(least, off);
    }
    out.missed = out.missed || least < -kMostVolumeShare;
    if (worst > kMostVolumeShare) {
      leak << " " << structure_name(structure) << " " << std::lround(100 * worst) << " %";
    }
  }
  out.leak = leak.str();
  out.alarms = segment::leak_alarms(exam.stack, found, options, context);
  return out;
}

int run(const std::string& preset, int count, unsigned first) {
  int leaks = 0;
  int rung = 0;
  int refused = 0;
  int false_alarms = 0;
  int missed = 0;
  std::map<std::string, int> kinds;
  for (unsigned seed = first; seed < first + static_cast<unsigned>(count); ++seed) {
    const Outcome outcome = tried(drawn(preset, seed), {});
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
  return rung < leaks || false_alarms > std::max(1, clean / 20) || refused > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) {
    std::cerr << "usage: leak_draws PRESET COUNT [FIRST]\n";
    return 2;
  }
  return run(argv[1], std::atoi(argv[2]),
             argc > 3 ? static_cast<unsigned>(std::atoi(argv[3])) : 1U);
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 1;
}
