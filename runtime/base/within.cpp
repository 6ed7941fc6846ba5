#include "runtime/base/within.h"

#include <algorithm>
#include <system_error>

namespace beatlas {
namespace fs = std::filesystem;

bool lies_within(const fs::path& file, const fs::path& folder) {
  std::error_code no_file;
  std::error_code no_folder;
  const fs::path to = fs::canonical(file, no_file);
  const fs::path from = fs::canonical(folder.empty() ? "." : folder, no_folder);
  if (no_file || no_folder) return false;
  return std::mismatch(from.begin(), from.end(), to.begin(), to.end()).first == from.end();
}

}  // namespace beatlas
