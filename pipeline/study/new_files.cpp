#include "pipeline/study/new_files.h"

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
  std::string name = (folder_ / ".beatlas-XXXXXX").string();
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
  for (const auto& entry : fs::directory_iterator(place_)) names.push_back(entry.path().filename());
  for (const fs::path& name : names) {
    const fs::path there = folder_ / name;
    std::error_code ignored;
    if (!fs::exists(fs::symlink_status(there, ignored))) continue;
    if (!fs::is_regular_file(there, ignored) || !holds(there, sha256_of_file(place_ / name))) {
      throw Error(ErrorCode::Usage, there.string() +
                                        " is there and would be lost; name another folder, or "
                                        "move it away");
    }
  }
  for (const fs::path& name : names) {
    std::error_code failure;
    fs::rename(place_ / name, folder_ / name, failure);
    if (failure) {
      throw Error(ErrorCode::Machine,
                  (folder_ / name).string() + " cannot be written: " + failure.message());
    }
  }
}

}  // namespace beatlas::study
