/// What is measured of a run, from the package it left.
#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/assess/voxel_model.h"
#include "pipeline/build/heart_images.h"
#include "pipeline/build/surfaces.h"
#include "pipeline/cli/bench_settings.h"
#include "pipeline/formats/nifti.h"
#include "pipeline/phantom/render.h"
#include "pipeline/tissue/tissue.h"
#include "runtime/atlas/volume.h"
#include "runtime/atlas/volume_payload.h"
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
constexpr double kBetweenPhases = 0.43;  // of the beat: a moment that is no phase's
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

/// Voxels of a box of images that the heart comes within its outer_mm of in any phase.
std::vector<std::size_t> voxels_near(const FieldCycle& heart, const Affine& workspace_from_index,
                                     const Index3& size) {
  const Grid& lattice = heart.distance_mm.grid;
  const Affine lattice_from_index = lattice.mm_from_index.inverse() * workspace_from_index;
  std::vector<std::size_t> out;
  std::size_t v = 0;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i, ++v) {
        const Vec3 place = (lattice_from_index * Vec3(i, j, k)).array().round();
        const Index3 at{static_cast<int>(place[0]), static_cast<int>(place[1]),
                        static_cast<int>(place[2])};
        if (!lattice.contains(at[0], at[1], at[2])) continue;
        const std::size_t sample = lattice.offset(at[0], at[1], at[2]);
        const auto is_near = [&](const std::vector<float>& phase) {
          return static_cast<double>(phase[sample]) < heart.outer_mm;
        };
        if (std::ranges::any_of(heart.distance_mm.phases, is_near)) out.push_back(v);
      }
    }
  }
  return out;
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
    case Family::Volume:
      measure_volume(row, context);
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
  std::vector<SurfaceCycle> surfaces;
  std::vector<FieldCycle> fields;
  for (const Structure structure : structures) {
    surfaces.push_back(*surface(settings, sweep, structure, context).value);
    fields.push_back(*field(settings, sweep, structure, context).value);
  }
  const mesh::MeshOptions made = recipe_of_settings(settings).mesh;
  double edge_mm = mesh::triangle_edge_mm(fields.front().voxel_mm, made);
  if (settings.at("level") != defaults_.at("level")) {
    edge_mm = settings.at("level").at("edge_mm").get<double>();
    const auto level = timed(
        [&] { return build::surfaces_at_level(surfaces, fields, made, edge_mm, true, context); });
    costs.add("level", level);
    surfaces = *level.value;
  }
  const Package package = pack_surfaces(settings, surfaces, edge_mm, sweep, context);
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

void BenchRunner::measure_volume(BenchRow& row, StageContext& context) {
  const json& settings = row.run.settings;
  const Sweep sweep = row.run.sweep;
  const auto images = imaging(settings, context);
  const auto heart = field(settings, sweep, Structure::Heart, context);
  const Affine& map = shapes(settings, sweep, context).value->workspace_from_lps;
  const ImageCycle<float>& stack = images.value->exam.stack.images;
  const build::StackBox box = build::box_around(stack.grid, map, heart.value->distance_mm.grid, 0);
  Costs costs;
  const auto packed = timed([&] {
    return build::packed_volume(build::cut_images(stack, tissue::noise_level(stack), box), map,
                                *heart.value, recipe_of_settings(settings).pack);
  });
  costs.add("pack", packed);
  row.package_bytes = packed.value->entry.size();
  take_costs(row, costs);
  std::optional<atlas::VolumePayload> volume;
  row.load_ms =
      median_wall_ms(repeats_, [&] { volume = atlas::decode_volume(packed.value->entry); });

  phantom::PhantomSpec clean = spec_of(spec_, settings);
  clean.scanner.snr_blood = std::numeric_limits<double>::infinity();
  const Cine truth = phantom::render(phantom::Phantom(clean), context).cine;
  const build::HeartImages given = build::cut_images(stack, packed.value->noise, box);
  const build::HeartImages wanted = build::cut_images(truth.images, 0, box);
  const std::vector<std::size_t> near =
      voxels_near(*heart.value, map * given.images.grid.mm_from_index, box.size);
  double sum = 0;
  double of_images = 0;
  std::vector<float> found(volume->sample_count());
  for (std::size_t p = 0; p < given.images.phases.size(); ++p) {
    atlas::volume_intensities(*volume, static_cast<double>(p) / volume->phases, found);
    for (const std::size_t v : near) {
      const double right = wanted.images.phases[p][v];
      sum += std::pow(static_cast<double>(found[v]) - right, 2);
      of_images += std::pow(static_cast<double>(given.images.phases[p][v]) - right, 2);
    }
  }
  assess::VolumeErrors errors;
  errors.of_noise = std::sqrt(sum / of_images);
  errors.voxel_ns = 1e6 / static_cast<double>(found.size()) * median_wall_ms(repeats_, [&] {
                      atlas::volume_intensities(*volume, kBetweenPhases, found);
                    });
  row.volume = errors;
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
