#include "pipeline/build/recipe.h"

#include <array>
#include <optional>
#include <string>

#include "pipeline/study/files.h"
#include "pipeline/study/json_values.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::build {
using nlohmann::json;
namespace {

constexpr const char* kStructures = "structures";  // limits of single ones

template <class T>
struct Choice {
  const char* name;
  T value;
};
constexpr std::array kHandles{Choice<field::Handles>{"close", field::Handles::Close},
                              Choice<field::Handles>{"keep", field::Handles::Keep}};
constexpr std::array kFlicker{Choice<field::Flicker>{"remove", field::Flicker::Remove},
                              Choice<field::Flicker>{"keep", field::Flicker::Keep}};
constexpr std::array kLeakActions{Choice<alarm::LeakAction>{"warn", alarm::LeakAction::Warn},
                                  Choice<alarm::LeakAction>{"error", alarm::LeakAction::Error}};
constexpr std::array kMethods{Choice<segment::Method>{"competition", segment::Method::Competition},
                              Choice<segment::Method>{"threshold", segment::Method::Threshold}};
constexpr std::array kPapillary{Choice<segment::Papillary>{"cavity", segment::Papillary::Cavity},
                                Choice<segment::Papillary>{"muscle", segment::Papillary::Muscle}};
constexpr std::array kLabelsDrawnOn{
    Choice<segment::LabelsDrawnOn>{"imaged", segment::LabelsDrawnOn::Imaged},
    Choice<segment::LabelsDrawnOn>{"aligned", segment::LabelsDrawnOn::Aligned}};
constexpr std::array kNeighbours{Choice<segment::Neighbours>{"faces", segment::Neighbours::Faces},
                                 Choice<segment::Neighbours>{"all", segment::Neighbours::All}};

constexpr std::array kSliceAlignments{
    Choice<motion::AlignOptions::Slices>{"auto", motion::AlignOptions::Slices::Auto},
    Choice<motion::AlignOptions::Slices>{"off", motion::AlignOptions::Slices::Off}};

/// Every option of a recipe, once: section, key, member and range.
template <class AnyRecipe, class Visit>
void visit_options(AnyRecipe& recipe, Visit& visit) {
  visit.section("import");
  visit.option("rr_interval_s", recipe.import.rr_interval_s, 0.0, 3.0);
  visit.option("phases", recipe.import.phases, 0, 200);
  visit.option("frame_times_s", recipe.import.frame_times_s, 0.0, 10.0);
  visit.option("exam", recipe.import.exam, 0, 100000);
  visit.option("series", recipe.import.series, 0, 2147483647);
  visit.option("stack", recipe.import.stack, 0, 100000);
  visit.choice("align_slices", recipe.align.slices, kSliceAlignments);
  visit.section("segment");
  visit.flag("even_shading", recipe.segment.even_shading);
  visit.flag("denoise", recipe.segment.denoise);
  visit.flag("follow_motion", recipe.segment.follow_motion);
  visit.flag("atria", recipe.segment.atria);
  visit.choice("method", recipe.segment.method, kMethods);
  visit.choice("papillary", recipe.segment.papillary, kPapillary);
  visit.choice("labels_drawn_on", recipe.segment.labels_drawn_on, kLabelsDrawnOn);
  visit.text("prior", recipe.segment.prior);
  visit.option("edge_cost_mm", recipe.segment.edge_cost_mm, 0.0, 100.0);
  visit.option("outline_sigma_mm", recipe.segment.outline_sigma_mm, 0.5, 5.0);
  visit.option("threshold_low", recipe.segment.threshold_low, 0.0, 1e6);
  visit.option("threshold_high", recipe.segment.threshold_high, 0.0, 1e6);
  visit.choice("threshold_neighbours", recipe.segment.threshold_neighbours, kNeighbours);
  visit.choice("leak", recipe.segment.leak.action, kLeakActions);
  visit.option("leak_volume_percent", recipe.segment.leak.volume_percent, 2.0, 100.0);
  visit.option("leak_contact_mm2", recipe.segment.leak.contact_mm2, 10.0, 10000.0);
  visit.option("leak_still_mm2", recipe.segment.leak.still_mm2, 10.0, 10000.0);
  visit.option("leak_edgeless_mm2", recipe.segment.leak.edgeless_mm2, 10.0, 10000.0);
  visit.section("register");
  visit.choosable("shape_mm", recipe.registration.shape_mm, 0.3, 3.0);
  visit.option("margin_mm", recipe.registration.margin_mm, 4.0, 40.0);
  visit.section("field");
  visit.choosable("voxel_mm", recipe.field.voxel_mm, 0.5, 4.0);
  visit.option("inner_mm", recipe.field.inner_mm, 3.0, 40.0);
  visit.option("outer_mm", recipe.field.outer_mm, 3.0, 40.0);
  visit.choice("flicker", recipe.field.flicker, kFlicker);
  visit.choice("handles", recipe.field.handles, kHandles);
  visit.section("mesh");
  visit.choosable("edge_mm", recipe.mesh.edge_mm, 0.5, 10.0);
  visit.option("reference_phase", recipe.mesh.reference_phase, -1, study::kLastPhase);
  visit.section("pack");
  visit.option("step_mm", recipe.pack.step_mm, 0.0005, 0.1);
  visit.option("nested_step_mm", recipe.pack.nested_step_mm, 0.0005, 0.1);
  visit.option("surface_step_mm", recipe.pack.surface_step_mm, 0.002, 0.5);
  visit.option("volume_step", recipe.pack.volume_step, 0.25, 16.0);
  visit.option("volume_threshold", recipe.pack.volume_threshold, 0.0, 16.0);
  visit.section("quality");
  visit.option("max_volume_gap_percent", recipe.quality.max_volume_gap_percent, 0.1, 100.0);
  visit.section("validate");
  visit.limits(recipe.validate);
  visit.end();
}

/// Moves options that earlier recipes, which studies keep, had elsewhere, and drops those that
/// nothing reads any more.
json as_of_today(json recipe) {
  const auto has = [&](const char* section, const char* key) {
    return recipe.is_object() && recipe.contains(section) && recipe.at(section).is_object() &&
           recipe.at(section).contains(key);
  };
  if (has("segment", "tricuspid_excursion_mm")) {
    recipe.at("segment").erase("tricuspid_excursion_mm");
  }
  const bool takes =
      recipe.is_object() && (!recipe.contains("field") || recipe["field"].is_object());
  if (takes && has("mesh", "handles")) {
    if (!has("field", "handles")) recipe["field"]["handles"] = recipe.at("mesh").at("handles");
    recipe.at("mesh").erase("handles");
  }
  return recipe;
}

class Reader {
 public:
  explicit Reader(const json& recipe) : whole_(recipe, "") {}

