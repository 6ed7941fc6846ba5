#pragma once
/// Which contrast an exam's cines have, decided once for all its stacks and views.

#include <optional>
#include <vector>

#include "pipeline/ingest/plane_groups.h"

namespace beatlas::ingest {

/// Of the contrasts of ordinary cines (originals, if there are any) the one that was planned in
/// most directions, then at most places, then the one that is not spoiled: a cine protocol goes
/// through all views, tagging and flow through a few. Only a contrast that has a stack is asked,
/// and that not beside one of half as many slices again in the same direction. Nothing if two are
/// equal.
[[nodiscard]] std::optional<Contrast> contrast_of_cines(const std::vector<Plane>& planes);

}  // namespace beatlas::ingest
