#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <system_error>

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include "pipeline/field/field.h"
#include "runtime/base/error.h"
#include "runtime/base/replace_file.h"
#include "runtime/base/sha256.h"

namespace beatlas::field {
namespace {

using openvdb::FloatGrid;

constexpr const char* kStructureKey = "beatlas_structure";
constexpr const char* kPhaseKey = "beatlas_phase";
constexpr const char* kPhasesKey = "beatlas_phases";
constexpr const char* kSizeKey = "beatlas_size";
constexpr const char* kVoxelKey = "beatlas_voxel_mm";
constexpr const char* kInnerKey = "beatlas_inner_mm";
constexpr const char* kOuterKey = "beatlas_outer_mm";
constexpr const char* kVolumeKey = "beatlas_volume_ml";

std::string grid_name(Structure structure, std::size_t phase) {
  return std::string(structure_name(structure)) + "_" + std::to_string(phase);
}

FloatGrid::Ptr to_vdb(const FieldCycle& field, std::size_t phase) {
  const Grid& grid = field.distance_mm.grid;
  const auto outside = static_cast<float>(field.outer_mm);
  const auto inside = static_cast<float>(-field.inner_mm);
  FloatGrid::Ptr out = FloatGrid::create(outside);
  FloatGrid::Accessor accessor = out->getAccessor();
  const std::vector<float>& samples = field.distance_mm.phases[phase];
  std::size_t n = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++n) {
        const float v = samples[n];
        if (v > inside && v < outside) {
          accessor.setValueOn({i, j, k}, v);
        } else if (v != outside) {
          accessor.setValueOff({i, j, k}, v);
        }
      }
    }
  }
  out->tree().prune();

  out->setName(grid_name(field.structure, phase));
  out->setGridClass(openvdb::GRID_LEVEL_SET);
  openvdb::Mat4R mm_from_index = openvdb::Mat4R::identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      // OpenVDB multiplies row vectors from the left.
      mm_from_index(column, row) = grid.mm_from_index.linear()(row, column);
    }
    mm_from_index(3, row) = grid.mm_from_index.translation()[row];
  }
  out->setTransform(openvdb::math::Transform::createLinearTransform(mm_from_index));
  const auto phases = static_cast<std::int32_t>(field.distance_mm.phases.size());
  out->insertMeta(kStructureKey,
                  openvdb::StringMetadata(std::string(structure_name(field.structure))));
  out->insertMeta(kPhaseKey, openvdb::Int32Metadata(static_cast<std::int32_t>(phase)));
  out->insertMeta(kPhasesKey, openvdb::Int32Metadata(phases));
  out->insertMeta(kSizeKey, openvdb::Vec3IMetadata({grid.size[0], grid.size[1], grid.size[2]}));
  out->insertMeta(kVoxelKey, openvdb::DoubleMetadata(field.voxel_mm));
  out->insertMeta(kInnerKey, openvdb::DoubleMetadata(field.inner_mm));
  out->insertMeta(kOuterKey, openvdb::DoubleMetadata(field.outer_mm));
  out->insertMeta(kVolumeKey, openvdb::DoubleMetadata(field.volume_ml[phase]));
  return out;
}

// OpenVDB puts a random identifier in the header; one made from the content takes its place, so
// that the same field gives the same bytes.
void fix_identifier(const std::filesystem::path& file) {
  // Magic number, file version, library version, and the flag for grid offsets come before it.
  constexpr std::size_t kAt = sizeof(std::int64_t) + 3 * sizeof(std::uint32_t) + sizeof(char);
  constexpr std::size_t kLength = 36;
  std::ifstream in(file, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in || bytes.size() < kAt + kLength || bytes[kAt + 8] != '-' || bytes[kAt + 23] != '-') {
    throw Error(ErrorCode::Machine, "the field just written could not be read back");
  }
  in.close();
  std::fill_n(bytes.begin() + kAt, kLength, '0');
  const std::string hash = sha256_hex(std::as_bytes(std::span(bytes)));
  // The form of an RFC 4122 name-based identifier: version 5, variant 1.
  const std::string identifier = hash.substr(0, 8) + "-" + hash.substr(8, 4) + "-5" +
                                 hash.substr(13, 3) + "-a" + hash.substr(17, 3) + "-" +
                                 hash.substr(20, 12);
  std::fstream out(file, std::ios::binary | std::ios::in | std::ios::out);
  out.seekp(kAt);
  out.write(identifier.data(), kLength);
  out.flush();
  if (!out) throw Error(ErrorCode::Machine, "the field could not be written; is the disk full?");
}

template <class T>
T meta(const openvdb::GridBase& grid, const char* key) {
  const auto found = grid.getMetadata<openvdb::TypedMetadata<T>>(key);
  if (!found) {
    throw_invalid("grid '" + grid.getName() + "' lacks the entry '" + key +
                  "'; build the field again instead of editing it with a tool that drops entries");
  }
  return found->value();
}

struct Header {
  Structure structure{};
  std::int32_t phases = 0;
  Grid grid;
  double voxel_mm = 0;
  double inner_mm = 0;
  double outer_mm = 0;
};

