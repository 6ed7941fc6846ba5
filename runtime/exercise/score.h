#pragma once
/// How well a trainee did: marks against what was hidden.

#include <optional>
#include <vector>

#include "runtime/exercise/findings.h"

namespace beatlas::exercise {

struct LesionScore {
  Lesion lesion;
  std::optional<std::size_t> mark;  ///< of those made, the one that is nearest; none: none was left
  double distance_mm = 0;           ///< along a straight line at end-diastole, on the endocardium
  bool found = false;               ///< the mark lies within the lesion's radius
  bool named = false;               ///< found, and named as what it is
};

struct Score {
  std::vector<LesionScore> lesions;
  int false_marks = 0;  ///< that found nothing
  /// 0..100, a yardstick of this trainer's own: of each lesion 60 for its place (whole within its
  /// radius, none beyond twice that), 20 for its name; 10 for the share of the wall that was
  /// palpated (whole from 80 % on), 10 for no harmful force (none left from a tenth of the time in
  /// contact on). A mark more than there are lesions takes 20 off.
  double points = 0;
};

/// Each lesion gets one mark at most: the nearest pair first.
[[nodiscard]] Score score_of(const std::vector<Lesion>& lesions, const Findings& findings,
                             const palpation::LvWall& wall);

/// Which of the places a mark means: the nearest. @pre there is a place
[[nodiscard]] std::size_t place_of(const Mark& mark, const std::vector<std::uint32_t>& places,
                                   const palpation::LvWall& wall);

}  // namespace beatlas::exercise
