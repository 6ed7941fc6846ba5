// maps/*.map.zst, unpacked: the input is packed again before it is read.
#include <zstd.h>

#include "runtime/atlas/surface_map_payload.h"
#include "runtime/atlas/zip_archive.h"
#include "runtime/atlas/zstd_frame.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  const atlas::ZipArchive zip(BEATLAS_GOLDEN_MAP);
  std::vector<std::string> out;
  for (std::size_t i = 0; i < zip.entries().size(); ++i) {
    if (!zip.entries()[i].name.ends_with(".map.zst")) continue;
    const auto bytes = atlas::zstd_unpack(zip.read(i));
    out.emplace_back(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  return out;
}
std::vector<std::string> tokens() { return {std::string(atlas::kMapMagic)}; }
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  atlas::Bytes packed(ZSTD_compressBound(size));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), data, size, 1));
  for (const Structure structure : {Structure::LvBlood, Structure::RvBlood}) {
    fuzz::only_errors([&] {
      const atlas::SurfaceMapPayload map = atlas::decode_surface_map(packed, structure);
      atlas::check_surface_map(map);
      fuzz::require(map.segment.size() * map.thickness_mm.size() <= size);
    });
  }
  // And as it stands, for the frame's own header.
  fuzz::only_errors([&] {
    (void)atlas::decode_surface_map(std::as_bytes(std::span(data, size)), Structure::LvBlood);
  });
  return 0;
}
