#include "tests/package/sample_package.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include <stdlib.h>

#include "pipeline/pack/volume_encoder.h"
#include "runtime/palpation/segments.h"
#include "tests/unit/unit_sphere.h"

namespace beatlas::test {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// Radius of the ball in direction `unit`; bumps of a few mm that move with the beat.
double radius_at(const Vec3& unit, double radius_mm, double beat_mm, double phase) {
  const double beat = 0.5 - 0.5 * std::cos(kTwoPi * phase);
  const double bump =
      std::sin(5 * unit.x() + 0.4 * std::sin(kTwoPi * phase)) * std::cos(4 * unit.z());
  return radius_mm * (1 + 0.05 * bump) - beat_mm * beat * (1 + 0.2 * unit.y());
}

double distance_mm(const Vec3& offset, double radius_mm, double beat_mm, double phase) {
  const double r = offset.norm();
  const Vec3 unit = r > 1e-9 ? Vec3(offset / r) : Vec3(0, 0, 1);
  return r - radius_at(unit, radius_mm, beat_mm, phase);
}

const Vec3 kCentre(128, 128, 96);

}  // namespace

atlas::FieldPayload beating_field(Structure structure, double radius_mm, double beat_mm, int phases,
                                  double voxel_mm) {
  using atlas::FieldPayload;
  FieldPayload field;
  field.structure = structure;
  field.voxel_mm = voxel_mm;
  field.phases = phases;
  field.step_mm = 0.01;
  field.inner_mm = std::min(15.0, 0.6 * radius_mm);
  field.outer_mm = 6;
  const double half_mm = 1.06 * radius_mm + field.outer_mm + 2 * voxel_mm;
  const int edge = static_cast<int>(std::ceil(2 * half_mm / (8 * voxel_mm)));
  field.block_count = {edge, edge, edge};
  field.origin_mm = kCentre - Vec3::Constant(4 * voxel_mm * edge);
  for (int bz = 0; bz < edge; ++bz) {
    for (int by = 0; by < edge; ++by) {
      for (int bx = 0; bx < edge; ++bx) {
        // [z][y][phase][x]
        std::vector<std::int16_t> leaf;
        bool all_outside = true;
        bool all_inside = true;
        for (int row = 0; row < 64; ++row) {
          for (int p = 0; p < phases; ++p) {
            for (int x = 0; x < 8; ++x) {
              const Vec3 at =
                  field.origin_mm + voxel_mm * Vec3(8 * bx + x, 8 * by + row % 8, 8 * bz + row / 8);
              const double d = distance_mm(at - kCentre, radius_mm, beat_mm, double(p) / phases);
              all_outside = all_outside && d >= field.outer_mm;
              all_inside = all_inside && d <= -field.inner_mm;
              leaf.push_back(static_cast<std::int16_t>(std::lround(d / field.step_mm)));
            }
          }
        }
        if (all_outside || all_inside) {
          field.blocks.push_back(all_inside ? FieldPayload::kInside : FieldPayload::kOutside);
          continue;
        }
        field.blocks.push_back(static_cast<std::int32_t>(
            field.coefficients.size() / (FieldPayload::kBlockSamples * std::size_t(phases))));
        field.coefficients.insert(field.coefficients.end(), leaf.begin(), leaf.end());
      }
    }
  }
  return field;
}

atlas::SurfacePayload beating_surface(Structure structure, double radius_mm, double beat_mm,
                                      int phases, int levels) {
  const auto [points, triangles] = unit_sphere(levels);
  std::vector<std::uint32_t> place(points.size());
  for (std::uint32_t v = 0; v < place.size(); ++v) place[v] = v;
  std::mt19937 random(7);
  for (std::size_t v = place.size() - 1; v > 0; --v) std::swap(place[v], place[random() % (v + 1)]);

  atlas::SurfacePayload surface;
  surface.structure = structure;
  for (const auto& [a, b, c] : triangles) {
    surface.triangles.push_back({place[a], place[b], place[c]});
  }
  for (int p = 0; p < phases; ++p) {
    const double phase = double(p) / phases;
    const Eigen::AngleAxisd twist(0.1 * std::sin(kTwoPi * phase), Vec3::UnitZ());
    std::vector<Vec3f> positions(points.size());
    for (std::size_t v = 0; v < points.size(); ++v) {
      const Vec3 unit = twist * points[v];
      positions[place[v]] =
          (kCentre + radius_at(unit, radius_mm, beat_mm, phase) * unit).cast<float>();
    }
    surface.positions.push_back(std::move(positions));
  }
  return surface;
}

