#include "pipeline/assess/force_error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/assess/statistics.h"
#include "pipeline/core/parallel.h"

namespace beatlas::assess {
namespace {

constexpr double kJndShare = 0.07;         // Pang 1991
constexpr double kSmallestForceN = 0.049;  // 5 gf, the smallest that is felt

/// What one trajectory gave.
struct Felt {
  std::vector<Weighted> error_n;  // of ticks in contact in either
  std::vector<Weighted> error_jnd;
  double max_jump_n = 0;
  double true_max_jump_n = 0;
  int differs = 0;
};

Felt follow(const ForceCandidate& candidate, const TrueForces& truth, std::size_t trajectory) {
  const std::vector<Vec3>& path = truth.set.trajectories[trajectory].at_lps;
  const double tick_s = candidate.rr_interval_s / truth.set.ticks_per_beat;
  const Eigen::Matrix3d turn = candidate.workspace_from_lps.linear();
  const ForceAt force_at = candidate.start();
  Felt out;
  Vec3 before = Vec3::Zero();
  for (std::size_t tick = 0; tick < path.size(); ++tick) {
    const haptics::Contact contact =
        force_at(candidate.workspace_from_lps * path[tick], tick_s * static_cast<double>(tick));
    const Vec3& true_force = truth.force_n[trajectory][tick];
    const bool true_touch = truth.touching[trajectory][tick] != 0;
    if (contact.touching || true_touch) {
      const double error = (contact.force_n - turn * true_force).norm();
      out.error_n.push_back({error});
      out.error_jnd.push_back({error / (kJndShare * std::max(true_force.norm(), kSmallestForceN))});
    }
    if (contact.touching != true_touch) ++out.differs;
    if (tick > 0) {
      out.max_jump_n = std::max(out.max_jump_n, (contact.force_n - before).norm());
      out.true_max_jump_n =
          std::max(out.true_max_jump_n, (true_force - truth.force_n[trajectory][tick - 1]).norm());
    }
    before = contact.force_n;
  }
  return out;
}

}  // namespace

ForceCandidate two_step_candidate(std::shared_ptr<const field::FieldQuery> field,
                                  const haptics::TwoStepOptions& options,
                                  const Affine& workspace_from_lps) {
  const double rr_s = field->rr_interval_s();
  (void)haptics::TwoStepModel(field, options);  // so that a bad option is told here
  return {[field = std::move(field), options]() -> ForceAt {
            const auto model = std::make_shared<haptics::TwoStepModel>(field, options);
            return [model](const Vec3& x, double t_s) { return model->evaluate(x, t_s); };
          },
          workspace_from_lps, rr_s};
}

TrueForces true_forces(const phantom::Phantom& phantom, PalpationSet set, double stiffness_n_per_m,
                       StageContext& context) {
  TrueForces out{std::move(set), stiffness_n_per_m, {}, {}};
  const Structure structure = out.set.structure;
  for (const Trajectory& path : out.set.trajectories) {
    out.force_n.emplace_back(path.at_lps.size(), Vec3::Zero());
    out.touching.emplace_back(path.at_lps.size(), 0);
  }
  // Moment by moment of the beat: the phantom at one moment serves all trajectories and beats.
  const auto beat = static_cast<std::size_t>(out.set.ticks_per_beat);
  parallel_for(beat, [&](std::size_t moment) {
    context.check_cancelled();
    const auto frame = phantom.frame(out.set.tick_s * static_cast<double>(moment));
    for (std::size_t n = 0; n < out.set.trajectories.size(); ++n) {
      const std::vector<Vec3>& path = out.set.trajectories[n].at_lps;
      for (std::size_t tick = moment; tick < path.size(); tick += beat) {
        if (!frame->contains(structure, path[tick])) continue;
        const phantom::Nearest nearest = frame->nearest(structure, path[tick]);
        out.touching[n][tick] = 1;
        out.force_n[n][tick] =
            haptics::contact_force_n(stiffness_n_per_m, nearest.distance_mm, nearest.outward);
      }
    }
  });
  return out;
}

ForceErrors force_errors(const ForceCandidate& candidate, const TrueForces& truth) {
  const std::size_t count = truth.set.trajectories.size();
  std::vector<Felt> felt(count);
  parallel_for(count, [&](std::size_t n) { felt[n] = follow(candidate, truth, n); });
  ForceErrors out;
  out.trajectories = static_cast<int>(count);
  std::vector<Weighted> error_n;
  std::vector<Weighted> error_jnd;
  for (std::size_t n = 0; n < count; ++n) {
    const Felt& each = felt[n];
    error_n.insert(error_n.end(), each.error_n.begin(), each.error_n.end());
    error_jnd.insert(error_jnd.end(), each.error_jnd.begin(), each.error_jnd.end());
    out.max_jump_n = std::max(out.max_jump_n, each.max_jump_n);
    out.true_max_jump_n = std::max(out.true_max_jump_n, each.true_max_jump_n);
    out.contact_differs_ticks += each.differs;
    out.ticks += static_cast<int>(truth.set.trajectories[n].at_lps.size());
  }
  out.contact_ticks = static_cast<int>(error_n.size());
  if (out.ticks > 0) out.contact_differs_percent = 100.0 * out.contact_differs_ticks / out.ticks;
  if (error_n.empty()) return out;
  const DistanceStatistics n = pooled_statistics(error_n, {});
  const DistanceStatistics jnd = pooled_statistics(error_jnd, {});
  out.mean_n = n.mean;
  out.rms_n = n.rms;
  out.p95_n = n.p95;
  out.max_n = n.maximum;
  out.mean_jnd = jnd.mean;
  out.p95_jnd = jnd.p95;
  out.max_jnd = jnd.maximum;
  return out;
}

}  // namespace beatlas::assess
