#pragma once
/// What the stages made -> what a package of a scene holds.

#include <optional>
#include <vector>

#include "pipeline/build/facts.h"
#include "pipeline/build/recipe.h"
#include "pipeline/build/scene.h"
#include "pipeline/core/surface_map.h"
#include "pipeline/pack/pack.h"

namespace beatlas::build {

/// What the stages made; all of it stands elsewhere and is only looked at.
struct MadeOfExam {
  const std::vector<FieldCycle>& fields;      ///< of the scene's plan, at least
  const std::vector<SurfaceCycle>& surfaces;  ///< of the scene's plan, at least; see make_surfaces
  const std::vector<SurfaceMap>& maps;        ///< of these surfaces
  std::vector<Structure> edited;              ///< whose surfaces a person edited: they stay so
  std::optional<LongAxis> axis;               ///< the LV's
};

/// The package of a scene, but for the images around the heart, which whoever has them packs.
/// Volume curves are those of the segmentation, of every structure and whatever the scene.
/// @param needed see structures_needed
/// @pre facts.workspace_from_lps
/// @throws Error{Quality} if volumes are farther from the segmentation's than the recipe allows;
/// Error{InvalidInput} if a surface of the scene is missing
[[nodiscard]] pack::PackageContent package_content(const Scene& scene, const Recipe& recipe,
                                                   const Facts& facts,
                                                   const std::vector<Structure>& needed,
                                                   const MadeOfExam& made, StageContext& context);

/// Takes the images around the heart into a package, and what they lost into its provenance.
void add_volume(pack::PackedVolume volume, pack::PackageContent& content);

/// What a package tells of its images.
[[nodiscard]] nlohmann::json volume_figures(const pack::PackedVolume& volume);

/// Names of structures as JSON lists them.
[[nodiscard]] nlohmann::json names_of(const std::vector<Structure>& structures);

}  // namespace beatlas::build
