#pragma once
/// Markups of 3D Slicer (.mrk.json, schema 1.x) as seeds.

#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/segment/options.h"

namespace beatlas::cli {

/// What a markup or a painted image does not tell of itself.
struct MarkingWords {
  int phase = 0;  ///< it was made on; -1 = every phase
  double radius_mm = segment::Seed{}.radius_mm;
};

/// Whether a JSON file holds markups and no seeds of ours.
[[nodiscard]] bool holds_markups(const nlohmann::json& json);

/// Each point of a list ("Fiducial") is a ball; a "Line" or "Curve" a stroke through its points,
/// straight from each to the next, a "ClosedCurve" one that returns to its first. A label is told
/// by the point's label, else by the name of its list (label_from_name); of a stroke all points
/// must tell the same. The phase: by "@5" (or "@all") at the end of that name, else by `words`.
/// A radius: by the point's description, as in "radius 6 mm", else by `words`. Points that were not
/// placed are passed over; what else such files hold is not looked at.
/// @throws Error{InvalidInput} naming the JSON path: another kind of markup, a name that stands for
/// no label (with those that do), a place that is no place, no point at all.
[[nodiscard]] std::vector<segment::Seed> seeds_from_markups(const nlohmann::json& json,
                                                            const MarkingWords& words);

/// The same seeds as a file that 3D Slicer opens: a list for all balls of a label and phase, called
/// as in "lv_blood@5", and a line or curve for each stroke. seeds_from_markups gives them back, by
/// lists in the order of their first seeds.
[[nodiscard]] nlohmann::json seeds_to_markups(const std::vector<segment::Seed>& seeds);

}  // namespace beatlas::cli
