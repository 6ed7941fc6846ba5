#include "runtime/atlas/surface_payload.h"

#include <cmath>

#include "runtime/atlas/manifest.h"
#include "runtime/atlas/residual.h"
#include "runtime/atlas/zstd_frame.h"

namespace beatlas::atlas {
namespace {

constexpr float kMaxPositionMm = 1e5F;

void require(bool ok, const std::string& what) {
  if (!ok) throw_invalid("surface " + what + "; build the package again");
}

}  // namespace

VertexPredictor::VertexPredictor(const std::vector<std::array<std::uint32_t, 3>>& triangles,
                                 std::size_t vertex_count)
    : first_(vertex_count + 1, 0) {
  // Each edge of a closed surface runs once in each direction: one of the two is taken.
  const auto for_each_lower = [&triangles](auto&& body) {
    for (const auto& triangle : triangles) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t from = triangle[corner];
        const std::uint32_t to = triangle[(corner + 1) % 3];
        if (to < from) body(from, to);
      }
    }
  };
  for_each_lower([this](std::uint32_t from, std::uint32_t) { ++first_[from + 1]; });
  for (std::size_t v = 0; v < vertex_count; ++v) first_[v + 1] += first_[v];
  neighbours_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for_each_lower([&](std::uint32_t from, std::uint32_t to) { neighbours_[next[from]++] = to; });
}

std::int32_t VertexPredictor::predict(std::size_t vertex,
                                      const std::vector<std::int32_t>& values) const noexcept {
  const std::uint32_t begin = first_[vertex];
  const std::uint32_t end = first_[vertex + 1];
  if (begin == end) return 0;
  std::int64_t sum = 0;
  for (std::uint32_t n = begin; n < end; ++n) sum += values[neighbours_[n]];
  return static_cast<std::int32_t>(sum / static_cast<std::int64_t>(end - begin));
}

void check_surface(const SurfacePayload& surface) {
  require(!surface.positions.empty() && !surface.positions.front().empty() &&
              !surface.triangles.empty(),
          "is empty");
  require(surface.positions.size() <= static_cast<std::size_t>(kMaxPhases), "has too many phases");
  require(surface.triangles.size() <= kMaxTriangles, "has too many triangles");
  const std::size_t vertices = surface.positions.front().size();
  require(vertices <= 3 * surface.triangles.size(), "has a vertex that no triangle uses");
  for (const auto& phase : surface.positions) {
    require(phase.size() == vertices, "has phases of different vertex counts");
    for (const Vec3f& position : phase) {
      require((position.array().abs() <= kMaxPositionMm).all(), "has a vertex at no finite place");
    }
  }
  std::vector<bool> used(vertices, false);
  for (const auto& [a, b, c] : surface.triangles) {
    require(a < vertices && b < vertices && c < vertices, "has a triangle of unknown vertices");
    require(a != b && b != c && c != a, "has a triangle that uses a vertex twice");
    used[a] = used[b] = used[c] = true;
  }
  for (bool is_used : used) require(is_used, "has a vertex that no triangle uses");
}

SurfacePayload decode_surface(ByteView drc, ByteView motion, Structure structure) {
  const Bytes bytes = zstd_unpack(motion);
  ByteReader reader(bytes);
  reader.expect_magic(kMotionMagic);
  require(reader.get<std::uint32_t>() == kMotionVersion, "motion is of an unknown version");
  const auto vertices = reader.get<std::uint32_t>();
  const auto triangles = reader.get<std::uint32_t>();
  const auto phases = reader.get<std::uint32_t>();
  const auto step_mm = reader.get<double>();
  require(phases >= 1 && phases <= static_cast<std::uint32_t>(kMaxPhases),
          "has a phase count out of range");
  require(step_mm >= 1e-6 && step_mm <= 10, "motion has a step out of range");
  const std::uint64_t counts = std::uint64_t{phases - 1} * 3 * vertices;  // < 2^10 * 3 * 2^32
  require(reader.remaining() == 2 * counts, "motion has counts that its size contradicts");

  SurfacePayload surface;
  surface.structure = structure;
  BaseSurface base = decode_base(drc, vertices, triangles);
  surface.triangles = std::move(base.triangles);
  surface.positions.assign(phases, base.positions);

  const ByteView low = reader.take(static_cast<std::size_t>(counts));
  const ByteView high = reader.take(static_cast<std::size_t>(counts));
  const VertexPredictor predictor(surface.triangles, vertices);
  std::array<std::vector<std::int32_t>, 3> count;
  count.fill(std::vector<std::int32_t>(vertices, 0));
  std::vector<std::int32_t> difference(vertices, 0);
  std::size_t at = 0;
  for (std::size_t phase = 1; phase < phases; ++phase) {
    for (int axis = 0; axis < 3; ++axis) {
      auto& along = count[static_cast<std::size_t>(axis)];
      for (std::size_t v = 0; v < vertices; ++v, ++at) {
        const auto code = static_cast<std::uint16_t>(std::to_integer<unsigned>(low[at]) |
                                                     std::to_integer<unsigned>(high[at]) << 8);
        const std::int32_t sum = predictor.predict(v, difference) + unzigzag(code);
        difference[v] = static_cast<std::int16_t>(static_cast<std::uint16_t>(sum));
        along[v] = static_cast<std::int16_t>(static_cast<std::uint16_t>(along[v] + difference[v]));
        surface.positions[phase][v][axis] =
            static_cast<float>(base.positions[v][axis] + step_mm * along[v]);
      }
    }
  }
  check_surface(surface);
  return surface;
}

}  // namespace beatlas::atlas
