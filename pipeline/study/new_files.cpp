#include "pipeline/study/new_files.h"

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::study {
namespace fs = std::filesystem;

NewFiles::NewFiles(fs::path folder) : folder_(std::move(folder)) {
  std::error_code ignored;
  made_ = !fs::exists(folder_, ignored);
  make_folder(folder_);
  // As replace_file names what is not whole yet; see is_partial.
  std::string name = (folder_ / ".partial-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    const std::error_code failure(errno, std::generic_category());
    if (made_) fs::remove(folder_, ignored);
    throw Error(ErrorCode::Machine,
                "the folder " + folder_.string() + " cannot be written: " + failure.message());
  }
  place_ = name;
}

NewFiles::~NewFiles() {
  std::error_code ignored;
  fs::remove_all(place_, ignored);
  // It is removed only if it is empty.
  if (made_) fs::remove(folder_, ignored);
}

void NewFiles::put() {
  std::vector<fs::path> names;
  std::error_code failure;
  for (auto it = fs::directory_iterator(place_, failure);
       !failure && it != fs::directory_iterator(); it.increment(failure)) {
    const fs::path name = it->path().filename();
    const fs::path there = folder_ / name;
    std::error_code ignored;
    const fs::file_status status = fs::symlink_status(there, ignored);
    if (!fs::exists(status)) {
      names.push_back(name);
    } else if (!fs::is_regular_file(status) || !holds(there, sha256_of_file(it->path()))) {
      throw Error(ErrorCode::Usage, there.string() +
                                        " is there and would be lost; name another folder, or "
                                        "move it away");
    }
  }
  for (std::size_t n = 0; !failure && n < names.size(); ++n) {
    fs::rename(place_ / names[n], folder_ / names[n], failure);
    if (!failure) continue;
    std::error_code ignored;
    while (n > 0) fs::remove(folder_ / names[--n], ignored);
    break;
  }
  if (failure) {
    throw Error(ErrorCode::Machine,
                "the folder " + folder_.string() + " cannot be written: " + failure.message());
  }
}

}  // namespace beatlas::study
