/// package_bench PACKAGE [REPEATS]: CPU time (of all threads) and bytes of what a program may ask
/// of a package, and of its volume beside what one would take instead: the images that went in
/// cannot be had back from a package, so the alternatives hold what the volume decodes to, as 16
/// bit.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <iostream>
#include <vector>

#include <zstd.h>

#include "runtime/atlas/atlas.h"
#include "runtime/atlas/volume.h"
#include "runtime/base/error.h"

namespace beatlas {
namespace {

/// The least of the repeats [ms].
double cpu_ms(int repeats, const std::function<void()>& body) {
  double least = 1e300;
  for (int n = 0; n < repeats; ++n) {
    const std::clock_t start = std::clock();
    body();
    least = std::min(least, 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return least;
}

void row(const char* name, std::size_t bytes, double ms, double unit_ms) {
  std::printf("| %-44s | %10zu | %8.2f | %5.2f |\n", name, bytes, ms, ms / unit_ms);
}

void measure(const char* file, int repeats) {
  const atlas::Manifest manifest = atlas::Atlas::open(file, {}).manifest();
  const auto bytes_of = [&](std::string_view kind, std::string_view structure) {
    std::size_t bytes = 0;
    for (const atlas::Item& item : manifest.items) {
      if (item.kind == kind && (structure.empty() || item.structure == structure)) {
        bytes += item.bytes;
      }
    }
    return bytes;
  };
  const auto open = [&](const atlas::Needs& needs) {
    return cpu_ms(repeats, [&] { (void)atlas::Atlas::open(file, needs); });
  };
  atlas::Needs all = atlas::everything_in(manifest);
  const double force_ms = open({{Structure::Heart}, {}});
  std::printf("| %-44s | %10s | %8s | %5s |\n|---|---|---|---|\n", "", "bytes", "CPU ms", "x");
  row("open and verify, field of the heart", bytes_of("field", "heart"), force_ms, force_ms);
  row("all fields", bytes_of("field", ""), open({all.fields, {}}), force_ms);
  if (!all.surfaces.empty()) {
    row("all surfaces", bytes_of("surface", "") + bytes_of("motion", ""), open({{}, all.surfaces}),
        force_ms);
  }
  if (!all.volume) return;
  row("volume", bytes_of("volume", ""), open({{}, {}, true}), force_ms);

  const auto volume = atlas::Atlas::open(file, {{}, {}, true}).volume();
  const std::size_t count = volume->sample_count();
  const auto phases = static_cast<std::size_t>(volume->phases);
  std::vector<std::uint8_t> image(count);
  const atlas::IntensityWindow window = atlas::whole_window(*volume);
  double beats = 0;
  row("an image of the volume, 8 bit", count,
      cpu_ms(repeats, [&] { atlas::volume_8bit(*volume, beats += 0.013, window, image); }),
      force_ms);
  std::vector<std::uint16_t> raw(count * phases);
  for (std::size_t p = 0; p < phases; ++p) {
    atlas::volume_16bit(*volume, static_cast<double>(p) / volume->phases,
                        std::span(raw).subspan(p * count, count));
  }
  const std::size_t size = raw.size() * sizeof(raw[0]);
  row("volume as 16 bit", size, 0, force_ms);
  for (const int level : {3, 19}) {
    std::vector<char> frame(ZSTD_compressBound(size));
    frame.resize(ZSTD_compress(frame.data(), frame.size(), raw.data(), size, level));
    const double ms = cpu_ms(
        repeats, [&] { (void)ZSTD_decompress(raw.data(), size, frame.data(), frame.size()); });
    row(level == 3 ? "the same, zstd -3" : "the same, zstd -19", frame.size(), ms, force_ms);
  }
}

}  // namespace
}  // namespace beatlas

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "package_bench PACKAGE [REPEATS]\n";
    return 2;
  }
  try {
    beatlas::measure(argv[1], argc > 2 ? std::atoi(argv[2]) : 7);
  } catch (const beatlas::Error& error) {
    std::cerr << "package_bench: " << error.what() << '\n';
    return static_cast<int>(error.code());
  }
  return 0;
}
