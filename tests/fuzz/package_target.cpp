// A whole package: the zip, its directory, what the manifest promises.
#include "runtime/atlas/atlas.h"
#include "runtime/atlas/info.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  return {read_file(BEATLAS_GOLDEN_PACKAGE), read_file(BEATLAS_GOLDEN_VOLUME),
          read_file(BEATLAS_GOLDEN_LEVELS)};
}
std::vector<std::string> tokens() {
  return {"PK\x03\x04",   "PK\x01\x02", "PK\x05\x06",         "PK\x06\x06",      "atlas.json",
          "fields/heart", ".level1",    std::string(4, '\0'), "\xff\xff\xff\xff"};
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  static const fuzz::MemoryFolder folder;
  const auto file = folder.write("a.beatlas", fuzz::text(data, size));
  fuzz::only_errors([&] {
    const auto manifest = atlas::Atlas::open(file, {}).manifest();
    (void)atlas::Atlas::open(file, atlas::everything_in(manifest));
  });
  return 0;
}
