#include "tests/fuzz/mutate.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace beatlas::fuzz {
namespace {

constexpr std::array<std::uint64_t, 20> kOdd{0,
                                             1,
                                             2,
                                             0x7f,
                                             0x80,
                                             0xff,
                                             0x7fff,
                                             0x8000,
                                             0xffff,
                                             0x10000,
                                             0x7fffffff,
                                             0x80000000U,
                                             0xffffffffU,
                                             0x100000000U,
                                             0x7f800000,
                                             0x7fc00000,
                                             0xff800000,
                                             0x7fefffffffffffff,
                                             0x7ff8000000000000,
                                             0xffffffffffffffff};
constexpr std::array<const char*, 12> kWords{"0",          "-1",         "1e999",
                                             "nan",        "inf",        "-inf",
                                             "2147483648", "4294967296", "18446744073709551616",
                                             "1e-320",     "0.1",        ""};

class Mutation {
 public:
  Mutation(std::string& bytes, const std::vector<std::string>& inputs,
           const std::vector<std::string>& tokens, std::mt19937_64& random)
      : bytes_(bytes), inputs_(inputs), tokens_(tokens), random_(random) {}

  void apply() {
    switch (below(11)) {
      case 0:
        if (!bytes_.empty()) bytes_[at()] ^= static_cast<char>(1 << below(8));
        break;
      case 1:
        if (!bytes_.empty()) bytes_[at()] = static_cast<char>(below(256));
        break;
      case 2:
        odd_number();
        break;
      case 3:  // the end cut off
        bytes_.resize(below(bytes_.size() + 1));
        break;
      case 4:  // a piece cut out
        bytes_.erase(at(), 1 + below(1 + below(64)));
        break;
      case 5:  // a piece doubled
        insert(piece(bytes_));
        break;
      case 6:  // a piece of another input
        insert(piece(pick(inputs_)));
        break;
      case 7: {  // the rest of another input
        const std::string& other = pick(inputs_);
        bytes_ = bytes_.substr(0, at()) + other.substr(below(other.size() + 1));
        break;
      }
      case 8:
        if (!tokens_.empty()) insert(pick(tokens_));
        break;
      case 9:
        if (!tokens_.empty()) overwrite(pick(tokens_));
        break;
      default:
        number_in_text();
        break;
    }
  }

 private:
  std::size_t below(std::size_t count) { return count == 0 ? 0 : random_() % count; }
  std::size_t at() { return below(bytes_.size()); }
  const std::string& pick(const std::vector<std::string>& from) { return from[below(from.size())]; }
  std::string piece(const std::string& of) {
    return of.substr(below(of.size() + 1), 1 + below(1 + below(256)));
  }
  void insert(const std::string& what) { bytes_.insert(below(bytes_.size() + 1), what); }
  void overwrite(const std::string& what) {
    const std::size_t place = below(bytes_.size() + 1);
    bytes_.replace(place, std::min(what.size(), bytes_.size() - place), what);
  }
  void odd_number() {
    const std::size_t width = std::size_t{1} << below(4);
    if (bytes_.size() < width) return;
    const std::uint64_t value = kOdd[below(kOdd.size())] + below(3) - 1;
    std::array<char, 8> raw{};
    std::memcpy(raw.data(), &value, raw.size());
    if (below(4) == 0) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(width));
    std::copy_n(raw.begin(), width,
                bytes_.begin() + static_cast<std::ptrdiff_t>(below(bytes_.size() - width + 1)));
  }
  /// A number in a text becomes another.
  void number_in_text() {
    const std::size_t first = bytes_.find_first_of("0123456789", at());
    if (first == std::string::npos) return;
    const std::size_t end =
        std::min(bytes_.find_first_not_of("0123456789.e+-", first), bytes_.size());
    bytes_.replace(first, end - first,
                   below(2) == 0 ? std::string(kWords[below(kWords.size())])
                                 : std::to_string(below(std::size_t{1} << below(63))));
  }

  std::string& bytes_;
  const std::vector<std::string>& inputs_;
  const std::vector<std::string>& tokens_;
  std::mt19937_64& random_;
};

}  // namespace

std::string mutated(const std::string& input, const std::vector<std::string>& inputs,
                    const std::vector<std::string>& tokens, std::size_t most,
                    std::mt19937_64& random) {
  std::string out = input;
  Mutation mutation(out, inputs, tokens, random);
  for (std::uint64_t changes = 1 + random() % 8; changes > 0; --changes) mutation.apply();
  if (out.size() > most) out.resize(most);
  return out;
}

}  // namespace beatlas::fuzz
