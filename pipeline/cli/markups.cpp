#include "pipeline/cli/markups.h"

#include <charconv>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "pipeline/build/seeds.h"
#include "pipeline/cli/label_names.h"
#include "pipeline/study/json_values.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
using nlohmann::json;
namespace {

constexpr std::string_view kSchema = "markups-schema-v";
constexpr std::string_view kRadius = "radius ";
constexpr std::string_view kMm = " mm";
constexpr double kLeastRadiusMm = 0.1;
constexpr double kMostRadiusMm = 50;

/// A text of an object, or `otherwise` where there is none.
std::string text_of(const json& object, const char* key, const std::string& path,
                    const std::string& otherwise) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return otherwise;
  if (!found->is_string()) throw_invalid(path + "/" + key + " must be a string");
  return found->get<std::string>();
}

/// What a name tells: a label, and a phase if it ends with one.
struct Told {
  std::optional<std::uint8_t> label;
  std::optional<int> phase;
};

Told told_by(const std::string& name, const std::string& path) {
  const std::size_t at = name.rfind('@');
  if (at == std::string::npos) return {label_from_name(name), std::nullopt};
  // Programs number copies of a name behind it: "lv_blood@5-2".
  std::string_view word = std::string_view(name).substr(at + 1);
  if (word.starts_with("all")) return {label_from_name(name.substr(0, at)), -1};
  int phase = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), phase);
  const bool ends = end == word.data() + word.size() || *end == '-' || *end == '_' || *end == ' ';
  if (error != std::errc() || !ends || phase < 0 || phase > study::kLastPhase) {
    throw_invalid(path + ": " + shown_word(name) +
                  " names no phase; end it with @ and a phase from 0, or with @all");
  }
  return {label_from_name(name.substr(0, at)), phase};
}

/// What "radius 6 mm" tells; none if it tells something else.
std::optional<double> radius_told(const std::string& description, const std::string& path) {
  std::string_view rest = description;
  if (!rest.starts_with(kRadius)) return std::nullopt;
  rest.remove_prefix(kRadius.size());
  double radius_mm = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), radius_mm);
  if (error != std::errc() || std::string_view(end, rest.data() + rest.size()) != kMm) {
    return std::nullopt;
  }
  if (!(radius_mm >= kLeastRadiusMm && radius_mm <= kMostRadiusMm)) {
    throw_invalid(path + ": a radius must be from 0.1 to 50 mm");
  }
  return radius_mm;
}

/// One markup: its kind, its name, and how its points lie.
struct Markup {
  const json& object;
  std::string path;
  std::string name;
  Vec3 lps_from_numbers = Vec3::Ones();
  bool points_are_counted = false;  ///< labels of points are but their count

  Markup(const json& markup, std::string where) : object(markup), path(std::move(where)) {
    if (!object.is_object()) throw_invalid(path + " must be a JSON object");
    name = text_of(object, "name", path, "");
    const std::string frame = text_of(object, "coordinateSystem", path, "LPS");
    if (frame == "RAS" || frame == "0") {
      lps_from_numbers = Vec3(-1, -1, 1);
    } else if (frame != "LPS" && frame != "1") {
      throw_invalid(path + "/coordinateSystem must be LPS or RAS");
    }
    const auto units = object.find("coordinateUnits");
    if (units != object.end() && !units->is_null()) {
      const json& unit = units->is_array() && !units->empty() ? units->front() : *units;
      if (unit == "um") {
        lps_from_numbers *= 1e-3;
      } else if (unit != "mm") {
        throw_invalid(path + "/coordinateUnits must be mm or um");
      }
    }
    points_are_counted =
        text_of(object, "labelFormat", path, "%N-%d").find("%N") == std::string::npos;
  }

  /// Label and phase of a point, or of the whole markup where the point tells none.
  [[nodiscard]] Told told_at(const json& point, const std::string& where) const {
    const std::string label = text_of(point, "label", where, "");
    const Told list = told_by(name, path + "/name");
    Told own;
    const bool counted =
        points_are_counted && label.find_first_not_of("0123456789") == std::string::npos;
    if (!counted) own = told_by(label, where + "/label");
    if (!own.label && !list.label) {
      // A program calls points after their list, so the list's name is what was mistyped.
      const bool by_list = label.empty() || counted || label.starts_with(name + "-");
      const std::string& unknown = by_list ? name : label;
      throw_invalid((by_list ? path + "/name: the list " : where + "/label: ") +
                    shown_word(unknown) + " is no known label; " + what_it_may_be(unknown));
    }
    return {own.label ? own.label : list.label, own.phase ? own.phase : list.phase};
  }

  [[nodiscard]] Vec3 place_of(const json& point, const std::string& where) const {
    const auto found = point.find("position");
    if (found == point.end()) throw_invalid(where + "/position is missing");
    const std::vector<double> numbers = study::numbers_from_json(*found, where + "/position");
    if (numbers.size() != 3) throw_invalid(where + "/position must be 3 numbers");
    Vec3 lps_mm = Vec3(numbers[0], numbers[1], numbers[2]).cwiseProduct(lps_from_numbers);
    if (!(lps_mm.cwiseAbs().maxCoeff() <= build::kFarthestMm)) {
      throw_invalid(where + "/position must lie within -5000 to 5000 mm");
    }
    return lps_mm;
  }
};

