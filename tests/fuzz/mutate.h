#pragma once
#include <random>
#include <string>
#include <vector>

namespace beatlas::fuzz {

/// One to eight random changes of a sound input: bits, bytes and numbers that are often wrong,
/// pieces cut out, doubled or taken from another input, words, a cut end. At most `most` bytes.
[[nodiscard]] std::string mutated(const std::string& input, const std::vector<std::string>& inputs,
                                  const std::vector<std::string>& tokens, std::size_t most,
                                  std::mt19937_64& random);

}  // namespace beatlas::fuzz
