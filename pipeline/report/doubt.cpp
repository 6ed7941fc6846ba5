#include "pipeline/report/doubt.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "pipeline/core/words.h"

namespace beatlas::report {
namespace {

constexpr double kWorthTelling = 0.2;  ///< of what is doubted
constexpr std::size_t kMostSlices = 3;

double excess_mm2(const SliceBelief& slice) { return slice.labelled_mm2 - slice.agreed_mm2; }
double missed_mm2(const SliceBelief& slice) { return slice.expected_mm2 - slice.agreed_mm2; }

/// @param doubted_mm2 excess_mm2 or missed_mm2
DoubtedVolume doubted_volume(const std::vector<SliceBelief>& slices, double thickness_mm,
                             double (*doubted_mm2)(const SliceBelief&)) {
  DoubtedVolume out;
  const double all_mm2 = doubted_mm2(about_labels(slices));
  out.ml = all_mm2 * thickness_mm * 1e-3;
  if (all_mm2 <= 0) return out;
  for (const std::size_t k : slices_about_labels(slices)) {
    out.slices.push_back({static_cast<int>(k), slices[k]});
  }
  std::stable_sort(out.slices.begin(), out.slices.end(),
                   [&](const SliceDoubt& a, const SliceDoubt& b) {
                     return doubted_mm2(a.belief) > doubted_mm2(b.belief);
                   });
  // The worst is told in any case.
  const auto told = std::find_if(
      out.slices.begin() + 1, out.slices.end(),
      [&](const SliceDoubt& slice) { return doubted_mm2(slice.belief) < kWorthTelling * all_mm2; });
  out.slices.erase(told, out.slices.end());
  if (out.slices.size() > kMostSlices) out.slices.resize(kMostSlices);
  return out;
}

Doubt doubt_of(Structure structure, bool end_systole, int phase,
               const std::vector<SliceBelief>& slices, double thickness_mm) {
  return {structure,
          end_systole,
          phase,
          about_labels(slices).expected_dice(),
          doubted_volume(slices, thickness_mm, excess_mm2),
          doubted_volume(slices, thickness_mm, missed_mm2)};
}

std::string in_words(const DoubtedVolume& doubted, const char* what) {
  std::vector<std::string> slices;
  char text[128];
  for (const SliceDoubt& slice : doubted.slices) {
    const double either =
        slice.belief.labelled_mm2 + slice.belief.expected_mm2 - slice.belief.agreed_mm2;
    std::snprintf(text, sizeof text, "slice %d (%.0f mm2 labelled, %.0f likely, %.0f %% in common)",
                  slice.slice, slice.belief.labelled_mm2, slice.belief.expected_mm2,
                  either > 0 ? 100 * slice.belief.agreed_mm2 / either : 100);
    slices.emplace_back(text);
  }
  std::snprintf(text, sizeof text, "%.0f ml may be %s, most in ", doubted.ml, what);
  return text + listed(slices);
}

}  // namespace

double ExpectedLimits::of(Structure structure, bool end_systole) const {
  if (structure == Structure::LvMyocardium) return muscle;
  if (structure == Structure::RvBlood) return end_systole ? rv_es : rv_ed;
  return end_systole && structure == Structure::LvBlood ? lv_es : lv_ed;
}

bool is_borne_out(const LeakAlarm& alarm, const Segmentation& segmentation,
                  const ExpectedLimits& limits) {
  const auto found = segmentation.belief.find(alarm.structure);
  if (found == segmentation.belief.end()) return true;
  if (alarm.kind == LeakKind::VolumeJump || alarm.kind == LeakKind::OpenCycle) {
    return alarm.structure != Structure::Heart;  // it holds atria, which come and go in the slices
  }
  const Grid& grid = segmentation.labels.grid;
  const double k = (grid.mm_from_index.inverse() * alarm.lps_mm)[2];
  const std::vector<SliceBelief>& slices = found->second[static_cast<std::size_t>(alarm.phase)];
  const auto slice = std::clamp<long>(std::lround(k), 0, static_cast<long>(slices.size()) - 1);
  const SliceBelief& there = slices[static_cast<std::size_t>(slice)];
  return there.is_told() || there.expected_dice() <
                                limits.of(alarm.structure, alarm.phase == segmentation.end_systole);
}

std::vector<Doubt> doubts_of(const Segmentation& segmentation, const HeartFigures& figures) {
  std::vector<Doubt> out;
  const double thickness_mm = segmentation.labels.grid.spacing_mm()[2];
  const auto add = [&](Structure structure, bool end_systole) {
    const auto found = segmentation.belief.find(structure);
    if (found == segmentation.belief.end()) return;
    const auto& own = structure == Structure::RvBlood ? figures.rv : figures.lv;
    const int of_heart = end_systole ? segmentation.end_systole : segmentation.end_diastole;
    const int phase = own ? (end_systole ? own->es : own->ed) : of_heart;
    out.push_back(doubt_of(structure, end_systole, phase,
                           found->second[static_cast<std::size_t>(phase)], thickness_mm));
  };
  for (const Structure ventricle : {Structure::LvBlood, Structure::RvBlood}) {
    add(ventricle, false);
    add(ventricle, true);
  }
  add(Structure::LvMyocardium, false);
  return out;
}

std::string volumes_in_words(const Doubt& doubt) {
  const bool is_excess = doubt.excess.ml > doubt.missed.ml;
  const double lesser_ml = std::min(doubt.excess.ml, doubt.missed.ml);
  const std::string excess = in_words(doubt.excess, "too much");
  const std::string missed = in_words(doubt.missed, "missing");
  const std::string& first = is_excess ? excess : missed;
  if (lesser_ml < kWorthTelling * (doubt.excess.ml + doubt.missed.ml)) return first;
  return first + "; " + (is_excess ? missed : excess);
}

std::string figures_in_words(const Doubt& doubt) {
  if (doubt.structure == Structure::LvMyocardium) return "the mass of the LV";
  const std::string of = doubt.structure == Structure::LvBlood ? "the LV" : "the RV";
  return std::string(doubt.end_systole ? "ESV" : "EDV") + ", EF and stroke volume of " + of;
}

}  // namespace beatlas::report
