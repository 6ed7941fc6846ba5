#include "pipeline/cli/package_report.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/assess/structural_checks.h"
#include "pipeline/build/report_facts.h"
#include "pipeline/build/version.h"
#include "pipeline/cli/stored_images.h"
#include "pipeline/core/parallel.h"
#include "pipeline/report/report_data.h"
#include "pipeline/study/files.h"
#include "runtime/atlas/atlas.h"
#include "runtime/base/error.h"
#include "runtime/field/field_query.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

/// Of what the maker told; empty if it told none. Provenance may hold anything.
std::vector<std::string> told_lines(const json& provenance, const char* key) {
  std::vector<std::string> out;
  const auto found = provenance.find(key);
  if (found == provenance.end() || !found->is_array()) return out;
  for (const json& line : *found) {
    if (line.is_string()) out.push_back(line.get<std::string>());
  }
  return out;
}

std::string told_text(const json& provenance, const char* key) {
  const auto found = provenance.find(key);
  return found != provenance.end() && found->is_string() ? found->get<std::string>() : "";
}

Exam exam_of(const atlas::Atlas& package) {
  const atlas::Manifest& manifest = package.manifest();
  Exam out;
  out.source_format = told_text(manifest.provenance, "source_format");
  out.decisions = told_lines(manifest.provenance, "decisions");
  out.stack.rr_interval_s = manifest.rr_interval_s;
  out.stack.frame_times_s = manifest.frame_times_s;
  const Grid source{manifest.source_size, manifest.source_lps_from_index};
  if (const auto volume = package.volume()) {
    out.stack.images = images_of(*volume, source, manifest.workspace_from_lps);
    return out;
  }
  // Without images outlines lie on nothing; without fields there are none.
  out.stack.images.grid = source;
  const std::size_t voxels = package.field(Structure::Heart) ? source.count() : 0;
  out.stack.images.phases.assign(static_cast<std::size_t>(manifest.phase_count()),
                                 std::vector<float>(voxels));
  return out;
}

/// The part of the grid in which the lattice of the field lies.
std::pair<Index3, Index3> part_within(const atlas::FieldPayload& field, const Grid& grid,
                                      const Affine& workspace_from_index) {
  Vec3 low = Vec3::Constant(1e9);
  Vec3 high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 at = field.origin_mm;
    for (int axis = 0; axis < 3; ++axis) {
      if ((corner >> axis & 1) == 0) continue;
      at[axis] += field.voxel_mm * atlas::FieldPayload::kBlockEdge *
                  field.block_count[static_cast<std::size_t>(axis)];
    }
    const Vec3 index = workspace_from_index.inverse() * at;
    low = low.cwiseMin(index);
    high = high.cwiseMax(index);
  }
  Index3 first{};
  Index3 size{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    const int most = grid.size[axis];
    first[axis] = std::clamp(static_cast<int>(std::floor(low[a])), 0, most - 1);
    size[axis] =
        std::clamp(static_cast<int>(std::ceil(high[a])) + 1 - first[axis], 1, most - first[axis]);
  }
  return {first, size};
}

/// Coverage that is one half where a distance is zero in the middle of a slice, as what the page
/// draws outlines of; volumes are the package's own.
Segmentation outlined(const atlas::Atlas& package, const Grid& grid, StageContext& context) {
  const atlas::Manifest& manifest = package.manifest();
  const Affine workspace_from_index = manifest.workspace_from_lps * grid.mm_from_index;
  const auto phases = static_cast<std::size_t>(manifest.phase_count());
  Segmentation out;
  out.end_diastole = manifest.end_diastole;
  out.end_systole = manifest.end_systole;
  out.warnings = told_lines(manifest.provenance, "warnings");
  out.labels.grid = grid;
  out.labels.phases.resize(phases);
  CoverageCycle& coverage = out.coverage;
  const auto part = part_within(*package.field(Structure::Heart), grid, workspace_from_index);
  const Index3& first = part.first;
  const Index3& size = part.second;
  coverage.first = first;
  coverage.grid = grid.part(first, size);
  const Vec3 spacing = grid.spacing_mm();
  const double across_mm = (spacing[0] + spacing[1]) / 2;
  const auto slices = static_cast<std::size_t>(size[2]);
  for (const Structure structure : kAllStructures) {
    const auto payload = package.field(structure);
    if (!payload) continue;
    const field::FieldQuery query(payload, manifest.rr_interval_s);
    std::vector<std::vector<float>>& share = coverage.phases[structure];
    share.assign(phases, std::vector<float>(coverage.grid.count()));
    parallel_for(phases * slices, [&](std::size_t slab) {
      context.check_cancelled();
      const std::size_t phase = slab / slices;
      const int k = static_cast<int>(slab % slices);
      const double t_s = manifest.rr_interval_s * double(phase) / double(phases);
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i) {
          const Vec3 at = workspace_from_index * Vec3(first[0] + i, first[1] + j, first[2] + k);
          const double inside = 0.5 - query.sample(at, t_s).distance_mm / across_mm;
          share[phase][coverage.grid.offset(i, j, k)] =
              static_cast<float>(std::clamp(inside, 0.0, 1.0));
        }
      }
    });
  }
  return out;
}

