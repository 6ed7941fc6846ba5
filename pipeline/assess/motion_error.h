#pragma once
#include "pipeline/assess/figures.h"
#include "pipeline/phantom/phantom.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::assess {

struct MotionOptions {
  double on_wall_mm = 1.0;  ///< > 0 [mm]: a vertex this near to a face of the LV's wall is of it
  double rim_mm = 4.0;      ///< >= 0 [mm]: and this far from the creases of the true surface
  int parts = 4;            ///< 1..64: of normal-only motion, to a step between phases
};

/// How far the vertices of a surface leave the muscle that they were on. A vertex that lies on the
/// LV's endocardium or epicardium in the first phase stands for the muscle there
/// (phantom/material.h); where the surface lay beside the true one then does not count:
///
///   e = (x_p - x_0) - (X_p - X_0),  x the vertex, X the muscle,
///
/// over all other phases. The tangential part is that across the shell's normal at X_p. Beside it
/// stands what motion along normals alone would have made of the same points, on the true surface:
/// from X_0 to the nearest point of each following moment's surface, `parts` to a phase.
/// @return points == 0 where no vertex lies on the wall, or the phantom has an infarct, whose
/// muscle has no closed form
[[nodiscard]] MotionErrors motion_errors(const atlas::SurfacePayload& surface,
                                         const Affine& workspace_from_lps,
                                         const phantom::Phantom& truth,
                                         const MotionOptions& options);

}  // namespace beatlas::assess
