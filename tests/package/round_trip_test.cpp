#include <algorithm>
#include <chrono>

#include <gtest/gtest.h>

#include "pipeline/pack/payload_encoders.h"
#include "runtime/atlas/atlas.h"
#include "runtime/atlas/field_payload.h"
#include "runtime/atlas/surface_payload.h"
#include "tests/package/sample_package.h"

namespace beatlas {
namespace {
TEST(Probe, Size) {
  for (double voxel : {1.5, 1.0}) {
    const auto field = test::beating_field(Structure::Heart, 53.5, 6, 15, voxel);
    const auto t0 = std::chrono::steady_clock::now();
    const auto bytes = pack::pack_field(field);
    const auto t1 = std::chrono::steady_clock::now();
    const auto back = atlas::decode_field(bytes, Structure::Heart);
    const auto t2 = std::chrono::steady_clock::now();
    std::printf("voxel %.1f samples %zu raw %zu packed %zu enc %.0f ms dec %.1f ms eq %d\n", voxel,
                field.coefficients.size() / 15, field.coefficients.size() * 2, bytes.size(),
                std::chrono::duration<double, std::milli>(t1 - t0).count(),
                std::chrono::duration<double, std::milli>(t2 - t1).count(),
                back.coefficients == field.coefficients);
  }
  const auto surface = test::beating_surface(Structure::Heart, 53.5, 6, 15, 6);
  const auto t0 = std::chrono::steady_clock::now();
  const auto bytes = pack::pack_surface(surface);
  const auto t1 = std::chrono::steady_clock::now();
  const auto back = atlas::decode_surface(bytes.drc, bytes.motion, Structure::Heart);
  const auto t2 = std::chrono::steady_clock::now();
  std::printf("vertices %zu drc %zu motion %zu enc %.0f dec %.1f\n", surface.positions[0].size(),
              bytes.drc.size(), bytes.motion.size(),
              std::chrono::duration<double, std::milli>(t1 - t0).count(),
              std::chrono::duration<double, std::milli>(t2 - t1).count());
}
}  // namespace
}  // namespace beatlas