atlas::SurfaceMapPayload beating_map(const atlas::SurfacePayload& surface) {
  atlas::SurfaceMapPayload map;
  map.structure = surface.structure;
  const auto phases = static_cast<double>(surface.positions.size());
  map.thickness_mm.resize(surface.positions.size());
  for (std::size_t v = 0; v < surface.positions[0].size(); ++v) {
    const Vec3 unit = (surface.positions[0][v].cast<double>() - kCentre).normalized();
    const double turn = std::atan2(unit.y(), unit.x());
    map.long_axis.push_back(static_cast<float>(std::clamp(0.5 + 0.5 * unit.z(), 0.0, 1.0)));
    map.angle_rad.push_back(static_cast<float>(turn < 0 ? turn + kTwoPi : turn));
    const int segment =
        surface.structure == Structure::RvBlood ? 0 : 1 + static_cast<int>(v * 5 % 17);
    map.segment.push_back(static_cast<std::uint8_t>(segment));
    for (std::size_t p = 0; p < map.thickness_mm.size(); ++p) {
      const double beat = 0.5 - 0.5 * std::cos(kTwoPi * static_cast<double>(p) / phases);
      const double wall_mm = (8.2 + unit.y()) * (1 + 0.4 * beat);
      map.thickness_mm[p].push_back(v % 16 == 9 ? 0.0F : static_cast<float>(wall_mm));
    }
  }
  return map;
}

SampleImages sample_images(int phases, double radius_mm, double noise) {
  SampleImages out;
  out.noise = noise;
  const Vec3 spacing_mm(1.25, 1.25, 4);
  Grid grid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    grid.size[axis] = static_cast<int>(2 * (radius_mm + 6) / spacing_mm[Eigen::Index(axis)]) + 1;
  }
  grid.mm_from_index.linear() = spacing_mm.asDiagonal();
  grid.mm_from_index.translation() =
      kCentre -
      0.5 * spacing_mm.cwiseProduct(Vec3(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1));
  Grid lattice;
  const int edge = static_cast<int>(2 * (radius_mm + 8) / 1.5) + 1;
  lattice.size = {edge, edge, edge};
  lattice.mm_from_index.linear() = 1.5 * Eigen::Matrix3d::Identity();
  lattice.mm_from_index.translation() = kCentre - Vec3::Constant(0.75 * (edge - 1));
  out.heart.structure = Structure::Heart;
  out.heart.voxel_mm = 1.5;
  out.heart.inner_mm = 6;
  out.heart.outer_mm = 6;
  out.heart.distance_mm.grid = lattice;
  out.clean.grid = grid;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto each = [](const Grid& of, auto&& value) {
    std::vector<float> values;
    for (int k = 0; k < of.size[2]; ++k) {
      for (int j = 0; j < of.size[1]; ++j) {
        for (int i = 0; i < of.size[0]; ++i) values.push_back(float(value(of.mm(i, j, k))));
      }
    }
    return values;
  };
  for (int p = 0; p < phases; ++p) {
    const auto distance = [&](const Vec3& at) {
      return distance_mm(at - kCentre, radius_mm, 0.15 * radius_mm, double(p) / phases);
    };
    out.clean.phases.push_back(each(grid, [&](const Vec3& at) {
      return 80 + 0.5 * (at.x() - kCentre.x()) + 200 / (1 + std::exp(2 * distance(at)));
    }));
    out.heart.distance_mm.phases.push_back(
        each(lattice, [&](const Vec3& at) { return std::clamp(distance(at), -6.0, 6.0); }));
    out.heart.volume_ml.push_back(1);
  }
  out.images = out.clean;
  for (auto& phase : out.images.phases) {
    for (float& value : phase) value += static_cast<float>(noise * normal(random));
  }
  return out;
}

