#include "pipeline/cli/label_names.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <set>
#include <vector>

#include "pipeline/core/words.h"
#include "runtime/base/error.h"
#include "runtime/base/nearest_name.h"

namespace beatlas::cli {
namespace {

struct Name {
  std::string_view letters;  ///< lower case, no separators
  std::uint8_t label;
};

constexpr std::array<Name, 28> kNames{{{"background", kLabelBackground},
                                       {"outside", kLabelBackground},
                                       {"bg", kLabelBackground},
                                       {"rvblood", kLabelRvBlood},
                                       {"rv", kLabelRvBlood},
                                       {"rvcavity", kLabelRvBlood},
                                       {"lvmyocardium", kLabelLvMyocardium},
                                       {"myocardium", kLabelLvMyocardium},
                                       {"lvmyo", kLabelLvMyocardium},
                                       {"myo", kLabelLvMyocardium},
                                       {"lvwall", kLabelLvMyocardium},
                                       {"lvblood", kLabelLvBlood},
                                       {"lv", kLabelLvBlood},
                                       {"lvcavity", kLabelLvBlood},
                                       {"restofheart", kLabelRestOfHeart},
                                       {"rest", kLabelRestOfHeart},
                                       {"heart", kLabelRestOfHeart},
                                       {"otherheart", kLabelRestOfHeart},
                                       {"lablood", kLabelLaBlood},
                                       {"la", kLabelLaBlood},
                                       {"lacavity", kLabelLaBlood},
                                       {"leftatrium", kLabelLaBlood},
                                       {"rablood", kLabelRaBlood},
                                       {"ra", kLabelRaBlood},
                                       {"racavity", kLabelRaBlood},
                                       {"rightatrium", kLabelRaBlood},
                                       {"aorta", kLabelAorta},
                                       {"ao", kLabelAorta}}};

/// Names of more than one label: a ventricle is its cavity and the wall around it.
struct WideName {
  std::string_view letters;
  std::string_view meant;
};
constexpr std::array<WideName, 2> kWideNames{{{"leftventricle", "'lv_blood' or 'lv_myocardium'"},
                                              {"rightventricle", "'rv_blood' or 'rest_of_heart'"}}};

constexpr std::string_view kOwnNumbers =
    "1=rv_blood,2=lv_myocardium,3=lv_blood,4=rest_of_heart,5=la_blood,6=ra_blood,7=aorta";

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Runs of letters in lower case, and runs of digits; all else parts them. Bytes of letters beyond
/// ASCII count as letters: a name that has one is no known one.
std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  bool letters = false;
  bool open = false;
  for (const char c : text) {
    const bool letter = is_letter(c) || static_cast<unsigned char>(c) >= 0x80;
    if (!letter && !is_digit(c)) {
      open = false;
      continue;
    }
    if (!open || letter != letters) words.emplace_back();
    words.back().push_back(c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c);
    open = true;
    letters = letter;
  }
  return words;
}

std::optional<int> number_of(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace

std::optional<std::uint8_t> label_from_name(std::string_view name) {
  const std::vector<std::string> words = words_of(name);
  if (words.empty()) return std::nullopt;
  if (is_digit(words.front().front())) {
    // A list called "3" has places called "3-1".
    const std::optional<int> number = number_of(words.front());
    const bool numbers = std::all_of(words.begin(), words.end(),
                                     [](const std::string& word) { return is_digit(word[0]); });
    if (!numbers || !number || *number > kLastLabel) return std::nullopt;
    return static_cast<std::uint8_t>(*number);
  }
  std::string letters;
  bool behind = false;  // numbers stand behind the name alone
  for (const std::string& word : words) {
    const bool number = is_digit(word[0]);
    if (behind && !number) return std::nullopt;
    behind = number;
    if (!number) letters += word;
  }
  for (const Name& known : kNames) {
    if (known.letters == letters) return known.label;
  }
  return std::nullopt;
}

std::string_view name_of_label(std::uint8_t label) { return kLabelWords.at(label); }

std::string what_it_may_be(std::string_view name) {
  name = name.substr(0, name.find('@'));
  while (!name.empty() && (is_digit(name.back()) || name.back() == '-')) name.remove_suffix(1);
  std::string letters;
  for (const std::string& word : words_of(name)) letters += word;
  for (const WideName& wide : kWideNames) {
    if (letters == wide.letters) return "did you mean " + std::string(wide.meant) + "?";
  }
  const std::string meant =
      nearest_name(name, std::set<std::string>(kLabelWords.begin(), kLabelWords.end()));
  return meant.empty() ? "call it one of " + known_label_names() : "did you mean '" + meant + "'?";
}

std::string known_label_names() {
  return "background, rv_blood, lv_myocardium, lv_blood, rest_of_heart, la_blood, ra_blood, aorta "
         "(or 0 to 7)";
}

std::string shown_word(std::string_view word) {
  constexpr std::size_t kMost = 40;
  std::string out = "'";
  for (const char c : word.substr(0, kMost)) out += c >= ' ' && c <= '~' ? c : '?';
  return out + (word.size() > kMost ? "...'" : "'");
}

LabelMap own_label_map() { return label_map_from_word(std::string(kOwnNumbers)); }

LabelMap label_map_from_word(const std::string& word) {
  if (word == "acdc") return label_map_from_word("1=rv_blood,2=lv_myocardium,3=lv_blood");
  if (word == "mms") return label_map_from_word("1=lv_blood,2=lv_myocardium,3=rv_blood");
  const auto refuse = [](const std::string& what) -> void {
    throw Error(ErrorCode::Usage, "--label-map: " + what +
                                      "; give acdc, mms, or pairs like 3=lv_blood,2=lv_myocardium");
  };
  LabelMap map;
  std::string_view rest = word;
  while (true) {
    const std::string_view pair = rest.substr(0, rest.find(','));
    const std::size_t equals = pair.find('=');
    const std::optional<int> number =
        equals == std::string_view::npos ? std::nullopt : number_of(pair.substr(0, equals));
    if (!number) refuse(shown_word(pair) + " is no NUMBER=NAME");
    if (*number < 1 || *number > 255) {
      refuse("the number " + std::to_string(*number) + " is not within 1 to 255");
    }
    const std::optional<std::uint8_t> label = label_from_name(pair.substr(equals + 1));
    if (!label) {
      refuse(shown_word(pair.substr(equals + 1)) + " is no known label; " +
             what_it_may_be(pair.substr(equals + 1)));
    }
    if (!map.emplace(*number, *label).second) {
      refuse("the number " + std::to_string(*number) + " is mapped twice");
    }
    if (pair.size() == rest.size()) return map;
    rest.remove_prefix(pair.size() + 1);
  }
}

LabelCycle mapped_labels(LabelCycle images, const LabelMap& map, std::uint8_t unnamed) {
  std::array<int, 256> table{};
  table.fill(-1);
  table[0] = unnamed;
  table[kLabelUnknown] = kLabelUnknown;
  std::string known;
  for (const auto& [number, label] : map) {
    table[static_cast<std::size_t>(number)] = label;
    known += (known.empty() ? "" : ", ") + std::to_string(number);
  }
  for (std::vector<std::uint8_t>& image : images.phases) {
    for (std::uint8_t& voxel : image) {
      const int label = table[voxel];
      if (label < 0) {
        throw_invalid("it holds the number " + std::to_string(voxel) +
                      ", which stands for no label (known: " + known +
                      "); say what it is with --label-map " + std::to_string(voxel) + "=NAME");
      }
      voxel = static_cast<std::uint8_t>(label);
    }
  }
  return images;
}

}  // namespace beatlas::cli