void add_markup(const Markup& markup, const MarkingWords& words, std::vector<segment::Seed>& out) {
  const std::string kind = text_of(markup.object, "type", markup.path, "");
  const bool list = kind == "Fiducial";
  const bool closed = kind == "ClosedCurve";
  if (!list && !closed && kind != "Line" && kind != "Curve") {
    throw_invalid(markup.path + "/type is " + shown_word(kind) +
                  ", which marks no places; use points (Fiducial), Line, Curve or ClosedCurve");
  }
  const auto points = markup.object.find("controlPoints");
  if (points == markup.object.end()) return;
  if (!points->is_array()) throw_invalid(markup.path + "/controlPoints must be a list");
  segment::Seed stroke;
  int joined = 0;
  for (std::size_t at = 0; at < points->size(); ++at) {
    const json& point = (*points)[at];
    const std::string where = markup.path + "/controlPoints/" + std::to_string(at);
    if (!point.is_object()) throw_invalid(where + " must be a JSON object");
    if (text_of(point, "positionStatus", where, "defined") != "defined") continue;
    segment::Seed seed;
    const Told told = markup.told_at(point, where);
    seed.label = ventricles_apart(*told.label);
    seed.phase = told.phase.value_or(words.phase);
    seed.radius_mm = radius_told(text_of(point, "description", where, ""), where + "/description")
                         .value_or(words.radius_mm);
    seed.lps_mm = markup.place_of(point, where);
    if (list) {
      out.push_back(seed);
    } else if (joined++ == 0) {
      stroke = seed;
    } else if (seed.label != stroke.label || seed.phase != stroke.phase) {
      throw_invalid(where + " has another label or phase than the points before; a stroke has one");
    } else {
      stroke.stroke_lps_mm.push_back(seed.lps_mm);
    }
  }
  if (joined == 0) return;
  if (closed && joined > 2) stroke.stroke_lps_mm.push_back(stroke.lps_mm);
  out.push_back(std::move(stroke));
}

}  // namespace

bool holds_markups(const json& value) { return value.is_object() && value.contains("markups"); }

std::vector<segment::Seed> seeds_from_markups(const json& value, const MarkingWords& words) {
  const std::string schema = text_of(value, "@schema", "", "");
  const std::size_t at = schema.find(kSchema);
  if (at != std::string::npos && schema.substr(at + kSchema.size(), 2) != "1.") {
    throw_invalid("/@schema names another version of markups than 1.x, which this program reads");
  }
  const json& list = value.at("markups");
  if (!list.is_array()) throw_invalid("/markups must be a list");
  std::vector<segment::Seed> seeds;
  for (std::size_t m = 0; m < list.size(); ++m) {
    add_markup(Markup(list[m], "/markups/" + std::to_string(m)), words, seeds);
  }
  if (seeds.empty()) throw_invalid("/markups hold no point that was placed");
  return seeds;
}

json seeds_to_markups(const std::vector<segment::Seed>& seeds) {
  const auto point = [](const std::string& name, std::size_t at, const Vec3& lps_mm,
                        double radius_mm) -> json {
    return {{"id", std::to_string(at)},
            {"label", name + "-" + std::to_string(at)},
            {"description", std::string(kRadius) + json(radius_mm).dump() + std::string(kMm)},
            {"position", {lps_mm[0], lps_mm[1], lps_mm[2]}},
            {"selected", true},
            {"locked", false},
            {"visibility", true},
            {"positionStatus", "defined"}};
  };
  json markups = json::array();
  std::map<std::string, std::size_t> list_of;  // name -> its list of balls
  for (const segment::Seed& seed : seeds) {
    const std::string name = std::string(name_of_label(seed.label)) + "@" +
                             (seed.phase < 0 ? "all" : std::to_string(seed.phase));
    const bool ball = seed.stroke_lps_mm.empty();
    if (!ball || !list_of.contains(name)) {
      if (ball) list_of[name] = markups.size();
      markups.push_back({{"type", ball                             ? "Fiducial"
                                  : seed.stroke_lps_mm.size() == 1 ? "Line"
                                                                   : "Curve"},
                         {"name", name},
                         {"coordinateSystem", "LPS"},
                         {"coordinateUnits", "mm"},
                         {"locked", false},
                         {"labelFormat", "%N-%d"},
                         {"controlPoints", json::array()}});
    }
    json& list = ball ? markups[list_of[name]] : markups.back();
    json& points = list["controlPoints"];
    points.push_back(point(name, points.size() + 1, seed.lps_mm, seed.radius_mm));
    for (const Vec3& lps_mm : seed.stroke_lps_mm) {
      points.push_back(point(name, points.size() + 1, lps_mm, seed.radius_mm));
    }
    list["lastUsedControlPointNumber"] = points.size();
  }
  return {{"@schema",
           "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/"
           "Resources/Schema/markups-schema-v1.0.3.json#"},
          {"markups", markups}};
}

}  // namespace beatlas::cli
