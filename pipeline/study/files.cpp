#include "pipeline/study/files.h"

#include <algorithm>
#include <fstream>
#include <set>
#include <system_error>

#include "runtime/base/sha256.h"

namespace beatlas::study {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail_machine(const std::string& message) {
  throw Error(ErrorCode::Machine, message);
}

}  // namespace

void write_bytes(const fs::path& file, std::span<const std::byte> bytes) {
  replace_file(file, bytes);
}

void write_text(const fs::path& file, std::string_view text) { replace_file(file, text); }

void write_json(const fs::path& file, const nlohmann::json& json) {
  write_text(file, json.dump(2) + "\n");
}

std::vector<std::byte> read_bytes(const fs::path& file) {
  std::error_code failure;
  if (!fs::is_regular_file(file, failure)) throw_invalid(file.string() + " is not a file");
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) throw_invalid(file.string() + " cannot be opened for reading");
  std::vector<std::byte> bytes(static_cast<std::size_t>(in.tellg()));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in) throw_invalid(file.string() + " cannot be read to its end");
  return bytes;
}

nlohmann::json read_json(const fs::path& file) {
  const std::vector<std::byte> bytes = read_bytes(file);
  const auto* first = reinterpret_cast<const char*>(bytes.data());
  std::vector<std::set<std::string>> keys;
  std::string repeated;
  const nlohmann::json::parser_callback_t note_keys = [&](int, nlohmann::json::parse_event_t event,
                                                          nlohmann::json& parsed) {
    using Event = nlohmann::json::parse_event_t;
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::object_end) keys.pop_back();
    if (event == Event::key && !keys.back().insert(parsed.get<std::string>()).second) {
      repeated = parsed.get<std::string>();
    }
    return true;
  };
  try {
    nlohmann::json json = nlohmann::json::parse(first, first + bytes.size(), note_keys, true, true);
    if (!repeated.empty()) {
      throw_invalid(file.string() + ": the key '" + repeated + "' stands twice in one object");
    }
    return json;
  } catch (const nlohmann::json::parse_error& error) {
    const std::size_t at = std::min(bytes.size(), error.byte > 0 ? error.byte - 1 : 0);
    const auto line = 1 + std::count(first, first + at, '\n');
    const char* last = first + at;
    while (last != first && last[-1] != '\n') --last;
    throw_invalid(file.string() + " is not valid JSON (at line " + std::to_string(line) +
                  ", column " + std::to_string(first + at - last + 1) + ")");
  } catch (const nlohmann::json::exception&) {
    throw_invalid(file.string() + " is not valid JSON: a number is out of range");
  }
}

Error said_of(const fs::path& index, const Error& error) {
  const std::string folder = index.parent_path().string() + "/";
  return std::string_view(error.what()).starts_with(folder) ? error
                                                            : error.with_context(index.string());
}

std::string sha256_of_file(const fs::path& file) {
  std::error_code failure;
  if (!fs::is_regular_file(file, failure)) throw_invalid(file.string() + " is not a file");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw_invalid(file.string() + " cannot be opened for reading");
  Sha256 hash;
  std::vector<std::byte> piece(std::size_t{1} << 18);
  while (in) {
    in.read(reinterpret_cast<char*>(piece.data()), static_cast<std::streamsize>(piece.size()));
    hash.add(std::span(piece).first(static_cast<std::size_t>(in.gcount())));
  }
  if (in.bad()) throw_invalid(file.string() + " cannot be read to its end");
  return hash.hex();
}

bool holds(const fs::path& file, const std::string& sha256) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && sha256_of_file(file) == sha256;
}

void make_folder(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  std::error_code ignored;
  if (failure || !fs::is_directory(folder, ignored)) {
    fail_machine("the folder " + folder.string() +
                 " cannot be made: " + (failure ? failure.message() : "a file has that name"));
  }
}

void check_writable(const fs::path& file) {
  std::error_code ignored;
  if (file.filename().empty() || fs::is_directory(file, ignored)) {
    fail_machine(file.string() + " cannot be written: it is a folder; name a file");
  }
  if (fs::exists(file, ignored) && !fs::is_regular_file(file, ignored)) {
    fail_machine(file.string() + " cannot be written: it is a device or pipe; name a file");
  }
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, ignored)) {
    fail_machine(file.string() + " cannot be written: the folder " + folder.string() +
                 " does not exist");
  }
  if (!can_replace(file)) {
    fail_machine(file.string() + " cannot be written: no permission in " + folder.string() +
                 ", or the disk is full");
  }
}

}  // namespace beatlas::study
