#pragma once
/// What a trainee is asked to find by touch, and its JSON (schemas/exercise.schema.json).

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace beatlas::exercise {

/// What a finger can tell apart: each differs in what is felt at rest and in what the contraction
/// adds.
enum class LesionKind {
  Soft,      ///< softer at rest, contracts as before
  Thin,      ///< softer at rest, contracts less: there is less muscle
  Akinetic,  ///< as stiff at rest, does not harden in systole
  Scar       ///< stiffer at rest, does not harden in systole
};
inline constexpr int kLesionKinds = 4;
/// soft, thin, akinetic, scar
[[nodiscard]] std::string_view lesion_name(LesionKind kind) noexcept;

enum class Task {
  Find,      ///< lesions anywhere on the left ventricle: mark where each is, and name it
  Threshold  ///< which of some places is softer, again and again: the least difference that is felt
};

struct Range {
  double low = 0;
  double high = 0;
};

struct Exercise {
  std::string title;
  std::string preset = "healthy";  ///< palpation_preset of the heart, beside what is hidden in it
  Task task = Task::Find;
  /// What may be hidden, without repetition; a trainee marks the n-th by button n.
  std::vector<LesionKind> kinds{LesionKind::Soft, LesionKind::Thin, LesionKind::Akinetic,
                                LesionKind::Scar};
  Range grade{0.4, 0.7};        ///< Find: 0.05..1, of thin and soft at most 0.7
  int lesions = 1;              ///< Find: 1..3
  Range radius_mm{10, 15};      ///< 4..40: of a lesion, where its grade is at half
  std::vector<int> segments{};  ///< 1..17, where lesions may lie; empty: wherever a finger reaches
  double seconds = 120;         ///< 5..1800: until a trial ends without the last mark
  double tool_radius_mm = 5;    ///< 0..20: of the fingertip
  double harmful_force_n = 0;   ///< 0..50; 0: what closes vessels under the finger, see score.h
  int trials = 40;              ///< Threshold: 5..200
  int places = 4;               ///< Threshold: 2..8
  double first_difference = 0.3;  ///< Threshold: 0.05..0.4, of the stiffness at rest

  /// Trials of the whole exercise: Find has one.
  [[nodiscard]] int trial_count() const noexcept { return task == Task::Find ? 1 : trials; }
};

/// @param path JSON path of `document` in its file, for messages
/// @throws Error{InvalidInput} naming the JSON path of what is missing, unknown or out of range.
[[nodiscard]] Exercise exercise_from_json(const nlohmann::json& document,
                                          const std::string& path = "");
[[nodiscard]] nlohmann::json exercise_to_json(const Exercise& exercise);

}  // namespace beatlas::exercise
