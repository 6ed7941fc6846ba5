#pragma once
/// How far off surfaces may lie.

#include <map>
#include <vector>

#include "pipeline/core/shapes.h"
#include "pipeline/report/report_data.h"
#include "runtime/atlas/manifest.h"

namespace beatlas::build {

/// Bands of the ventricles, the muscle and the heart's outside that hold the true surface with a
/// probability of 90 %; see atlas::BandQuery.
///
/// Within a slice the prior tells how far off an outline is likely to lie: what is labelled and not
/// expected and what is expected and not labelled, over the length of the outline, taken as that of
/// a circle of the larger area. Half of the band's width is a length of the structure's own and
/// that expectation times a number. Where a surface lies flat in the slices, images tell least:
/// there it is a share of the slices' distance, another at the structure's last slices toward base
/// and apex than between them. The numbers, 0 or more, are found by quantile regression (Koenker
/// and Bassett, Econometrica 1978;46:33-50, doi:10.2307/1913643) on the surfaces of drawn hearts at
/// end-diastole and end-systole, where no person had told anything: `scripts/fit_bands`. They are
/// known of labels that grew as is_fitted_to asks.
///
/// A structure has none where no prior was asked, where a person labelled more than half of its
/// area, or where it or the LV's axis was not found.
[[nodiscard]] std::map<Structure, atlas::SurfaceBand> surface_bands(
    const Segmentation& segmentation);

/// What a report tells of them: of structures whose end-diastole a person has not mostly labelled.
[[nodiscard]] std::vector<report::KnownSurface> known_surfaces(const Segmentation& segmentation);

}  // namespace beatlas::build
