/// surface_bench STUDY: bytes, errors and time of a study's stored surfaces, at steps of 14 bits of
/// their box and of the default; as they are, and with their motion held to the first beats of the
/// cycle, beside the zstd-19 frame of what is coded: what noise in time costs.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>

#include <zstd.h>

#include "pipeline/pack/payload_encoders.h"
#include "pipeline/study/stage_files.h"
#include "runtime/base/cycle_modes.h"

namespace beatlas {
namespace {

double cpu_ms(std::clock_t start) {
  return 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/// Without what turns faster than `beats` a cycle.
SurfaceCycle smoothed(SurfaceCycle surface, int beats) {
  const auto phases = static_cast<int>(surface.positions.size());
  const std::vector<double> modes = cycle_modes(phases);
  for (std::size_t v = 0; v < surface.positions[0].size(); ++v) {
    std::vector<Vec3> at(surface.positions.size(), Vec3::Zero());
    for (int m = 0; m < phases && mode_frequency(m) <= beats; ++m) {
      Vec3 term = Vec3::Zero();
      const double* weight = modes.data() + static_cast<std::size_t>(m * phases);
      for (std::size_t p = 0; p < at.size(); ++p) {
        term += weight[p] * surface.positions[p][v].cast<double>();
      }
      for (std::size_t p = 0; p < at.size(); ++p) at[p] += weight[p] * term;
    }
    for (std::size_t p = 0; p < at.size(); ++p) surface.positions[p][v] = at[p].cast<float>();
  }
  return surface;
}

/// Longest edge of the box of all phases.
double extent_mm(const SurfaceCycle& surface) {
  Vec3f low = surface.positions[0][0];
  Vec3f high = low;
  for (const auto& phase : surface.positions) {
    for (const Vec3f& x : phase) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
  }
  return static_cast<double>((high - low).maxCoeff());
}

std::size_t zstd_bytes(const SurfaceCycle& surface) {
  std::string raw(reinterpret_cast<const char*>(surface.triangles.data()),
                  sizeof(surface.triangles[0]) * surface.triangles.size());
  for (const auto& phase : surface.positions) {
    raw.append(reinterpret_cast<const char*>(phase.data()), sizeof(Vec3f) * phase.size());
  }
  std::string out(ZSTD_compressBound(raw.size()), '\0');
  return ZSTD_compress(out.data(), out.size(), raw.data(), raw.size(), 19);
}

void row(const SurfaceCycle& surface, const char* motion, double step_mm) {
  const atlas::SurfacePayload payload{surface.structure, surface.triangles, surface.positions};
  std::clock_t start = std::clock();
  const pack::PackedSurface packed = pack::pack_surface(payload, step_mm);
  const double pack_ms = cpu_ms(start);
  start = std::clock();
  const auto stored = atlas::decode_surface(packed.drc, packed.motion, surface.structure);
  const double decode_ms = cpu_ms(start);
  double squares = 0;
  double most = 0;
  const std::size_t vertices = packed.given.size();
  for (std::size_t p = 0; p < stored.positions.size(); ++p) {
    for (std::size_t v = 0; v < vertices; ++v) {
      const auto error = static_cast<double>(
          (stored.positions[p][v] - surface.positions[p][packed.given[v]]).squaredNorm());
      squares += error;
      most = std::max(most, error);
    }
  }
  const auto samples = static_cast<double>(3 * vertices * stored.positions.size());
  std::printf(
      "| %-14s | %6zu | %2zu | %-8s | %6.4f | %7zu | %7zu | %7zu | %8zu | %5.2f | %5.1f | "
      "%5.1f | %6.0f | %6.0f |\n",
      std::string(structure_name(surface.structure)).c_str(), vertices, stored.positions.size(),
      motion, step_mm, packed.drc.size(), packed.motion.size(),
      packed.drc.size() + packed.motion.size(), zstd_bytes(surface),
      8 * static_cast<double>(packed.drc.size() + packed.motion.size()) / samples,
      1e3 * std::sqrt(squares / samples), 1e3 * std::sqrt(most), pack_ms, decode_ms);
}

}  // namespace
}  // namespace beatlas

int main(int argc, char** argv) {
  using namespace beatlas;
  if (argc != 2) {
    std::cerr << "surface_bench STUDY\n";
    return 2;
  }
  try {
    std::printf(
        "| surface | vertices | phases | motion | step mm | mean surface, bytes | motion | "
        "both | floats, zstd-19 | bits a coordinate | rms um an axis | most um | pack ms | "
        "open ms |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (const SurfaceCycle& surface : study::read_surfaces(argv[1])) {
      const double step_mm = extent_mm(surface) / (1 << 14);
      row(surface, "as it is", step_mm);
      row(smoothed(surface, 4), "4 beats", step_mm);
      row(smoothed(surface, 3), "3 beats", step_mm);
      row(surface, "as it is", atlas::kSurfaceStepMm);
    }
  } catch (const Error& error) {
    std::cerr << "surface_bench: " << error.what() << '\n';
    return static_cast<int>(error.code());
  }
  return 0;
}
