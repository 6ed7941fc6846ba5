#include "pipeline/formats/label_table.h"

#include <map>
#include <sstream>

#include <gtest/gtest.h>

#include "runtime/atlas/structure_colours.h"

namespace beatlas::formats {
namespace {

struct Entry {
  std::string name;
  Colour colour{};
  int opacity = 0;
};

Colour colour_of(int red, int green, int blue) {
  return {static_cast<std::uint8_t>(red), static_cast<std::uint8_t>(green),
          static_cast<std::uint8_t>(blue)};
}

// As the two programs read their files: words between blanks, remarks behind "#".
std::map<int, Entry> as_itk_snap(const std::string& text) {
  std::map<int, Entry> entries;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    int number = -1, red = -1, green = -1, blue = -1, opacity = -1, seen = -1, meshed = -1;
    words >> number >> red >> green >> blue >> opacity >> seen >> meshed >> std::ws;
    std::string name;
    std::getline(words, name);
    EXPECT_TRUE(name.size() > 2 && name.front() == '"' && name.back() == '"') << line;
    EXPECT_EQ(seen, opacity) << line;
    entries[number] = {name.substr(1, name.size() - 2), colour_of(red, green, blue), opacity};
  }
  return entries;
}

std::map<int, Entry> as_slicer(const std::string& text) {
  std::map<int, Entry> entries;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    int number = -1, red = -1, green = -1, blue = -1, opacity = -1;
    std::string name, more;
    words >> number >> name >> red >> green >> blue >> opacity;
    EXPECT_FALSE(words.fail()) << line;
    EXPECT_FALSE(words >> more) << line;
    entries[number] = {name, colour_of(red, green, blue), opacity / 255};
  }
  return entries;
}

TEST(LabelTable, HasNameAndColourOfEveryLabel) {
  for (const auto& entries : {as_itk_snap(itk_snap_labels()), as_slicer(slicer_colour_table())}) {
    ASSERT_EQ(entries.size(), std::size_t{kLastLabel} + 1);
    EXPECT_EQ(entries.at(0).name, "background");
    EXPECT_EQ(entries.at(0).opacity, 0);
    for (const Structure structure : kAllStructures) {
      const Entry& entry = entries.at(label_of(structure));
      EXPECT_EQ(entry.colour, structure_colour(structure)) << entry.name;
      EXPECT_EQ(entry.opacity, 1) << entry.name;
      EXPECT_EQ(entry.name, structure == Structure::Heart ? "rest_of_heart"
                                                          : std::string(structure_name(structure)));
    }
  }
}

}  // namespace
}  // namespace beatlas::formats
