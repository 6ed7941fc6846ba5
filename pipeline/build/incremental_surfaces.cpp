// The mesh stage in a build.
#include "pipeline/build/incremental_build.h"
#include "pipeline/build/surfaces.h"

namespace beatlas::build {
using study::Stage;

void IncrementalBuild::surfaces() {
  if (keeps(Stage::Mesh, wanted_of(Stage::Mesh, orders_))) return;
  run(Stage::Mesh, [&](StageContext& context) {
    const StageContext making = context.part(0, kMade);
    surfaces_ = make_surfaces(field_cycles(), plan_.surfaces, orders_.recipe.mesh, making);
    if (!exam_noted_) (void)exam();
    const std::optional<LongAxis> along = axis();
    if (along && !along->rv_base_mm.empty() && !along->rv_centre_mm) {
      context.warn(
          "segment/long_axis.json does not tell rv_centre_lps_mm, from which segments are counted: "
          "nothing on the wall is named, and no thickness is told");
    }
    maps_ = make_maps(field_cycles(), *surfaces_,
                      mesh::map_frame(along, workspace_from_lps(), facts_.source.spacing_mm()));
    context.progress(kMade, "files of the study");
    leave(Stage::Mesh, new_record(Stage::Mesh), [&] {
      study::FileList files = study::write_surfaces(study_->folder(), *surfaces_);
      const study::FileList maps = study::write_surface_maps(study_->folder(), *maps_);
      files.insert(files.end(), maps.begin(), maps.end());
      return files;
    });
  });
}

std::optional<LongAxis> IncrementalBuild::axis() const {
  return study_ ? study::read_long_axis(study_->folder()) : facts_.axis;
}

Affine IncrementalBuild::workspace_from_lps() const {
  return study_ ? study::read_workspace_from_lps(study_->folder())
                : facts_.workspace_from_lps.value();
}

}  // namespace beatlas::build
