// The CSV of beatlas-play: points to probe, recorded paths.
#include <sstream>

#include "runtime/device/csv_table.h"
#include "runtime/device/replay.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  return {"x_mm,y_mm,z_mm,t_s\n1,2,3,0.5\n-1.5e2,+2,3.25,0\n",
          "\xEF\xBB\xBFt_s, x_mm ,y_mm,z_mm,name\r\n0,1,2,3,a\r\n\r\n0.001,1,2,3,b\r\n",
          "t_s,x_mm,y_mm,z_mm\n0,0,0,0\n1e-3,1,1,1\n"};
}
std::vector<std::string> tokens() { return {",", "\n", "\r\n", "t_s", "x_mm", "\"", "0x10", " "}; }
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  const std::string input(fuzz::text(data, size));
  fuzz::only_errors([&] {
    std::istringstream stream(input);
    const auto table = device::read_csv(stream, "a.csv", {"x_mm", "y_mm", "z_mm", "t_s"});
    fuzz::require(table.rows.size() == table.lines.size());
    for (const auto& row : table.rows) fuzz::require(row.size() == 4);
  });
  fuzz::only_errors([&] {
    std::istringstream stream(input);
    const auto path = device::read_recording(stream, "a.csv");
    fuzz::require(path.time_s.size() == path.position_m.size());
  });
  return 0;
}
