/// What is measured of a run, from the package it left.
#include <algorithm>

#include "pipeline/assess/voxel_model.h"
#include "pipeline/cli/bench_settings.h"
#include "pipeline/formats/nifti.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
using assess::BenchRow;
using assess::Family;
using assess::Sweep;
using nlohmann::json;
namespace fs = std::filesystem;
namespace {

/// Below this the fields of the ventricles would double the time of the sweep.
constexpr double kFinestOfVentriclesMm = 1.0;
constexpr double kCreaseMm = assess::TruthOptions{}.crease_band_mm;

field::SpatialMode space_of(const json& settings) {
  for (const field::SpatialMode mode : field::kSpatialModes) {
    if (settings.at("query").at("space") == field::mode_name(mode)) return mode;
  }
  throw Error(ErrorCode::Usage, "/query/space must be nearest, trilinear or cubic");
}

field::TemporalMode time_of(const json& settings) {
  for (const field::TemporalMode mode : field::kTemporalModes) {
    if (settings.at("query").at("time") == field::mode_name(mode)) return mode;
  }
  throw Error(ErrorCode::Usage, "/query/time must be nearest, linear or cubic");
}

}  // namespace

void BenchRunner::take_costs(BenchRow& row, const Costs& costs) const {
  row.stage_s = costs.stage_s;
  const std::string first = row.run.is_default || row.run.family == Family::Published
                                ? "phantom"
                                : assess::first_difference(row.run.settings, defaults_);
  bool concerned = false;
  row.build_s = 0;
  row.total_s = 0;
  for (const char* stage : kBenchStages) {
    concerned = concerned || first == stage;
    const auto found = costs.stage_s.find(stage);
    if (found == costs.stage_s.end()) continue;
    row.total_s += found->second;
    if (!concerned) continue;
    row.build_s += found->second;
    const auto& memory = costs.memory_mb.at(stage);
    if (memory) row.peak_memory_mb = std::max(row.peak_memory_mb.value_or(0), *memory);
  }
}

BenchRow BenchRunner::measure(const assess::BenchRun& run, StageContext& context) {
  const std::string key = std::string(sweep_name(run.sweep)) +
                          std::string(family_name(run.family)) + run.settings.dump();
  const auto found = rows_.find(key);
  BenchRow row;
  if (found != rows_.end()) row = found->second;
  row.run = run;
  if (found != rows_.end()) return row;
  forget();
  (void)truth(context);
  switch (run.family) {
    case Family::Field:
      measure_field(row, context);
      break;
    case Family::Surface:
      measure_surface(row, context);
      break;
    case Family::Published:
      measure_published(row, context);
      break;
  }
  rows_[key] = row;
  return row;
}

void BenchRunner::measure_field(BenchRow& row, StageContext& context) {
  const json& settings = row.run.settings;
  const Sweep sweep = row.run.sweep;
  const std::string key = std::string(sweep_name(sweep)) + key_of(settings, "pack");
  const std::string key_full = "full " + key;
  if (packages_.count(key) == 0) {
    Costs costs;
    if (sweep == Sweep::Images) {
      costs.add("segment", segmentation(settings, context));
      costs.add("register", shapes(settings, sweep, context));
    }
    costs.add("field", field(settings, sweep, Structure::Heart, context));
    packages_[key] = pack_fields(settings, sweep, {Structure::Heart}, context);
    costs.add("pack", packages_.at(key));
    if (row.run.ventricles &&
        settings.at("field").at("voxel_mm").get<double>() >= kFinestOfVentriclesMm) {
      packages_[key_full] = pack_fields(settings, sweep, kBenchStructures, context);
    }
    costs_[key] = costs;
  }
  const Package& package = packages_.at(key);
  row.package_bytes = package.bytes;
  take_costs(row, costs_.at(key));

  std::shared_ptr<const field::FieldQuery> heart;
  Affine map = Affine::Identity();
  row.load_ms = median_wall_ms(repeats_, [&] {
    const atlas::Atlas opened =
        atlas::Atlas::open(package.file, {.fields = {Structure::Heart}, .surfaces = {}});
    heart = std::make_shared<const field::FieldQuery>(opened.field(Structure::Heart),
                                                      opened.manifest().rr_interval_s);
    map = opened.manifest().workspace_from_lps;
  });

  const assess::TruthSet& wanted = truth(context);
  const double rr_s = heart->rr_interval_s();
  const field::SpatialMode space = space_of(settings);
  const field::TemporalMode time = time_of(settings);
  const bool is_spline =
      space == field::SpatialMode::Cubic && time == field::TemporalMode::PeriodicCubic;
  const auto cheaper = [&](const std::shared_ptr<const field::FieldQuery>& query) {
    return std::make_shared<const field::SampledQuery>(query, space, time);
  };
  const auto sampled = is_spline ? nullptr : cheaper(heart);
  const assess::MakeTouch of_heart =
      is_spline ? assess::touch_of(heart, wanted.forces.stiffness_n_per_m)
                : assess::touch_of(sampled, wanted.forces.stiffness_n_per_m);
  row.errors[Structure::Heart] =
      assess::surface_errors(of_heart, wanted.surfaces.at(Structure::Heart), map, rr_s);
  row.force = assess::force_errors({of_heart, map, rr_s}, wanted.forces);
  const auto full = packages_.find(key_full);
  if (full != packages_.end()) {
    const atlas::Atlas opened = atlas::Atlas::open(
        full->second.file, {.fields = {Structure::LvBlood, Structure::RvBlood}, .surfaces = {}});
    for (const Structure structure : {Structure::LvBlood, Structure::RvBlood}) {
      const auto query = std::make_shared<const field::FieldQuery>(opened.field(structure),
                                                                   opened.manifest().rr_interval_s);
      row.errors[structure] = assess::surface_errors(
          is_spline ? assess::touch_of(query, wanted.forces.stiffness_n_per_m)
                    : assess::touch_of(cheaper(query), wanted.forces.stiffness_n_per_m),
          wanted.surfaces.at(structure), map, rr_s);
    }
  }

  const std::vector<Question> path = path_questions(wanted, map, rr_s);
  const std::vector<Question> anywhere = random_questions(wanted, map, rr_s);
  const auto ask = [&](const auto& query) {
    const auto distance = [&](const Vec3& x, double t) { return query.sample(x, t).distance_mm; };
    row.query_path_ns = nanoseconds(path, repeats_, distance);
    row.query_random_ns = nanoseconds(anywhere, repeats_, distance);
  };
  if (is_spline) {
    ask(*heart);
  } else {
    ask(*sampled);
  }
}

