// The CSV that an exercise keeps of a trial's part.
#include <sstream>

#include "runtime/app/trace.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  std::vector<app::TraceRow> rows;
  for (int n = 0; n < 3; ++n) {
    rows.push_back({.time_s = 0.001 * n,
                    .position_mm = Vec3(1.5, -2 * n, 1e-300),
                    .depth_mm = -0.0,
                    .force_n = Vec3(1e300, n / 3.0, 0),
                    .buttons = n == 1 ? 0xffffffffU : 0U,
                    .valid = n != 1,
                    .stalled = n == 2});
  }
  std::string windows = app::trace_csv(rows);
  for (std::size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 2) {
    windows.insert(at, "\r");
  }
  return {app::trace_csv(rows), app::trace_csv({}), windows};
}
std::vector<std::string> tokens() {
  return {",", "\n", "\r\n", "t_s", "buttons", "4294967295", "4294967296", "0.5", "-0", "1e999"};
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  const std::string name = "trial_001_1.csv";
  const auto read = [&](const std::string& text) {
    std::istringstream stream(text);
    return app::read_trace(stream, name);
  };
  try {
    // What was read is written and read again the same.
    const std::string text = app::trace_csv(read(std::string(fuzz::text(data, size))));
    fuzz::require(app::trace_csv(read(text)) == text);
  } catch (const Error& error) {
    fuzz::require(error.code() == ErrorCode::InvalidInput);
    fuzz::require(std::string_view(error.what()).starts_with(name));
  }
  return 0;
}
