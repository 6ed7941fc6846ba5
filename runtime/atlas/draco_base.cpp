#include <exception>

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

#include "runtime/atlas/surface_payload.h"

namespace beatlas::atlas {
namespace {

[[noreturn]] void fail() {
  throw_invalid("the Draco surface is damaged or of another kind; build the package again");
}

std::uint64_t varint(ByteReader& reader) {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 35; shift += 7) {
    const auto byte = reader.get<std::uint8_t>();
    value |= std::uint64_t{byte & 0x7FU} << shift;
    if ((byte & 0x80U) == 0) return value;
  }
  fail();
}

/// Draco allocates for the counts in its header before it has seen a triangle, so they are compared
/// with those that are already known to be plausible. Metadata, which it reads recursively, is
/// refused.
void check_header(ByteView drc, std::uint32_t triangles) {
  constexpr std::uint8_t kTriangularMesh = 1;
  constexpr std::uint8_t kEdgebreaker = 1;
  ByteReader reader(drc);
  reader.expect_magic("DRACO");
  const auto major = reader.get<std::uint8_t>();
  const auto minor = reader.get<std::uint8_t>();
  const auto type = reader.get<std::uint8_t>();
  const auto method = reader.get<std::uint8_t>();
  const auto flags = reader.get<std::uint16_t>();
  if (major != 2 || minor != 2 || type != kTriangularMesh || method != kEdgebreaker || flags != 0) {
    fail();
  }
  (void)reader.get<std::uint8_t>();  // traversal
  const std::uint64_t corner_vertices = varint(reader);
  const std::uint64_t faces = varint(reader);
  if (faces != triangles || corner_vertices > 3 * faces) fail();
}

}  // namespace

BaseSurface decode_base(ByteView drc, std::uint64_t points, std::uint32_t triangles) {
  // A triangle of a closed surface takes more than a bit; 32 to a byte is out of reach.
  constexpr std::uint64_t kTrianglesPerByte = 32;
  if (triangles == 0 || points == 0 || triangles > kMaxTriangles ||
      triangles > kTrianglesPerByte * drc.size() || points > 3 * std::uint64_t{triangles}) {
    fail();
  }
  check_header(drc, triangles);
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(drc.data()), drc.size());
  std::unique_ptr<draco::Mesh> mesh;
  try {
    auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) fail();
    mesh = std::move(decoded).value();
  } catch (const Error&) {
    throw;
  } catch (const std::exception&) {
    fail();
  }
  const draco::PointAttribute* position =
      mesh->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (mesh->num_attributes() != 1 || position == nullptr ||
      position->data_type() != draco::DT_FLOAT32 || position->num_components() != 3 ||
      mesh->num_faces() != triangles || mesh->num_points() != points) {
    fail();
  }

  BaseSurface base;
  base.positions.resize(static_cast<std::size_t>(points));
  for (draco::PointIndex point(0); point < mesh->num_points(); ++point) {
    const draco::AttributeValueIndex position_at = position->mapped_index(point);
    if (position_at >= static_cast<std::uint32_t>(position->size())) fail();
    position->GetValue(position_at, base.positions[point.value()].data());
    if (!base.positions[point.value()].allFinite()) fail();
  }
  base.triangles.reserve(triangles);
  for (draco::FaceIndex face(0); face < mesh->num_faces(); ++face) {
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const draco::PointIndex point = mesh->face(face)[corner];
      if (point >= mesh->num_points()) fail();
      triangle[corner] = point.value();
    }
    base.triangles.push_back(triangle);
  }
  return base;
}

BaseSurface join_points(BaseSurface points, const JoinedPoints& joined) {
  if (joined.empty()) return points;
  std::vector<std::uint32_t> vertex_of(points.positions.size());
  std::vector<Vec3f> positions;
  std::size_t next = 0;
  for (std::uint32_t point = 0; point < vertex_of.size(); ++point) {
    if (next == joined.size() || joined[next][0] != point) {
      vertex_of[point] = static_cast<std::uint32_t>(positions.size());
      positions.push_back(points.positions[point]);
      continue;
    }
    const std::uint32_t other = joined[next++][1];
    if (other >= point || points.positions[other] != points.positions[point]) fail();
    vertex_of[point] = vertex_of[other];
  }
  if (next != joined.size()) fail();
  points.positions = std::move(positions);
  for (auto& triangle : points.triangles) {
    for (std::uint32_t& corner : triangle) corner = vertex_of[corner];
  }
  return points;
}

}  // namespace beatlas::atlas
