#include "pipeline/cli/no_package.h"

#include <string>

#include "pipeline/formats/image_file.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;

void refuse_what_is_no_package(const fs::path& file) {
  std::error_code ignored;
  const std::string name = file.string();
  if (fs::is_regular_file(file / "study.json", ignored)) {
    throw_invalid(name + " is a study, not a package; 'beatlas status " + name +
                  "' tells what is done, 'beatlas report " + name + "' writes its report");
  }
  if (fs::is_directory(file, ignored)) {
    throw_invalid(name + " is a folder, not a package; if it holds images, 'beatlas import " +
                  name + " --study DIR' tells what they are");
  }
  if (fs::exists(file, ignored) && formats::format_of(file)) {
    throw_invalid(name + " is an image, not a package; 'beatlas import " + name +
                  " --study DIR' tells what it is");
  }
}

}  // namespace beatlas::cli
