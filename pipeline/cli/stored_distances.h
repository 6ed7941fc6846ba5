#pragma once
#include <memory>

#include "pipeline/core/shapes.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::cli {

/// The distances that a package's field stands for, at its own samples and phases: the value of
/// the spline, clamped. @param volume_ml [phase]
[[nodiscard]] FieldCycle distances_of(const std::shared_ptr<const atlas::FieldPayload>& field,
                                      std::vector<double> volume_ml);

}  // namespace beatlas::cli
