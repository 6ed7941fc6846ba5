#include "runtime/app/case_files.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <fstream>
#include <span>
#include <system_error>
#include <utility>

#include "runtime/app/text.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"
#include "runtime/base/sha256.h"
#include "runtime/palpation/parameters.h"
#include "runtime/palpation/segments.h"

namespace beatlas::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kCaseVersion = 1;
constexpr std::string_view kCaseEnding = ".case.json";
constexpr std::string_view kPackageEnding = ".beatlas";
constexpr std::size_t kSha256Digits = 64;
constexpr std::size_t kHashedAtOnce = std::size_t{1} << 20;
constexpr std::array<std::string_view, 3> kWhen{"diastole", "systole", "throughout"};
constexpr std::array<std::string_view, 5> kStates{"none", "missing", "there", "same", "other"};

/// Words of one line: a list has a line for each case, and a terminal is told nothing else.
void check_words(const std::string& words, const std::string& path) {
  const auto is_control = [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) == 0x7F;
  };
  if (words.empty() || std::any_of(words.begin(), words.end(), is_control)) {
    throw_invalid(path + " must be words in one line");
  }
}

void read_line(JsonObject& object, const std::string& key, std::string& value) {
  if (!object.has(key)) return;
  object.read(key, value);
  check_words(value, object.path() + "/" + key);
}

void require_line(JsonObject& object, const std::string& key, std::string& value) {
  (void)object.at(key);
  read_line(object, key, value);
}

/// A file beside the case: both go together from machine to machine, which no absolute path does.
void read_file_name(JsonObject& object, const std::string& key, std::string& value) {
  read_line(object, key, value);
  if (fs::path(value).is_absolute()) {
    throw_invalid(object.path() + "/" + key + " must start from the case's own folder");
  }
}

void read_tags(JsonObject& object, std::vector<std::string>& tags) {
  if (!object.has("tags")) return;
  const json& list = object.at("tags");
  if (!list.is_array()) throw_invalid("/tags must be a list of words");
  for (std::size_t n = 0; n < list.size(); ++n) {
    const std::string path = "/tags/" + std::to_string(n);
    if (!list[n].is_string()) throw_invalid(path + " must be a string");
    tags.push_back(list[n].get<std::string>());
    check_words(tags.back(), path);
  }
}

void read_atlas(JsonObject& object, Case& out) {
  read_file_name(object, "atlas", out.atlas);
  if (!out.atlas.empty() && !out.atlas.ends_with(kPackageEnding)) {
    throw_invalid("/atlas must be the name of a .beatlas file");
  }
  object.read("atlas_sha256", out.atlas_sha256);
  if (!object.has("atlas_sha256")) return;
  if (out.atlas_sha256.size() != kSha256Digits ||
      out.atlas_sha256.find_first_not_of("0123456789abcdef") != std::string::npos) {
    throw_invalid("/atlas_sha256 must be 64 lower-case hexadecimal digits");
  }
  if (out.atlas.empty()) throw_invalid("/atlas_sha256 is of an atlas; name it by /atlas");
}

void read_muscle_of_case(JsonObject& object, Case& out) {
  read_line(object, "preset", out.preset);
  read_file_name(object, "parameters", out.parameters);
  if (!out.preset.empty() && !out.parameters.empty()) {
    throw_invalid("/preset and /parameters both name the muscle; give one of them");
  }
  const std::vector<std::string> presets = palpation::palpation_presets();
  if (!out.preset.empty() &&
      std::find(presets.begin(), presets.end(), out.preset) == presets.end()) {
    throw_invalid("/preset must be healthy, anterior_infarct or another of beatlas-play --preset");
  }
  object.read("heart_rate_per_min", out.heart_rate_per_min, 30, 220);
}

void read_number(JsonObject& object, const std::string& key, std::optional<double>& value,
                 double high) {
  if (!object.has(key)) return;
  object.read(key, value.emplace(0), 0, high);
}

Felt read_felt(const json& entry, const std::string& path) {
  JsonObject object(entry, path);
  Felt out;
  if (object.has("segment")) {
    std::string name;
    object.read("segment", name);
    out.segment = palpation::segment_from_name(name);
    if (!out.segment) {
      throw_invalid(path + "/segment is none of " + palpation::segment_names());
    }
  }
  std::string when;
  require_line(object, "when", when);
  const auto* const known = std::find(kWhen.begin(), kWhen.end(), when);
  if (known == kWhen.end()) {
    throw_invalid(path + "/when must be diastole, systole or throughout");
  }
  out.when = static_cast<FeltWhen>(known - kWhen.begin());
  require_line(object, "words", out.words);
  read_number(object, "force_n", out.force_n, 50);
  read_number(object, "depth_mm", out.depth_mm, 15);
  object.finish();
  return out;
}

void read_document(const json& document, Case& out) {
  JsonObject object(document, "");
  (void)object.at("version");
  int version = kCaseVersion;
  object.read("version", version, kCaseVersion, kCaseVersion);
  require_line(object, "title", out.title);
  read_line(object, "diagnosis", out.diagnosis);
  read_tags(object, out.tags);
  read_atlas(object, out);
  read_muscle_of_case(object, out);
  const json& felt = object.at("felt");
  object.finish();
  if (!felt.is_array()) throw_invalid("/felt must be a list of what was felt");
  for (std::size_t n = 0; n < felt.size(); ++n) {
    out.felt.push_back(read_felt(felt[n], "/felt/" + std::to_string(n)));
  }
}

