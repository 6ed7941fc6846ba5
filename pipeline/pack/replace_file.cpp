#include "pipeline/pack/replace_file.h"

#include <cerrno>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "runtime/base/error.h"

namespace beatlas::pack {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
  throw Error(ErrorCode::Machine,
              file.string() + " cannot be written: " + std::generic_category().message(error) +
                  "; check the disk and its permissions");
}

/// A file that is removed again unless it was renamed.
class Partial {
 public:
  explicit Partial(const std::filesystem::path& target) : target_(target) {
    for (int attempt = 0; attempt < 1000; ++attempt) {
      std::string name = ".beatlas-";
      name += std::to_string(::getpid()) + "-" + std::to_string(attempt) + ".partial";
      path_ = target.parent_path() / name;
      descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ >= 0 || errno != EEXIST) break;
    }
    if (descriptor_ < 0) fail(target_, errno);
  }
  ~Partial() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!renamed_) ::unlink(path_.c_str());
  }
  Partial(const Partial&) = delete;
  Partial& operator=(const Partial&) = delete;

  void write(atlas::ByteView bytes) {
    while (!bytes.empty()) {
      const ssize_t done = ::write(descriptor_, bytes.data(), bytes.size());
      if (done < 0 && errno == EINTR) continue;
      if (done < 0) fail(target_, errno);
      bytes = bytes.subspan(static_cast<std::size_t>(done));
    }
    if (::fsync(descriptor_) != 0) fail(target_, errno);
    const int descriptor = descriptor_;
    descriptor_ = -1;
    if (::close(descriptor) != 0) fail(target_, errno);
  }

  void rename_to_target() {
    if (::rename(path_.c_str(), target_.c_str()) != 0) fail(target_, errno);
    renamed_ = true;
  }

 private:
  std::filesystem::path target_;
  std::filesystem::path path_;
  int descriptor_ = -1;
  bool renamed_ = false;
};

}  // namespace

void replace_file(const std::filesystem::path& file, atlas::ByteView bytes) {
  Partial partial(file);
  partial.write(bytes);
  partial.rename_to_target();
  // The rename itself reaches the disk with the folder; some file systems cannot be asked to.
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor >= 0) {
    (void)::fsync(descriptor);
    ::close(descriptor);
  }
}

}  // namespace beatlas::pack
