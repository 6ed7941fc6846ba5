// atlas.json.
#include "runtime/atlas/manifest.h"
#include "runtime/atlas/zip_archive.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  const atlas::ZipArchive zip(BEATLAS_GOLDEN_PACKAGE);
  const auto bytes = zip.read(zip.find(atlas::kManifestEntry).value());
  return {std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())};
}
std::vector<std::string> tokens() {
  return {"{", "}", "[", "]", "\"", ":", ",", "null", "true", "[[[[[[[[", "\\u0000", "\xff"};
}
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  fuzz::only_errors([&] {
    const auto manifest = atlas::manifest_from_text(fuzz::text(data, size));
    (void)atlas::manifest_from_json(atlas::manifest_to_json(manifest));  // what is sound stays so
  });
  return 0;
}
