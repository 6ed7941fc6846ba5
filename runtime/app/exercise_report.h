#pragma once
/// What an exercise ends with: for a program, a person at a terminal, and trainee and instructor.

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/app/exercise_files.h"
#include "runtime/app/exercise_ground.h"
#include "runtime/exercise/score.h"
#include "runtime/exercise/staircase.h"

namespace beatlas::app {

/// One answer of a staircase.
struct ThresholdTrial {
  double difference = 0;                               ///< 0..1 of the stiffness at rest
  std::uint32_t place = 0;                             ///< vertex where it was softer
  std::optional<std::uint32_t> marked = std::nullopt;  ///< vertex that the trainee meant
  bool right = false;
};

struct ExerciseResult {
  std::size_t ticks = 0;
  std::vector<exercise::Findings> findings;  ///< [trial]
  std::vector<exercise::Lesion> lesions;     ///< Find: what was hidden
  exercise::Score score;                     ///< Find
  std::vector<ThresholdTrial> trials;        ///< Threshold
  exercise::Staircase::Estimate threshold;   ///< Threshold
};

/// schemas/exercise_score.schema.json
[[nodiscard]] nlohmann::json result_json(const KeptSession& session, const ExerciseGround& atlas,
                                         const ExerciseResult& result);
/// Some lines; ends with a newline.
[[nodiscard]] std::string result_text(const KeptSession& session, const ExerciseGround& atlas,
                                      const ExerciseResult& result);
/// A page that needs nothing beside it: figures, the palpation on the bull's eye and on the wall.
[[nodiscard]] std::string report_html(const KeptSession& session, const ExerciseGround& atlas,
                                      const ExerciseResult& result);

}  // namespace beatlas::app
