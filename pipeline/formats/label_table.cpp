#include "pipeline/formats/label_table.h"

#include <array>
#include <cstdio>

#include "runtime/atlas/structure_colours.h"

namespace beatlas::formats {
namespace {

/// The structure whose colour a label has; of the rest of the heart the heart itself.
Structure structure_of(std::uint8_t label) {
  for (const Structure structure : kAllStructures) {
    if (label_of(structure) == label) return structure;
  }
  return Structure::Heart;
}

std::string name_of(std::uint8_t label) {
  if (label == kLabelBackground) return "background";
  if (label == kLabelRestOfHeart) return "rest_of_heart";
  return std::string(structure_name(structure_of(label)));
}

/// A line a label: `line_of` writes number, colour, whether it is shown, and name.
template <class Line>
std::string lines(const Line& line_of) {
  std::string text;
  for (int label = kLabelBackground; label <= kLastLabel; ++label) {
    const auto number = static_cast<std::uint8_t>(label);
    const bool shown = number != kLabelBackground;
    const Colour colour = shown ? structure_colour(structure_of(number)) : Colour{0, 0, 0};
    std::array<char, 128> line{};
    line_of(line, label, colour, shown ? 1 : 0, name_of(number));
    text += line.data();
  }
  return text;
}

}  // namespace

std::string itk_snap_labels() {
  return "# ITK-SNAP label descriptions: number, red, green, blue, opacity, seen, meshed, name\n" +
         lines([](auto& line, int label, const Colour& c, int shown, const std::string& name) {
           std::snprintf(line.data(), line.size(), "%5d %5d %4d %4d %8d %2d %2d    \"%s\"\n", label,
                         c[0], c[1], c[2], shown, shown, shown, name.c_str());
         });
}

std::string slicer_colour_table() {
  return "# Colour table of 3D Slicer: number, name, red, green, blue, opacity\n" +
         lines([](auto& line, int label, const Colour& c, int shown, const std::string& name) {
           std::snprintf(line.data(), line.size(), "%d %s %d %d %d %d\n", label, name.c_str(), c[0],
                         c[1], c[2], 255 * shown);
         });
}

}  // namespace beatlas::formats