  void section(const std::string& name) {
    finish_section();
    static const json empty = json::object();
    section_.emplace(whole_.has(name) ? whole_.at(name) : empty, "/" + name);
  }
  template <class T, class Bound>
  void option(const std::string& key, T& value, Bound low, Bound high) {
    section_->read(key, value, low, high);
  }
  /// One that may be null: the stage chooses.
  void choosable(const std::string& key, std::optional<double>& value, double low, double high) {
    read_nullable(*section_, key, value, low, high);
  }
  void flag(const std::string& key, bool& value) { section_->read(key, value); }
  void text(const std::string& key, std::string& value) { section_->read(key, value); }
  template <class T, std::size_t N>
  void choice(const std::string& key, T& value, const std::array<Choice<T>, N>& choices) {
    if (!section_->has(key)) return;
    std::string word;
    section_->read(key, word);
    std::string names;
    for (const Choice<T>& each : choices) {
      if (word == each.name) {
        value = each.value;
        return;
      }
      names += (names.empty() ? "" : " or ") + std::string(each.name);
    }
    throw_invalid(section_->path() + "/" + key + " must be " + names);
  }
  void limits(assess::LimitSet& limits) {
    read_limits(*section_, limits.all);
    if (!section_->has(kStructures)) return;
    JsonObject structures(section_->at(kStructures), section_->path() + "/" + kStructures);
    for (const Structure structure : kVentricular) {
      const std::string name(structure_name(structure));
      if (!structures.has(name)) continue;
      JsonObject one(structures.at(name), structures.path() + "/" + name);
      read_limits(one, limits.structures[structure]);
      one.finish();
    }
    structures.finish();
  }
  void end() {
    finish_section();
    whole_.finish();
  }

