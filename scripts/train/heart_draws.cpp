// Streams drawn slices for training, see scripts/train/README.md.

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "pipeline/phantom/drawn_slices.h"

int main(int argc, char** argv) {
  unsigned long first = 0;
  unsigned long count = 0;
  for (int a = 1; a < argc; ++a) {
    if (std::strcmp(argv[a], "--first") == 0 && a + 1 < argc) {
      first = std::strtoul(argv[++a], nullptr, 10);
    } else if (std::strcmp(argv[a], "--count") == 0 && a + 1 < argc) {
      count = std::strtoul(argv[++a], nullptr, 10);
    } else if (std::strcmp(argv[a], "--stream") != 0) {
      std::fprintf(
          stderr,
          "heart_draws: unknown word '%s'\nusage: heart_draws --first SEED --count SAMPLES "
          "--stream   (samples go to stdout)\n",
          argv[a]);
      return 2;
    }
  }
  unsigned long written = 0;
  for (unsigned long seed = first; written < count; ++seed) {
    for (const auto& sample : beatlas::phantom::drawn_samples(static_cast<std::uint32_t>(seed))) {
      if (written++ == count) return 0;
      for (const auto& plane : sample.planes) {
        if (std::fwrite(plane.data(), 1, plane.size(), stdout) != plane.size()) return 5;
      }
    }
  }
  return 0;
}
