// JSON walked in place: what Haply's service sends a thousand times a second.
#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "runtime/device/json_scan.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  return {
      R"({"inverse3":[{"device_id":"04C6","config":{"type":"inverse3"},"state":)"
      R"({"cursor_position":{"x":0.1,"y":-2e-3,"z":0},"cursor_velocity":{"x":1,"y":2,"z":3}}}]})",
      R"([1, -2.5, "a\"b\\", true, false, null, {}, [], {"a": [[[]]]}])", " { } \n",
      std::string(40, '[') + std::string(40, ']')};
}
std::vector<std::string> tokens() {
  return {"{", "}", "[", "]", "\"", "\\", ":", ",", "null", "true", "1e9", "-", "[[[[[[[[", "]]]]"};
}

namespace {

// Deepest nesting of brackets outside of strings.
int depth_of(std::string_view text) {
  int depth = 0;
  int deepest = 0;
  bool quoted = false;
  for (std::size_t n = 0; n < text.size(); ++n) {
    const char c = text[n];
    if (quoted) {
      n += c == '\\' ? 1 : 0;
      quoted = c != '"';
    } else {
      quoted = c == '"';
      if (c == '{' || c == '[') deepest = std::max(deepest, ++depth);
      if (c == '}' || c == ']') --depth;
    }
  }
  return deepest;
}

// All of a value by `object`, `array`, `string` and `number` instead of `skip`.
bool walk(device::JsonScan& in, int depth) {
  if (depth > 64) return false;
  for (int kind = 0; kind < 5; ++kind) {
    device::JsonScan tried = in;
    std::string_view text;
    double value = 0;
    bool sound = false;
    if (kind == 0) {
      sound = tried.object([&](std::string_view key, device::JsonScan& member) {
        (void)std::count(key.begin(), key.end(), 'x');  // every byte can be read
        return walk(member, depth + 1);
      });
    } else if (kind == 1) {
      sound = tried.array([&](device::JsonScan& element) { return walk(element, depth + 1); });
    } else if (kind == 2) {
      sound = tried.string(text);
      (void)std::count(text.begin(), text.end(), 'x');
    } else if (kind == 3) {
      sound = tried.number(value);
      require(!sound || std::isfinite(value));
    } else {
      sound = tried.skip();
    }
    if (!sound) continue;
    in = tried;
    return true;
  }
  return false;
}

}  // namespace
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  const std::string_view text = fuzz::text(data, size);
  device::JsonScan by_parts(text);
  (void)fuzz::walk(by_parts, 0);
  device::JsonScan whole(text);
  const bool taken = whole.skip() && whole.at_end();
  // What an independent reader takes is taken, but for nesting, for numbers that a double does not
  // hold, for a byte order mark, and for a NUL, which that reader takes for the end.
  bool plain = size < 300 && text.find('\0') == std::string_view::npos;
  for (std::size_t n = 1; n < size; ++n) {
    const bool exponent = text[n] == 'e' || text[n] == 'E';
    plain = plain && !(exponent && text[n - 1] >= '0' && text[n - 1] <= '9');
  }
  if (plain && !text.starts_with('\xEF') && fuzz::depth_of(text) <= 30 &&
      nlohmann::json::accept(text)) {
    fuzz::require(taken);
  }
  return 0;
}
