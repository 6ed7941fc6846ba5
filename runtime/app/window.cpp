#include "runtime/app/window.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <ostream>
#include <string_view>

#include <unistd.h>

#include "runtime/base/error.h"

namespace beatlas::app {

bool wants_picture(int argc, const char* const* argv) {
  const std::string_view first = argc < 2 ? "" : argv[1];
  if (first == "probe" || first == "replay-ticks" || first == "replay-exercise" ||
      first == "sensitivity" || first == "cases")
    return false;
  // An exercise has a picture if that is said: what is touched there is to be found by touch.
  constexpr std::array<std::string_view, 5> kWithout{"--headless", "--exercise", "--list-devices",
                                                     "--help", "-h"};
  const auto said = [&](const char* asked) {
    return std::any_of(argv + 1, argv + argc,
                       [asked](const char* word) { return std::string_view(word) == asked; });
  };
  if (said("--window") && !said("--headless")) return true;
  return std::none_of(argv + 1, argv + argc, [&](const char* word) {
    return std::find(kWithout.begin(), kWithout.end(), word) != kWithout.end();
  });
}

int become_viewer(char** argv, std::ostream& err) {
  std::error_code failed;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", failed);
  const std::filesystem::path viewer = self.parent_path() / "beatlas-view";
  if (failed || !std::filesystem::exists(viewer, failed)) {
    err << "beatlas-play: this build has no viewer; use --headless to feel the package without a "
           "picture, or `beatlas-play probe`\n";
    return static_cast<int>(ErrorCode::Usage);
  }
  execv(viewer.c_str(), argv);
  err << "beatlas-play: " << viewer.string() << " cannot be run: " << std::strerror(errno) << '\n';
  return static_cast<int>(ErrorCode::Machine);
}

}  // namespace beatlas::app