std::string lower(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

std::string told_atlas(const Case& found, AtlasState state) {
  switch (state) {
    case AtlasState::None:
      return "no atlas";
    case AtlasState::Missing:
      return found.atlas + " is not there";
    case AtlasState::There:
      return found.atlas;
    case AtlasState::Same:
      return found.atlas + ", its SHA-256 as stated";
    case AtlasState::Other:
      break;
  }
  return found.atlas + ", of another SHA-256 than stated";
}

std::string felt_line(const Felt& felt) {
  std::string out = felt.segment ? std::string(palpation::segment_name(*felt.segment)) + ", " : "";
  out += std::string(felt_when_name(felt.when)) + ": " + felt.words;
  std::string numbers;
  if (felt.force_n) {
    append_number(numbers, *felt.force_n);
    numbers += " N";
  }
  if (felt.depth_mm) {
    numbers += numbers.empty() ? "" : " at ";
    append_number(numbers, *felt.depth_mm);
    numbers += " mm";
  }
  return numbers.empty() ? out : out + " (" + numbers + ")";
}

}  // namespace

std::string_view felt_when_name(FeltWhen when) noexcept {
  return kWhen[static_cast<std::size_t>(when)];
}

std::string_view atlas_state_name(AtlasState state) noexcept {
  return kStates[static_cast<std::size_t>(state)];
}

fs::path Case::atlas_path() const {
  return atlas.empty() ? fs::path() : file.parent_path() / atlas;
}

fs::path Case::parameters_path() const {
  return parameters.empty() ? fs::path() : file.parent_path() / parameters;
}

AtlasState atlas_state(const Case& found) {
  if (found.atlas.empty()) return AtlasState::None;
  std::error_code failed;
  std::ifstream stream(found.atlas_path(), std::ios::binary);
  if (!stream || !fs::is_regular_file(found.atlas_path(), failed)) return AtlasState::Missing;
  if (found.atlas_sha256.empty()) return AtlasState::There;
  Sha256 hash;
  std::vector<char> piece(kHashedAtOnce);
  while (stream) {
    stream.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    hash.add(std::as_bytes(std::span(piece).first(static_cast<std::size_t>(stream.gcount()))));
  }
  if (stream.bad()) return AtlasState::Missing;
  return hash.hex() == found.atlas_sha256 ? AtlasState::Same : AtlasState::Other;
}

Case read_case(const fs::path& file) {
  const json document = read_json_file(file.string());
  Case out;
  out.file = file;
  try {
    read_document(document, out);
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
  return out;
}

json case_to_json(const Case& written) {
  json out = {{"version", kCaseVersion}, {"title", written.title}, {"felt", json::array()}};
  const std::array<std::pair<const char*, const std::string*>, 5> words{
      {{"diagnosis", &written.diagnosis},
       {"atlas", &written.atlas},
       {"atlas_sha256", &written.atlas_sha256},
       {"preset", &written.preset},
       {"parameters", &written.parameters}}};
  for (const auto& [key, value] : words) {
    if (!value->empty()) out[key] = *value;
  }
  if (!written.tags.empty()) out["tags"] = written.tags;
  if (written.heart_rate_per_min > 0) out["heart_rate_per_min"] = written.heart_rate_per_min;
  for (const Felt& felt : written.felt) {
    json entry = {{"when", felt_when_name(felt.when)}, {"words", felt.words}};
    if (felt.segment) entry["segment"] = palpation::segment_name(*felt.segment);
    if (felt.force_n) entry["force_n"] = *felt.force_n;
    if (felt.depth_mm) entry["depth_mm"] = *felt.depth_mm;
    out["felt"].push_back(std::move(entry));
  }
  return out;
}

Cases read_cases(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code failed;
  for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    if (at->path().filename().string().ends_with(kCaseEnding)) files.push_back(at->path());
  }
  if (failed) throw_invalid(folder.string() + " is no folder that can be read; name one of cases");
  std::sort(files.begin(), files.end());
  Cases out;
  for (const fs::path& file : files) {
    try {
      out.read.push_back(read_case(file));
    } catch (const Error& error) {
      out.troubles.emplace_back(error.what());
    }
  }
  return out;
}

bool matches(const Case& found, const std::vector<std::string>& words) {
  std::string text = found.title + '\n' + found.diagnosis + '\n' + found.preset;
  for (const std::string& tag : found.tags) text += '\n' + tag;
  for (const Felt& felt : found.felt) {
    text += '\n' + felt.words;
    if (felt.segment) text += '\n' + std::string(palpation::segment_name(*felt.segment));
  }
  text = lower(std::move(text));
  return std::all_of(words.begin(), words.end(), [&text](const std::string& word) {
    return text.find(lower(word)) != std::string::npos;
  });
}

std::string case_line(const Case& found, AtlasState state) {
  return found.file.filename().string() + ": " + found.title + "; " + told_atlas(found, state) +
         "; " + std::to_string(found.felt.size()) + " felt";
}

std::string case_text(const Case& found) {
  std::string out;
  if (!found.diagnosis.empty()) out += "  diagnosis: " + found.diagnosis + "\n";
  for (std::size_t n = 0; n < found.tags.size(); ++n) {
    out += (n == 0 ? "  tags: " : ", ") + found.tags[n];
  }
  if (!found.tags.empty()) out += "\n";
  const std::string& muscle = found.preset.empty() ? found.parameters : found.preset;
  out += "  muscle: " + (muscle.empty() ? "healthy" : muscle);
  if (found.heart_rate_per_min > 0) {
    out += ", ";
    append_number(out, found.heart_rate_per_min);
    out += " beats a minute";
  }
  out += "\n";
  for (const Felt& felt : found.felt) out += "  " + felt_line(felt) + "\n";
  return out;
}

}  // namespace beatlas::app
