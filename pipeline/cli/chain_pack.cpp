// The chain's package: what it holds, written, and looked at as `validate` looks at it.

#include <algorithm>
#include <utility>

#include "pipeline/assess/structural_checks.h"
#include "pipeline/cli/chain.h"
#include "pipeline/cli/quality.h"
#include "pipeline/cli/report_facts.h"
#include "pipeline/cli/version.h"
#include "pipeline/pack/volume_encoder.h"
#include "pipeline/segment/tissue.h"
#include "pipeline/study/files.h"
#include "pipeline/study/stage_files.h"
#include "runtime/atlas/atlas.h"
#include "runtime/atlas/scene.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
using nlohmann::json;
using study::Stage;
namespace {

constexpr auto kVolumeFigures = "pack/volume.json";

/// Of the package as it was written.
std::vector<assess::Check> checks_of(const fs::path& file, StageContext context) {
  const atlas::Needs all = atlas::everything_in(atlas::Atlas::open(file, {}).manifest());
  return assess::check_structure(atlas::Atlas::open(file, all), {}, context);
}

json names_of(const std::vector<Structure>& structures) {
  json out = json::array();
  for (const Structure structure : structures) out.push_back(structure_name(structure));
  return out;
}

}  // namespace

pack::PackedVolume Chain::packed_volume(const FieldCycle& heart) {
  const StackBox box =
      box_around(facts_.source, *facts_.workspace_from_lps, heart.distance_mm.grid, 0);
  HeartImages around =
      heart_images_ && heart_images_->box.holds(box)
          ? cut_images(*heart_images_, box)
          : cut_images(exam().stack.images, segment::noise_level(exam().stack.images), box);
  around.images.grid.mm_from_index = *facts_.workspace_from_lps * around.images.grid.mm_from_index;
  return pack::pack_volume(around.images, around.noise, heart, orders_.recipe.pack);
}

study::Wanted Chain::wanted_pack(const Scene& scene) {
  study::Wanted with = wanted_of(Stage::Pack, orders_);
  with.with_surfaces = scene_has_surfaces(scene);
  with.options["scene"] = scene_to_json(scene);
  with.options["quality"] = recipe_to_json(orders_.recipe).at("quality");
  with.options["needs"] = names_of(needed(scene));
  return with;
}

bool Chain::is_packed(const study::Wanted& with, const fs::path& file) const {
  return study_ && study::state_of(*study_, Stage::Pack, with).up_to_date() &&
         study::holds(file, study_->find(Stage::Pack)->package_sha256);
}

