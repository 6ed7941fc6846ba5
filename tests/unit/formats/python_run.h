#pragma once
/// Runs the small Python programs that write or read files independently of our code.

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "tests/json_file.h"

namespace beatlas::test {

/// A folder of its own for one test, removed with it.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "beatlas_test_XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const {
    return path_ / name;
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Runs BEATLAS_TEST_PYTHON `script` `arguments` and returns the JSON it leaves in `result`.
/// @throws std::runtime_error if it fails: python3-pydicom and python3-nibabel are required.
inline nlohmann::json run_python(const std::string& script, const std::string& arguments,
                                 const std::filesystem::path& result) {
  const std::string command = std::string("\"") + BEATLAS_TEST_PYTHON + "\" -W ignore \"" + script +
                              "\" " + arguments + " > \"" + result.string() + "\"";
  if (std::system(command.c_str()) != 0) throw std::runtime_error("failed: " + command);
  return json_file(result);
}

inline std::string quoted(const std::filesystem::path& path) { return '"' + path.string() + '"'; }

}  // namespace beatlas::test
