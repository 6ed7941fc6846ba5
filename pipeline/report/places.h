#pragma once
/// Where a technician has to look.

#include <optional>
#include <string>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"

namespace beatlas::report {

struct Place {
  enum class Kind { Leak, Uncertain } kind{};
  Structure structure{};
  int phase = 0;
  Vec3 lps_mm = Vec3::Zero();
  std::string title;       ///< a few words
  std::string sentence;    ///< what, where, what to do
  std::string alarm = {};  ///< of a leak: its kind, see leak_kind_name
  double figure = 0;       ///< of a leak: how large it is, [mm2] or [% of the largest volume]
  double limit = 0;        ///< same unit
  std::vector<LeakSeed> seeds = {};  ///< that together correct it, tried
};

/// "the left ventricle's blood" and the like.
[[nodiscard]] std::string structure_words(Structure structure);

/// The leak alarms, as they are.
[[nodiscard]] std::vector<Place> leak_places(const Segmentation& segmentation);

struct UncertainOptions {
  /// [mm] > 0: a boundary known no better is one where two human readers differ as much: their
  /// contours lie 1 mm apart in the mean (LV), 2 mm (RV), Bai et al. 2018.
  double sigma_mm = 2;
  double apart_mm = 20;       ///< of two places of one structure
  double smallest_mm2 = 100;  ///< surface that must be as uncertain around the place, in its phase
  int most = 3;               ///< of one structure
};

/// Per structure, where most of its boundary is known no better than sigma_mm, in the phase in
/// which that is so of most of it. What a leak alarm rings for within apart_mm is left to it.
/// @param grid of the coverage, on which the points lie
[[nodiscard]] std::vector<Place> uncertain_places(const BoundaryUncertainty& uncertainty,
                                                  const Grid& grid, const std::vector<Place>& leaks,
                                                  const UncertainOptions& options = {});

/// Share [%] of a structure's boundary, over all phases, that is known no better than sigma_mm;
/// 0 without points.
[[nodiscard]] double uncertain_percent(const BoundaryUncertainty& uncertainty, Structure structure,
                                       double sigma_mm);

}  // namespace beatlas::report
