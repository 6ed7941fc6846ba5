#include "pipeline/formats/gltf.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include <nlohmann/json.hpp>

#include "runtime/atlas/structure_colours.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

using nlohmann::json;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// Numbers of the glTF 2.0 specification, sections 3.6 and 4.
constexpr int kFloat = 5126;
constexpr int kUnsignedInt = 5125;
constexpr int kVertices = 34962;
constexpr int kIndices = 34963;
constexpr std::uint32_t kMagic = 0x46546C67;
constexpr std::uint32_t kVersion = 2;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;

/// The binary chunk, and the accessors that say what lies in it.
class Buffer {
 public:
  /// @return the accessor's index, as the others
  int add_vectors(const std::vector<Vec3f>& vectors, bool with_bounds) {
    json accessor = view_of(vectors.data(), vectors.size(), kVertices);
    accessor["componentType"] = kFloat;
    accessor["type"] = "VEC3";
    if (with_bounds) {
      Vec3f low = vectors.front();
      Vec3f high = vectors.front();
      for (const Vec3f& vector : vectors) {
        low = low.cwiseMin(vector);
        high = high.cwiseMax(vector);
      }
      accessor["min"] = {low.x(), low.y(), low.z()};
      accessor["max"] = {high.x(), high.y(), high.z()};
    }
    return add(std::move(accessor));
  }
  int add_triangles(const Triangles& triangles) {
    json accessor = view_of(triangles.data(), triangles.size(), kIndices);
    accessor["count"] = 3 * triangles.size();
    accessor["componentType"] = kUnsignedInt;
    accessor["type"] = "SCALAR";
    return add(std::move(accessor));
  }
  int add_numbers(const std::vector<float>& numbers, bool with_bounds) {
    json accessor = view_of(numbers.data(), numbers.size(), 0);
    accessor["componentType"] = kFloat;
    accessor["type"] = "SCALAR";
    if (with_bounds) {
      accessor["min"] = json::array({numbers.front()});
      accessor["max"] = json::array({numbers.back()});  // ascending
    }
    return add(std::move(accessor));
  }

  [[nodiscard]] const atlas::Bytes& bytes() const { return bytes_; }
  [[nodiscard]] json take_accessors() { return std::move(accessors_); }
  [[nodiscard]] json take_views() { return std::move(views_); }

 private:
  template <class T>
  json view_of(const T* values, std::size_t count, int target) {
    static_assert(sizeof(T) % 4 == 0);  // so that the next view is aligned too
    const std::size_t size = count * sizeof(T);
    json view{{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}};
    if (target != 0) view["target"] = target;
    views_.push_back(std::move(view));
    const auto* first = reinterpret_cast<const std::byte*>(values);
    bytes_.insert(bytes_.end(), first, first + size);
    return {{"bufferView", views_.size() - 1}, {"count", count}};
  }
  int add(json accessor) {
    accessors_.push_back(std::move(accessor));
    return static_cast<int>(accessors_.size()) - 1;
  }

  atlas::Bytes bytes_;
  json views_ = json::array();
  json accessors_ = json::array();
};

/// At the vertices: the mean of the triangles' normals, by area.
std::vector<Vec3f> normals_of(const Triangles& triangles, const std::vector<Vec3f>& positions) {
  std::vector<Vec3f> normals(positions.size(), Vec3f::Zero());
  for (const auto& [a, b, c] : triangles) {
    const Vec3f area = (positions[b] - positions[a]).cross(positions[c] - positions[a]);
    for (const std::uint32_t corner : {a, b, c}) normals[corner] += area;
  }
  for (Vec3f& normal : normals) {
    const float length = normal.norm();
    normal = length > 0 ? Vec3f(normal / length) : Vec3f(0, 0, 1);  // the format wants unit length
  }
  return normals;
}

std::vector<Vec3f> differences(const std::vector<Vec3f>& from, const std::vector<Vec3f>& to) {
  std::vector<Vec3f> out(from.size());
  for (std::size_t v = 0; v < from.size(); ++v) out[v] = to[v] - from[v];
  return out;
}

/// Of the linear light that the format wants; what encloses others lets them be seen.
json material_of(Structure structure) {
  const auto linear = [](std::uint8_t value) {
    const double s = value / 255.0;
    return s > 0.04045 ? std::pow((s + 0.055) / 1.055, 2.4) : s / 12.92;
  };
  const Colour colour = structure_colour(structure);
  const double alpha = structure == Structure::Heart          ? 0.35
                       : structure == Structure::LvMyocardium ? 0.5
                                                              : 1;
  json out{{"name", structure_name(structure)},
           {"pbrMetallicRoughness",
            {{"baseColorFactor", {linear(colour[0]), linear(colour[1]), linear(colour[2]), alpha}},
             {"metallicFactor", 0.0},
             {"roughnessFactor", 0.55}}}};
  if (alpha < 1) out["alphaMode"] = "BLEND";
  return out;
}