void Chain::pack(const Scene& scene, const fs::path& file) {
  scene_ = scene;
  const study::Wanted with = wanted_pack(scene);
  if (is_packed(with, file)) {
    kept_.push_back(Stage::Pack);
    forget_refusal();
    return;
  }
  run(Stage::Pack, [&](StageContext& context) {
    note_for_package();
    segmentation_.reset();
    demand_usable(scene, with.with_surfaces ? surface_cycles() : std::vector<SurfaceCycle>());
    const std::vector<FieldCycle>& fields = field_cycles();
    std::vector<SurfaceCycle> used;
    for (const FieldCycle& field : fields) {
      if (!atlas::scene_holds(scene.content, atlas::kSurfaceKind, field.structure)) continue;
      const std::vector<SurfaceCycle>& surfaces = surface_cycles();
      const auto surface = std::find_if(
          surfaces.begin(), surfaces.end(),
          [&](const SurfaceCycle& candidate) { return candidate.structure == field.structure; });
      if (surface == surfaces.end()) {
        throw_invalid("there is no surface of " + std::string(structure_name(field.structure)) +
                      ", which the scene " + scene.content + " needs; run the stage mesh again");
      }
      used.push_back(*surface);
    }
    // A package is the same from a study that knows atria and from a build that had no use for
    // them.
    const bool with_atria = scene_has_atria(scene);
    const auto is_told = [&](Structure structure) {
      return with_atria || !is_beyond_base(structure);
    };
    std::vector<StructureQuality> quality = measure_quality(facts_.volumes, fields, used);
    std::erase_if(quality, [&](const StructureQuality& each) { return !is_told(each.structure); });
    demand_quality(quality, orders_.recipe.quality);

    pack::PackageContent content;
    atlas::Manifest& manifest = content.manifest;
    manifest.scene = scene.content;
    manifest.stiffness_n_per_m = scene.stiffness_n_per_m;
    manifest.rr_interval_s = facts_.rr_interval_s;
    manifest.frame_times_s = facts_.frame_times_s;
    manifest.workspace_from_lps = *facts_.workspace_from_lps;
    manifest.source_size = facts_.source.size;
    manifest.source_lps_from_index = facts_.source.mm_from_index;
    manifest.end_diastole = facts_.end_diastole;
    manifest.end_systole = facts_.end_systole;
    for (const FieldCycle& field : fields) {
      if (!is_told(field.structure)) continue;
      manifest.structures.push_back(
          {std::string(structure_name(field.structure)), field.volume_ml});
    }
    json stages = json::object();
    for (const auto& [stage, fact] : facts_.stages) {
      if (stage == Stage::Mesh && used.empty()) continue;
      stages[std::string(study::stage_name(stage))] = {{"version", fact.version},
                                                       {"options", fact.options}};
    }
    if (!with_atria && stages.contains("segment")) stages["segment"]["options"]["atria"] = false;
    const json pack_options = stage_options(orders_.recipe, Stage::Pack);
    stages["pack"] = {{"version", kVersion}, {"options", pack_options}};
    manifest.provenance = {{"program", "beatlas"},
                           {"version", kVersion},
                           {"stages", stages},
                           {"input_sha256", facts_.input_sha256},
                           {"source_format", facts_.source_format},
                           {"decisions", facts_.decisions},
                           {"warnings", facts_.warnings},
                           {"quality", quality_to_json(quality)},
                           {"needs", names_of(needed(scene))}};
    if (!facts_.phantom_identity.empty()) {
      manifest.provenance["phantom_identity"] = facts_.phantom_identity;
    }
    for (const FieldCycle& field : fields) {
      context.check_cancelled();
      if (!atlas::scene_holds(scene.content, atlas::kFieldKind, field.structure)) continue;
      const double share = static_cast<double>(content.fields.size()) / double(fields.size());
      context.progress(0.4 * share, std::string(structure_name(field.structure)) + ", distances");
      content.fields.push_back(pack::encode_field(field, orders_.recipe.pack));
    }
    context.progress(0.4, "images around the heart");
    json volume;
    if (scene_has_volume(scene)) {
      const auto heart = std::find_if(fields.begin(), fields.end(), [](const FieldCycle& field) {
        return field.structure == Structure::Heart;
      });
      if (heart != fields.end()) content.volume = packed_volume(*heart);
    }
    exam_.reset();
    heart_images_.reset();
    if (content.volume) {
      volume = {{"noise", content.volume->noise},
                {"quantum", content.volume->quantum},
                {"rms_error", content.volume->rms_error},
                {"psnr_db", content.volume->psnr_db}};
      manifest.provenance["volume"] = volume;
    }
    StageContext levels = context.part(0.5, 0.75);
    add_surfaces(scene, used, content, levels);
    context.check_cancelled();
    context.progress(0.75, "the package's file");
    pack::write_package(file, content, orders_.recipe.pack);
    const std::vector<assess::Check> checks = checks_of(file, context.part(0.8, 1, "checks"));
    for (const std::string& failure : assess::failures_of(checks)) context.warn(failure);
    study::StageRecord record{with.version, with.options, {}, {}, {}, {}};
    if (study_) {
      record.inputs = study_->inputs_now(Stage::Pack, with.with_surfaces);
      record.package_sha256 = study::sha256_of_file(file);
    }
    leave(Stage::Pack, std::move(record), [&] {
      study::make_folder(study_->folder() / "pack");
      study::write_json(
          study_->folder() / kPackContents,
          pack_contents(atlas::Atlas::open(file, {}).manifest(), fs::file_size(file), checks));
      if (volume.is_null()) return study::FileList{kPackContents};
      study::write_json(study_->folder() / kVolumeFigures, volume);
      return study::FileList{kPackContents, kVolumeFigures};
    });
  });
}

}  // namespace beatlas::cli
