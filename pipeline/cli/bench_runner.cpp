#include "pipeline/cli/bench_runner.h"

#include <algorithm>

#include "pipeline/assess/bench_phantom.h"
#include "pipeline/assess/voxel_model.h"
#include "pipeline/cli/bench_probe.h"
#include "pipeline/formats/nifti.h"
#include "pipeline/phantom/render.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
using assess::BenchRow;
using assess::Family;
using assess::Sweep;
using nlohmann::json;
namespace fs = std::filesystem;
namespace {

constexpr std::array kStages{"phantom", "segment", "register", "field", "mesh", "pack", "query"};
const std::vector<Structure> kStructures{Structure::Heart, Structure::LvBlood, Structure::RvBlood};
/// Below this the fields of the ventricles would double the time of the sweep.
constexpr double kFinestOfVentriclesMm = 1.0;
constexpr double kCreaseMm = assess::TruthOptions{}.crease_band_mm;

/// What a stage and those before it obey, as a key.
std::string key_of(const json& settings, const std::string& stage) {
  json out = json::object();
  for (const char* each : kStages) {
    out[each] = settings.at(each);
    if (stage == each) break;
  }
  return out.dump();
}

Recipe recipe_of_settings(json settings) {
  settings.erase("phantom");
  settings.erase("query");
  return recipe_from_json(settings);
}

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

phantom::PhantomSpec spec_of(phantom::PhantomSpec spec, const json& settings) {
  const json& phantom = settings.at("phantom");
  spec.phases = phantom.at("phases").get<int>();
  return assess::scaled_matrix(std::move(spec), phantom.at("matrix").get<double>());
}

template <class Make>
auto timed(const Make& make) {
  const MemoryMeter memory;
  const double start = wall_clock_s();
  using Value = decltype(make());
  Timed<Value> out;
  out.value = std::make_shared<const Value>(make());
  out.wall_s = wall_clock_s() - start;
  out.memory_mb = memory.added_mb();
  return out;
}

CoverageCycle coverage_of_truth(const LabelCycle& labels) {
  CoverageCycle out;
  out.grid = labels.grid;
  for (const std::vector<std::uint8_t>& phase : labels.phases) {
    std::vector<float>& to = out.phases[Structure::Heart].emplace_back(phase.size());
    for (std::size_t v = 0; v < phase.size(); ++v) to[v] = phase[v] != kLabelBackground ? 1.F : 0.F;
  }
  return out;
}

int extreme_phase(const std::vector<double>& volumes, bool largest) {
  const auto at = largest ? std::max_element(volumes.begin(), volumes.end())
                          : std::min_element(volumes.begin(), volumes.end());
  return static_cast<int>(at - volumes.begin());
}

}  // namespace

BenchRunner::BenchRunner(phantom::PhantomSpec spec, json defaults, int repeats, fs::path work)
    : spec_(std::move(spec)),
      defaults_(std::move(defaults)),
      repeats_(repeats),
      work_(std::move(work)) {}

json BenchRunner::default_settings(const phantom::PhantomSpec& spec) {
  json out = recipe_to_json(Recipe{});
  out["phantom"] = {{"matrix", 1.0}, {"phases", spec.phases}};
  out["query"] = {{"space", "cubic"}, {"time", "cubic"}};
  return out;
}

template <class T, class Make>
Timed<T> BenchRunner::memo(std::map<std::string, Timed<T>>& kept, const std::string& key,
                           bool shared, const Make& make) {
  const auto found = kept.find(key);
  if (found != kept.end()) return found->second;
  Timed<T> made = timed(make);
  made.shared = shared;
  kept[key] = made;
  return made;
}

void BenchRunner::forget() {
  const auto of_one_run = [](const auto& entry) { return !entry.second.shared; };
  std::erase_if(imagings_, of_one_run);
  std::erase_if(segmentations_, of_one_run);
  std::erase_if(shapes_, of_one_run);
  std::erase_if(fields_, of_one_run);
  std::erase_if(surfaces_, of_one_run);
}

bool BenchRunner::is_default(const json& settings, const std::string& stage) const {
  return key_of(settings, stage) == key_of(defaults_, stage);
}

const assess::TruthSet& BenchRunner::truth(StageContext& context) {
  if (!truth_) {
    truth_ = assess::make_truth_set(phantom::Phantom(spec_), kStructures, {}, context);
  }
  return *truth_;
}