Header read_header(const openvdb::GridBase& grid) {
  Header out;
  const auto name = meta<std::string>(grid, kStructureKey);
  const std::optional<Structure> structure = structure_from_name(name);
  if (!structure) throw_invalid("grid '" + grid.getName() + "' is of no known structure");
  out.structure = *structure;
  out.phases = meta<std::int32_t>(grid, kPhasesKey);
  const openvdb::Vec3i size = meta<openvdb::Vec3i>(grid, kSizeKey);
  constexpr int kMaxEdge = 2048;
  for (int axis = 0; axis < 3; ++axis) {
    if (size[axis] < 1 || size[axis] > kMaxEdge) {
      throw_invalid("grid '" + grid.getName() + "' has an impossible size");
    }
    out.grid.size[static_cast<std::size_t>(axis)] = size[axis];
  }
  out.voxel_mm = meta<double>(grid, kVoxelKey);
  out.inner_mm = meta<double>(grid, kInnerKey);
  out.outer_mm = meta<double>(grid, kOuterKey);
  const auto positive = [](double v) { return std::isfinite(v) && v > 0; };
  if (out.phases < 1 || !positive(out.voxel_mm) || !positive(out.inner_mm) ||
      !positive(out.outer_mm)) {
    throw_invalid("grid '" + grid.getName() +
                  "' has an impossible number of phases, voxel or clamp");
  }
  if (!grid.transform().isLinear()) {
    throw_invalid("grid '" + grid.getName() + "' does not lie on a regular lattice");
  }
  const openvdb::Mat4R m = grid.transform().baseMap()->getAffineMap()->getMat4();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      out.grid.mm_from_index.linear()(row, column) = m(column, row);
    }
    out.grid.mm_from_index.translation()[row] = m(3, row);
  }
  if (!out.grid.mm_from_index.matrix().allFinite() ||
      !out.grid.mm_from_index.linear().isApprox(out.voxel_mm * Eigen::Matrix3d::Identity(), 1e-9)) {
    throw_invalid("grid '" + grid.getName() + "' does not have the voxels its entries name");
  }
  return out;
}

std::vector<float> to_samples(const FloatGrid& grid, const Header& header) {
  std::vector<float> out(header.grid.count());
  FloatGrid::ConstAccessor accessor = grid.getConstAccessor();
  std::size_t n = 0;
  for (int k = 0; k < header.grid.size[2]; ++k) {
    for (int j = 0; j < header.grid.size[1]; ++j) {
      for (int i = 0; i < header.grid.size[0]; ++i, ++n) {
        const float v = accessor.getValue({i, j, k});
        if (!std::isfinite(v)) {
          throw_invalid("grid '" + grid.getName() + "' holds values that are not finite");
        }
        out[n] = std::clamp(v, static_cast<float>(-header.inner_mm),
                            static_cast<float>(header.outer_mm));
      }
    }
  }
  return out;
}

}  // namespace

void write_vdb(const std::filesystem::path& file, const FieldCycle& field) {
  openvdb::initialize();
  replace_file(file, [&](const std::filesystem::path& partial) {
    try {
      openvdb::GridCPtrVec grids;
      for (std::size_t p = 0; p < field.distance_mm.phases.size(); ++p) {
        grids.push_back(to_vdb(field, p));
      }
      openvdb::io::File out(partial.string());
      out.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC);
      out.write(grids);
      out.close();
      fix_identifier(partial);
    } catch (const openvdb::Exception& error) {
      throw Error(ErrorCode::Machine, error.what());
    }
  });
}

FieldCycle read_vdb(const std::filesystem::path& file) {
  openvdb::initialize();
  try {
    openvdb::io::File in(file.string());
    in.open(false);
    const openvdb::GridPtrVecPtr grids = in.getGrids();
    in.close();
    if (grids->empty()) throw_invalid("the file holds no grids");
    const Header header = read_header(*grids->front());
    FieldCycle out;
    out.structure = header.structure;
    out.distance_mm.grid = header.grid;
    out.voxel_mm = header.voxel_mm;
    out.inner_mm = header.inner_mm;
    out.outer_mm = header.outer_mm;
    if (grids->size() != static_cast<std::size_t>(header.phases)) {
      throw_invalid("the file holds " + std::to_string(grids->size()) + " grids but names " +
                    std::to_string(header.phases) + " phases");
    }
    out.distance_mm.phases.resize(grids->size());
    out.volume_ml.resize(grids->size());
    for (const openvdb::GridBase::Ptr& any : *grids) {
      const FloatGrid::Ptr grid = openvdb::gridPtrCast<FloatGrid>(any);
      if (!grid) throw_invalid("grid '" + any->getName() + "' is not of floats");
      const Header here = read_header(*grid);
      const std::int32_t phase = meta<std::int32_t>(*grid, kPhaseKey);
      if (here.structure != header.structure || !(here.grid == header.grid) ||
          here.inner_mm != header.inner_mm || here.outer_mm != header.outer_mm) {
        throw_invalid("grid '" + grid->getName() +
                      "' differs from the first in its lattice or clamp");
      }
      if (phase < 0 || phase >= header.phases ||
          !out.distance_mm.phases[static_cast<std::size_t>(phase)].empty()) {
        throw_invalid("grid '" + grid->getName() + "' has a phase out of range or given twice");
      }
      out.distance_mm.phases[static_cast<std::size_t>(phase)] = to_samples(*grid, header);
      out.volume_ml[static_cast<std::size_t>(phase)] = meta<double>(*grid, kVolumeKey);
    }
    return out;
  } catch (const Error& error) {
    throw error.with_context(file.string());
  } catch (const std::exception& error) {
    throw Error(ErrorCode::InvalidInput,
                file.string() + ": not a readable .vdb file (" + error.what() + ")");
  }
}

}  // namespace beatlas::field
