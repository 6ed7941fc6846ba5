#pragma once
/// The words that make a phantom's spec: a preset or a file, and options that change it.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/phantom/spec.h"

namespace CLI {
class App;
}

namespace beatlas::cli {

struct PhantomWords {
  std::string preset = "adult";
  std::string spec_file;
  /// What the options do to the spec, in the order of the options' groups.
  std::vector<std::function<void(phantom::PhantomSpec&)>> changes;
};

/// Adds the options in groups. An option that is not given changes nothing.
void add_phantom_words(CLI::App& command, const std::shared_ptr<PhantomWords>& words);

/// @throws Error{InvalidInput} naming the file or the key.
[[nodiscard]] phantom::PhantomSpec phantom_spec(const PhantomWords& words);

}  // namespace beatlas::cli
