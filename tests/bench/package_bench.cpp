/// package_bench PACKAGE [REPEATS]: how long it takes from nothing to the first force, by the
/// clock, with the file on disk and in the page cache, and the memory of a program that has it;
/// then CPU time (of all threads) and bytes of what a program may ask of a package, and of its
/// volume beside what one would take instead: the images that went in cannot be had back from a
/// package, so the alternatives hold what the volume decodes to, as 16 bit.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <fcntl.h>
#include <unistd.h>
#include <zstd.h>

#include "runtime/atlas/atlas.h"
#include "runtime/atlas/volume.h"
#include "runtime/base/error.h"
#include "runtime/base/sha256.h"
#include "runtime/haptics/servo.h"

namespace beatlas {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// MB, from the kernel's account of this process.
double memory_mb(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != key + ":") continue;
    double kb = 0;
    status >> kb;
    return kb / 1024;
  }
  return NAN;
}

/// Asks the kernel to forget what it has read of the file.
void forget(const char* file) {
  const int handle = open(file, O_RDONLY);
  if (handle < 0) return;
  (void)fdatasync(handle);
  (void)posix_fadvise(handle, 0, 0, POSIX_FADV_DONTNEED);
  (void)close(handle);
}

/// What a trainer does until it feels something.
std::unique_ptr<haptics::Servo> first_force(const char* file) {
  const atlas::Atlas package =
      atlas::Atlas::open(file, {.fields = {Structure::Heart}, .surfaces = {}});
  const auto heart = std::make_shared<const field::FieldQuery>(package.field(Structure::Heart),
                                                               package.manifest().rr_interval_s);
  haptics::TwoStepOptions model;
  model.stiffness_n_per_m = package.manifest().stiffness_n_per_m;
  auto servo = std::make_unique<haptics::Servo>(heart, model, haptics::SafetyOptions{});
  (void)servo->tick({.time_s = 0, .position_mm = heart->centre_mm(), .valid = true});
  return servo;
}

/// The rows come first of all, before anything has been read.
void measure_opening(const char* file, int repeats) {
  const double before_mb = memory_mb("VmRSS");
  forget(file);
  Clock::time_point start = Clock::now();
  auto servo = first_force(file);
  const double cold_ms = ms_since(start);
  const double resident_mb = memory_mb("VmRSS");
  const double most_mb = memory_mb("VmHWM");
  servo.reset();
  std::vector<double> warm;
  for (int n = 0; n < std::max(9, repeats); ++n) {
    start = Clock::now();
    const auto kept = first_force(file);
    warm.push_back(ms_since(start));
  }
  std::sort(warm.begin(), warm.end());
  // Plain work in the same run, so that machines and loads can be compared.
  std::vector<std::byte> block(std::size_t{16} << 20U);
  start = Clock::now();
  (void)sha256_hex(block);
  const double hash_ms = ms_since(start);
  std::printf(
      "| until the first force, by the clock | ms | over SHA-256 of 16 MiB |\n|---|---|---|\n"
      "| file not in the page cache, first use of the program | %.1f | %.2f |\n"
      "| again, median of %zu | %.1f | %.2f |\n| the same, least | %.1f | %.2f |\n\n",
      cold_ms, cold_ms / hash_ms, warm.size(), warm[warm.size() / 2],
      warm[warm.size() / 2] / hash_ms, warm.front(), warm.front() / hash_ms);
  std::printf(
      "| memory, MB | |\n|---|---|\n| resident before | %.1f |\n"
      "| resident with the first force | %.1f |\n| most until then | %.1f |\n\n",
      before_mb, resident_mb, most_mb);
}

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
    const int repeats = argc > 2 ? std::atoi(argv[2]) : 7;
    beatlas::measure_opening(argv[1], repeats);
    beatlas::measure(argv[1], repeats);
  } catch (const beatlas::Error& error) {
    std::cerr << "package_bench: " << error.what() << '\n';
    return static_cast<int>(error.code());
  }
  return 0;
}
