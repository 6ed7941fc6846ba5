#pragma once
/// The words by which other programs' users call our labels, and their numbers for them.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "pipeline/core/shapes.h"

namespace beatlas::cli {

/// Label that a name stands for: its own (see known_label_names), "LV", "myocardium" and the like,
/// or a number 0..7. Upper or lower case, blanks and separators do not matter, nor does a number
/// behind a name, as programs add to tell copies apart ("LV_blood-3"). "Left ventricle" stands for
/// none: it is cavity and wall.
[[nodiscard]] std::optional<std::uint8_t> label_from_name(std::string_view name);

/// "lv_blood" and the like; label 0..7.
[[nodiscard]] std::string_view name_of_label(std::uint8_t label);

/// What a name that is no label's most likely means (without a number or @phase behind it), for
/// messages: "did you mean 'lv_blood'?", or where none is near "call it one of ...".
[[nodiscard]] std::string what_it_may_be(std::string_view name);

/// "background, rv_blood, ..., aorta (or 0 to 7)", for messages.
[[nodiscard]] std::string known_label_names();

/// A word of the user as a message may show it: printable characters, in quotes, cut if long.
[[nodiscard]] std::string shown_word(std::string_view word);

/// Number in an image -> our label.
using LabelMap = std::map<int, std::uint8_t>;

/// Ours: 1 to 4, each itself.
[[nodiscard]] LabelMap own_label_map();

/// "acdc" (1 RV, 2 myocardium, 3 LV), "mms" (1 LV, 2 myocardium, 3 RV), or NUMBER=NAME, separated
/// by commas. What stands for 0 is not asked: it is background, or not painted.
/// @throws Error{Usage} naming --label-map
[[nodiscard]] LabelMap label_map_from_word(const std::string& word);

/// Replaces the numbers of label images by our labels; 0 becomes `unnamed`, and 255 stays what it
/// is (unknown, or not painted) unless the map names it.
/// @throws Error{InvalidInput} if a number is not in the map, naming number, map and option
[[nodiscard]] LabelCycle mapped_labels(LabelCycle images, const LabelMap& map,
                                       std::uint8_t unnamed);

}  // namespace beatlas::cli