/// Along the LV from apex to base, LPS, by the map of its wall.
std::optional<LongAxis> axis_of(const atlas::Atlas& package) {
  const auto surface = package.surface(Structure::LvBlood);
  const auto map = package.surface_map(Structure::LvBlood);
  if (!surface || !map || map->long_axis.empty()) return {};
  double mean = 0;
  for (const float along : map->long_axis) mean += along;
  mean /= static_cast<double>(map->long_axis.size());
  Vec3 up = Vec3::Zero();
  for (std::size_t v = 0; v < map->long_axis.size(); ++v) {
    up += (map->long_axis[v] - mean) * surface->positions.front()[v].cast<double>();
  }
  if (!(up.norm() > 0)) return {};
  LongAxis out;
  out.towards_base = (package.manifest().workspace_from_lps.linear().transpose() * up).normalized();
  return out;
}

std::vector<report::ReportStage> stages_of(const json& provenance) {
  std::vector<report::ReportStage> out;
  const auto told = provenance.find("stages");
  if (told == provenance.end() || !told->is_object()) return out;
  for (const study::Stage stage : study::kAllStages) {
    const auto found = told->find(std::string(study::stage_name(stage)));
    if (found == told->end() || !found->is_object()) continue;
    report::ReportStage entry;
    entry.name = std::string(study::stage_name(stage));
    entry.version = told_text(*found, "version");
    entry.state = "in the package";
    if (found->contains("options")) entry.options = found->at("options");
    out.push_back(std::move(entry));
  }
  return out;
}

}  // namespace

json report_package(const fs::path& file, const fs::path& page, StageContext& context) {
  const atlas::Needs all = atlas::everything_in(atlas::Atlas::open(file, {}).manifest());
  const atlas::Atlas package = atlas::Atlas::open(file, all);
  const atlas::Manifest& manifest = package.manifest();
  context.progress(0.1, "checks");
  report::ReportInput input;
  input.is_study = false;
  input.has_images = package.volume() != nullptr;
  const std::string sha256 = study::sha256_of_file(file);
  StageContext checking = context.part(0.1, 0.5, "checks");
  const std::vector<assess::Check> checks = assess::check_structure(package, {}, checking);
  try {
    input.package = build::package_facts(
        build::pack_contents(manifest, fs::file_size(file), checks, {}), sha256);
  } catch (const json::exception&) {
    throw_invalid(file.string() + ": its provenance is not what 'beatlas pack' writes");
  }
  input.volumes = input.package->volumes;
  const Exam exam = exam_of(package);
  input.exam = &exam;
  Segmentation segmentation;
  if (package.field(Structure::Heart) && exam.stack.grid().count() > 0) {
    StageContext outlining = context.part(0.5, 0.7, "outlines");
    segmentation = outlined(package, exam.stack.grid(), outlining);
  } else {
    segmentation.end_diastole = manifest.end_diastole;
    segmentation.end_systole = manifest.end_systole;
    segmentation.warnings = told_lines(manifest.provenance, "warnings");
  }
  segmentation.axis = axis_of(package);
  input.segmentation = &segmentation;
  for (const Structure structure : kAllStructures) {
    const auto surface = package.surface(structure);
    if (!surface) continue;
    context.check_cancelled();
    input.surfaces.push_back({structure, surface->triangles, surface->positions});
    input.surface_figures.push_back(build::surface_figures(input.surfaces.back()));
  }
  context.progress(0.85, "the page");
  input.workspace_from_lps = manifest.workspace_from_lps;
  for (const std::string& name : told_lines(manifest.provenance, "needs")) {
    if (const auto structure = structure_from_name(name)) input.needed.push_back(*structure);
  }
  input.stages = stages_of(manifest.provenance);
  input.input_sha256 = told_text(manifest.provenance, "input_sha256");
  input.program = std::string("beatlas ") + build::kVersion;
  input.made_from = sha256;
  const std::string html = report::report_html(report::report_json(input));
  context.check_cancelled();
  study::write_text(page, html);
  return report::report_summary(input);
}

}  // namespace beatlas::cli
