/// The table of bytes and error: the heart's field at several voxels and steps, and as others keep
/// it.
#include <algorithm>
#include <cmath>
#include <limits>

#include <openvdb/io/File.h>

#include "pipeline/field/field.h"
#include "pipeline/pack/pack.h"
#include "pipeline/pack/payload_encoders.h"
#include "runtime/atlas/field_payload.h"
#include "tests/bench/alternatives.h"
#include "tests/bench/alternatives_files.h"
#include "tests/bench/alternatives_samplers.h"

namespace beatlas::bench {
namespace {

constexpr double kNearMm = 3;  // errors are taken of samples within it of the surface

double mb(std::size_t bytes) { return 1e-6 * static_cast<double>(bytes); }

/// Distance that a way to keep the field gives at a sample of the lattice and a phase [mm].
using Stored = std::function<double(const Index3&, std::size_t)>;

struct SampleErrors {
  double rms_mm = 0;
  double largest_mm = 0;
};

SampleErrors errors_of(const FieldCycle& field, const Stored& stored) {
  const Index3& size = field.distance_mm.grid.size;
  SampleErrors out;
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t p = 0; p < field.distance_mm.phases.size(); ++p) {
    std::size_t n = 0;
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i, ++n) {
          const auto given = static_cast<double>(field.distance_mm.phases[p][n]);
          if (std::abs(given) > kNearMm) continue;
          const double error = std::abs(stored({i, j, k}, p) - given);
          squares += error * error;
          out.largest_mm = std::max(out.largest_mm, error);
          ++count;
        }
      }
    }
  }
  out.rms_mm = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, count)));
  return out;
}

Row row_of(const std::string& name, const FieldCycle& field, std::size_t bytes,
           const Stored& stored) {
  const SampleErrors errors = errors_of(field, stored);
  return {name, {field.voxel_mm, mb(bytes), 1e3 * errors.rms_mm, 1e3 * errors.largest_mm}};
}

Row our_row(const FieldCycle& field, double rr_s, double step_mm) {
  pack::EncodeOptions options;
  options.step_mm = step_mm;
  const atlas::Bytes entry = pack::pack_field(pack::encode_field(field, options), step_mm);
  const field::FieldQuery query(
      std::make_shared<atlas::FieldPayload>(atlas::decode_field(entry, Structure::Heart)), rr_s);
  const double frame_s = rr_s / static_cast<double>(field.distance_mm.phases.size());
  std::array<char, 64> name{};
  std::snprintf(name.data(), name.size(), "beatlas, step %g mm", step_mm);
  return row_of(name.data(), field, entry.size(), [&](const Index3& at, std::size_t phase) {
    return query
        .sample(field.distance_mm.grid.mm(at[0], at[1], at[2]),
                frame_s * static_cast<double>(phase))
        .distance_mm;
  });
}

void add_dense(const FieldCycle& field, std::vector<Row>& rows) {
  std::string bytes;
  for (const std::vector<float>& phase : field.distance_mm.phases) {
    bytes.append(reinterpret_cast<const char*>(phase.data()), sizeof(float) * phase.size());
  }
  const auto exact = [&](const Index3& at, std::size_t phase) {
    return static_cast<double>(
        field.distance_mm.phases[phase][field.distance_mm.grid.offset(at[0], at[1], at[2])]);
  };
  rows.push_back(row_of("dense float volumes, raw", field, bytes.size(), exact));
  rows.push_back(row_of("dense float volumes, zstd-3", field, zstd_packed(bytes).size(), exact));
}

void add_half_vdb(const Setting& setting, const FieldCycle& field, std::vector<Row>& rows) {
  openvdb::initialize();
  const std::string file = (setting.work / "half.vdb").string();
  openvdb::GridPtrVec grids;
  for (std::size_t p = 0; p < field.distance_mm.phases.size(); ++p) {
    const openvdb::FloatGrid::Ptr grid = narrow_band(field, p);
    grid->setName("phase_" + std::to_string(p));
    grid->setSaveFloatAsHalf(true);
    grids.push_back(grid);
  }
  {
    openvdb::io::File out(file);
    out.write(grids);
    out.close();
  }
  openvdb::io::File in(file);
  in.open();
  std::vector<openvdb::FloatGrid::Ptr> read;
  for (std::size_t p = 0; p < grids.size(); ++p) {
    read.push_back(
        openvdb::gridPtrCast<openvdb::FloatGrid>(in.readGrid("phase_" + std::to_string(p))));
  }
  in.close();
  rows.push_back(
      row_of("VDB, half floats, a grid a phase", field, std::filesystem::file_size(file),
             [&](const Index3& at, std::size_t phase) {
               return static_cast<double>(read[phase]->tree().getValue({at[0], at[1], at[2]}));
             }));
}

void add_nano(const Setting& setting, const FieldCycle& field, std::vector<Row>& rows) {
  const auto handles = nano_grids<nanovdb::Fp8>(field);
  const std::filesystem::path file = setting.work / "storage.nvdb";
  nanovdb::io::writeGrids<nanovdb::HostBuffer, std::vector>(file.string(), handles);
  const std::string bytes = read_file(file);
  const Stored stored = [&](const Index3& at, std::size_t phase) {
    return static_cast<double>(
        handles[phase].template grid<nanovdb::Fp8>()->tree().getValue({at[0], at[1], at[2]}));
  };
  rows.push_back(row_of("NanoVDB Fp8, a grid a phase", field, bytes.size(), stored));
  rows.push_back(row_of("NanoVDB Fp8, zstd-3", field, zstd_packed(bytes).size(), stored));
}

}  // namespace

Table storage_table(const Setting& setting) {
  Table out;
  out.key = "storage";
  out.title = "The heart's field on disk: bytes and error";
  out.note =
      "Of the field that beatlas made from the images. Error: what is stored against what was "
      "given, at samples and phases within 3 mm of the surface; the step is that of "
      "pack/step_mm. Surfaces phase by phase stand in the table of the surface.";
  out.columns = {{"voxel_mm", "voxel mm", 1, false},
                 {"disk_mb", "disk MB", 2},
                 {"rms_um", "error rms um", 1},
                 {"largest_um", "largest um", 0}};
  const double rr_s = setting.rr_interval_s();
  out.rows.push_back(our_row(setting.field, rr_s, pack::EncodeOptions{}.step_mm));
  StageContext quiet;
  for (const double voxel_mm : {1.0, 1.5, 2.0}) {
    field::FieldOptions options;
    options.voxel_mm = voxel_mm;
    const FieldCycle field = field::build_field(setting.shape, options, quiet);
    for (const double step_mm : {0.005, 0.01, 0.02, 0.04}) {
      out.rows.push_back(our_row(field, rr_s, step_mm));
    }
    add_dense(field, out.rows);
    add_half_vdb(setting, field, out.rows);
    add_nano(setting, field, out.rows);
  }
  return out;
}

}  // namespace beatlas::bench