Timed<BenchRunner::Imaging> BenchRunner::imaging(const json& settings, StageContext& context) {
  return memo(imagings_, key_of(settings, "phantom"), is_default(settings, "phantom"), [&] {
    Imaging out;
    out.phantom = std::make_shared<const phantom::Phantom>(spec_of(spec_, settings));
    phantom::Rendering rendering = phantom::render(*out.phantom, context);
    out.exam.stack = std::move(rendering.cine);
    out.exam.source_format = "nifti";
    out.truth = std::make_shared<const LabelCycle>(std::move(rendering.labels));
    return out;
  });
}

Timed<Segmentation> BenchRunner::segmentation(const json& settings, StageContext& context) {
  const auto images = imaging(settings, context);
  return memo(segmentations_, key_of(settings, "segment"), is_default(settings, "segment"), [&] {
    return segment::segment_exam(images.value->exam, {}, recipe_of_settings(settings).segment,
                                 context);
  });
}

Timed<BenchRunner::Shapes> BenchRunner::shapes(const json& settings, Sweep sweep,
                                               StageContext& context) {
  const auto images = imaging(settings, context);
  std::optional<Timed<Segmentation>> found;
  if (sweep == Sweep::Images) found = segmentation(settings, context);
  const std::string key = std::string(sweep_name(sweep)) + key_of(settings, "register");
  return memo(shapes_, key, is_default(settings, "register"), [&] {
    const reg::RegisterOptions options = recipe_of_settings(settings).registration;
    const Grid& grid = images.value->exam.stack.grid();
    Shapes out;
    if (found) {
      out.workspace_from_lps = reg::workspace_from_lps(grid, found->value->coverage);
      for (ShapeCycle& shape :
           reg::shapes_in_workspace(*found->value, out.workspace_from_lps, options, context)) {
        const Structure structure = shape.structure;
        out.cycles[structure] = std::move(shape);
      }
      return out;
    }
    out.workspace_from_lps = reg::workspace_from_lps(grid, coverage_of_truth(*images.value->truth));
    for (const Structure structure : kStructures) {
      out.cycles[structure] =
          assess::exact_shape(*images.value->phantom, structure, out.workspace_from_lps,
                              options.shape_mm, options.margin_mm, context);
    }
    return out;
  });
}

Timed<FieldCycle> BenchRunner::field(const json& settings, Sweep sweep, Structure structure,
                                     StageContext& context) {
  const auto made = shapes(settings, sweep, context);
  const auto shape = made.value->cycles.find(structure);
  if (shape == made.value->cycles.end()) {
    throw Error(ErrorCode::Quality, std::string(structure_name(structure)) +
                                        " was not found in the images with these options");
  }
  const std::string key = std::string(sweep_name(sweep)) + std::string(structure_name(structure)) +
                          key_of(settings, "field");
  return memo(fields_, key, is_default(settings, "field"), [&] {
    return field::build_field(shape->second, recipe_of_settings(settings).field, context);
  });
}

Timed<SurfaceCycle> BenchRunner::surface(const json& settings, Sweep sweep, Structure structure,
                                         StageContext& context) {
  const auto made = field(settings, sweep, structure, context);
  const std::string key = std::string(sweep_name(sweep)) + std::string(structure_name(structure)) +
                          key_of(settings, "mesh");
  return memo(surfaces_, key, is_default(settings, "mesh"), [&] {
    return mesh::mesh_cycle(*made.value, recipe_of_settings(settings).mesh, context);
  });
}

atlas::Manifest BenchRunner::manifest(const Imaging& imaging, const Shapes& shapes,
                                      const std::string& scene) const {
  const Cine& cine = imaging.exam.stack;
  atlas::Manifest out;
  out.scene = scene;
  out.rr_interval_s = cine.rr_interval_s;
  out.frame_times_s = cine.frame_times_s;
  out.workspace_from_lps = shapes.workspace_from_lps;
  out.source_size = cine.grid().size;
  out.source_lps_from_index = cine.grid().mm_from_index;
  return out;
}

