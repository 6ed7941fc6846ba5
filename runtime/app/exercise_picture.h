#pragma once
/// A palpation as a picture: on the bull's eye of the AHA, and on the ventricle's wall. SVG.

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/app/exercise_ground.h"
#include "runtime/exercise/findings.h"

namespace beatlas::app {

struct PalpationPicture {
  std::vector<float> under_finger_s;       ///< [vertex]
  std::vector<exercise::Lesion> lesions;   ///< drawn as what was hidden
  std::vector<exercise::Mark> marks;       ///< numbered from 1
  std::vector<std::uint32_t> places = {};  ///< lettered from A
};

/// 420 x 420: the anterior wall above, the septum to the left.
[[nodiscard]] std::string bulls_eye_svg(const ExerciseGround& atlas,
                                        const PalpationPicture& picture);
/// 840 x 420: the endocardium at end-diastole from two sides of the wall that is touched, the apex
/// below.
[[nodiscard]] std::string wall_svg(const ExerciseGround& atlas, const PalpationPicture& picture);
/// What the colours of both mean, as HTML.
[[nodiscard]] std::string colour_key();

}  // namespace beatlas::app
