#pragma once
/// A folder of cases: hearts with what a finger felt on them, one NAME.case.json each
/// (schemas/case.schema.json). They are read and searched here; case_command.h speaks of them.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace beatlas::app {

/// The part of the beat in which something was felt.
enum class FeltWhen { Diastole, Systole, Throughout };
/// diastole, systole, throughout
[[nodiscard]] std::string_view felt_when_name(FeltWhen when) noexcept;

/// One thing that was felt.
struct Felt {
  std::optional<int> segment;  ///< 1..17 of the AHA; none: of the whole ventricle
  FeltWhen when = FeltWhen::Throughout;
  std::string words;
  std::optional<double> force_n;   ///< 0..50: of the finger
  std::optional<double> depth_mm;  ///< 0..15: how deep it pressed
};

/// A case as its file has it; nothing in it names a patient. Words are one line each and not empty.
struct Case {
  std::filesystem::path file;
  std::string title;
  std::string diagnosis;  ///< or empty
  std::vector<std::string> tags;
  std::string atlas;         ///< from the file's folder on; empty: none
  std::string atlas_sha256;  ///< 64 lower-case hexadecimal digits; empty: not said
  std::string preset;        ///< palpation_preset; at most one of it and `parameters`
  std::string parameters;    ///< JSON after schemas/palpation.schema.json, as `atlas`; or empty
  double heart_rate_per_min = 0;  ///< 30..220; 0: the atlas's or the parameters'
  std::vector<Felt> felt;

  /// Where its atlas and its parameters are; empty where it names none.
  [[nodiscard]] std::filesystem::path atlas_path() const;
  [[nodiscard]] std::filesystem::path parameters_path() const;
};

/// What became of the atlas that a case names.
enum class AtlasState {
  None,     ///< it names none
  Missing,  ///< no file is there that can be read
  There,    ///< and the case does not say which bytes it has
  Same,     ///< of the SHA-256 that the case says
  Other     ///< of another one
};
/// none, missing, there, same, other
[[nodiscard]] std::string_view atlas_state_name(AtlasState state) noexcept;
/// Reads the whole atlas where the case says its SHA-256.
[[nodiscard]] AtlasState atlas_state(const Case& found);

/// @throws Error{InvalidInput} naming the file, and the JSON path of what is missing, unknown, of
/// another type or out of range. Neither the atlas nor the parameters are opened.
[[nodiscard]] Case read_case(const std::filesystem::path& file);
/// As the file has it, without what is left out.
[[nodiscard]] nlohmann::json case_to_json(const Case& written);

struct Cases {
  std::vector<Case> read;             ///< by the names of their files
  std::vector<std::string> troubles;  ///< a sentence for each file that could not be read
};
/// Every NAME.case.json of a folder, and none of the folders in it.
/// @throws Error{InvalidInput} if there is no such folder or it cannot be read
[[nodiscard]] Cases read_cases(const std::filesystem::path& folder);

/// Whether every word is part of the title, the diagnosis, a tag, words that were felt, the name
/// of their segment, or the preset; large and small letters of ASCII are the same. Without a word
/// every case matches.
[[nodiscard]] bool matches(const Case& found, const std::vector<std::string>& words);

/// The line of a list: file, title, atlas, how much was felt; without a newline.
[[nodiscard]] std::string case_line(const Case& found, AtlasState state);
/// Diagnosis, tags, muscle and all that was felt, a line each; ends with a newline.
[[nodiscard]] std::string case_text(const Case& found);

}  // namespace beatlas::app
