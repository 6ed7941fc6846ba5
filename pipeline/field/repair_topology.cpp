#include "pipeline/field/repair_topology.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "pipeline/core/parallel.h"
#include "pipeline/core/words.h"
#include "pipeline/field/closest_triangle.h"
#include "pipeline/field/cycle_topology.h"
#include "pipeline/field/simple_points.h"
#include "pipeline/field/surface.h"
#include "runtime/base/error.h"

namespace beatlas::field {
namespace {

/// [voxels] A changed sample moves the surface this far and hardly farther: the cubic through the
/// samples weighs it by less than a tenth from the second sample on.
constexpr double kCellsAround = 2;
/// Distances to a wall that two structures share agree to this, where one was taken again.
constexpr float kAgreeMm = 0.1F;
/// A sample beside the surface keeps its side whatever rounding does to its distance.
constexpr float kLeastMm = 1e-3F;

/// The samples between two corners, both included.
struct Box {
  Index3 first{};
  Index3 last{};
};

/// A surface of points: the samples in which two phases differ.
TriangleSoup changed_points(const Grid& grid, const std::vector<float>& before,
                            const std::vector<float>& after) {
  TriangleSoup out;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const std::size_t here = grid.offset(i, j, k);
        if (before[here] == after[here]) continue;
        const auto n = static_cast<std::uint32_t>(out.points.size());
        out.points.push_back(grid.mm(i, j, k));
        out.triangles.push_back({n, n, n});
      }
    }
  }
  return out;
}

Box box_around(const Grid& grid, const std::vector<Vec3>& points, double reach_mm) {
  Vec3 low = points.front();
  Vec3 high = points.front();
  for (const Vec3& x : points) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const Affine index_from_mm = grid.mm_from_index.inverse(Eigen::Affine);
  const double voxel_mm = grid.spacing_mm().x();
  const Vec3 first = index_from_mm * low - Vec3::Constant(reach_mm / voxel_mm);
  const Vec3 last = index_from_mm * high + Vec3::Constant(reach_mm / voxel_mm);
  Box out;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    out.first[a] = std::max(0, static_cast<int>(std::floor(first[axis])));
    out.last[a] = std::min(grid.size[a] - 1, static_cast<int>(std::ceil(last[axis])));
  }
  return out;
}

/// The distance to what is nearer than `most_mm`, else `most_mm` itself.
double distance_mm(const ClosestTriangle& tree, const Vec3& mm, double most_mm) {
  const ClosestTriangle::Hit bound{static_cast<float>(most_mm * most_mm)};
  const float found2 = tree.nearest(mm, bound).distance2_mm2;
  return found2 < bound.distance2_mm2 ? std::sqrt(static_cast<double>(found2)) : most_mm;
}

/// Makes samples of one phase whose sides were changed distances again.
/// @param before the samples as they were, distances of the surface as it was
/// @param now the surface of the changed samples
void take_distances_again(const std::vector<float>& before, const TriangleSoup& now,
                          std::size_t phase, FieldCycle& field) {
  const Grid& grid = field.distance_mm.grid;
  const double around_mm = kCellsAround * field.voxel_mm;
  const double farthest_mm = std::max(field.inner_mm, field.outer_mm);
  std::vector<float> after = field.distance_mm.phases[phase];
  const TriangleSoup points = changed_points(grid, before, after);
  const ClosestTriangle changed(points);
  const ClosestTriangle surface(now);
  const Box box = box_around(grid, points.points, farthest_mm + around_mm);
  const int layers = box.last[2] - box.first[2] + 1;
  parallel_for(static_cast<std::size_t>(layers), [&](std::size_t layer) {
    const int k = box.first[2] + static_cast<int>(layer);
    for (int j = box.first[1]; j <= box.last[1]; ++j) {
      for (int i = box.first[0]; i <= box.last[0]; ++i) {
        const std::size_t here = grid.offset(i, j, k);
        const Vec3 mm = grid.mm(i, j, k);
        const bool inside = after[here] < 0;
        const bool same_side = inside == (before[here] < 0);
        const double reach_mm = std::abs(static_cast<double>(before[here])) + around_mm;
        if (same_side && distance_mm(changed, mm, reach_mm) >= reach_mm) {
          after[here] = before[here];
          continue;
        }
        const double most_mm = inside ? field.inner_mm : field.outer_mm;
        const auto away = std::max(kLeastMm, static_cast<float>(distance_mm(surface, mm, most_mm)));
        after[here] = inside ? -away : away;
      }
    }
  });
  field.distance_mm.phases[phase] = std::move(after);
}

