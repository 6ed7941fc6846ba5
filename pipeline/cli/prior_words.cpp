#include "pipeline/cli/prior_words.h"

#include <cstdlib>

#include <CLI/CLI.hpp>

#include "pipeline/build/learned_prior.h"

namespace beatlas::cli {

void add_prior_word(CLI::App& command, std::optional<std::string>& word) {
  command
      .add_option("--prior", word,
                  "The network that tells what voxels are likely to be before labels grow: a file "
                  "with its MODEL.json beside it, none, or '' for the built-in one; see "
                  "/segment/prior of 'beatlas defaults'")
      ->type_name("MODEL.onnx|none");
}

void take_prior_of_environment() {
  if (const char* everywhere = std::getenv("BEATLAS_PRIOR")) build::set_usual_prior(everywhere);
}

}  // namespace beatlas::cli