void BenchRunner::measure_surface(BenchRow& row, StageContext& context) {
  const json& settings = row.run.settings;
  const Sweep sweep = row.run.sweep;
  // The heart and a ventricle: a large surface and a small, strongly moving one.
  const std::vector<Structure> structures{Structure::Heart, Structure::LvBlood};
  Costs costs;
  if (sweep == Sweep::Images) {
    costs.add("segment", segmentation(settings, context));
    costs.add("register", shapes(settings, sweep, context));
  }
  costs.add("field", field(settings, sweep, Structure::Heart, context));
  costs.add("mesh", surface(settings, sweep, Structure::Heart, context));
  const Package package = pack_surfaces(settings, sweep, structures, context);
  costs.add("pack", package);
  row.package_bytes = package.bytes;
  take_costs(row, costs);

  const atlas::Needs needs{.fields = {}, .surfaces = {structures.begin(), structures.end()}};
  std::optional<atlas::Atlas> opened;
  row.load_ms = median_wall_ms(repeats_, [&] { opened = atlas::Atlas::open(package.file, needs); });
  const auto images = imaging(settings, context);
  for (const Structure structure : structures) {
    const auto surface = opened->surface(structure);
    row.errors[structure] = assess::mesh_errors(surface->triangles, surface->positions, structure,
                                                *images.value->phantom,
                                                opened->manifest().workspace_from_lps, kCreaseMm);
    if (structure != Structure::Heart) continue;
    Vec3f low = surface->positions.front().front();
    Vec3f high = low;
    for (const Vec3f& x : surface->positions.front()) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
    row.draco_bits = pack::draco_bits((high - low).cast<double>().maxCoeff(),
                                      recipe_of_settings(settings).pack.surface_step_mm);
  }
  std::error_code ignored;
  fs::remove(package.file, ignored);
}

void BenchRunner::measure_published(BenchRow& row, StageContext& context) {
  const json& settings = row.run.settings;
  const auto images = imaging(settings, context);
  const bool exact = row.run.sweep == Sweep::Exact;
  const auto mapped = shapes(settings, row.run.sweep, context);
  Costs costs;
  std::shared_ptr<const LabelCycle> labels = images.value->truth;
  if (!exact) {
    const auto found = segmentation(settings, context);
    costs.add("segment", found);
    labels = std::shared_ptr<const LabelCycle>(found.value, &found.value->labels);
  }
  const fs::path file = work_ / "labels.nii.gz";
  const double rr_s = images.value->exam.stack.rr_interval_s;
  costs.add("pack", timed([&] {
              formats::write_nifti_labels(file, *labels, rr_s / labels->phase_count());
              return 0;
            }));
  row.package_bytes = fs::file_size(file);
  take_costs(row, costs);
  std::shared_ptr<const LabelCycle> read;
  row.load_ms = median_wall_ms(repeats_, [&] {
    read = std::make_shared<const LabelCycle>(formats::read_nifti_labels(file));
  });
  const assess::TruthSet& wanted = truth(context);
  const Affine& map = mapped.value->workspace_from_lps;
  for (const Structure structure : kBenchStructures) {
    const auto model = std::make_shared<const assess::VoxelModel>(read, structure, map, rr_s,
                                                                  wanted.forces.stiffness_n_per_m);
    row.errors[structure] =
        assess::surface_errors(assess::touch_of(model), wanted.surfaces.at(structure), map, rr_s);
    if (structure != Structure::Heart) continue;
    row.force = assess::force_errors({assess::touch_of(model), map, rr_s}, wanted.forces);
    const auto distance = [&](const Vec3& x, double t) { return model->contact(x, t).distance_mm; };
    row.query_path_ns = nanoseconds(path_questions(wanted, map, rr_s), 1, distance);
    row.query_random_ns = nanoseconds(random_questions(wanted, map, rr_s), 1, distance);
  }
}

}  // namespace beatlas::cli
