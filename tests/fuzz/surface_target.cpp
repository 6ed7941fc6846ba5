// surfaces/*.drc and *.motion: 4 bytes size of the first, the first, the second.
#include <algorithm>
#include <cstring>

#include "runtime/atlas/surface_payload.h"
#include "runtime/atlas/zip_archive.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  const atlas::ZipArchive zip(BEATLAS_GOLDEN_PACKAGE);
  std::vector<std::string> out;
  for (const auto& entry : zip.entries()) {
    if (!entry.name.ends_with(".drc")) continue;
    const std::string stem = entry.name.substr(0, entry.name.size() - 4);
    const auto drc = zip.read(zip.find(entry.name).value());
    const auto motion = zip.read(zip.find(stem + ".motion").value());
    const auto size = static_cast<std::uint32_t>(drc.size());
    std::string input(4, '\0');
    std::memcpy(input.data(), &size, 4);
    input.append(reinterpret_cast<const char*>(drc.data()), drc.size());
    input.append(reinterpret_cast<const char*>(motion.data()), motion.size());
    out.push_back(std::move(input));
  }
  return out;
}
std::vector<std::string> tokens() { return {std::string(atlas::kMotionMagic), "DRACO"}; }
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  if (size < 4) return 0;
  std::uint32_t told = 0;
  std::memcpy(&told, data, 4);
  const std::size_t first = std::min<std::size_t>(told, size - 4);
  const auto drc = std::as_bytes(std::span(data + 4, first));
  const auto motion = std::as_bytes(std::span(data + 4 + first, size - 4 - first));
  fuzz::only_errors(
      [&] { atlas::check_surface(atlas::decode_surface(drc, motion, Structure::Heart)); });
  return 0;
}