pack::PackageContent sample_content(int phases, double radius_mm, double voxel_mm, int levels) {
  pack::PackageContent content;
  atlas::Manifest& manifest = content.manifest;
  manifest.rr_interval_s = 0.9;
  for (int p = 0; p < phases; ++p) manifest.frame_times_s.push_back(0.01 + 0.8 * p / phases);
  manifest.workspace_from_lps =
      Eigen::Translation3d(128, 120, 96) * Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized());
  manifest.source_size = {64, 48, 12};
  manifest.source_lps_from_index =
      manifest.workspace_from_lps.inverse() * Eigen::Scaling(1.25, 1.25, 8.0);
  manifest.stiffness_n_per_m = 160;
  manifest.end_systole = phases / 2;
  manifest.surface_edges_mm = {2, 4};
  manifest.provenance = {{"beatlas", "0.1.0"}, {"stages", {{"pack", {{"step_mm", 0.01}}}}}};
  const double beat_mm = 0.15 * radius_mm;
  for (const auto& [structure, scale] :
       {std::pair{Structure::Heart, 1.0}, std::pair{Structure::LvBlood, 0.6}}) {
    atlas::StructureEntry entry{std::string(structure_name(structure)), {}};
    for (int p = 0; p < phases; ++p) {
      const double r = scale * (radius_mm - beat_mm * (0.5 - 0.5 * std::cos(kTwoPi * p / phases)));
      entry.volume_ml.push_back(4 * std::numbers::pi / 3 * r * r * r * 1e-3);
    }
    manifest.structures.push_back(entry);
    content.fields.push_back(
        beating_field(structure, scale * radius_mm, scale * beat_mm, phases, voxel_mm));
    content.surfaces.push_back(
        beating_surface(structure, scale * radius_mm, scale * beat_mm, phases, levels));
    if (structure == Structure::LvBlood) {
      content.maps.push_back(beating_map(content.surfaces.back()));
      if (levels > 1) {
        content.surfaces.push_back(
            beating_surface(structure, scale * radius_mm, scale * beat_mm, phases, levels - 1));
        content.surfaces.back().level = 1;
        content.maps.push_back(beating_map(content.surfaces.back()));
        content.maps.back().level = 1;
      }
    }
  }
  const SampleImages made = sample_images(phases, radius_mm, 12);
  content.volume = pack::pack_volume(made.images, made.noise, made.heart, {});
  return content;
}

pack::PackageContent palpation_content() {
  pack::PackageContent content = sample_content(6, 36, 2, 4);
  content.manifest.scene = "palpation";
  atlas::SurfaceMapPayload& map = content.maps.at(0);
  for (std::size_t v = 0; v < map.segment.size(); ++v) {
    map.segment[v] = static_cast<std::uint8_t>(palpation::segment_at(
        static_cast<double>(map.long_axis[v]), static_cast<double>(map.angle_rad[v])));
    for (auto& phase : map.thickness_mm) {
      if (!(phase[v] > 0)) phase[v] = 8.2F;  // the sample leaves some out
    }
  }
  return content;
}

pack::PackageContent tiny_content() { return sample_content(4, 10, 1.5, 2); }

