#include "runtime/base/replace_file.h"

#include <cerrno>
#include <cstdint>
#include <fstream>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "runtime/base/error.h"

namespace beatlas {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPartialPrefix = ".partial-";
constexpr std::size_t kLongestEnd = 32;  // of a name, kept: names may not become too long
constexpr int kMostAttempts = 1000;

[[noreturn]] void fail(const fs::path& file, int error) {
  throw Error(ErrorCode::Machine,
              file.string() + " cannot be written: " + std::generic_category().message(error) +
                  "; check the disk and its permissions");
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// While what could not be written whole still lies there.
bool disk_is_full(const fs::path& file) {
  constexpr std::uintmax_t kRoom = 1U << 16;
  std::error_code failure;
  const fs::space_info room = fs::space(folder_of(file), failure);
  return !failure && room.available < kRoom;
}

/// A new file that is removed again unless it was renamed.
class Partial {
 public:
  explicit Partial(const fs::path& target) : target_(target) {
    std::string end = target.filename().string();
    if (end.size() > kLongestEnd) end.erase(0, end.size() - kLongestEnd);
    for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
      std::string name(kPartialPrefix);
      name += std::to_string(::getpid()) + '-' + std::to_string(attempt) + '-' + end;
      path_ = target.parent_path() / name;
      descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ >= 0 || errno != EEXIST) break;
    }
    error_ = descriptor_ < 0 ? errno : 0;
  }
  ~Partial() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (error_ == 0 && !renamed_) ::unlink(path_.c_str());
  }
  Partial(const Partial&) = delete;
  Partial& operator=(const Partial&) = delete;

  /// Of making it; 0 if it is there.
  [[nodiscard]] int error() const { return error_; }
  [[nodiscard]] const fs::path& path() const { return path_; }

  void write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t done = ::write(descriptor_, bytes.data(), bytes.size());
      if (done < 0 && errno == EINTR) continue;
      if (done < 0) fail(target_, errno);
      bytes = bytes.subspan(static_cast<std::size_t>(done));
    }
  }

  /// Has the content reach the disk, then gives it the target's name.
  void rename_to_target() {
    // By its name: whoever filled it may have put another file in its place.
    const int filled = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (filled < 0) fail(target_, errno);
    const int failed = ::fsync(filled) != 0 ? errno : 0;
    ::close(filled);
    if (failed != 0) fail(target_, failed);
    const int descriptor = descriptor_;
    descriptor_ = -1;
    if (::close(descriptor) != 0) fail(target_, errno);
    if (::rename(path_.c_str(), target_.c_str()) != 0) fail(target_, errno);
    renamed_ = true;
    // The rename itself reaches the disk with the folder; some file systems cannot be asked to.
    const int folder = ::open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) return;
    (void)::fsync(folder);
    ::close(folder);
  }

 private:
  fs::path target_;
  fs::path path_;
  int descriptor_ = -1;
  int error_ = 0;
  bool renamed_ = false;
};

bool begins_alike(const fs::path& file, std::string_view text) {
  const bool is_markup = text.starts_with('<');
  const std::string_view beginning = text.substr(0, text.find_first_of(is_markup ? " >\n" : "\n"));
  std::string there(beginning.size() + 1, '\n');
  std::ifstream stream(file, std::ios::binary);
  stream.read(there.data(), static_cast<std::streamsize>(there.size()));
  const bool ends = there.back() == '\n' || there.back() == '\r';
  return there.starts_with(beginning) && (is_markup || ends);
}

bool has_keys_of(const fs::path& file, std::string_view text) {
  using nlohmann::json;
  std::ifstream stream(file, std::ios::binary);
  const json there = json::parse(stream, nullptr, false);
  const json wanted = json::parse(text, nullptr, false);
  if (!there.is_object() || !wanted.is_object()) return false;
  for (const auto& item : wanted.items()) {
    if (!there.contains(item.key())) return false;
  }
  return true;
}

}  // namespace

void replace_file(const fs::path& file, const std::function<void(const fs::path&)>& write) {
  Partial partial(file);
  if (partial.error() != 0) fail(file, partial.error());
  try {
    write(partial.path());
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Machine) throw;
    throw Error(ErrorCode::Machine,
                file.string() + " cannot be written: " +
                    (disk_is_full(file) ? "the disk is full; make room and try again"
                                        : "check the permissions and limits of its folder and "
                                          "disk"));
  }
  partial.rename_to_target();
}

void replace_file(const fs::path& file, std::span<const std::byte> bytes,
                  const std::function<void(const fs::path&)>& look) {
  Partial partial(file);
  if (partial.error() != 0) fail(file, partial.error());
  partial.write(bytes);
  if (look) look(partial.path());
  partial.rename_to_target();
}

void replace_file(const fs::path& file, std::string_view text) {
  replace_file(file, std::as_bytes(std::span(text.data(), text.size())));
}

void refuse_other_kind(const fs::path& file, std::string_view text) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored) || fs::file_size(file, ignored) == 0) return;
  if (text.starts_with('{') ? has_keys_of(file, text) : begins_alike(file, text)) return;
  throw Error(ErrorCode::Usage, file.string() +
                                    " is there, is none of what is to be written and would be "
                                    "lost; name another file to write");
}

bool is_partial(const fs::path& file) {
  return file.filename().string().starts_with(kPartialPrefix);
}

bool can_replace(const fs::path& file) { return Partial(file).error() == 0; }

}  // namespace beatlas
