#pragma once
/// `beatlas-play`, called as a user calls it.

#include <sstream>
#include <string>
#include <vector>

#include "runtime/app/play.h"

namespace beatlas::app::test {

struct Result {
  int code = 0;
  std::string out;
  std::string err;
};

inline Result run(std::vector<std::string> words, const std::string& input = "") {
  words.insert(words.begin(), "beatlas-play");
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  std::istringstream in(input);
  std::ostringstream out;
  std::ostringstream err;
  Result result;
  result.code = play(static_cast<int>(argv.size()), argv.data(), in, out, err);
  result.out = out.str();
  result.err = err.str();
  return result;
}

}  // namespace beatlas::app::test
