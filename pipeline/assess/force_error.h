#pragma once
/// The force that is felt over a set of palpations, against that of the closed form.

#include <functional>
#include <memory>
#include <vector>

#include "pipeline/assess/figures.h"
#include "pipeline/assess/palpation_set.h"
#include "pipeline/core/stage_context.h"
#include "runtime/haptics/two_step.h"

namespace beatlas::assess {

/// What the user point feels at a place of the workspace [mm] and a time [s], before any cap. Asked
/// tick after tick of one trajectory, so it may remember.
using ForceAt = std::function<haptics::Contact(const Vec3& workspace_mm, double t_s)>;

/// Whatever makes a force: a package, or another interpolation.
struct ForceCandidate {
  /// A ForceAt for one trajectory. Called from several threads at once.
  std::function<ForceAt()> start;
  Affine workspace_from_lps = Affine::Identity();
  double rr_interval_s = 0;  ///< [s] > 0: its cycle; a share of it is the same share of the truth's
};

/// The two-step model on a package's field, as the runtime makes it.
[[nodiscard]] ForceCandidate two_step_candidate(std::shared_ptr<const field::FieldQuery> field,
                                                const haptics::TwoStepOptions& options,
                                                const Affine& workspace_from_lps);

/// F = K max(0, -phi) n of the closed form at every tick.
struct TrueForces {
  PalpationSet set;
  double stiffness_n_per_m = 0;
  std::vector<std::vector<Vec3>> force_n;   ///< [trajectory][tick] axes of patient LPS
  std::vector<std::vector<char>> touching;  ///< [trajectory][tick] whether phi < 0
};

/// Computed once for any number of candidates. @throws Error{Machine} if cancelled.
[[nodiscard]] TrueForces true_forces(const phantom::Phantom& phantom, PalpationSet set,
                                     double stiffness_n_per_m, StageContext& context);

/// Every trajectory starts with a candidate of its own. The result does not depend on the number
/// of threads. See ForceErrors for the figures.
[[nodiscard]] ForceErrors force_errors(const ForceCandidate& candidate, const TrueForces& truth);

}  // namespace beatlas::assess
