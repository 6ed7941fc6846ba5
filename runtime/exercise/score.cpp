#include "runtime/exercise/score.h"

#include <algorithm>
#include <limits>

namespace beatlas::exercise {
namespace {

constexpr double kPlacePoints = 60;
constexpr double kNamePoints = 20;
constexpr double kSharePoints = 10;
constexpr double kGentlePoints = 10;
constexpr double kFalsePoints = 20;
constexpr double kWholeShare = 0.8;
constexpr double kHarmfulShare = 0.1;

void assign_marks(const std::vector<Mark>& marks, const palpation::LvWall& wall, Score& score) {
  std::vector<bool> taken(marks.size(), false);
  for (std::size_t round = 0; round < std::min(marks.size(), score.lesions.size()); ++round) {
    double least = std::numeric_limits<double>::infinity();
    LesionScore* nearest = nullptr;
    std::size_t by = 0;
    for (LesionScore& lesion : score.lesions) {
      if (lesion.mark) continue;
      for (std::size_t m = 0; m < marks.size(); ++m) {
        const double away = (marks[m].place.mm - wall.mm(lesion.lesion.vertex)).norm();
        if (taken[m] || !(away < least)) continue;
        least = away;
        nearest = &lesion;
        by = m;
      }
    }
    if (nearest == nullptr) return;
    nearest->mark = by;
    nearest->distance_mm = least;
    nearest->found = least <= nearest->lesion.radius_mm;
    nearest->named = nearest->found && marks[by].named == nearest->lesion.kind;
    taken[by] = true;
  }
}

}  // namespace

Score score_of(const std::vector<Lesion>& lesions, const Findings& findings,
               const palpation::LvWall& wall) {
  Score out;
  for (const Lesion& lesion : lesions) out.lesions.emplace_back().lesion = lesion;
  assign_marks(findings.marks, wall, out);
  double sum = 0;
  int found = 0;
  for (const LesionScore& lesion : out.lesions) {
    found += lesion.found ? 1 : 0;
    if (!lesion.mark) continue;
    const double beyond = lesion.distance_mm / lesion.lesion.radius_mm - 1;
    sum += kPlacePoints * std::clamp(1 - beyond, 0.0, 1.0) + (lesion.named ? kNamePoints : 0);
  }
  out.false_marks = static_cast<int>(findings.marks.size()) - found;
  out.points = sum / static_cast<double>(std::max<std::size_t>(1, out.lesions.size()));
  const Palpation& p = findings.palpation;
  out.points += kSharePoints * std::min(1.0, p.share / kWholeShare);
  if (p.contact_s > 0) {
    out.points +=
        kGentlePoints * std::clamp(1 - p.harmful_s / (kHarmfulShare * p.contact_s), 0.0, 1.0);
  }
  const int surplus = static_cast<int>(findings.marks.size() - out.lesions.size());
  if (findings.marks.size() > out.lesions.size()) out.points -= kFalsePoints * surplus;
  out.points = std::max(0.0, out.points);
  return out;
}

std::size_t place_of(const Mark& mark, const std::vector<std::uint32_t>& places,
                     const palpation::LvWall& wall) {
  const auto away = [&](std::uint32_t v) { return (wall.mm(v) - mark.place.mm).norm(); };
  const auto nearest =
      std::min_element(places.begin(), places.end(),
                       [&](std::uint32_t a, std::uint32_t b) { return away(a) < away(b); });
  return static_cast<std::size_t>(nearest - places.begin());
}

}  // namespace beatlas::exercise
