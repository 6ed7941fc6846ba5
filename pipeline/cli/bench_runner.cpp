#include "pipeline/cli/bench_runner.h"

#include <algorithm>

#include "pipeline/assess/bench_phantom.h"
#include "pipeline/build/build_atlas.h"
#include "pipeline/build/learned_prior.h"
#include "pipeline/cli/bench_settings.h"
#include "pipeline/phantom/render.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
using assess::Sweep;
using nlohmann::json;
namespace fs = std::filesystem;
namespace {

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

Segmentation segmented(const Exam& exam, const build::Recipe& recipe, StageContext& context) {
  const std::optional<prior::PriorCycle> learned = build::prior_of(exam, recipe, context);
  return build::segment_with(exam, {}, recipe.segment, context, learned ? &*learned : nullptr);
}

/// Notes what each stage of a build takes, and passes on what it says.
class Clocked : public build::Listener {
 public:
  explicit Clocked(const StageContext& context) : context_(context) {}

  void stage(const std::string& name, const std::function<void(StageContext&)>& body) override {
    context_.check_cancelled();
    StageContext own = context_;
    const double start = wall_clock_s();
    body(own);
    times_.push_back({name, wall_clock_s() - start, 0});
  }
  void warn(std::string_view line) override { context_.warn(line); }
  void tell(std::string_view line) override { context_.log(line); }
  void log(std::string_view line) override { context_.log(line); }
  [[nodiscard]] const std::vector<report::StageTime>& times() const override { return times_; }

 private:
  const StageContext& context_;
  std::vector<report::StageTime> times_;
};

}  // namespace

std::string key_of(const json& settings, const std::string& stage) {
  json out = json::object();
  for (const char* each : kBenchStages) {
    out[each] = settings.at(each);
    if (stage == each) break;
  }
  return out.dump();
}

build::Recipe recipe_of_settings(json settings) {
  settings.erase("phantom");
  settings.erase("level");
  settings.erase("query");
  return build::recipe_from_json(settings);
}

phantom::PhantomSpec spec_of(phantom::PhantomSpec spec, const json& settings) {
  const json& phantom = settings.at("phantom");
  spec.phases = phantom.at("phases").get<int>();
  return assess::scaled_matrix(std::move(spec), phantom.at("matrix").get<double>());
}

BenchRunner::BenchRunner(phantom::PhantomSpec spec, json defaults, int repeats, fs::path work)
    : spec_(std::move(spec)),
      defaults_(std::move(defaults)),
      repeats_(repeats),
      work_(std::move(work)) {}

json BenchRunner::default_settings(const phantom::PhantomSpec& spec) {
  // What the stages choose for such slices is said in numbers, which the runs vary.
  build::Recipe recipe;
  recipe.registration.shape_mm =
      shape::lattice_edge_mm(spec.grid.spacing_mm().z(), {}, recipe.registration);
  recipe.field.voxel_mm = field::voxel_edge_mm(*recipe.registration.shape_mm, recipe.field);
  recipe.mesh.edge_mm = mesh::triangle_edge_mm(*recipe.field.voxel_mm, recipe.mesh);
  json out = build::recipe_to_json(recipe);
  out["phantom"] = {{"matrix", 1.0}, {"phases", spec.phases}};
  out["level"] = {{"edge_mm", out.at("mesh").at("edge_mm")}};
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
    truth_ = assess::make_truth_set(phantom::Phantom(spec_), kBenchStructures, {}, context);
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
  return memo(segmentations_, key_of(settings, "segment"), is_default(settings, "segment"),
              [&] { return segmented(images.value->exam, recipe_of_settings(settings), context); });
}

Timed<BenchRunner::Shapes> BenchRunner::shapes(const json& settings, Sweep sweep,
                                               StageContext& context) {
  const auto images = imaging(settings, context);
  std::optional<Timed<Segmentation>> found;
  if (sweep == Sweep::Images) found = segmentation(settings, context);
  const std::string key = std::string(sweep_name(sweep)) + key_of(settings, "register");
  return memo(shapes_, key, is_default(settings, "register"), [&] {
    const shape::RegisterOptions options = recipe_of_settings(settings).registration;
    const Grid& grid = images.value->exam.stack.grid();
    Shapes out;
    if (found) {
      out.workspace_from_lps = shape::workspace_from_lps(grid, found->value->coverage);
      for (ShapeCycle& shape :
           shape::shapes_in_workspace(*found->value, out.workspace_from_lps, options, context)) {
        const Structure structure = shape.structure;
        out.cycles[structure] = std::move(shape);
      }
      return out;
    }
    out.workspace_from_lps =
        shape::workspace_from_lps(grid, coverage_of_truth(*images.value->truth));
    for (const Structure structure : kBenchStructures) {
      out.cycles[structure] = assess::exact_shape(
          *images.value->phantom, structure, out.workspace_from_lps,
          shape::lattice_edge_mm(grid.spacing_mm().z(), {}, options), options.margin_mm, context);
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
  const build::Recipe recipe = recipe_of_settings(settings);
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

BenchRunner::Package BenchRunner::pack_surfaces(const json& settings,
                                                const std::vector<SurfaceCycle>& surfaces,
                                                double edge_mm, Sweep sweep,
                                                StageContext& context) {
  const build::Recipe recipe = recipe_of_settings(settings);
  pack::PackageContent content;
  content.manifest = manifest(*imaging(settings, context).value,
                              *shapes(settings, sweep, context).value, "anatomy");
  content.manifest.surface_edges_mm = {edge_mm};
  for (const SurfaceCycle& surface : surfaces) {
    content.manifest.structures.push_back(
        {std::string(structure_name(surface.structure)),
         field(settings, sweep, surface.structure, context).value->volume_ml});
    content.surfaces.push_back({surface.structure, surface.triangles, surface.positions});
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

assess::ScalingRow BenchRunner::build_all(const json& settings, StageContext& context) {
  assess::ScalingRow out;
  const MemoryMeter memory;
  const phantom::Phantom phantom(spec_of(spec_, settings));
  Clocked listener(context);
  Exam exam;
  listener.stage("phantom", [&](StageContext& own) {
    exam.stack = phantom::render(phantom, own).cine;
    exam.source_format = "nifti";
  });
  out.size = static_cast<double>(exam.stack.grid().count());
  const fs::path file = work_ / "scaling.beatlas";
  build::Scene scene;
  scene.content = "palpation";
  build::build_atlas(std::move(exam), recipe_of_settings(settings), scene, file, listener);
  out.peak_memory_mb = memory.added_mb();
  for (const report::StageTime& time : listener.times()) {
    out.stage_s[time.stage] = time.wall_s;
    if (time.stage != "phantom") out.total_s += time.wall_s;
  }
  out.package_bytes = fs::file_size(file);
  std::error_code ignored;
  fs::remove(file, ignored);
  return out;
}

}  // namespace beatlas::cli
