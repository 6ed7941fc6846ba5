#include "pipeline/study/lock.h"

#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "runtime/base/error.h"

namespace beatlas::study {

Lock::Lock(const std::filesystem::path& folder, const std::function<void()>& waiting,
           const std::atomic<bool>* cancel)
    : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0) {
    throw Error(ErrorCode::Machine, "the folder " + folder.string() + " cannot be opened: " +
                                        std::generic_category().message(errno));
  }
  bool told = false;
  while (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && (errno == EWOULDBLOCK || errno == EINTR)) {
    if (!told && waiting) waiting();
    told = true;
    if (cancel && cancel->load(std::memory_order_relaxed)) {
      ::close(descriptor_);
      throw Error(ErrorCode::Machine, "interrupted while waiting for " + folder.string());
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

Lock::~Lock() { ::close(descriptor_); }

bool Lock::held(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool busy = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(descriptor);
  return busy;
}

}  // namespace beatlas::study