 private:
  static void read_limits(JsonObject& object, assess::Limits& limits) {
    for (const assess::LimitName& limit : assess::kLimitNames) {
      read_nullable(object, limit.name, limits.*limit.member, 0.0, limit.most);
    }
  }
  static void read_nullable(JsonObject& object, const std::string& key,
                            std::optional<double>& value, double low, double high) {
    if (!object.has(key)) return;
    if (object.at(key).is_null()) {
      value.reset();
    } else {
      object.read(key, value.emplace(), low, high);
    }
  }
  void finish_section() {
    if (section_) section_->finish();
  }

  JsonObject whole_;
  std::optional<JsonObject> section_;
};

class Writer {
 public:
  void section(const std::string& name) {
    section_ = name;
    out_[name] = json::object();
  }
  template <class T, class Bound>
  void option(const std::string& key, const T& value, Bound, Bound) {
    out_[section_][key] = value;
  }
  void choosable(const std::string& key, const std::optional<double>& value, double, double) {
    out_[section_][key] = json_of(value);
  }
  void flag(const std::string& key, bool value) { out_[section_][key] = value; }
  void text(const std::string& key, const std::string& value) { out_[section_][key] = value; }
  template <class T, std::size_t N>
  void choice(const std::string& key, const T& value, const std::array<Choice<T>, N>& choices) {
    for (const Choice<T>& each : choices) {
      if (value == each.value) out_[section_][key] = each.name;
    }
  }
  void limits(const assess::LimitSet& limits) {
    json& all = out_[section_] = limits_to_json(limits.all);
    all[kStructures] = json::object();
    for (const auto& [structure, own] : limits.structures) {
      all[kStructures][std::string(structure_name(structure))] = limits_to_json(own);
    }
  }
  void end() {}

  [[nodiscard]] json take() { return std::move(out_); }

 private:
  static json json_of(const std::optional<double>& value) {
    return value ? json(*value) : json(nullptr);
  }
  static json limits_to_json(const assess::Limits& limits) {
    json out = json::object();
    for (const assess::LimitName& limit : assess::kLimitNames) {
      out[limit.name] = json_of(limits.*limit.member);
    }
    return out;
  }

  json out_ = json::object();
  std::string section_;
};

/// Where a recipe has what tells of one exam. @param all every option, as recipe_to_json
std::vector<json::json_pointer> options_of_exam(const json& all) {
  std::vector<json::json_pointer> out{json::json_pointer("/segment/prior")};
  for (const auto& item : all.at("import").items()) {
    out.push_back(json::json_pointer("/import") / item.key());
  }
  return out;
}

template <class Take>
Recipe read_named(const std::filesystem::path& file, Take take) {
  const json content = study::read_json(file);
  try {
    return take(content);
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

}  // namespace

Recipe recipe_from_json(const json& value) {
  Recipe recipe;
  const json read = as_of_today(value);
  Reader reader(read);
  visit_options(recipe, reader);
  return recipe;
}

json recipe_to_json(const Recipe& recipe) {
  Writer writer;
  visit_options(recipe, writer);
  return writer.take();
}

json stage_options(const Recipe& recipe, study::Stage stage) {
  return recipe_to_json(recipe).value(std::string(study::stage_name(stage)), json::object());
}

Recipe read_recipe(const std::filesystem::path& file) { return read_named(file, recipe_from_json); }

Recipe recipe_for_exam(const json& value, const Recipe& before) {
  json read = as_of_today(value);
  (void)recipe_from_json(read);  // Nothing is put beside what is no recipe.
  const json kept = recipe_to_json(before);
  for (const json::json_pointer& option : options_of_exam(kept)) {
    if (!read.contains(option)) read[option] = kept.at(option);
  }
  return recipe_from_json(read);
}

Recipe read_recipe_for_exam(const std::filesystem::path& file, const Recipe& before) {
  return read_named(file, [&](const json& content) { return recipe_for_exam(content, before); });
}

std::vector<std::string> replaced_of_exam(const Recipe& before, const Recipe& now) {
  const json usual = recipe_to_json({});
  const json then = recipe_to_json(before);
  const json here = recipe_to_json(now);
  std::vector<std::string> out;
  for (const json::json_pointer& option : options_of_exam(usual)) {
    const json& value = then.at(option);
    if (value == usual.at(option) || value == here.at(option)) continue;
    // Of a list the length would be all that a reader takes in.
    out.push_back(option.to_string() + (value.is_array() ? "" : " " + value.dump()));
  }
  return out;
}

}  // namespace beatlas::build
