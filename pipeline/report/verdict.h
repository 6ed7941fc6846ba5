#pragma once
/// Is this atlas good? One answer, from checks whose limits and reasons are stated.

#include <optional>
#include <string>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/possible_heart.h"
#include "pipeline/report/curves.h"
#include "pipeline/report/doubt.h"
#include "pipeline/report/heart_figures.h"
#include "pipeline/report/places.h"

namespace beatlas::report {

enum class Level { Good, Check, Rejected };
/// "good", "check", "rejected".
[[nodiscard]] std::string level_name(Level level);

/// One thing that was looked at.
struct Finding {
  std::string id;
  std::string title;    ///< what should be
  std::string trouble;  ///< what is so where it is not good, in a few words
  Level level = Level::Good;
  std::string said;                        ///< what was found, for people
  std::string limit;                       ///< beyond what it is no longer good
  std::string why;                         ///< of the limit
  std::string how = {};                    ///< to mend it; empty: nothing is known to
  std::vector<std::string> commands = {};  ///< that do, in the study's folder
};

/// Each with its reason in verdict.cpp, which the page shows.
struct VerdictLimits {
  double volume_gap_percent = 5;    ///< of package against segmentation
  double ef_difference_points = 3;  ///< of the package's surfaces against the segmentation
  double stroke_difference_percent = 20;
  double muscle_change_percent = 15;
  double least_ef_percent = kLeastEfPercent;
  double most_ef_percent = kMostEfPercent;
  double shift_mm = 5;
  double uncertain_percent = 10;
  double uncertain_mm = 2;
  double crossing_percent = 1;  ///< as `validate`, see assess/structural_checks.h
  ExpectedLimits expected;
  double least_rr_s = 0.4;
  double most_rr_s = 1.6;
  int least_phases = 8;
};

/// How well a surface is made, see assess/surface_checks.h; the worst of all phases.
struct SurfaceFigures {
  Structure structure{};
  double open_edges = 0;
  double pinched_vertices = 0;
  double crossing_percent = 0;  ///< pairs that cut each other, of the triangles
};

struct VerdictInput {
  std::string refused;             ///< why no package was written; empty: it was, or was not tried
  std::vector<std::string> stale;  ///< stages that would run again
  bool of_study = true;            ///< else nothing is known of leaks and shifts
  bool segmented = false;
  HeartFigures segmentation;
  std::vector<Structure> missing;  ///< that the scene needs, see missing_structures
  std::string how_to_find;         ///< them
  std::vector<std::string> finding_commands;
  /// What its surfaces enclose at the ends of the labels' beat, see ventricles_at; none: it is of
  /// no study, or there is none.
  std::optional<HeartFigures> package;
  /// Package against segmentation, of the structure's largest volume in the beat.
  std::optional<double> worst_gap_percent;
  int worst_gap_sign = 0;    ///< 1 too much, -1 too little, 0 not known
  std::string worst_gap_of;  ///< what does: "the surface of heart in phase 3"
  std::size_t checks = 0;    ///< of the package without the truth; 0: it was not looked at
  std::vector<std::string> failed_checks;  ///< those it did not pass, a sentence each
  std::vector<SurfaceFigures> surfaces;
  std::vector<Place> leaks;           ///< that are borne out, see is_borne_out
  std::size_t other_leaks = 0;        ///< alarms that are not
  std::vector<Doubt> doubts;          ///< of the prior; empty: it was not asked
  std::vector<std::string> warnings;  ///< of the segmentation, without those of leaks
  std::vector<std::string> remarks;   ///< of the stages behind it, each after the stage's name
  std::vector<Vec2> slice_shifts_mm;
  std::vector<int> slice_lags;              ///< see Exam
  std::optional<double> uncertain_percent;  ///< of the worst structure, see places.h
  std::string uncertain_structure;
  int phases = 0;
  double rr_interval_s = 0;
};

/// Those of `needed` that are not there in every phase.
[[nodiscard]] std::vector<Structure> missing_structures(const std::vector<VolumeCurve>& volumes,
                                                        const std::vector<Structure>& needed);

/// In order of importance: what is missing or refused, then whether it is this heart, last how
/// fields and triangles were made.
[[nodiscard]] std::vector<Finding> findings(const VerdictInput& input,
                                            const VerdictLimits& limits = {});
/// Those of them for which no package may be used, a sentence each: where there is one, `build`
/// leaves no package.
[[nodiscard]] std::vector<std::string> rejections(const std::vector<Finding>& findings);
/// The worst of them.
[[nodiscard]] Level verdict(const std::vector<Finding>& findings);

}  // namespace beatlas::report
