#include "pipeline/assess/force_error.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/assess/made_candidate.h"

namespace beatlas::assess {
namespace {

using test::Made;

constexpr double kStiffness = 150.0;

PalpationOptions few() {
  PalpationOptions options;
  options.structure = Structure::LvBlood;
  options.places = 6;
  options.cycles = 1;
  return options;
}

/// The closed form itself at t = 0, of a surface that lies `grown_mm` further out.
ForceCandidate closed_form(const Made& made, Structure structure, double grown_mm) {
  const auto frame = made.truth.frame(0.0);
  return {[&made, frame, structure, grown_mm]() -> ForceAt {
            return [&made, frame, structure, grown_mm](const Vec3& x, double) {
              const auto nearest = frame->nearest(structure, made.lps_from_workspace * x);
              haptics::Contact contact;
              contact.distance_mm = nearest.distance_mm - grown_mm;
              contact.touching = contact.distance_mm < 0.0;
              contact.force_n =
                  haptics::contact_force_n(kStiffness, contact.distance_mm,
                                           made.workspace_from_lps.linear() * nearest.outward);
              return contact;
            };
          },
          made.workspace_from_lps, made.manifest.rr_interval_s};
}

TEST(Palpations, AreWhatAFingerDoes) {
  const phantom::Phantom truth(phantom::preset("small"));
  PalpationOptions options;
  options.places = 12;
  const PalpationSet set = palpation_set(truth, options);
  ASSERT_EQ(set.trajectories.size(), 36U);
  EXPECT_EQ(set.ticks_per_beat, 750);
  EXPECT_NEAR(set.tick_s, 1e-3, 1e-9);
  std::vector<Vec3> places;
  for (const Trajectory& path : set.trajectories) {
    ASSERT_EQ(path.at_lps.size(), 1500U);
    double deepest = 0.0;
    double fastest = 0.0;
    for (std::size_t n = 0; n < path.at_lps.size(); ++n) {
      deepest = std::min(deepest, truth.distance_mm(Structure::Heart, path.at_lps[n], 0.0));
      if (n > 0) {
        fastest = std::max(fastest, (path.at_lps[n] - path.at_lps[n - 1]).norm() / set.tick_s);
      }
    }
    EXPECT_GE(deepest, -8.0 - 1e-6);
    EXPECT_LE(deepest, -1.9) << "every finger touches the heart at end diastole";
    EXPECT_LE(fastest, 76.0);  // 3 Hz, 4 mm amplitude
    EXPECT_EQ(fastest > 0.0, path.touch != Touch::Hold);
    if (path.touch == Touch::Press) places.push_back(path.at_lps.front());
  }
  for (std::size_t a = 0; a < places.size(); ++a) {
    EXPECT_LT(std::abs(truth.distance_mm(Structure::Heart, places[a], 0.0)), 1e-6);
    EXPECT_FALSE(truth.on_crease(Structure::Heart, places[a], 0.0, options.crease_mm));
    for (std::size_t b = 0; b < a; ++b) {
      EXPECT_GT((places[a] - places[b]).norm(), 25.0) << "spread over 50 000 mm2";
    }
  }
  const PalpationSet again = palpation_set(truth, options);
  EXPECT_EQ(again.trajectories.back().at_lps, set.trajectories.back().at_lps);
  options.places = 0;
  EXPECT_THROW((void)palpation_set(truth, options), Error);
}

TEST(ForceErrors, FollowFromThePairsOfForces) {
  // Three ticks, one trajectory: both in contact, the truth alone, the package alone.
  TrueForces truth;
  truth.set.ticks_per_beat = 3;
  truth.set.trajectories = {{Touch::Hold, {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)}}};
  truth.force_n = {{Vec3(1.0, 0, 0), Vec3(0, 0.02, 0), Vec3::Zero()}};
  truth.touching = {{1, 1, 0}};
  Affine turned = Affine::Identity();
  turned.linear() = Eigen::AngleAxisd(1.0, Vec3::UnitZ()).toRotationMatrix();
  const std::vector<Vec3> mine{Vec3(1.0, 0.3, 0), Vec3::Zero(), Vec3(0, 0, 0.1)};
  const ForceCandidate candidate{[&]() -> ForceAt {
                                   return [&](const Vec3& x, double t_s) {
                                     haptics::Contact contact;
                                     const auto tick = std::lround((turned.inverse() * x).x());
                                     EXPECT_NEAR(t_s, 0.3 * static_cast<double>(tick), 1e-12);
                                     contact.force_n = turned.linear() * mine[tick];
                                     contact.touching = !mine[tick].isZero();
                                     return contact;
                                   };
                                 },
                                 turned, 0.9};
  const ForceErrors errors = force_errors(candidate, truth);
  EXPECT_EQ(errors.ticks, 3);
  EXPECT_EQ(errors.contact_ticks, 3);
  EXPECT_EQ(errors.contact_differs_ticks, 2);
  EXPECT_NEAR(errors.contact_differs_percent, 200.0 / 3.0, 1e-9);
  EXPECT_NEAR(errors.mean_n, (0.3 + 0.02 + 0.1) / 3.0, 1e-12);
  EXPECT_NEAR(errors.rms_n, std::sqrt((0.09 + 0.0004 + 0.01) / 3.0), 1e-12);
  EXPECT_NEAR(errors.p95_n, 0.3, 1e-12);
  EXPECT_NEAR(errors.max_n, 0.3, 1e-12);
  // 7 % of 1 N; of the floor of 0.049 N where the true force is less.
  const double first = 0.3 / 0.07;
  const double others = (0.02 + 0.1) / (0.07 * 0.049);
  EXPECT_NEAR(errors.mean_jnd, (first + others) / 3.0, 1e-9);
  EXPECT_NEAR(errors.max_jnd, 0.1 / (0.07 * 0.049), 1e-9);
  EXPECT_NEAR(errors.max_jump_n, std::hypot(1.0, 0.3), 1e-12);
  EXPECT_NEAR(errors.true_max_jump_n, std::hypot(1.0, 0.02), 1e-12);
}

TEST(ForceErrors, OfASurfaceThatLiesFurtherOutAreItsStiffness) {
  const Made made(Made::still());
  StageContext context;
  const TrueForces truth =
      true_forces(made.truth, palpation_set(made.truth, few()), kStiffness, context);
  const ForceErrors none = force_errors(closed_form(made, Structure::LvBlood, 0.0), truth);
  EXPECT_GT(none.contact_ticks, 5000);
  EXPECT_NEAR(none.max_n, 0.0, 1e-9);
  EXPECT_LE(none.contact_differs_ticks, few().places) << "a press begins on the surface itself";
  EXPECT_NEAR(none.max_jump_n, none.true_max_jump_n, 1e-9);
  const ForceErrors grown = force_errors(closed_form(made, Structure::LvBlood, 0.4), truth);
  EXPECT_NEAR(grown.max_n, kStiffness * 0.4e-3, 1e-9);
  EXPECT_NEAR(grown.p95_n, kStiffness * 0.4e-3, 1e-9);
  EXPECT_GT(grown.mean_n, 0.9 * kStiffness * 0.4e-3) << "less only where the truth lets go";
  EXPECT_GT(grown.contact_differs_ticks, 0);
  EXPECT_LT(grown.contact_differs_percent, 10.0);
}

TEST(ForceErrors, OfTheTwoStepModelOnTheExactFieldAreThoseOfItsSpline) {
  const Made made(Made::still());
  StageContext context;
  const TrueForces truth =
      true_forces(made.truth, palpation_set(made.truth, few()), kStiffness, context);
  const auto felt = [&](double grown_mm) {
    const auto query = std::make_shared<const field::FieldQuery>(
        made.field(Structure::LvBlood,
                   [&](const Vec3& x, double share) {
                     return made.distance_mm(Structure::LvBlood, x, share) - grown_mm;
                   }),
        made.manifest.rr_interval_s);
    haptics::TwoStepOptions model;
    model.stiffness_n_per_m = kStiffness;
    return force_errors(two_step_candidate(query, model, made.workspace_from_lps), truth);
  };
  const ForceErrors exact = felt(0.0);
  EXPECT_LT(exact.mean_n, 0.015);  // 0.1 mm: a slide crosses the rim, which the spline rounds
  EXPECT_LT(exact.contact_differs_percent, 1.0);
  EXPECT_NEAR(felt(0.5).mean_n, kStiffness * 0.5e-3, 0.008);
}

TEST(ForceErrors, AreTheSameForAnyNumberOfThreads) {
  const Made made(Made::small());
  StageContext context;
  const auto measure = [&] {
    const TrueForces truth =
        true_forces(made.truth, palpation_set(made.truth, few()), kStiffness, context);
    return force_errors(closed_form(made, Structure::LvBlood, 0.3), truth).mean_n;
  };
  set_thread_count(1);
  const double one = measure();
  set_thread_count(3);
  const double three = measure();
  set_thread_count(0);
  EXPECT_EQ(one, three);
  EXPECT_GT(one, 0.0);
}

}  // namespace
}  // namespace beatlas::assess
