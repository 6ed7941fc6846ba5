#include "pipeline/cli/import_words.h"

#include <charconv>
#include <filesystem>
#include <system_error>

#include <CLI/CLI.hpp>

#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace {

constexpr std::size_t kMostTimes = 1000;
constexpr double kLatestS = 10;  // far beyond a heart beat: such times are no seconds

}  // namespace

void add_import_words(CLI::App& command, ImportWords& words) {
  command.add_option("--rr", words.rr_interval_s, "R-R interval [s], instead of the source's")
      ->check(CLI::Range(0.2, 3.0))
      ->type_name("SECONDS");
  command
      .add_option("--times", words.times,
                  "When each frame of a slice was taken [s], instead of the source's times: "
                  "0,0.04,... or a file of such numbers")
      ->type_name("LIST|FILE");
  command.add_option("--phases", words.phases, "Phases to resample to; 0 = as many as there are")
      ->check(CLI::Range(0, 200))
      ->type_name("N");
  command
      .add_option("--exam", words.exam,
                  "Which of several patients or studies in one folder, as the message lists them")
      ->check(CLI::Range(0, 100000))
      ->type_name("N");
  command.add_option("--series", words.series, "Take images of these series numbers only")
      ->delimiter(',')
      ->check(CLI::Range(0, 2147483647))
      ->type_name("N,N,...");
  command
      .add_option("--stack", words.stack,
                  "Which of the possible stacks, as import lists them; 0 = the best")
      ->check(CLI::Range(0, 100000))
      ->type_name("N");
}

std::vector<double> parse_times(const std::string& text, const std::string& what) {
  const auto fail = [&](const std::string& why) {
    throw Error(ErrorCode::Usage,
                what + " " + why + "; give ascending seconds such as 0,0.04,0.08");
  };
  std::vector<double> out;
  const char* at = text.data();
  const char* const end = at + text.size();
  constexpr std::string_view kGaps = " \t\r\n,;";
  while (true) {
    while (at != end && kGaps.find(*at) != std::string_view::npos) ++at;
    if (at == end) break;
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc{} || (next != end && kGaps.find(*next) == std::string_view::npos)) {
      fail("holds what is no number");
    }
    if (!(value >= 0 && value <= kLatestS)) fail("holds a time that is not within 0 to 10 s");
    if (!out.empty() && !(value > out.back())) fail("do not ascend");
    if (out.size() == kMostTimes) fail("are more than 1000 numbers");
    out.push_back(value);
    at = next;
  }
  if (out.size() < 2) fail("are fewer than two numbers");
  return out;
}

void apply(const ImportWords& words, ingest::IngestOptions& options) {
  if (words.rr_interval_s) options.rr_interval_s = *words.rr_interval_s;
  if (words.phases) options.phases = *words.phases;
  if (words.exam) options.exam = *words.exam;
  if (words.stack) options.stack = *words.stack;
  if (!words.series.empty()) options.series = words.series;
  if (words.times.empty()) return;
  std::error_code ignored;
  if (std::filesystem::is_regular_file(words.times, ignored)) {
    const std::vector<std::byte> bytes = study::read_bytes(words.times);
    options.frame_times_s =
        parse_times(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
                    "the times in " + words.times);
  } else {
    options.frame_times_s = parse_times(words.times, "the times of --times");
  }
}

}  // namespace beatlas::cli
