// Recorded ticks of a servo, which beatlas-play replays.
#include <sstream>

#include "runtime/haptics/recorder.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
namespace {

std::string written(const std::string& about, const std::vector<haptics::TickRecord>& ticks) {
  std::ostringstream out;
  haptics::write_ticks(out, about, ticks);
  return out.str();
}

}  // namespace

std::vector<std::string> seeds() {
  std::vector<haptics::TickRecord> ticks(3);
  for (std::size_t n = 0; n < ticks.size(); ++n) {
    haptics::TickRecord& tick = ticks[n];
    const auto turn = static_cast<double>(n);
    tick.time_s = 0.001 * turn;
    tick.position_mm = {1.5, -2 * turn, 1e-300};
    tick.valid = n != 1;
    tick.status = n == 1 ? haptics::TickStatus::Fault : haptics::TickStatus::Ok;
    tick.before.model[3] = turn / 3;
    tick.model_force_n = {-0.0, 1e300, turn};
  }
  std::string windows = written("{}", ticks);
  for (std::size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 2) {
    windows.insert(at, "\r");
  }
  return {written(R"({"touch": {"model": "proxy"}})", ticks), written("", {}), windows};
}
std::vector<std::string> tokens() {
  return {",", "\n", "\r\n", "beatlas ticks 1", "t_s", "nan", "inf", "-0", "1e999", "4294967296"};
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  const std::string input(fuzz::text(data, size));
  fuzz::only_errors([&] {
    std::istringstream stream(input);
    const haptics::RecordedTicks read = haptics::read_ticks(stream, "a.ticks");
    // What was read is written and read again to the bit, a NaN as a NaN.
    const std::string text = fuzz::written(read.about, read.ticks);
    std::istringstream again(text);
    const haptics::RecordedTicks twice = haptics::read_ticks(again, "b.ticks");
    fuzz::require(twice.ticks.size() == read.ticks.size());
    fuzz::require(fuzz::written(twice.about, twice.ticks) == text);
  });
  return 0;
}
