#pragma once
/// What a target is: LLVMFuzzerTestOneInput, which clang's libFuzzer and our driver both call, and
/// sound inputs to start from. Only beatlas::Error may come out of the code under test.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace beatlas::fuzz {

/// Of the target that is linked: sound inputs, and words that its inputs are made of.
[[nodiscard]] std::vector<std::string> seeds();
[[nodiscard]] std::vector<std::string> tokens();

/// Words of JSON, and `more` of the target's own.
[[nodiscard]] inline std::vector<std::string> json_tokens(std::vector<std::string> more) {
  for (const char* word :
       {"{", "}", "[", "]", "\"", ":", ",", "null", "1e400", "-0", "1e-320", "[[[[[[[["}) {
    more.emplace_back(word);
  }
  return more;
}

[[nodiscard]] inline std::string_view text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Calls `body`; swallows Error, the one exception a reader may throw.
template <class Body>
void only_errors(Body&& body) {
  try {
    body();
  } catch (const Error& error) {
    if (std::string_view(error.what()).empty()) std::abort();
  }
}

/// A bug that no sanitizer sees.
inline void require(bool sound) {
  if (!sound) std::abort();
}

/// A folder in memory, one a process, removed at its end.
class MemoryFolder {
 public:
  MemoryFolder() {
    const bool memory = std::filesystem::is_directory("/dev/shm");
    std::string name =
        (memory ? std::filesystem::path("/dev/shm") : std::filesystem::temp_directory_path()) /
        "beatlas_fuzz_XXXXXX";
    if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~MemoryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  MemoryFolder(const MemoryFolder&) = delete;
  MemoryFolder& operator=(const MemoryFolder&) = delete;

  std::filesystem::path write(const std::string& name, std::string_view bytes) const {
    std::ofstream(path_ / name, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path_ / name;
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

[[nodiscard]] inline std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Takes numbers off the front of an input; zeros at its end.
class Values {
 public:
  Values(const std::uint8_t* data, std::size_t size) : rest_(text(data, size)) {}
  [[nodiscard]] bool empty() const { return rest_.empty(); }
  template <class T>
  T take() {
    T out{};
    const std::size_t count = std::min(sizeof(T), rest_.size());
    std::copy_n(rest_.begin(), count, reinterpret_cast<char*>(&out));
    rest_.remove_prefix(count);
    return out;
  }

 private:
  std::string_view rest_;
};

}  // namespace beatlas::fuzz
