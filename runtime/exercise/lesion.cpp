#include "runtime/exercise/lesion.h"

#include <algorithm>
#include <limits>
#include <string>

#include "runtime/base/error.h"
#include "runtime/exercise/random.h"

namespace beatlas::exercise {
namespace {

using palpation::LvWall;

/// [mm] between the borders of two lesions: about the width of a fingertip, so that each is felt.
constexpr double kApartMm = 15;
constexpr double kWholeTo = 0.75;  ///< of the radius: the grade is whole; at 2 less this it is none
constexpr int kTries = 400;        ///< to place lesions beside each other

/// 1 up to kWholeTo of the radius, 0.5 at the radius, 0 as far beyond it; smooth between.
double share_of_grade(double away_mm, double radius_mm) noexcept {
  const double along =
      std::clamp((away_mm / radius_mm - kWholeTo) / (2 * (1 - kWholeTo)), 0.0, 1.0);
  return 1 - along * along * (3 - 2 * along);
}

std::vector<std::uint32_t> where_it_may_lie(const Exercise& exercise, const Ground& ground) {
  std::vector<std::uint32_t> out;
  const std::vector<std::uint8_t>& segment = ground.wall.map().segment;
  for (std::uint32_t v = 0; v < segment.size(); ++v) {
    if (!ground.touchable[v]) continue;
    const bool asked = exercise.segments.empty() ||
                       std::find(exercise.segments.begin(), exercise.segments.end(),
                                 static_cast<int>(segment[v])) != exercise.segments.end();
    if (asked) out.push_back(v);
  }
  if (out.empty()) {
    throw_invalid(
        "a finger can reach none of the exercise's segments on this heart; name others in "
        "/segments, or leave them out");
  }
  return out;
}

/// Whether most of a lesion's muscle lies where a finger gets.
bool mostly_touchable(const Lesion& lesion, const Ground& ground) {
  double all = 0;
  double touched = 0;
  const Vec3 middle = ground.wall.mm(lesion.vertex);
  for (std::uint32_t v = 0; v < ground.touchable.size(); ++v) {
    if ((ground.wall.mm(v) - middle).norm() > lesion.radius_mm) continue;
    all += ground.wall.muscle_share()[v];
    touched += ground.touchable[v] ? ground.wall.muscle_share()[v] : 0;
  }
  return touched > 0.5 * all;
}

/// What the muscle itself is of the whole stiffness under a finger at end-diastole.
double own_share(std::uint32_t vertex, const palpation::AtlasMuscle& muscle) {
  const palpation::PatchConstants& here = muscle.as_it_is(vertex);
  return here.k_v_n_per_m /
         (here.k_v_n_per_m + here.k_e_rest_n_per_m + muscle.natural().pressure_at(0));
}

}  // namespace

std::vector<Lesion> draw_lesions(const Exercise& exercise, const Ground& ground,
                                 std::uint64_t seed) {
  const std::vector<std::uint32_t> places = where_it_may_lie(exercise, ground);
  Random random(seed);
  std::vector<Lesion> out;
  for (int n = 0; n < kTries && static_cast<int>(out.size()) < exercise.lesions; ++n) {
    const Lesion lesion{
        .kind = exercise.kinds[random.below(exercise.kinds.size())],
        .grade = random.within(exercise.grade.low, exercise.grade.high),
        .radius_mm = random.within(exercise.radius_mm.low, exercise.radius_mm.high),
        .vertex = places[random.below(places.size())],
    };
    const bool clear = std::all_of(out.begin(), out.end(), [&](const Lesion& other) {
      return (ground.wall.mm(lesion.vertex) - ground.wall.mm(other.vertex)).norm() >
             lesion.radius_mm + other.radius_mm + kApartMm;
    });
    if (clear && mostly_touchable(lesion, ground)) out.push_back(lesion);
  }
  if (static_cast<int>(out.size()) < exercise.lesions) {
    throw_invalid("this heart has no room for " + std::to_string(exercise.lesions) +
                  " such lesions where a finger reaches; ask for fewer or smaller ones, or for "
                  "more segments");
  }
  return out;
}

std::vector<std::uint32_t> threshold_places(const Exercise& exercise, const Ground& ground) {
  std::vector<std::uint32_t> places = where_it_may_lie(exercise, ground);
  std::erase_if(places, [&](std::uint32_t v) {
    return !mostly_touchable({.radius_mm = exercise.radius_mm.high, .vertex = v}, ground);
  });
  std::vector<std::uint32_t> out;
  std::vector<double> away(places.size(), std::numeric_limits<double>::infinity());
  while (static_cast<int>(out.size()) < exercise.places && !places.empty()) {
    const auto farthest =
        static_cast<std::size_t>(std::max_element(away.begin(), away.end()) - away.begin());
    if (away[farthest] < 2 * exercise.radius_mm.high) break;  // the lesion of one reaches the next
    out.push_back(places[farthest]);
    for (std::size_t n = 0; n < places.size(); ++n) {
      away[n] = std::min(away[n], (ground.wall.mm(places[n]) - ground.wall.mm(out.back())).norm());
    }
  }
  if (static_cast<int>(out.size()) < exercise.places) {
    throw_invalid("this heart has no " + std::to_string(exercise.places) +
                  " places apart where a finger reaches; ask for fewer in /places, a smaller "
                  "/radius_mm or more segments");
  }
  return out;
}

Lesion lesion_of_difference(double difference, double radius_mm, std::uint32_t vertex,
                            const palpation::AtlasMuscle& muscle) {
  constexpr double kMost = 0.9;
  return {.kind = LesionKind::Soft,
          .grade = std::clamp(difference / own_share(vertex, muscle), 0.0, kMost),
          .radius_mm = radius_mm,
          .vertex = vertex};
}

double difference_of_lesion(const Lesion& lesion, const palpation::AtlasMuscle& muscle) {
  return lesion.grade * own_share(lesion.vertex, muscle);
}

palpation::Tissue with_lesion(const palpation::Tissue& tissue, LesionKind kind,
                              double grade) noexcept {
  palpation::Tissue out = tissue;
  const double left = 1 - grade;
  switch (kind) {
    case LesionKind::Soft:
      out.stiffness_ratio *= left;
      break;
    case LesionKind::Thin:
      out.thickness_ratio *= left;
      out.alpha *= left;
      break;
    case LesionKind::Akinetic:
      out.alpha *= left;
      break;
    case LesionKind::Scar:
      out.scar = std::max(out.scar, grade);
      out.alpha *= left;
      break;
  }
  return out;
}

void hide_lesions(const std::vector<Lesion>& lesions, const LvWall& wall,
                  palpation::TissueMap& tissue) {
  for (const Lesion& lesion : lesions) {
    const Vec3 middle = wall.mm(lesion.vertex);
    for (std::uint32_t v = 0; v < wall.vertex_count(); ++v) {
      const double share = share_of_grade((wall.mm(v) - middle).norm(), lesion.radius_mm);
      if (share > 0) {
        tissue.of_vertex[v] = with_lesion(tissue.of_vertex[v], lesion.kind, share * lesion.grade);
      }
    }
  }
  tissue.infarct = palpation::infarct_of_wall(wall, tissue.of_vertex);
}

}  // namespace beatlas::exercise
