/// The table of surfaces of a cycle: our package, Draco phase by phase, plain floats.
#include <cstring>

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include "pipeline/mesh/mesh.h"
#include "pipeline/pack/pack.h"
#include "runtime/atlas/atlas.h"
#include "runtime/base/error.h"
#include "tests/bench/alternatives.h"
#include "tests/bench/alternatives_files.h"

namespace beatlas::bench {
namespace {

using Positions = std::vector<std::vector<Vec3f>>;

double mb(std::size_t bytes) { return 1e-6 * static_cast<double>(bytes); }

/// Edgebreaker, slowest speed, positions in steps as large as our package's.
std::string draco_encoded(const SurfaceCycle& surface, std::size_t phase, double step_mm) {
  const std::vector<Vec3f>& positions = surface.positions[phase];
  const auto count = static_cast<std::uint32_t>(positions.size());
  draco::Mesh mesh;
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
  const int at = mesh.AddAttribute(position, true, count);
  Vec3f low = positions.front();
  Vec3f high = low;
  for (std::uint32_t v = 0; v < count; ++v) {
    mesh.attribute(at)->SetAttributeValue(draco::AttributeValueIndex(v), positions[v].data());
    low = low.cwiseMin(positions[v]);
    high = high.cwiseMax(positions[v]);
  }
  const int bits = pack::draco_bits((high - low).cast<double>().maxCoeff(), step_mm);
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(0, 0);
  encoder.SetAttributeExplicitQuantization(draco::GeometryAttribute::POSITION, bits, 3, low.data(),
                                           static_cast<float>(step_mm * ((1 << bits) - 1)));
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) {
    throw_invalid("a phase of the heart's surface cannot be coded by Draco");
  }
  return {buffer.data(), buffer.size()};
}

std::vector<Vec3f> draco_decoded(const std::string& bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) throw_invalid("a phase of the heart's surface cannot be decoded by Draco");
  const auto mesh = std::move(decoded).value();
  const draco::PointAttribute& position =
      *mesh->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  std::vector<Vec3f> out(mesh->num_points());
  for (std::uint32_t v = 0; v < mesh->num_points(); ++v) {
    position.GetMappedValue(draco::PointIndex(v), out[v].data());
  }
  return out;
}

DistanceErrors errors_of(const Setting& setting, const Positions& positions) {
  const Affine lps_from_workspace = setting.workspace_from_lps.inverse(Eigen::Isometry);
  std::vector<double> all;
  for (int p = 0; p < setting.phases(); ++p) {
    std::vector<Vec3> lps;
    for (const Vec3f& x : positions[static_cast<std::size_t>(p)]) {
      lps.push_back(lps_from_workspace * x.cast<double>());
    }
    const std::vector<double> found = distances_to_truth(setting, p, lps);
    all.insert(all.end(), found.begin(), found.end());
  }
  return summed_errors(std::move(all));
}

}  // namespace

Table mesh_table(const Setting& setting) {
  constexpr double kStepMm = pack::EncodeOptions{}.surface_step_mm;
  StageContext quiet;
  const SurfaceCycle surface = mesh::mesh_cycle(setting.field, {}, quiet);
  const std::size_t triangle_bytes = 3 * sizeof(std::uint32_t) * surface.triangles.size();
  const std::size_t phase_bytes = sizeof(Vec3f) * surface.positions.front().size();
  const std::size_t phases = surface.positions.size();

  const std::filesystem::path package = setting.work / "surface.beatlas";
  pack::PackageContent content;
  content.manifest = manifest_of(setting, "anatomy");
  content.surfaces.push_back({surface.structure, surface.triangles, surface.positions});
  pack::write_package(package, content);
  const auto open = [&] {
    return atlas::Atlas::open(package, {.fields = {}, .surfaces = {Structure::Heart}})
        .surface(Structure::Heart);
  };

  std::vector<std::filesystem::path> coded;
  std::size_t coded_bytes = 0;
  for (std::size_t p = 0; p < phases; ++p) {
    coded.push_back(setting.work / ("phase" + std::to_string(p) + ".drc"));
    write_file(coded.back(), draco_encoded(surface, p, kStepMm));
    coded_bytes += std::filesystem::file_size(coded.back());
  }
  const auto decode = [&] {
    Positions out;
    for (const std::filesystem::path& file : coded) out.push_back(draco_decoded(read_file(file)));
    return out;
  };

  const std::filesystem::path raw = setting.work / "surface.raw";
  std::string bytes(reinterpret_cast<const char*>(surface.triangles.data()), triangle_bytes);
  for (const std::vector<Vec3f>& each : surface.positions) {
    bytes.append(reinterpret_cast<const char*>(each.data()), phase_bytes);
  }
  write_file(raw, bytes);
  const auto read = [&] {
    const std::string from = read_file(raw);
    Positions out(phases, std::vector<Vec3f>(surface.positions.front().size()));
    for (std::size_t p = 0; p < phases; ++p) {
      std::memcpy(static_cast<void*>(out[p].data()), from.data() + triangle_bytes + p * phase_bytes,
                  phase_bytes);
    }
    return out;
  };

  const auto clocks =
      interleaved(3 * setting.repeats,
                  {[&]() -> std::vector<double> { return {clocked_ms([&] { (void)open(); })}; },
                   [&]() -> std::vector<double> { return {clocked_ms([&] { (void)decode(); })}; },
                   [&]() -> std::vector<double> { return {clocked_ms([&] { (void)read(); })}; }});

  Table out;
  out.key = "mesh";
  out.title = "The heart's surface through the cycle";
  out.note = std::to_string(surface.positions.front().size()) +
             " vertices in each phase, made from the images; Draco in steps of 0.01 mm, as ours, "
             "which stores motion between phases. Loaded from the page cache.";
  out.columns = {{"memory_mb", "memory MB", 2},
                 {"disk_mb", "disk MB", 3},
                 {"load_ms", "load ms", 1},
                 {"mean_mm", "error at vertices, mean mm", 3},
                 {"p95_mm", "p95 mm", 3}};
  const auto add = [&](const std::string& name, std::size_t memory, std::size_t disk, double ms,
                       const Positions& positions) {
    const DistanceErrors errors = errors_of(setting, positions);
    out.rows.push_back({name, {mb(memory), mb(disk), ms, errors.mean_mm, errors.p95_mm}});
  };
  const std::size_t one_connectivity = triangle_bytes + phases * phase_bytes;
  add("beatlas package", one_connectivity, std::filesystem::file_size(package), clocks[0][0],
      open()->positions);
  add("Draco, each phase", phases * (triangle_bytes + phase_bytes), coded_bytes, clocks[1][0],
      decode());
  add("plain floats, one connectivity", one_connectivity, bytes.size(), clocks[2][0], read());
  return out;
}

}  // namespace beatlas::bench
