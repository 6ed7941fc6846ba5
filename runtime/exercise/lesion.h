#pragma once
/// Lesions that are hidden in a heart: where, how large, how grave.

#include <cstdint>
#include <vector>

#include "runtime/exercise/exercise.h"
#include "runtime/palpation/atlas_muscle.h"

namespace beatlas::exercise {

struct Lesion {
  LesionKind kind = LesionKind::Soft;
  double grade = 0;          ///< 0..1: what is lost of stiffness, thickness or contraction
  double radius_mm = 0;      ///< where the grade has fallen to half; it is whole up to 3/4 of it
  std::uint32_t vertex = 0;  ///< its middle, of the endocardium
};

/// The wall that an exercise is about, and where a finger gets at it.
struct Ground {
  const palpation::LvWall& wall;
  std::vector<bool> touchable;  ///< [vertex] over_wall finds a place
};

/// Lesions of an exercise of Task::Find, apart from each other by more than their sizes, each with
/// its middle where a finger gets and most of it, too. The same seed on the same wall draws the
/// same. @throws Error{InvalidInput} if the exercise's segments cannot be touched on this heart, or
/// have no room
[[nodiscard]] std::vector<Lesion> draw_lesions(const Exercise& exercise, const Ground& ground,
                                               std::uint64_t seed);

/// Places of an exercise of Task::Threshold, spread over what a finger reaches: farthest first.
/// @return vertices, exercise.places of them. @throws Error{InvalidInput} as draw_lesions
[[nodiscard]] std::vector<std::uint32_t> threshold_places(const Exercise& exercise,
                                                          const Ground& ground);

/// Soft muscle under which a finger at rest meets `difference` (0..1) less of the whole stiffness:
/// that of the muscle, of the contractile element at rest and of the filling pressure. No more than
/// nine tenths of the muscle's own stiffness can be missing.
[[nodiscard]] Lesion lesion_of_difference(double difference, double radius_mm, std::uint32_t vertex,
                                          const palpation::AtlasMuscle& muscle);

/// What `lesion_of_difference` was asked for, less what cannot be missing.
[[nodiscard]] double difference_of_lesion(const Lesion& lesion,
                                          const palpation::AtlasMuscle& muscle);

/// What a grade of a kind makes of a tissue that may be ill already.
[[nodiscard]] palpation::Tissue with_lesion(const palpation::Tissue& tissue, LesionKind kind,
                                            double grade) noexcept;

/// Puts lesions into the wall; what they do to the whole ventricle goes with them.
void hide_lesions(const std::vector<Lesion>& lesions, const palpation::LvWall& wall,
                  palpation::TissueMap& tissue);

}  // namespace beatlas::exercise
