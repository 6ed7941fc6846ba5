#include <algorithm>
#include <cmath>

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include "pipeline/pack/pack.h"
#include "pipeline/pack/payload_encoders.h"
#include "runtime/atlas/residual.h"
#include "runtime/atlas/surface_payload.h"
#include "runtime/base/error.h"

namespace beatlas::pack {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

[[noreturn]] void refuse(const atlas::SurfacePayload& surface, const std::string& why) {
  throw_invalid("the surface of " + std::string(structure_name(surface.structure)) + " " + why);
}

void fill_mesh(const atlas::SurfacePayload& surface, draco::Mesh& mesh) {
  const std::vector<Vec3f>& positions = surface.positions.front();
  const auto count = static_cast<std::uint32_t>(positions.size());
  mesh.set_num_points(count);
  mesh.SetNumFaces(surface.triangles.size());
  for (std::uint32_t f = 0; f < surface.triangles.size(); ++f) {
    const auto& [a, b, c] = surface.triangles[f];
    mesh.SetFace(draco::FaceIndex(f),
                 {draco::PointIndex(a), draco::PointIndex(b), draco::PointIndex(c)});
  }
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false,
                3 * sizeof(float), 0);
  draco::GeometryAttribute id;
  id.Init(draco::GeometryAttribute::GENERIC, nullptr, 1, draco::DT_UINT32, false,
          sizeof(std::uint32_t), 0);
  const int position_at = mesh.AddAttribute(position, true, count);
  const int id_at = mesh.AddAttribute(id, true, count);
  for (std::uint32_t v = 0; v < count; ++v) {
    const draco::AttributeValueIndex index(v);
    mesh.attribute(position_at)->SetAttributeValue(index, positions[v].data());
    mesh.attribute(id_at)->SetAttributeValue(index, &v);
  }
}

atlas::Bytes encode_base(const atlas::SurfacePayload& surface, double step_mm) {
  const std::vector<Vec3f>& positions = surface.positions.front();
  Vec3f low = positions.front();
  Vec3f high = positions.front();
  for (const Vec3f& position : positions) {
    low = low.cwiseMin(position);
    high = high.cwiseMax(position);
  }
  const double extent_mm = (high - low).cast<double>().maxCoeff();
  const int bits = draco_bits(extent_mm, step_mm);
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(0, 0);
  encoder.SetAttributeExplicitQuantization(draco::GeometryAttribute::POSITION, bits, 3, low.data(),
                                           static_cast<float>(step_mm * ((1 << bits) - 1)));
  // Ids jump: any prediction from more than one neighbour only adds their jumps up.
  encoder.SetAttributePredictionScheme(draco::GeometryAttribute::GENERIC,
                                       draco::PREDICTION_DIFFERENCE);
  draco::Mesh mesh;
  fill_mesh(surface, mesh);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) {
    refuse(surface, "cannot be coded by Draco; check that it is a closed manifold");
  }
  const auto* first = reinterpret_cast<const std::byte*>(buffer.data());
  return {first, first + buffer.size()};
}

/// Each triangle turned so that its smallest vertex is first, in order.
std::vector<Triangle> sorted(std::vector<Triangle> triangles) {
  for (Triangle& triangle : triangles) {
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                triangle.end());
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// Counts of steps from the decoded first phase.
std::int16_t displacement(const atlas::SurfacePayload& surface, float to, float from,
                          double step_mm) {
  const double count = std::round((static_cast<double>(to) - static_cast<double>(from)) / step_mm);
  if (std::abs(count) > INT16_MAX) {
    refuse(surface, "moves by more than " + std::to_string(static_cast<int>(INT16_MAX * step_mm)) +
                        " mm; check its phases");
  }
  return static_cast<std::int16_t>(count);
}

atlas::Bytes encode_motion(const atlas::SurfacePayload& surface, const atlas::BaseSurface& base,
                           double step_mm) {
  const std::size_t vertices = base.positions.size();
  const std::size_t phases = surface.positions.size();
  atlas::ByteWriter writer;
  writer.put_text(atlas::kMotionMagic);
  writer.put(atlas::kMotionVersion);
  writer.put(static_cast<std::uint32_t>(vertices));
  writer.put(static_cast<std::uint32_t>(base.triangles.size()));
  writer.put(static_cast<std::uint32_t>(phases));
  writer.put(step_mm);

  const atlas::VertexPredictor predictor(base.triangles, vertices);
  std::array<std::vector<std::int16_t>, 3> before;
  before.fill(std::vector<std::int16_t>(vertices, 0));
  std::vector<std::int32_t> difference(vertices, 0);
  std::vector<std::uint8_t> low;
  std::vector<std::uint8_t> high;
  for (std::size_t phase = 1; phase < phases; ++phase) {
    for (int axis = 0; axis < 3; ++axis) {
      for (std::size_t v = 0; v < vertices; ++v) {
        const std::int16_t count = displacement(surface, surface.positions[phase][v][axis],
                                                base.positions[v][axis], step_mm);
        std::int16_t& last = before[static_cast<std::size_t>(axis)][v];
        difference[v] = static_cast<std::int16_t>(static_cast<std::uint16_t>(count - last));
        last = count;
        const std::uint16_t code = atlas::zigzag(
            static_cast<std::uint16_t>(difference[v] - predictor.predict(v, difference)));
        low.push_back(static_cast<std::uint8_t>(code & 0xFFU));
        high.push_back(static_cast<std::uint8_t>(code >> 8U));
      }
    }
  }
  writer.put_many(low.data(), low.size());
  writer.put_many(high.data(), high.size());
  return zstd_pack(writer.take());
}

double largest_error_mm(const atlas::SurfacePayload& given, const atlas::SurfacePayload& stored) {
  double largest = 0;
  for (std::size_t phase = 0; phase < given.positions.size(); ++phase) {
    for (std::size_t v = 0; v < given.positions[phase].size(); ++v) {
      const Vec3 error =
          given.positions[phase][v].cast<double>() - stored.positions[phase][v].cast<double>();
      largest = std::max(largest, error.norm());
    }
  }
  return largest;
}

}  // namespace

int draco_bits(double extent_mm, double surface_step_mm) {
  int bits = 1;  // positions are within 1e5 mm: at most 27
  while (surface_step_mm * ((1 << bits) - 1) < extent_mm) ++bits;
  return bits;
}

PackedSurface pack_surface(const atlas::SurfacePayload& surface, double step_mm) {
  if (!(step_mm >= 0.002 && step_mm <= 0.5)) {
    throw Error(ErrorCode::Usage, "surface_step_mm must be from 0.002 to 0.5 mm");
  }
  atlas::check_surface(surface);
  PackedSurface packed;
  packed.drc = encode_base(surface, step_mm);
  // What the reader will see: Draco drops or splits what is no manifold, and that must not pass.
  const auto base = [&] {
    try {
      return atlas::decode_base(packed.drc,
                                static_cast<std::uint32_t>(surface.positions.front().size()),
                                static_cast<std::uint32_t>(surface.triangles.size()));
    } catch (const Error&) {
      refuse(surface, "is changed by Draco; check that it is a closed manifold");
    }
  }();
  if (sorted(base.triangles) != sorted(surface.triangles)) {
    refuse(surface, "is changed by Draco; check that it is a closed manifold");
  }
  packed.motion = encode_motion(surface, base, step_mm);
  if (!(largest_error_mm(surface, atlas::decode_surface(packed.drc, packed.motion,
                                                        surface.structure)) <= step_mm)) {
    refuse(surface, "cannot be stored within its step; check that it lies near the workspace");
  }
  return packed;
}

}  // namespace beatlas::pack