BenchRunner::Package BenchRunner::pack_fields(const json& settings, Sweep sweep,
                                              const std::vector<Structure>& structures,
                                              StageContext& context) {
  const Recipe recipe = recipe_of_settings(settings);
  pack::PackageContent content;
  content.manifest =
      manifest(*imaging(settings, context).value, *shapes(settings, sweep, context).value,
               structures.size() == 1 ? "palpation" : "full");
  std::vector<Timed<FieldCycle>> fields;
  for (const Structure structure : structures) {
    fields.push_back(field(settings, sweep, structure, context));
    content.manifest.structures.push_back(
        {std::string(structure_name(structure)), fields.back().value->volume_ml});
  }
  content.manifest.end_diastole = extreme_phase(fields.front().value->volume_ml, true);
  content.manifest.end_systole = extreme_phase(fields.front().value->volume_ml, false);
  Package out;
  out.file = work_ / ("package" + std::to_string(packages_.size()) + ".beatlas");
  const auto written = timed([&] {
    for (const Timed<FieldCycle>& each : fields) {
      content.fields.push_back(pack::encode_field(*each.value, recipe.pack));
    }
    pack::write_package(out.file, content, recipe.pack);
    return fs::file_size(out.file);
  });
  out.bytes = *written.value;
  out.wall_s = written.wall_s;
  out.memory_mb = written.memory_mb;
  return out;
}

BenchRunner::Package BenchRunner::pack_surfaces(const json& settings, Sweep sweep,
                                                const std::vector<Structure>& structures,
                                                StageContext& context) {
  const Recipe recipe = recipe_of_settings(settings);
  pack::PackageContent content;
  content.manifest = manifest(*imaging(settings, context).value,
                              *shapes(settings, sweep, context).value, "anatomy");
  for (const Structure structure : structures) {
    const auto made = surface(settings, sweep, structure, context);
    content.manifest.structures.push_back(
        {std::string(structure_name(structure)),
         field(settings, sweep, structure, context).value->volume_ml});
    content.surfaces.push_back({structure, made.value->triangles, made.value->positions});
  }
  Package out;
  out.file = work_ / ("package" + std::to_string(packages_.size()) + ".beatlas");
  const auto written = timed([&] {
    pack::write_package(out.file, content, recipe.pack);
    return fs::file_size(out.file);
  });
  out.bytes = *written.value;
  out.wall_s = written.wall_s;
  out.memory_mb = written.memory_mb;
  return out;
}

