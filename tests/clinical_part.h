#pragma once
/// A phantom whose images are as coarse as those of a clinical exam, in a fraction of the time.

#include "pipeline/phantom/spec.h"

namespace beatlas::made {

/// The preset `clinical`, half its field of view about the same middle.
[[nodiscard]] inline phantom::PhantomSpec clinical_part() {
  phantom::PhantomSpec spec = phantom::preset("clinical");
  const Vec3 middle = spec.grid.mm(95.5, 95.5, 0);
  spec.grid.size = {112, 112, 13};
  spec.grid.mm_from_index.translation() += middle - spec.grid.mm(55.5, 55.5, 0);
  return spec;
}

}  // namespace beatlas::made
