// The build's package: what it holds, written, and looked at as `validate` looks at it.

#include <algorithm>
#include <utility>

#include "pipeline/assess/structural_checks.h"
#include "pipeline/build/incremental_build.h"
#include "pipeline/build/package_content.h"
#include "pipeline/build/report_facts.h"
#include "pipeline/build/surfaces.h"
#include "pipeline/study/files.h"
#include "pipeline/study/stage_files.h"
#include "pipeline/tissue/tissue.h"
#include "runtime/atlas/atlas.h"
#include "runtime/atlas/scene.h"
#include "runtime/base/error.h"

namespace beatlas::build {
namespace fs = std::filesystem;
using study::Stage;
namespace {

constexpr auto kVolumeFigures = "pack/volume.json";

atlas::Atlas opened(const fs::path& file) {
  return atlas::Atlas::open(file, atlas::everything_in(atlas::Atlas::open(file, {}).manifest()));
}

}  // namespace

pack::PackedVolume IncrementalBuild::packed_volume(const FieldCycle& heart) {
  const StackBox box =
      box_around(facts_.source, *facts_.workspace_from_lps, heart.distance_mm.grid, 0);
  HeartImages around =
      heart_images_ && heart_images_->box.holds(box)
          ? cut_images(*heart_images_, facts_.source, box)
          : cut_images(exam().stack.images, tissue::noise_level(exam().stack.images), box);
  return build::packed_volume(std::move(around), *facts_.workspace_from_lps, heart,
                              orders_.recipe.pack);
}

study::Wanted IncrementalBuild::wanted_pack(const Scene& scene) {
  study::Wanted with = wanted_of(Stage::Pack, orders_);
  with.options["scene"] = scene_to_json(scene);
  with.options["quality"] = recipe_to_json(orders_.recipe).at("quality");
  with.options["needs"] = names_of(needed(scene));
  return with;
}

bool IncrementalBuild::is_packed(const study::Wanted& with, const fs::path& file) const {
  return study_ && study::state_of(*study_, Stage::Pack, with).up_to_date() &&
         study::holds(file, study_->find(Stage::Pack)->package_sha256);
}

void IncrementalBuild::pack(const Scene& scene, const fs::path& file) {
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
    demand_usable(scene, surface_cycles());
    const std::vector<FieldCycle>& fields = field_cycles();
    std::optional<pack::PackedVolume> volume;
    const auto heart = std::find_if(fields.begin(), fields.end(), [](const FieldCycle& field) {
      return field.structure == Structure::Heart;
    });
    if (plan_of(scene).volume && heart != fields.end()) {
      context.progress(0, "images around the heart");
      volume = packed_volume(*heart);
    }
    exam_.reset();
    heart_images_.reset();
    const MadeOfExam made{fields, surface_cycles(), surface_maps(),
                          study_ ? edited_surfaces(*study_) : std::vector<Structure>(), axis()};
    StageContext making = context.part(0.1, 0.75);
    pack::PackageContent content =
        package_content(scene, orders_.recipe, facts_, needed(scene), made, making);
    const bool has_volume = volume.has_value();
    if (has_volume) add_volume(std::move(*volume), content);
    context.check_cancelled();
    context.progress(0.75, "the package's file");
    study::StageRecord record = new_record(with);
    nlohmann::json contents;
    // All that takes a while, and may be stopped, comes before the package has its name: a study
    // finds the package that it made by the record, which has to be of the one that lies there.
    const auto look = [&](const fs::path& written) {
      const atlas::Atlas package = opened(written);
      StageContext checking = context.part(0.8, 1, "checks");
      const std::vector<assess::Check> checks = assess::check_structure(package, {}, checking);
      for (const std::string& failure : assess::failures_of(checks)) context.warn(failure);
      if (!study_) return;
      contents = pack_contents(package.manifest(), fs::file_size(written), checks,
                               enclosed_volumes(package));
      record.inputs = study_->inputs_now(Stage::Pack);
      record.package_sha256 = study::sha256_of_file(written);
      context.check_cancelled();
    };
    pack::write_package(file, content, orders_.recipe.pack, look);
    leave(Stage::Pack, std::move(record), [&] {
      study::make_folder(study_->folder() / "pack");
      study::write_json(study_->folder() / kPackContents, contents);
      if (!has_volume) return study::FileList{kPackContents};
      study::write_json(study_->folder() / kVolumeFigures, volume_figures(*content.volume));
      return study::FileList{kPackContents, kVolumeFigures};
    });
  });
}

}  // namespace beatlas::build
