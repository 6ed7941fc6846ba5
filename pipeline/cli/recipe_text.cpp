#include "pipeline/cli/recipe_text.h"

#include <algorithm>

namespace beatlas::cli {
using nlohmann::json;
namespace {

constexpr std::size_t kColumns = 98;

/// What `content` refers to with $ref, if it does.
const json& referred(const json& schema, const json& content) {
  const auto ref = content.find("$ref");
  return ref == content.end() ? content
                              : schema.at(json::json_pointer(ref->get<std::string>().substr(1)));
}

/// Of an option, wherever in the section's content it stands.
const json* option_of(const json& schema, const json& section, const std::string& key) {
  for (const json* content : {&section, &referred(schema, section)}) {
    const auto all = content->find("properties");
    if (all != content->end() && all->contains(key)) return &all->at(key);
  }
  return nullptr;
}

std::string range_of(const json& rule) {
  if (rule.contains("enum")) {
    std::string out;
    for (const json& word : rule.at("enum")) {
      out += (out.empty() ? "" : " or ") + word.get<std::string>();
    }
    return out;
  }
  if (rule.contains("items")) return "a list of " + range_of(rule.at("items"));
  if (rule.contains("minimum")) {
    const std::string none = rule.at("type").is_array() ? ", or null" : "";
    return rule.at("minimum").dump() + " to " + rule.at("maximum").dump() + none;
  }
  return rule.at("type") == "boolean" ? "true or false" : "";
}

/// `text` in comment lines behind `indent`.
std::string comment(const std::string& text, const std::string& indent) {
  std::string out;
  std::string line = indent + "//";
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view word = rest.substr(0, rest.find(' '));
    rest.remove_prefix(std::min(rest.size(), word.size() + 1));
    if (line.size() + 1 + word.size() > kColumns) {
      out += line + "\n";
      line = indent + "//";
    }
    line.append(" ").append(word);
  }
  return out + line + "\n";
}

}  // namespace

std::string commented_recipe(const build::Recipe& recipe) {
  const json schema = json::parse(recipe_schema());
  const json values = build::recipe_to_json(recipe);
  const json defaults = build::recipe_to_json(build::Recipe{});
  std::string out = "// " + schema.at("description").get<std::string>() + "\n{\n";
  for (auto section = values.begin(); section != values.end(); ++section) {
    const json& content = schema.at("properties").at(section.key());
    out += comment(content.at("description"), "  ") + "  " + json(section.key()).dump() + ": {\n";
    for (auto option = section->begin(); option != section->end(); ++option) {
      if (const json* rule = option_of(schema, content, option.key())) {
        std::string text = rule->value("description", "");
        const std::string range = range_of(*rule);
        if (!range.empty()) text += "; range: " + range;
        const json& usual = defaults.at(section.key()).at(option.key());
        if (*option != usual) text += "; default " + usual.dump();
        out += comment(text, "    ");
      }
      out += "    " + json(option.key()).dump() + ": " + option->dump() +
             (std::next(option) == section->end() ? "\n" : ",\n");
    }
    out += std::next(section) == values.end() ? "  }\n" : "  },\n";
  }
  return out + "}\n";
}

}  // namespace beatlas::cli
