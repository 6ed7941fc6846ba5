#include "pipeline/cli/named_files.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "pipeline/core/words.h"
#include "pipeline/formats/image_file.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

/// The first bytes of a file.
std::string head_of(const fs::path& file) {
  std::array<char, 256> head{};
  std::ifstream in(file, std::ios::binary);
  in.read(head.data(), head.size());
  return {head.data(), static_cast<std::size_t>(in.gcount())};
}

/// A zip whose first entry is the manifest.
bool is_package(const fs::path& file) {
  constexpr std::size_t kName = 30;  // where a zip's local header has the name of its entry
  const std::string head = head_of(file);
  return head.starts_with("PK\x03\x04") && head.size() > kName &&
         std::string_view(head).substr(kName).starts_with("atlas.json");
}

bool is_page(const fs::path& file) {
  constexpr std::string_view kGenerator = R"(<meta name="generator" content="beatlas">)";
  return head_of(file).find(kGenerator) != std::string::npos;
}

bool is_timing(const fs::path& file) {
  try {
    const nlohmann::json content = study::read_json(file);
    return content.contains("stages") && content.contains("peak_memory_mb");
  } catch (const Error&) {
    return false;
  }
}

struct Kind {
  const char* name;
  bool (*is)(const fs::path&);
};

const Kind& described(OutputKind kind) {
  static constexpr std::array kKinds{Kind{"package", is_package}, Kind{"report", is_page},
                                     Kind{"file of times", is_timing}};
  return kKinds.at(static_cast<std::size_t>(kind));
}

}  // namespace

void refuse_what_is_no_package(const fs::path& file) {
  std::error_code ignored;
  const std::string name = file.string();
  if (fs::is_regular_file(file / "study.json", ignored)) {
    throw_invalid(name + " is a study, not a package; 'beatlas status " + shell_word(name) +
                  "' tells what is done, 'beatlas report " + shell_word(name) +
                  "' writes its report");
  }
  if (fs::is_directory(file, ignored)) {
    throw_invalid(name + " is a folder, not a package; if it holds images, 'beatlas import " +
                  shell_word(name) + " --study DIR' tells what they are");
  }
  if (fs::exists(file, ignored) && formats::format_of(file)) {
    throw_invalid(name + " is an image, not a package; 'beatlas import " + shell_word(name) +
                  " --study DIR' tells what it is");
  }
}

void refuse_to_replace(const std::string& output, OutputKind kind, const std::string& study) {
  std::error_code none_there;
  if (output.empty() || !fs::is_regular_file(output, none_there)) return;
  const Kind& wanted = described(kind);
  // An empty file, as mktemp makes it, holds nothing to lose.
  if (fs::file_size(output, none_there) > 0 && !wanted.is(output)) {
    throw Error(ErrorCode::Usage, output + " is there, is no " + wanted.name +
                                      " and would be lost; name another file to write");
  }
  if (study.empty()) return;
  const fs::path within =
      fs::canonical(output, none_there).lexically_relative(fs::weakly_canonical(study, none_there));
  const bool is_inside = !within.empty() && *within.begin() != "..";
  if (is_inside && (within.has_parent_path() || within == "study.json")) {
    throw Error(ErrorCode::Usage, output + " is a file of the study " + study +
                                      " and would be lost; name another file to write");
  }
}

}  // namespace beatlas::cli