pack::PackageContent golden_content() {
  pack::PackageContent content = tiny_content();
  content.surfaces.push_back(beating_surface(Structure::RvBlood, 7, 1, 4, 2));
  content.maps.push_back(beating_map(content.surfaces.back()));
  std::vector<double> volume_ml;
  for (const auto& positions : content.surfaces.back().positions) {
    volume_ml.push_back(1e-3 * 4 / 3 * std::numbers::pi *
                        std::pow((positions.front().cast<double>() - kCentre).norm(), 3));
  }
  content.manifest.structures.push_back(
      {std::string(structure_name(Structure::RvBlood)), std::move(volume_ml)});
  const auto slices = static_cast<std::size_t>(content.manifest.source_size[2]);
  const std::vector<double> known_mm(slices, 1.5);
  content.manifest.structures.back().band = {std::vector(4, known_mm),
                                             std::vector(4, std::vector<double>(slices, 4))};
  return content;
}

namespace {

void put(atlas::Bytes& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFFU));
}

std::uint64_t get(const atlas::Bytes& bytes, std::size_t at, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) {
    value |= std::to_integer<std::uint64_t>(bytes.at(at + static_cast<std::size_t>(i))) << (8 * i);
  }
  return value;
}

void put_text(atlas::Bytes& out, const std::string& text) {
  for (char c : text) out.push_back(static_cast<std::byte>(c));
}

std::uint32_t crc32(const atlas::Bytes& bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (std::byte byte : bytes) {
    crc ^= std::to_integer<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1U ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

}  // namespace

atlas::Bytes raw_zip(const std::vector<std::pair<std::string, atlas::Bytes>>& entries) {
  atlas::Bytes out;
  atlas::Bytes directory;
  for (const auto& [name, bytes] : entries) {
    atlas::Bytes common;
    put(common, 20, 2);  // version needed
    put(common, 0, 2);   // flags
    put(common, 0, 2);   // stored
    put(common, 0, 2);   // time
    put(common, 33, 2);  // 1980-01-01
    put(common, crc32(bytes), 4);
    put(common, bytes.size(), 4);
    put(common, bytes.size(), 4);
    put(common, name.size(), 2);
    put(common, 0, 2);  // extra field
    put(directory, 0x02014B50, 4);
    put(directory, 20, 2);  // made by
    directory.insert(directory.end(), common.begin(), common.end());
    put(directory, 0, 2 + 2 + 2);  // comment, disk, inner attributes
    put(directory, 0, 4);          // outer attributes
    put(directory, out.size(), 4);
    put_text(directory, name);
    put(out, 0x04034B50, 4);
    out.insert(out.end(), common.begin(), common.end());
    put_text(out, name);
    out.insert(out.end(), bytes.begin(), bytes.end());
  }
  const std::size_t start = out.size();
  out.insert(out.end(), directory.begin(), directory.end());
  put(out, 0x06054B50, 4);
  put(out, 0, 4);  // disks
  put(out, entries.size(), 2);
  put(out, entries.size(), 2);
  put(out, directory.size(), 4);
  put(out, start, 4);
  put(out, 0, 2);
  return out;
}

std::vector<std::pair<std::string, atlas::Bytes>> raw_unzip(const atlas::Bytes& zip) {
  std::vector<std::pair<std::string, atlas::Bytes>> entries;
  std::size_t at = 0;
  while (get(zip, at, 4) == 0x04034B50) {
    const auto size = static_cast<std::ptrdiff_t>(get(zip, at + 22, 4));
    const auto name = static_cast<std::ptrdiff_t>(get(zip, at + 26, 2));
    const auto extra = static_cast<std::ptrdiff_t>(get(zip, at + 28, 2));
    const auto first = zip.begin() + static_cast<std::ptrdiff_t>(at) + 30;
    std::string text;
    for (auto c = first; c != first + name; ++c) text.push_back(std::to_integer<char>(*c));
    const auto data = first + name + extra;
    entries.emplace_back(text, atlas::Bytes(data, data + size));
    at += static_cast<std::size_t>(30 + name + extra + size);
  }
  return entries;
}

atlas::Bytes read_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  atlas::Bytes bytes;
  put_text(bytes, text);
  return bytes;
}

void write_file(const std::filesystem::path& file, const atlas::Bytes& bytes) {
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "beatlas-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace beatlas::test