json mesh_of(const atlas::SurfacePayload& surface, std::size_t material, Buffer& buffer) {
  const std::vector<Vec3f>& first = surface.positions.front();
  const std::vector<Vec3f> normals = normals_of(surface.triangles, first);
  json primitive{{"attributes",
                  {{"POSITION", buffer.add_vectors(first, true)},
                   {"NORMAL", buffer.add_vectors(normals, false)}}},
                 {"indices", buffer.add_triangles(surface.triangles)},
                 {"material", material}};
  json mesh{{"name", structure_name(surface.structure)}};
  json names = json::array();
  for (std::size_t p = 1; p < surface.positions.size(); ++p) {
    const std::vector<Vec3f>& here = surface.positions[p];
    primitive["targets"].push_back(
        {{"POSITION", buffer.add_vectors(differences(first, here), true)},
         {"NORMAL",
          buffer.add_vectors(differences(normals, normals_of(surface.triangles, here)), false)}});
    names.push_back("phase " + std::to_string(p));
  }
  if (!names.empty()) {
    mesh["weights"] = std::vector<double>(names.size(), 0.0);
    mesh["extras"] = {{"targetNames", std::move(names)}};
  }
  mesh["primitives"] = json::array({std::move(primitive)});
  return mesh;
}

/// Key p, of `phases` + 1, has weight 1 on the target of phase p; the first and the last on none.
json animation_of(std::size_t phases, double rr_interval_s, std::size_t nodes, Buffer& buffer) {
  const std::size_t targets = phases - 1;
  std::vector<float> times;
  std::vector<float> weights((phases + 1) * targets, 0.0F);
  for (std::size_t key = 0; key <= phases; ++key) {
    times.push_back(
        static_cast<float>(rr_interval_s * static_cast<double>(key) / static_cast<double>(phases)));
    if (key > 0 && key < phases) weights[key * targets + key - 1] = 1;
  }
  const int input = buffer.add_numbers(times, true);
  const int output = buffer.add_numbers(weights, false);
  json channels = json::array();
  for (std::size_t node = 1; node <= nodes; ++node) {
    channels.push_back({{"sampler", 0}, {"target", {{"node", node}, {"path", "weights"}}}});
  }
  return {{"name", "beat"},
          {"samplers", {{{"input", input}, {"output", output}, {"interpolation", "LINEAR"}}}},
          {"channels", std::move(channels)}};
}

/// Column by column, as glTF writes matrices.
json root_matrix(const Affine& workspace_from_lps) {
  constexpr double kMetresAMillimetre = 1e-3;
  Eigen::Matrix3d up_from_lps;  // left, posterior, superior -> left, superior, anterior
  up_from_lps << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  Affine root = workspace_from_lps.inverse();
  root.linear() = kMetresAMillimetre * up_from_lps * root.linear();
  root.translation() =
      kMetresAMillimetre * up_from_lps * workspace_from_lps.inverse().translation();
  json out = json::array();
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) out.push_back(root.matrix()(row, column));
  }
  return out;
}

atlas::Bytes assemble(std::string text, const atlas::Bytes& binary) {
  constexpr std::size_t kHeader = 12;
  constexpr std::size_t kChunkHeader = 8;
  while (text.size() % 4 != 0) text += ' ';
  const std::size_t total = kHeader + 2 * kChunkHeader + text.size() + binary.size();
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    throw_invalid("the surfaces take more than 4 GiB as glTF; build them with longer edges");
  }
  atlas::ByteWriter writer;
  for (const std::uint32_t word : {kMagic, kVersion, static_cast<std::uint32_t>(total),
                                   static_cast<std::uint32_t>(text.size()), kJsonChunk}) {
    writer.put(word);
  }
  writer.put_text(text);
  writer.put(static_cast<std::uint32_t>(binary.size()));
  writer.put(kBinaryChunk);
  writer.put_many(binary.data(), binary.size());
  return writer.take();
}

}  // namespace

atlas::Bytes gltf_binary(const std::vector<std::shared_ptr<const atlas::SurfacePayload>>& surfaces,
                         const GltfPlacement& placement) {
  if (surfaces.empty()) throw_invalid("there is no surface to export");
  const std::size_t phases = surfaces.front()->positions.size();
  Buffer buffer;
  json nodes = json::array(
      {{{"name", "heart in metres"}, {"matrix", root_matrix(placement.workspace_from_lps)}}});
  json meshes = json::array();
  json materials = json::array();
  for (const auto& surface : surfaces) {
    if (surface->positions.size() != phases || phases == 0) {
      throw_invalid("the surfaces differ in their phases; build them again");
    }
    meshes.push_back(mesh_of(*surface, materials.size(), buffer));
    materials.push_back(material_of(surface->structure));
    nodes.front()["children"].push_back(nodes.size());
    nodes.push_back({{"name", structure_name(surface->structure)}, {"mesh", meshes.size() - 1}});
  }
  json document{{"asset", {{"version", "2.0"}, {"generator", "beatlas"}}},
                {"scene", 0},
                {"scenes", json::array({{{"nodes", json::array({0})}}})},
                {"nodes", std::move(nodes)},
                {"meshes", std::move(meshes)},
                {"materials", std::move(materials)}};
  if (phases > 1) {
    document["animations"] =
        json::array({animation_of(phases, placement.rr_interval_s, surfaces.size(), buffer)});
  }
  document["buffers"] = json::array({{{"byteLength", buffer.bytes().size()}}});
  document["bufferViews"] = buffer.take_views();
  document["accessors"] = buffer.take_accessors();
  return assemble(document.dump(), buffer.bytes());
}

}  // namespace beatlas::formats