void BenchRunner::take_costs(BenchRow& row, const Costs& costs) const {
  row.stage_s = costs.stage_s;
  const std::string first = row.run.is_default || row.run.family == Family::Published
                                ? "phantom"
                                : assess::first_difference(row.run.settings, defaults_);
  bool concerned = false;
  row.build_s = 0;
  row.total_s = 0;
  for (const char* stage : kStages) {
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
    if (settings.at("field").at("voxel_mm").get<double>() >= kFinestOfVentriclesMm) {
      packages_[key_full] = pack_fields(settings, sweep, kStructures, context);
    }
    costs_[key] = costs;
  }
  const Package& package = packages_.at(key);
  row.package_bytes = package.bytes;
  take_costs(row, costs_.at(key));

  std::shared_ptr<const field::FieldQuery> heart;
  Affine map = Affine::Identity();
  std::vector<double> loads;
  for (int repeat = 0; repeat < repeats_; ++repeat) {
    const double start = wall_clock_s();
    const atlas::Atlas opened =
        atlas::Atlas::open(package.file, {.fields = {Structure::Heart}, .surfaces = {}});
    heart = std::make_shared<const field::FieldQuery>(opened.field(Structure::Heart),
                                                      opened.manifest().rr_interval_s);
    loads.push_back(1e3 * (wall_clock_s() - start));
    map = opened.manifest().workspace_from_lps;
  }
  row.load_ms = median(loads);

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
  const assess::MakeTouch of_heart = is_spline
                                         ? assess::touch_of(heart, wanted.stiffness_n_per_m)
                                         : assess::touch_of(sampled, wanted.stiffness_n_per_m);
  row.errors[Structure::Heart] =
      assess::surface_errors(of_heart, wanted.surfaces.at(Structure::Heart), map, rr_s);
  row.force = assess::force_errors(of_heart, wanted, map, rr_s);
  const auto full = packages_.find(key_full);
  if (full != packages_.end()) {
    const atlas::Atlas opened = atlas::Atlas::open(
        full->second.file, {.fields = {Structure::LvBlood, Structure::RvBlood}, .surfaces = {}});
    for (const Structure structure : {Structure::LvBlood, Structure::RvBlood}) {
      const auto query = std::make_shared<const field::FieldQuery>(opened.field(structure),
                                                                   opened.manifest().rr_interval_s);
      row.errors[structure] = assess::surface_errors(
          is_spline ? assess::touch_of(query, wanted.stiffness_n_per_m)
                    : assess::touch_of(cheaper(query), wanted.stiffness_n_per_m),
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
  std::vector<double> loads;
  for (int repeat = 0; repeat < repeats_; ++repeat) {
    const double start = wall_clock_s();
    opened = atlas::Atlas::open(package.file, needs);
    loads.push_back(1e3 * (wall_clock_s() - start));
  }
  row.load_ms = median(loads);
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
  std::vector<double> loads;
  std::shared_ptr<const LabelCycle> read;
  for (int repeat = 0; repeat < repeats_; ++repeat) {
    const double start = wall_clock_s();
    read = std::make_shared<const LabelCycle>(formats::read_nifti_labels(file));
    loads.push_back(1e3 * (wall_clock_s() - start));
  }
  row.load_ms = median(loads);
  const assess::TruthSet& wanted = truth(context);
  const Affine& map = mapped.value->workspace_from_lps;
  for (const Structure structure : kStructures) {
    const auto model = std::make_shared<const assess::VoxelModel>(read, structure, map, rr_s,
                                                                  wanted.stiffness_n_per_m);
    row.errors[structure] =
        assess::surface_errors(assess::touch_of(model), wanted.surfaces.at(structure), map, rr_s);
    if (structure != Structure::Heart) continue;
    row.force = assess::force_errors(assess::touch_of(model), wanted, map, rr_s);
    const auto distance = [&](const Vec3& x, double t) { return model->contact(x, t).distance_mm; };
    row.query_path_ns = nanoseconds(path_questions(wanted, map, rr_s), 1, distance);
    row.query_random_ns = nanoseconds(random_questions(wanted, map, rr_s), 1, distance);
  }
}

assess::ScalingRow BenchRunner::build_all(const json& settings, StageContext& context) {
  assess::ScalingRow out;
  const Recipe recipe = recipe_of_settings(settings);
  const MemoryMeter memory;
  const auto clocked = [&](const std::string& stage, const auto& make) {
    context.check_cancelled();
    const double start = wall_clock_s();
    auto made = make();
    out.stage_s[stage] = wall_clock_s() - start;
    if (stage != "phantom") out.total_s += out.stage_s[stage];
    return made;
  };
  const phantom::Phantom phantom(spec_of(spec_, settings));
  Imaging images;
  {
    phantom::Rendering rendering =
        clocked("phantom", [&] { return phantom::render(phantom, context); });
    images.exam.stack = std::move(rendering.cine);
  }
  out.size = static_cast<double>(images.exam.stack.grid().count());
  Shapes shapes;
  pack::PackageContent content;
  const fs::path file = work_ / "scaling.beatlas";
  std::vector<FieldCycle> fields;
  {
    const Segmentation found = clocked(
        "segment", [&] { return segment::segment_exam(images.exam, {}, recipe.segment, context); });
    const std::vector<ShapeCycle> cycles = clocked("register", [&] {
      shapes.workspace_from_lps = reg::workspace_from_lps(images.exam.stack.grid(), found.coverage);
      return reg::shapes_in_workspace(found, shapes.workspace_from_lps, recipe.registration,
                                      context);
    });
    fields = clocked("field", [&] {
      std::vector<FieldCycle> made;
      for (const ShapeCycle& shape : cycles) {
        made.push_back(field::build_field(shape, recipe.field, context));
      }
      return made;
    });
  }
  content.manifest = manifest(images, shapes, "palpation");
  clocked("pack", [&] {
    for (const FieldCycle& field : fields) {
      content.manifest.structures.push_back(
          {std::string(structure_name(field.structure)), field.volume_ml});
      if (field.structure == Structure::Heart) {
        content.fields.push_back(pack::encode_field(field, recipe.pack));
      }
    }
    pack::write_package(file, content, recipe.pack);
    return 0;
  });
  out.package_bytes = fs::file_size(file);
  out.peak_memory_mb = memory.added_mb();
  std::error_code ignored;
  fs::remove(file, ignored);
  return out;
}

}  // namespace beatlas::cli
