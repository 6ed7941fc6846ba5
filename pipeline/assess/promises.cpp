#include "pipeline/assess/promises.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "pipeline/assess/validate.h"

namespace beatlas::assess {
namespace {

/// Says what is worse than its promise allows.
class Holder {
 public:
  Holder(const PromiseSet& set, std::vector<std::string>& failures)
      : set_(set), failures_(failures) {}

  void error(const std::string& what, double value, const std::optional<double>& promised) {
    if (!promised || value <= most_error(*promised)) return;
    tell(what, value, "beyond", most_error(*promised), *promised);
  }
  void dice(const std::string& what, double value, const std::optional<double>& promised) {
    if (!promised || value >= least_dice(*promised)) return;
    tell(what, value, "below", least_dice(*promised), *promised);
  }

 private:
  void tell(const std::string& what, double value, const char* side, double limit,
            double promised) {
    char text[200];
    std::snprintf(text, sizeof text, " is %.4g, %s %.4g: %.4g is promised of what is made from ",
                  value, side, limit, promised);
    failures_.push_back(what + text + std::string(set_.made_from) + " (--limits " +
                        std::string(set_.name) + ")");
  }

  const PromiseSet& set_;
  std::vector<std::string>& failures_;
};

void hold(const Promised& promised, const StructureErrors& structure, Holder& holder) {
  double dice = 1;
  double mean = 0;
  double bias = 0;
  double p95 = 0;
  for (const PhaseErrors& phase : structure.phases) {
    dice = std::min(dice, phase.dice);
    mean += phase.mean_mm;
    bias += phase.bias_mm;
    p95 = std::max(p95, phase.p95_mm);
  }
  const double phases = static_cast<double>(structure.phases.size());
  const std::string name(structure_name(structure.structure));
  holder.dice(name + ": the least Dice of the phases", dice, promised.least_dice);
  holder.error(name + ": mean_mm, the mean over the phases,", mean / phases, promised.mean_mm);
  holder.error(name + ": the size of bias_mm, the mean over the phases,", std::abs(bias) / phases,
               promised.bias_mm);
  holder.error(name + ": p95_mm of the worst phase", p95, promised.p95_mm);
}

}  // namespace

const PromiseSet* promise_set(std::string_view name) noexcept {
  const auto* found = std::find_if(kPromiseSets.begin(), kPromiseSets.end(),
                                   [&](const PromiseSet& set) { return set.name == name; });
  return found == kPromiseSets.end() ? nullptr : found;
}

void hold_to(const PromiseSet& promises, ValidationReport& report) {
  report.held_to = promises.name;
  Holder holder(promises, report.failures);
  for (const StructureErrors& structure : report.structures) {
    for (const Promised& promised : promises.structures) {
      if (promised.structure == structure.structure && !structure.phases.empty()) {
        hold(promised, structure, holder);
      }
    }
  }
  if (report.force && report.force->structure == Structure::Heart) {
    holder.error("force of heart: mean_n", report.force->errors.mean_n, promises.force_mean_n);
  }
  report.passed = report.failures.empty();
}

}  // namespace beatlas::assess