/// A place where a structure reaches farther than before, on the lattice that all fields share.
struct Gain {
  Index3 at{};
  float mm = 0;  ///< its distance now
};
using Gains = std::vector<std::vector<Gain>>;  ///< [phase]

/// Where a field's lattice begins on the one that all share.
Index3 first_of(const FieldCycle& field) {
  const Vec3 at = field.distance_mm.grid.mm_from_index.translation() / field.voxel_mm;
  return {static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())),
          static_cast<int>(std::lround(at.z()))};
}

/// The sample of a field at a place of the lattice that all share; none beyond its own.
std::optional<std::size_t> sample_at(const FieldCycle& field, const Index3& shared) {
  const Index3 first = first_of(field);
  const Index3 at{shared[0] - first[0], shared[1] - first[1], shared[2] - first[2]};
  if (!field.distance_mm.grid.contains(at[0], at[1], at[2])) return std::nullopt;
  return field.distance_mm.grid.offset(at[0], at[1], at[2]);
}

/// The place of a field's sample on the lattice that all share.
Index3 shared_place(const FieldCycle& field, std::size_t sample) {
  const Index3 at = Lattice(field.distance_mm.grid).at(sample);
  const Index3 first = first_of(field);
  return {at[0] + first[0], at[1] + first[1], at[2] + first[2]};
}

/// The piece of the inside that holds a sample.
Mask piece_with(const Lattice& lattice, const Mask& inside, std::size_t sample) {
  Mask out(inside.size());
  for (const Piece& piece : pieces_of(lattice, inside, 1)) {
    if (std::find(piece.samples.begin(), piece.samples.end(), sample) == piece.samples.end()) {
      continue;
    }
    for (const std::size_t n : piece.samples) out[n] = 1;
  }
  return out;
}

/// What of a phase is nearer now, as far from the surface as its cells reach.
std::vector<Gain> gained(const FieldCycle& field, const std::vector<float>& before,
                         const std::vector<float>& after) {
  const auto far_mm = static_cast<float>(kCellsAround * field.voxel_mm);
  std::vector<Gain> out;
  for (std::size_t n = 0; n < after.size(); ++n) {
    if (after[n] < before[n] && after[n] < far_mm)
      out.push_back({shared_place(field, n), after[n]});
  }
  return out;
}

/// Takes what another structure gained from one phase, and what that cuts off its largest piece.
/// @return whether its deepest place is left: of what encloses a whole body that takes nothing
bool give_way(const std::vector<Gain>& gains, const FieldCycle& field,
              std::vector<float>& samples) {
  const Grid& grid = field.distance_mm.grid;
  const auto deepest =
      static_cast<std::size_t>(std::min_element(samples.begin(), samples.end()) - samples.begin());
  const std::vector<float> before = samples;
  bool any = false;
  for (const Gain& gain : gains) {
    const std::optional<std::size_t> at = sample_at(field, gain.at);
    if (!at) continue;
    any = any || (samples[*at] < 0 && gain.mm < 0);
    samples[*at] = std::max(samples[*at], -gain.mm);
  }
  if (!any) {
    samples = before;
    return true;
  }
  if (!(samples[deepest] < 0)) return false;
  const Lattice lattice(grid);
  const Mask body = piece_with(lattice, inside_of(before), deepest);
  Mask inside = inside_of(samples);
  const Mask left = piece_with(lattice, inside, deepest);
  for (std::size_t n = 0; n < inside.size(); ++n) {
    if (body[n] != 0 && left[n] == 0) inside[n] = 0;
  }
  (void)change_sides(grid, inside, samples);
  return true;
}

/// The samples of one structure once it has given way to those that were repaired before it.
std::vector<std::vector<float>> beside(const std::vector<Gains>& others, const FieldCycle& field) {
  std::vector<std::vector<float>> out = field.distance_mm.phases;
  for (const Gains& gains : others) {
    std::vector<std::vector<float>> given = out;
    std::vector<std::uint8_t> is_left(given.size());
    parallel_for(given.size(),
                 [&](std::size_t p) { is_left[p] = give_way(gains[p], field, given[p]) ? 1 : 0; });
    const bool all = std::all_of(is_left.begin(), is_left.end(), [](auto left) { return left; });
    if (all) out = std::move(given);
  }
  return out;
}

