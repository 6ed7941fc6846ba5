// Runs a target on its sound inputs, on the cases that once broke it, and on random changes of
// both. The same seed and number of runs gives the same inputs.
//
// TARGET [--runs N] [--seconds S] [--seed K] [--cases DIR] [--write-corpus DIR] [FILE...]

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>

#include <sanitizer/asan_interface.h>

#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/mutate.h"

extern "C" const char* __asan_default_options();
/// Defined by a target whose libraries of the system ask for what an input claims, and take a no.
extern "C" __attribute__((weak)) void beatlas_libraries_may_hear_no();
// A reader that asks for more than this for an input of some kB has not checked a count. `new` of
// our own never hears a no: it is reported.
extern "C" const char* __asan_default_options() {
  if (beatlas_libraries_may_hear_no) {
    return "max_allocation_size_mb=600:allocator_may_return_null=1:detect_leaks=1:"
           "hard_rss_limit_mb=3000:handle_abort=1";
  }
  return "max_allocation_size_mb=600:allocator_may_return_null=0:detect_leaks=1:"
         "hard_rss_limit_mb=3000:handle_abort=1";
}

namespace {

namespace fs = std::filesystem;
using namespace beatlas::fuzz;

std::string current;  // for the report of a crash

void save_current() {
  std::ofstream("crash.bin", std::ios::binary) << current;
  std::fprintf(stderr, "the input is in crash.bin (%zu bytes)\n", current.size());
}

void run(const std::string& input) {
  current = input;
  try {
    // A copy of exactly its size, so that reading beyond it is seen.
    const std::vector<std::uint8_t> bytes(input.begin(), input.end());
    (void)LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "another exception than Error came out: %s\n", error.what());
    save_current();
    std::exit(1);
  }
}

}  // namespace

int main(int argc, char** argv) {
  long runs = 1000;
  double seconds = 1e9;
  std::uint64_t seed = 1;
  fs::path cases;
  fs::path corpus;
  std::vector<fs::path> files;
  for (int a = 1; a < argc; ++a) {
    const std::string word = argv[a];
    if (word.rfind("--", 0) == 0 && a + 1 == argc) {
      std::cerr << word << " needs a value\n";
      return 2;
    }
    if (word == "--runs") {
      runs = std::stol(argv[++a]);
    } else if (word == "--seconds") {
      seconds = std::stod(argv[++a]);
    } else if (word == "--seed") {
      seed = std::stoull(argv[++a]);
    } else if (word == "--cases") {
      cases = argv[++a];
    } else if (word == "--write-corpus") {
      corpus = argv[++a];
    } else {
      files.emplace_back(word);
    }
  }
  std::vector<std::string> inputs = seeds();
  if (inputs.empty()) {
    std::cerr << "the target has no sound input\n";
    return 1;
  }
  if (!corpus.empty()) {
    fs::create_directories(corpus);
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      std::ofstream(corpus / ("seed_" + std::to_string(i)), std::ios::binary) << inputs[i];
    }
    return 0;
  }
  __sanitizer_set_death_callback(save_current);
  if (!cases.empty() && fs::is_directory(cases)) {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(cases)) found.push_back(entry.path());
    std::sort(found.begin(), found.end());
    files.insert(files.end(), found.begin(), found.end());
  }
  for (const fs::path& file : files) inputs.push_back(read_file(file));
  for (const std::string& input : inputs) run(input);

  std::mt19937_64 random(seed);
  const auto words = tokens();
  std::size_t most = 256;
  for (const std::string& input : inputs) most = std::max(most, 2 * input.size());
  const auto start = std::chrono::steady_clock::now();
  long done = 0;
  for (; done < runs; ++done) {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    if (passed.count() > seconds) break;
    run(mutated(inputs[random() % inputs.size()], inputs, words, most, random));
  }
  std::cout << inputs.size() << " inputs, " << done << " changed ones\n";
  return 0;
}
