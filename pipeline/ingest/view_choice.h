#pragma once
/// Which cines are kept beside the stack, and what is told of those that are not.

#include <vector>

#include "pipeline/ingest/stack_choice.h"

namespace beatlas::ingest {

/// Cines of one or two parallel slices become views of a choice whose stack stands; whatever else
/// was not used is told, and what was used though it is no original.
/// @param good of the stack: it has trigger times, and frames enough to blend
void choose_views(const std::vector<Plane>& planes, const Plane& stack_plane, bool good,
                  const IngestOptions& options, Choice& choice);

}  // namespace beatlas::ingest