void check(const FieldCycle& field) {
  for (std::size_t p = 0; p < field.distance_mm.phases.size(); ++p) {
    const std::vector<float>& samples = field.distance_mm.phases[p];
    if (std::any_of(samples.begin(), samples.end(), [](float mm) { return mm < 0; })) continue;
    throw_invalid("phase " + std::to_string(p) + " of " +
                  std::string(structure_name(field.structure)) +
                  " has no sample inside; choose a smaller voxel_mm");
  }
}

/// @param when behind "was mended", for a structure whose turn comes twice
void tell(const FieldCycle& field, const std::vector<Repair>& repairs, const std::string& when,
          const StageContext& context) {
  const std::string name(structure_name(field.structure));
  std::size_t mended = 0;
  std::size_t changed = 0;
  std::size_t most = 0;
  for (std::size_t p = 0; p < repairs.size(); ++p) {
    const Repair& repair = repairs[p];
    if (repair.left_handles > 0) {
      context.warn("the surface of " + name + " in phase " + std::to_string(p) + " keeps " +
                   counted(repair.left_handles, "handle") +
                   ": look for holes in thin places of its labels");
    }
    mended += repair.changed > 0 ? 1 : 0;
    changed += repair.changed;
    if (repair.changed > repairs[most].changed) most = p;
  }
  if (mended == 0) return;
  const BodyTopology& before = repairs[most].before;
  const double ml = static_cast<double>(changed) * std::pow(field.voxel_mm, 3) * 1e-3 /
                    static_cast<double>(mended);
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", ml);
  const std::string why =
      before.is_ball()
          ? ", to agree with structures beside it; most in phase " + std::to_string(most)
          : "; most in phase " + std::to_string(most) + ", which had " +
                counted(before.pieces, "piece") + ", " + counted(before.hollows, "hollow") +
                " and " + counted(before.handles, "handle");
  context.warn(name + " was mended " + when + "in " + std::to_string(mended) + " of " +
               std::to_string(repairs.size()) + " phases, by " + text + " ml on average" + why);
}

/// The distances of one phase of another field at this one's samples, beyond its lattice outer_mm.
std::vector<float> at_samples_of(const FieldCycle& field, const FieldCycle& other,
                                 std::size_t phase) {
  std::vector<float> out(field.distance_mm.grid.count());
  for (std::size_t n = 0; n < out.size(); ++n) {
    const std::optional<std::size_t> at = sample_at(other, shared_place(field, n));
    out[n] = at ? other.distance_mm.phases[phase][*at] : static_cast<float>(other.outer_mm);
  }
  return out;
}

/// Makes places beyond the heart dearer, as if they were a voxel farther away, whether ways lead
/// there or holes are filled.
class WithinHeart {
 public:
  /// @param heart null: nothing is dear  @param field the structure that is priced
  WithinHeart(const FieldCycle* heart, const FieldCycle& field) : heart_(heart), field_(field) {}

  void price(std::vector<std::vector<float>>& samples) const {
    if (heart_ == nullptr) return;
    parallel_for(samples.size(), [&](std::size_t p) {
      const std::vector<float> hearts = at_samples_of(field_, *heart_, p);
      for (std::size_t n = 0; n < hearts.size(); ++n) {
        if (is_dear(hearts[n], samples[p][n])) samples[p][n] += static_cast<float>(field_.voxel_mm);
      }
    });
  }

  /// Takes back what price added to samples that were not changed since.
  /// @param before one phase of them, without that
  void settle(std::size_t phase, const std::vector<float>& before,
              std::vector<float>& samples) const {
    if (heart_ == nullptr) return;
    const std::vector<float> hearts = at_samples_of(field_, *heart_, phase);
    for (std::size_t n = 0; n < hearts.size(); ++n) {
      if (is_dear(hearts[n], before[n])) samples[n] = std::min(samples[n], before[n]);
    }
  }

 private:
  static bool is_dear(float hearts, float own) { return hearts > 0 && own > 0; }

  const FieldCycle* heart_;
  const FieldCycle& field_;
};

/// The samples of the heart with what others had to gain beyond it.
std::vector<std::vector<float>> around(const std::vector<Gains>& others, const FieldCycle& heart) {
  std::vector<std::vector<float>> out = heart.distance_mm.phases;
  const Lattice lattice(heart.distance_mm.grid);
  parallel_for(out.size(), [&](std::size_t p) {
    for (const Gains& gains : others) {
      for (const Gain& gain : gains[p]) {
        const std::optional<std::size_t> at = sample_at(heart, gain.at);
        if (!at || lattice.on_border(lattice.at(*at))) continue;
        if (gain.mm < out[p][*at] - kAgreeMm) out[p][*at] = gain.mm;
      }
    }
  });
  return out;
}

