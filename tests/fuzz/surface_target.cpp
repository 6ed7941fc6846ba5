// surfaces/*.drc and *.motion.zst: 4 bytes size of the first, the first, the second unpacked.
#include <algorithm>
#include <cstring>

#include <zstd.h>

#include "runtime/atlas/surface_payload.h"
#include "runtime/atlas/zip_archive.h"
#include "runtime/atlas/zstd_frame.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  const atlas::ZipArchive zip(BEATLAS_GOLDEN_PACKAGE);
  std::vector<std::string> out;
  for (const auto& entry : zip.entries()) {
    if (!entry.name.ends_with(".drc")) continue;
    const std::string stem = entry.name.substr(0, entry.name.size() - 4);
    const auto drc = zip.read(zip.find(entry.name).value());
    const auto motion = atlas::zstd_unpack(zip.read(zip.find(stem + ".motion.zst").value()));
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
  const std::size_t rest = size - 4 - first;
  atlas::Bytes packed(ZSTD_compressBound(rest));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), data + 4 + first, rest, 1));
  fuzz::only_errors(
      [&] { atlas::check_surface(atlas::decode_surface(drc, packed, Structure::Heart)); });
  return 0;
}
