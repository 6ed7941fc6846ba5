#include "runtime/atlas/surface_payload.h"

#include <algorithm>
#include <cmath>

#include <draco/compression/entropy/symbol_decoding.h>

#include "runtime/atlas/manifest.h"
#include "runtime/atlas/payload_check.h"
#include "runtime/atlas/surface_classes.h"
#include "runtime/atlas/surface_order.h"
#include "runtime/atlas/zstd_frame.h"
#include "runtime/base/cycle_modes.h"

namespace beatlas::atlas {
namespace {

constexpr float kMaxPositionMm = 1e5F;
constexpr std::uint16_t kDracoVersion = 0x0202;  // bitstream 2.2

/// Counts of the classes, each front to back.
class CountReader {
 public:
  /// Takes all that is left of `reader`. @param total of all classes together
  CountReader(ByteReader& reader, std::uint64_t total) {
    std::array<std::uint32_t, kMotionClasses> counts{};
    reader.get_many(counts.data(), counts.size());
    std::uint64_t sum = 0;
    for (const std::uint32_t count : counts) sum += count;
    require(sum == total, "surface motion has counts that its size contradicts");
    const ByteView rest = reader.take(reader.remaining());
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(rest.data()), rest.size(), kDracoVersion);
    for (std::size_t n = 0; n < counts.size(); ++n) {
      if (counts[n] == 0) continue;
      codes_[n].resize(counts[n]);
      bool sound = false;
      try {
        sound = draco::DecodeSymbols(counts[n], 1, &buffer, codes_[n].data());
      } catch (const std::exception&) {  // a size that its own decoder refuses
      }
      require(sound, "surface motion is damaged");
    }
    require(buffer.remaining_size() == 0, "surface motion is longer than it says");
  }

  [[nodiscard]] std::int64_t next(std::size_t of_class) {
    std::vector<std::uint32_t>& codes = codes_[of_class];
    require(at_[of_class] < codes.size(),
            "surface motion has counts in another class than it says");
    const std::uint32_t code = codes[at_[of_class]++];
    return static_cast<std::int64_t>(code >> 1U) ^ -static_cast<std::int64_t>(code & 1U);
  }

 private:
  std::array<std::vector<std::uint32_t>, kMotionClasses> codes_;
  std::array<std::size_t, kMotionClasses> at_{};
};

struct MotionHeader {
  std::uint32_t vertices = 0;
  std::uint32_t triangles = 0;
  std::uint32_t phases = 0;
  double step_mm = 0;
  JoinedPoints joined;
  std::vector<std::uint16_t> scales;
};

MotionHeader read_header(ByteReader& reader) {
  MotionHeader out;
  reader.expect_magic(kMotionMagic);
  require(reader.get<std::uint32_t>() == kMotionVersion, "surface motion is of an unknown version");
  out.vertices = reader.get<std::uint32_t>();
  out.triangles = reader.get<std::uint32_t>();
  out.phases = reader.get<std::uint32_t>();
  const auto joined = reader.get<std::uint32_t>();
  out.step_mm = reader.get<double>();
  require(out.phases >= 1 && out.phases <= static_cast<std::uint32_t>(kMaxPhases),
          "surface has a phase count out of range");
  require(out.step_mm >= 1e-6 && out.step_mm <= 10, "surface motion has a step out of range");
  require(joined <= reader.remaining() / sizeof(JoinedPoints::value_type),
          "surface motion has counts that its size contradicts");
  out.joined.resize(joined);
  reader.get_many(out.joined.data(), out.joined.size());
  out.scales.resize(kMotionKinds * (out.phases - 1));
  reader.get_many(out.scales.data(), out.scales.size());
  for (const std::uint16_t scale : out.scales)
    require(scale > 0, "surface motion has a scale of 0");
  return out;
}

}  // namespace

MotionBasis::MotionBasis(int phases)
    : phases_(static_cast<std::size_t>(phases)), weights_(cycle_modes(phases)) {}

Vec3f MotionBasis::at(const Vec3f& mean_mm, const Vec3* terms, int phase) const noexcept {
  const double* weight = weights_.data() + phases_ + phase;
  Vec3 sum = mean_mm.cast<double>();
  for (std::size_t n = 0; n + 1 < phases_; ++n) sum += weight[n * phases_] * terms[n];
  return sum.cast<float>();
}