std::size_t changed_sides(const std::vector<float>& before, const std::vector<float>& after) {
  std::size_t out = 0;
  for (std::size_t n = 0; n < after.size(); ++n) out += (before[n] < 0) != (after[n] < 0) ? 1 : 0;
  return out;
}

/// @param given the samples of `field` as those repaired already leave them
/// @param heart repaired, or null: what lies beyond it is gained only where nothing else will do
/// @param when see tell
/// @return what was gained
Gains repair(const std::vector<std::vector<float>>& given, const FieldCycle* heart,
             FieldCycle& field, const StageContext& context, const std::string& when = {}) {
  std::vector<std::vector<float>>& phases = field.distance_mm.phases;
  const Grid& grid = field.distance_mm.grid;
  check(field);
  const WithinHeart within(heart, field);
  std::vector<std::vector<float>> sided = given;
  within.price(sided);
  std::vector<Repair> repairs = make_balls(grid, sided, context.part(0, 0.6));
  Gains out(phases.size());
  parallel_for(phases.size(), context.part(0.6, 1), "distance in phase", [&](std::size_t p) {
    within.settle(p, given[p], sided[p]);
    if (sided[p] == phases[p]) return;
    const std::vector<float> before = std::exchange(phases[p], std::move(sided[p]));
    const TriangleSoup now = level_surface(grid, phases[p]);
    field.volume_ml[p] += enclosed_ml(now) - enclosed_ml(level_surface(grid, before));
    take_distances_again(before, now, p, field);
    repairs[p].changed = changed_sides(before, phases[p]);
    out[p] = gained(field, before, phases[p]);
  });
  tell(field, repairs, when, context);
  return out;
}

/// Who is repaired before whom: the heart, which holds all others, then the wall, which is the
/// thinnest and decides where blood may be. These three fields are made for every scene, and are
/// the same in each: nothing else changes them.
constexpr std::array kFirst{Structure::Heart, Structure::LvMyocardium, Structure::LvBlood};
constexpr std::array kThen{Structure::RvBlood, Structure::LaBlood, Structure::RaBlood,
                           Structure::Aorta};
static_assert(kFirst.size() + kThen.size() == kAllStructures.size());

FieldCycle* of(std::vector<FieldCycle>& fields, Structure structure) {
  for (FieldCycle& field : fields) {
    if (field.structure == structure) return &field;
  }
  return nullptr;
}

void check_alike(const std::vector<FieldCycle>& fields) {
  for (const FieldCycle& field : fields) {
    if (field.distance_mm.phases.size() == fields.front().distance_mm.phases.size() &&
        field.voxel_mm == fields.front().voxel_mm) {
      continue;
    }
    throw_invalid("the field of " + std::string(structure_name(field.structure)) +
                  " has other phases or voxels than that of " +
                  std::string(structure_name(fields.front().structure)) +
                  "; build them with the same options");
  }
}

}  // namespace

void repair_topology(FieldCycle& field, const StageContext& context) {
  (void)repair(std::vector(field.distance_mm.phases), nullptr, field, context);
}

void repair_topology(std::vector<FieldCycle>& fields, const StageContext& context) {
  check_alike(fields);
  FieldCycle* heart = of(fields, Structure::Heart);
  std::vector<Gains> gains;
  const double each = 1.0 / static_cast<double>(fields.size() + 1);
  double done = 0;
  const auto next = [&] {
    context.check_cancelled();
    StageContext part = context.part(done, done + each);
    done += each;
    return part;
  };
  const auto repair_one = [&](Structure structure) {
    FieldCycle* field = of(fields, structure);
    if (field == nullptr) return;
    if (field == heart) {
      (void)repair(std::vector(field->distance_mm.phases), nullptr, *field, next());
    } else {
      gains.push_back(repair(beside(gains, *field), heart, *field, next()));
    }
  };
  for (const Structure structure : kFirst) repair_one(structure);
  if (heart != nullptr)
    (void)repair(around(gains, *heart), nullptr, *heart, next(), "around what it holds, ");
  for (const Structure structure : kThen) repair_one(structure);
}

}  // namespace beatlas::field
