#include "pipeline/report/verdict.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "pipeline/core/words.h"

namespace beatlas::report {
namespace {

[[gnu::format(printf, 1, 2)]] std::string text(const char* format, ...) {
  char out[400];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(out, sizeof out, format, arguments);
  va_end(arguments);
  return out;
}

/// A figure to the last place that people are told. report.json keeps a thousandth, which the page
/// rounds again: both ways must lead to the same number.
long as_told(double value) { return std::lround(std::round(1e3 * value) / 1e3); }

Level check_if(bool bad) { return bad ? Level::Check : Level::Good; }
Level reject_if(bool bad) { return bad ? Level::Rejected : Level::Good; }

std::string listed(const std::vector<std::string>& lines, const char* between) {
  std::string out;
  for (const std::string& line : lines) out += (out.empty() ? "" : between) + line;
  return out;
}

/// "2 alarms (no edge in the image: the heart's outside; ...)".
std::string alarms_in_words(const std::vector<Place>& leaks) {
  std::vector<std::string> titles;
  titles.reserve(leaks.size());
  for (const Place& leak : leaks) titles.push_back(leak.title);
  const std::string all = listed(titles, "; ");
  return counted(leaks.size(), "alarm") + (all.empty() ? "" : " (" + all + ")");
}

Finding of_package(const VerdictInput& input, const VerdictLimits& limits) {
  Finding out{"package",
              "Package keeps the volumes",
              "The package does not keep the volumes",
              Level::Good,
              "",
              "",
              ""};
  out.limit = text("%g %% of the largest volume", limits.volume_gap_percent);
  out.why =
      "Fields and surfaces are made from the segmentation and nothing else; a volume that differs "
      "more was lost on the way. It is told as a share of the structure's largest volume in the "
      "beat. On the phantom small fields differ by 0.1 % and surfaces by up to "
      "2.3 %, the aorta's by 1 % and 4.7 %. The recipe refuses the package at "
      "/quality/max_volume_gap_percent.";
  if (!input.refused.empty()) {
    out.level = Level::Rejected;
    out.trouble = "No package was made";
    out.said = input.refused;
  } else if (!input.worst_gap_percent) {
    out.level = Level::Check;
    out.trouble = "There is no package";
    out.said = "none has been made from this study yet";
  } else {
    out.level = check_if(*input.worst_gap_percent > limits.volume_gap_percent);
    if (input.worst_gap_sign != 0) {
      out.trouble = input.worst_gap_sign > 0 ? "The package has too much volume"
                                             : "Volume is missing in the package";
    }
    const char* sign = input.worst_gap_sign == 0  ? ""
                       : input.worst_gap_sign > 0 ? " too much"
                                                  : " missing";
    out.said = text("largest difference %.1f %% of the largest volume in the beat%s",
                    *input.worst_gap_percent, sign);
    if (!input.worst_gap_of.empty()) out.said += ", " + input.worst_gap_of;
  }
  return out;
}

Finding of_checks(const VerdictInput& input) {
  Finding out{"checks",
              "Package passes its checks",
              "The package does not pass its checks",
              check_if(!input.failed_checks.empty()),
              "",
              "0 not passed",
              "What `beatlas validate` says of the package: closed surfaces, distances that rise "
              "evenly, nothing stray, surfaces and distances that agree, a beat that closes. Its "
              "limits are of damage and mix-up."};
  out.said = input.failed_checks.empty() ? text("all of %zu passed", input.checks)
                                         : listed(input.failed_checks, "; ");
  return out;
}

std::vector<std::string> names_of_missing(const HeartFigures& figures) {
  std::vector<std::string> out;
  if (!figures.lv) out.emplace_back("LV blood");
  if (!figures.rv) out.emplace_back("RV blood");
  if (!figures.lv_mass_g) out.emplace_back("LV muscle");
  return out;
}

/// What the scene needs and is not there leads to no package; what it could do without is told.
Finding of_structures(const VerdictInput& input) {
  const HeartFigures& figures = input.segmentation;
  Finding out{"structures",
              "All structures were found",
              "A structure is missing",
              Level::Good,
              "heart, LV blood, RV blood and LV muscle",
              "all four",
              "What is missing can be neither drawn nor touched. A scene that does without a "
              "structure says so (/structures of its JSON file); of labels that were given for "
              "every phase, what they hold is enough.",
              "",
              {}};
  if (!input.missing.empty()) {
    out.level = Level::Rejected;
    out.trouble = "A structure that the scene needs is missing";
    out.said = "";
    for (const Structure structure : input.missing) {
      out.said += (out.said.empty() ? "" : ", ") + std::string(structure_name(structure));
    }
    out.how = input.how_to_find;
    out.commands = input.finding_commands;
  } else if (!figures.lv || !figures.rv || !figures.lv_mass_g) {
    out.level = Level::Check;
    out.said = listed(names_of_missing(figures), ", ");
  }
  return out;
}

Finding of_ejection(const VentricleFigures& lv, const VerdictLimits& limits) {
  const double ef = lv.ef_percent();
  return {"ef_possible",
          "Ejection fraction is possible",
          ef < limits.least_ef_percent ? "The LV ejects too little for any heart"
                                       : "The LV ejects too much for any heart",
          reject_if(ef < limits.least_ef_percent || ef > limits.most_ef_percent),
          text("LV %ld %%", as_told(ef)),
          text("%g to %g %%", limits.least_ef_percent, limits.most_ef_percent),
          "No heart that ejects less keeps anyone alive, and none empties itself: labels that do "
          "not follow the beat, or images that do not show one."};
}

Finding of_strokes(const HeartFigures& figures, const VerdictLimits& limits) {
  const double lv = figures.lv->stroke_ml();
  const double rv = figures.rv->stroke_ml();
  const double mean = (lv + rv) / 2;
  const double share = mean > 0 ? 100 * std::abs(lv - rv) / mean : 100;
  const long lv_told = as_told(lv);
  const long rv_told = as_told(rv);
  const bool far = share > limits.stroke_difference_percent;
  const char* less = rv < lv ? "RV" : "LV";
  const char* more = rv < lv ? "LV" : "RV";
  return {"strokes",
          "Both ventricles eject as much",
          rv < lv ? "The RV ejects less than the LV" : "The LV ejects less than the RV",
          check_if(far),
          far ? text("LV %ld ml, RV %ld ml: %.0f %% of their mean missing in the %s or too much "
                     "in the %s",
                     lv_told, rv_told, share, less, more)
              : text("LV %ld ml, RV %ld ml: they differ by %.0f %%", lv_told, rv_told, share),
          text("%g %%", limits.stroke_difference_percent),
          "Without a shunt or a leaking valve the stroke volumes are nearly equal, so this checks "
          "both outlines at once. The limit leaves room for how far readers differ (SD of EDV "
          "15 to 28 ml between seven laboratories, Suinesiaputra 2015, "
          "doi:10.1186/s12968-015-0170-9). A patient with a shunt or regurgitation may rightly "
          "exceed it."};
}

/// A part of "LV 0.93 and 0.90, RV 0.85 and 0.79, muscle 0.80", in the order of the limits.
std::string told_of(const Doubt& doubt, bool is_first) {
  if (doubt.end_systole) return text(" and %.2f", doubt.expected_dice);
  const char* of = doubt.structure == Structure::LvBlood   ? "LV"
                   : doubt.structure == Structure::RvBlood ? "RV"
                                                           : "muscle";
  return text("%s%s %.2f", is_first ? "" : ", ", of, doubt.expected_dice);
}

/// One finding for each figure that is not to be trusted, or one for all that are.
std::vector<Finding> of_doubts(const VerdictInput& input, const VerdictLimits& limits) {
  constexpr auto kWhy =
      "Every voxel has a probability of each structure before anything grows, from a network that "
      "is shown its slice turned and enlarged in several ways. The Dice that labels would have in "
      "the mean, were those probabilities right, tells where they and the labels part. Of drawn "
      "hearts that nothing was learned from it goes with the true Dice "
      "(pipeline/report/README.md).";
  std::vector<Finding> out;
  std::string expected;
  for (const Doubt& doubt : input.doubts) {
    expected += told_of(doubt, expected.empty());
    const double limit = limits.expected.of(doubt.structure, doubt.end_systole);
    if (doubt.expected_dice >= limit) continue;
    const std::string when = doubt.end_systole ? "end-systole" : "end-diastole";
    const std::string what = structure_words(doubt.structure);
    out.push_back({"expected_" + std::string(structure_name(doubt.structure)) +
                       (doubt.end_systole ? "_es" : "_ed"),
                   "Labels are what was to be expected",
                   "Look before you trust " + figures_in_words(doubt), Level::Check,
                   text("%s at %s (phase %d): expected Dice %.2f, ", what.c_str(), when.c_str(),
                        doubt.phase, doubt.expected_dice) +
                       volumes_in_words(doubt),
                   text("%g", limit), kWhy,
                   "Look at these slices. Where an outline is wrong, mark what it lacks or has too "
                   "much with seeds; where it is right, leave it."});
  }
  if (out.empty()) {
    out.push_back(
        {"expected", "Labels are what was to be expected", "", Level::Good,
         "expected Dice at end-diastole and end-systole: " + expected,
         text("LV %g and %g, RV %g and %g, muscle %g", limits.expected.lv_ed, limits.expected.lv_es,
              limits.expected.rv_ed, limits.expected.rv_es, limits.expected.muscle),
         kWhy});
  }
  return out;
}

Finding of_surfaces(const VerdictInput& input, const VerdictLimits& limits) {
  Finding out{"surfaces",
              "Surfaces are whole",
              "A surface is torn or folds",
              Level::Good,
              "",
              text("0 open edges; %g %% of triangles that cut others of their surface",
                   limits.crossing_percent),
              "A gap or a pinch makes inside and outside undefined: touch would fail there. Some "
              "triangles of a thin wall may fold where it is carried through the beat; more than "
              "the limit shows as creases. Of the finest level of detail; the others, and two "
              "structures' surfaces that cut each other, are among the package's checks."};
  double gaps = 0;
  double crossing = 0;
  for (const SurfaceFigures& surface : input.surfaces) {
    gaps += surface.open_edges + surface.pinched_vertices;
    crossing = std::max(crossing, surface.crossing_percent);
  }
  out.level = gaps > 0 ? Level::Rejected : check_if(crossing > limits.crossing_percent);
  out.said = text(
      "%g open edges or pinched vertices; at most %.2f %% of triangles cut others of the "
      "same surface",
      gaps, crossing);
  return out;
}

Finding of_shifts(const VerdictInput& input, const VerdictLimits& limits) {
  double most = 0;
  std::size_t slice = 0;
  for (std::size_t k = 0; k < input.slice_shifts_mm.size(); ++k) {
    if (input.slice_shifts_mm[k].norm() <= most) continue;
    most = input.slice_shifts_mm[k].norm();
    slice = k;
  }
  return {"slice_shifts",
          "Slices lie where they belong",
          "A slice was shifted far",
          check_if(most > limits.shift_mm),
          input.slice_shifts_mm.empty()
              ? "no shift that is certain"
              : text("moved back by up to %.1f mm (slice %zu)", most, slice),
          text("%g mm", limits.shift_mm),
          "Each breath-hold moves the heart a little; what images tell is undone. A shift beyond "
          "the limit comes with one along the slice's normal, which cannot be undone: look whether "
          "outlines run on smoothly from slice to slice."};
}

Finding of_timing(const VerdictInput& input) {
  std::vector<std::string> turned;
  int most = 0;
  for (std::size_t k = 0; k < input.slice_lags.size(); ++k) {
    if (input.slice_lags[k] != 0) turned.push_back(std::to_string(k));
    most = std::max(most, std::abs(input.slice_lags[k]));
  }
  return {
      "slice_timing",
      "Slices show the beat in step",
      "Slices were imaged out of step",
      check_if(!turned.empty()),
      turned.empty()
          ? "no slice that is certainly late or early"
          : (turned.size() == 1 ? "slice " : "slices ") + beatlas::listed(turned) +
                text(" turned round the beat, by up to %d of %d phases", most, input.phases),
      "0 slices",
      "Each slice is imaged in beats of its own, and its frames may begin at another moment. "
      "Slices are put in step by whole phases, by what their images tell alone: look whether "
      "all are smallest in the same phase, for volumes that mix moments make the EF too small."};
}

Finding of_leaks(const VerdictInput& input) {
  std::string said = input.leaks.empty() ? "no alarm" : alarms_in_words(input.leaks);
  if (input.other_leaks > 0) {
    said += (input.leaks.empty() ? " that the prior bears out; " : "; ") +
            counted(input.other_leaks, "place") + " to look at, where labels are as expected";
  }
  return {"leaks",
          "No label has leaked",
          "A label may have leaked",
          check_if(!input.leaks.empty()),
          said,
          "0 alarms",
          "Volumes that jump, surfaces in lung, along the image's border, along what does not beat "
          "or where the image has no edge. Each alarm has its own limit, which clean segmentations "
          "of phantoms stay below. Of drawn hearts alarms of a surface ring for right labels as "
          "often as for wrong ones, so they count where the prior, too, expects something else in "
          "their slice, or where it has no say (pipeline/report/README.md)."};
}

Finding of_muscle(double change_percent, const VerdictLimits& limits) {
  return {"muscle",
          "Muscle keeps its volume",
          "The muscle changes its volume",
          check_if(change_percent > limits.muscle_change_percent),
          text("changes by %.0f %% in the beat", change_percent),
          text("%g %%", limits.muscle_change_percent),
          "Muscle can hardly be compressed, so its volume tests inner and outer outline "
          "against each other. Slices far apart lose some of it at the base, which the "
          "limit allows for."};
}

/// @pre a ventricle is in both
Finding of_package_ef(const HeartFigures& package, const HeartFigures& labels,
                      const VerdictLimits& limits) {
  Finding out{
      "ef_agrees",
      "Package and labels agree on the EF",
      "",
      Level::Good,
      "",
      text("%g points", limits.ef_difference_points),
      "The EF of the volumes that the package's own surfaces enclose at the phases in which "
      "the labels are largest and smallest: what is seen beat, beside what is told. The "
      "limit is less than the 4.6 to 7.5 points by which readers of seven laboratories "
      "differ on the LV (SD, Suinesiaputra 2015, doi:10.1186/s12968-015-0170-9)."};
  double worst = 0;
  const auto add = [&](const char* name, const std::optional<VentricleFigures>& made,
                       const std::optional<VentricleFigures>& labelled) {
    if (!made || !labelled) return;
    const double difference = made->ef_percent() - labelled->ef_percent();
    out.said += text("%s%s %.1f %% for the labels' %.1f %% (phases %d and %d)",
                     out.said.empty() ? "" : ", ", name, made->ef_percent(), labelled->ef_percent(),
                     made->ed, made->es);
    if (std::abs(difference) <= std::abs(worst)) return;
    worst = difference;
    out.trouble = text("The %s of the package has too %s an EF for its labels", name,
                       difference < 0 ? "low" : "high");
  };
  add("LV", package.lv, labels.lv);
  add("RV", package.rv, labels.rv);
  out.level = check_if(std::abs(worst) > limits.ef_difference_points);
  return out;
}

Finding of_boundaries(const VerdictInput& input, const VerdictLimits& limits) {
  return {
      "boundaries",
      "Boundaries are well seen",
      "A boundary is hardly seen",
      check_if(input.doubts.empty() && *input.uncertain_percent > limits.uncertain_percent),
      text("at most %.1f %% of a boundary (%s) are known no better than %g mm",
           *input.uncertain_percent, input.uncertain_structure.c_str(), limits.uncertain_mm),
      text("%g %%", limits.uncertain_percent),
      "Contours of two readers lie 1 mm (LV) to 2 mm (RV) apart in the mean (Bai 2018, "
      "doi:10.1186/s12968-018-0471-x): what is known no better than that needs an "
      "eye. Where a prior was asked, what it doubts decides: of drawn hearts this is so of right "
      "labels as often as of wrong ones."};
}

Finding of_beat(const VerdictInput& input, const VerdictLimits& limits) {
  const double rr = input.rr_interval_s;
  std::vector<std::string> beat;
  if (input.phases < limits.least_phases) beat.emplace_back("Phases are missing");
  if (rr < limits.least_rr_s) beat.emplace_back("The R-R interval is too short");
  if (rr > limits.most_rr_s) beat.emplace_back("The R-R interval is too long");
  return {
      "beat",
      "Beat is resolved",
      listed(beat, "; "),
      check_if(!beat.empty()),
      text("R-R %.0f ms (%.0f a minute), %d phases", 1000 * rr, rr > 0 ? 60 / rr : 0, input.phases),
      text("%g to %g s, %d phases", limits.least_rr_s, limits.most_rr_s, limits.least_phases),
      "Outside these rates the R-R interval was most likely misread (--rr gives it); "
      "with fewer phases nothing is known of how the heart moves between them."};
}

/// Is it this heart? Volumes first, then outlines.
void add_of_labels(const VerdictInput& input, const VerdictLimits& limits,
                   std::vector<Finding>& out) {
  const HeartFigures& figures = input.segmentation;
  if (input.missing.empty()) out.push_back(of_structures(input));
  if (figures.lv) out.push_back(of_ejection(*figures.lv, limits));
  if (!input.doubts.empty()) {
    const std::vector<Finding> doubts = of_doubts(input, limits);
    out.insert(out.end(), doubts.begin(), doubts.end());
  }
  if (figures.lv && figures.rv) out.push_back(of_strokes(figures, limits));
  if (figures.muscle_change_percent) {
    out.push_back(of_muscle(*figures.muscle_change_percent, limits));
  }
  if (input.of_study) out.push_back(of_leaks(input));
  out.push_back({"warnings", "Segmentation had no trouble", "The segmentation had trouble",
                 check_if(!input.warnings.empty()),
                 input.warnings.empty() ? "no warning" : listed(input.warnings, "; "), "0 warnings",
                 "What the segmentation could not do as it should."});
}

/// Is the package what the labels say?
void add_of_making(const VerdictInput& input, const VerdictLimits& limits,
                   std::vector<Finding>& out) {
  if (input.refused.empty()) out.push_back(of_package(input, limits));
  if (!input.stale.empty()) {
    out.push_back({"up_to_date", "Everything is up to date", "The package is not of these labels",
                   Level::Check, "to be made again: " + listed(input.stale, ", "), "all stages",
                   "The package does not show what the study says now. Build again."});
  }
  if (input.package && (input.package->lv || input.package->rv)) {
    out.push_back(of_package_ef(*input.package, input.segmentation, limits));
  }
  if (input.checks > 0) out.push_back(of_checks(input));
  if (!input.surfaces.empty()) out.push_back(of_surfaces(input, limits));
  if (input.package) {
    out.push_back({"remarks", "What later stages remarked", "", Level::Good,
                   input.remarks.empty() ? "nothing" : listed(input.remarks, "; "), "none",
                   "What was mended on the way from labels to surfaces. What it cost is measured "
                   "above, in volumes, surfaces and checks; this tells where to look for the "
                   "reason."});
  }
}

}  // namespace

std::string level_name(Level level) {
  return level == Level::Good ? "good" : level == Level::Check ? "check" : "rejected";
}

std::vector<Finding> findings(const VerdictInput& input, const VerdictLimits& limits) {
  std::vector<Finding> out;
  if (!input.missing.empty()) out.push_back(of_structures(input));
  if (!input.refused.empty()) out.push_back(of_package(input, limits));
  if (input.segmented) add_of_labels(input, limits, out);
  if (input.uncertain_percent) out.push_back(of_boundaries(input, limits));
  if (input.of_study) {
    out.push_back(of_timing(input));
    out.push_back(of_shifts(input, limits));
  }
  out.push_back(of_beat(input, limits));
  add_of_making(input, limits, out);
  return out;
}

std::vector<Structure> missing_structures(const std::vector<VolumeCurve>& volumes,
                                          const std::vector<Structure>& needed) {
  std::vector<Structure> out;
  for (const Structure structure : needed) {
    const bool there = std::any_of(volumes.begin(), volumes.end(), [&](const VolumeCurve& curve) {
      return curve.structure == structure && !curve.volume_ml.empty() &&
             std::all_of(curve.volume_ml.begin(), curve.volume_ml.end(),
                         [](double ml) { return ml > 0; });
    });
    if (!there) out.push_back(structure);
  }
  return out;
}

std::vector<std::string> rejections(const std::vector<Finding>& findings) {
  std::vector<std::string> out;
  for (const Finding& finding : findings) {
    if (finding.level == Level::Rejected) out.push_back(finding.trouble + ": " + finding.said);
  }
  return out;
}

Level verdict(const std::vector<Finding>& findings) {
  Level worst = Level::Good;
  for (const Finding& finding : findings) worst = std::max(worst, finding.level);
  return worst;
}

}  // namespace beatlas::report