void MotionBasis::analyse(const Vec3* displacement_mm, Vec3* terms) const noexcept {
  for (std::size_t n = 0; n + 1 < phases_; ++n) {
    const double* weight = weights_.data() + (n + 1) * phases_;
    terms[n].setZero();
    for (std::size_t p = 0; p < phases_; ++p) terms[n] += weight[p] * displacement_mm[p];
  }
}

void check_surface(const SurfacePayload& surface) {
  require(!surface.positions.empty() && !surface.positions.front().empty() &&
              !surface.triangles.empty(),
          "surface is empty");
  require(surface.positions.size() <= static_cast<std::size_t>(kMaxPhases),
          "surface has too many phases");
  require(surface.triangles.size() <= kMaxTriangles, "surface has too many triangles");
  const std::size_t vertices = surface.positions.front().size();
  require(vertices <= 3 * surface.triangles.size(), "surface has a vertex that no triangle uses");
  for (const auto& phase : surface.positions) {
    require(phase.size() == vertices, "surface has phases of different vertex counts");
    for (const Vec3f& position : phase) {
      require((position.array().abs() <= kMaxPositionMm).all(),
              "surface has a vertex at no finite place");
    }
  }
  std::vector<bool> used(vertices, false);
  for (const auto& [a, b, c] : surface.triangles) {
    require(a < vertices && b < vertices && c < vertices,
            "surface has a triangle of unknown vertices");
    require(a != b && b != c && c != a, "surface has a triangle that uses a vertex twice");
    used[a] = used[b] = used[c] = true;
  }
  for (bool is_used : used) require(is_used, "surface has a vertex that no triangle uses");
}

SurfacePayload decode_surface(ByteView drc, ByteView motion, Structure structure) {
  ByteReader reader(motion);
  const MotionHeader header = read_header(reader);
  const std::size_t phases = header.phases;
  const std::size_t modes = phases - 1;
  const std::uint64_t vertices = header.vertices;
  // < 2^32 * 2^10 * 2^6
  require(vertices * (phases * sizeof(Vec3f) + modes * 3 * sizeof(std::uint32_t)) <=
              plausible_bytes(drc.size() + motion.size()),
          "surface claims more positions than are plausible for its size");
  const BaseSurface base = join_points(
      decode_base(drc, vertices + header.joined.size(), header.triangles), header.joined);
  CountReader counts(reader, vertices * modes * 3);

  SurfacePayload surface;
  surface.structure = structure;
  surface.triangles = base.triangles;
  surface.positions.assign(phases, base.positions);
  if (modes > 0) {
    const SurfaceOrder order(base.triangles, base.positions);
    MotionClasses classes(header.scales, base.positions.size());
    const MotionBasis basis(static_cast<int>(phases));
    std::vector<Vec3> terms(modes * base.positions.size());
    for (const std::uint32_t v : order.vertices()) {
      const auto known = order.known(v);
      const std::vector<double> weights = order.weights(v);
      const Eigen::Matrix3d frame = order.frame(v) * header.step_mm;
      Vec3* own = terms.data() + modes * v;
      std::fill_n(own, modes, Vec3::Zero());
      classes.begin(v, known);
      for (std::size_t n = 0; n < known.size(); ++n) {
        const Vec3* other = terms.data() + modes * known[n];
        for (std::size_t mode = 0; mode < modes; ++mode) own[mode] += weights[n] * other[mode];
      }
      for (std::size_t slot = 0; slot < classes.slots(); ++slot) {
        const std::int64_t count = counts.next(classes.of(slot));
        classes.add(slot, count);
        if (count == 0) continue;
        own[slot / 3] +=
            static_cast<double>(count) * frame.row(static_cast<Eigen::Index>(slot % 3)).transpose();
      }
      for (std::size_t p = 0; p < phases; ++p) {
        surface.positions[p][v] = basis.at(base.positions[v], own, static_cast<int>(p));
      }
    }
  }
  check_surface(surface);
  return surface;
}

}  // namespace beatlas::atlas
