#include "pipeline/cli/import_words.h"

#include <array>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <system_error>

#include <CLI/CLI.hpp>

#include "pipeline/ingest/shown_path.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace {

constexpr std::size_t kMostTimes = 1000;
constexpr double kLatestS = 10;  // far beyond a heart beat: such times are no seconds

constexpr double kLeastRrS = 0.2;
constexpr double kMostRrS = 3;
constexpr int kMostPhases = 200;
constexpr auto kAllSeries = "all";
constexpr auto kNoTimes = "none";

template <class Number>
std::optional<Number> number(const std::string& text) {
  Number value{};
  const char* const start = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [end, error] = std::from_chars(start, text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// What is wrong with a word, for the parser, or nothing. The word is not repeated: it may be a
// path.

std::string wrong_rr(const std::string& text) {
  const auto value = number<double>(text);
  if (value && (*value == 0 || (*value >= kLeastRrS && *value <= kMostRrS))) return {};
  return "give the R-R interval in seconds, 0.2 to 3, or 0 for the source's";
}

std::string wrong_phases(const std::string& text) {
  const auto value = number<int>(text);
  if (value && (*value == 0 || (*value >= 2 && *value <= kMostPhases))) return {};
  return "give 2 to 200 phases, or 0 for as many as the source has";
}

std::string wrong_series(const std::string& text) {
  const auto value = number<int>(text);
  if (text == kAllSeries || (value && *value >= 0)) return {};
  return "one of its words is no series number; separate numbers by commas, as in 7001,8001, and "
         "name the source before it";
}

std::string empty_word(const std::string& text) {
  return text.empty() ? "it is empty" : std::string();
}

/// Whether the text is meant as numbers; else it names a file.
bool are_numbers(const std::string& text) {
  if (text.find('/') != std::string::npos) return false;
  return text.find_first_of(",;") != std::string::npos ||
         text.find_first_not_of("0123456789+-.eE \t\r\n") == std::string::npos;
}

}  // namespace

void add_import_words(CLI::App& command, ImportWords& words) {
  if (CLI::Option* source = command.get_option_no_throw("SOURCE")) source->check(empty_word);
  command
      .add_option("--rr", words.rr_interval_s,
                  "R-R interval [s], instead of the source's; 0 = the source's")
      ->check(wrong_rr)
      ->type_name("SECONDS");
  command
      .add_option("--times", words.times,
                  "When each frame of a slice was taken [s], instead of the source's times: "
                  "0,0.04,... or a file of such numbers; none = the source's")
      ->check(empty_word)
      ->type_name("LIST|FILE");
  command.add_option("--phases", words.phases, "Phases to resample to; 0 = as many as there are")
      ->check(wrong_phases)
      ->type_name("N");
  command
      .add_option("--exam", words.exam,
                  "Which of several patients or studies in one folder, as the message lists them")
      ->check(CLI::Range(0, 100000))
      ->type_name("N");
  command
      .add_option("--series", words.series,
                  "Take images of these series numbers only; all = of any")
      ->delimiter(',')
      ->check(wrong_series)
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
  if (!words.series.empty()) options.series.clear();
  for (const std::string& series : words.series) {
    if (series == kAllSeries && words.series.size() > 1) {
      throw Error(ErrorCode::Usage, "--series is either all or a list of numbers");
    }
    if (series != kAllSeries) options.series.push_back(*number<int>(series));
  }
  if (words.times.empty()) return;
  if (words.times == kNoTimes) {
    options.frame_times_s.clear();
    return;
  }
  std::error_code ignored;
  const std::filesystem::path file = words.times;
  const bool there = std::filesystem::exists(file, ignored);
  if (!there && are_numbers(words.times)) {
    options.frame_times_s = parse_times(words.times, "the times of --times");
    return;
  }
  const std::string shown = ingest::shown_to({file}, file);
  if (!there) throw_invalid(shown + ": no such file; --times takes numbers or a file of them");
  if (std::filesystem::is_directory(file, ignored)) {
    throw_invalid(shown +
                  ": no such file, it is a folder; --times takes numbers or a file of them");
  }
  const std::vector<std::byte> bytes = study::read_bytes(file);
  options.frame_times_s =
      parse_times(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
                  "the times in " + shown);
}

void warn_of_kept(const ImportWords& words, const build::Recipe& named, const build::Recipe& taken,
                  Console& console) {
  const ingest::IngestOptions& alone = named.import;
  const ingest::IngestOptions& now = taken.import;
  std::string out;
  const auto add = [&](const std::string& word) { out += (out.empty() ? "" : " ") + word; };
  if (now.rr_interval_s != alone.rr_interval_s && !words.rr_interval_s) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "--rr %g", now.rr_interval_s);
    add(text.data());
  }
  if (now.frame_times_s != alone.frame_times_s && words.times.empty()) add("--times ...");
  if (now.phases != alone.phases && !words.phases) add("--phases " + std::to_string(now.phases));
  if (now.exam != alone.exam && !words.exam) add("--exam " + std::to_string(now.exam));
  if (now.series != alone.series && words.series.empty()) {
    std::string list;
    for (const int series : now.series) list += (list.empty() ? "" : ",") + std::to_string(series);
    add("--series " + list);
  }
  if (now.stack != alone.stack && !words.stack) add("--stack " + std::to_string(now.stack));
  if (taken.align.slices != named.align.slices) {
    add("/import/align_slices " + build::recipe_to_json(taken)["import"]["align_slices"].dump());
  }
  if (out.empty()) return;
  console.warn("the images are taken as when this study was last built: " + out +
               "; to change that give other words or a recipe that names it, or for the source's "
               "own --rr 0, --times none, "
               "--phases 0, --exam 0, --series all, --stack 0");
}

}  // namespace beatlas::cli
