#include <filesystem>
#include <system_error>

#include "pipeline/prior/model.h"
#include "runtime/base/error.h"

namespace beatlas::prior {
namespace fs = std::filesystem;
namespace {

constexpr auto kName = "heart_prior.onnx";

}  // namespace

fs::path default_model_path() {
  std::error_code failed;
  const fs::path program = fs::read_symlink("/proc/self/exe", failed);
  const fs::path installed =
      (program.parent_path() / BEATLAS_DATA_FROM_PROGRAMS / kName).lexically_normal();
  for (const fs::path& path : {installed, fs::path(BEATLAS_PRIOR_SOURCES) / kName}) {
    if (fs::exists(path, failed)) return path;
  }
  throw_invalid("the built-in model is missing, looked for as " + installed.string() +
                "; install beatlas again, name a model with --prior MODEL.onnx, or go without "
                "with --prior none");
}

}  // namespace beatlas::prior
