#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "pipeline/core/parallel.h"
#include "pipeline/core/words.h"
#include "pipeline/field/surface.h"
#include "pipeline/mesh/carry.h"
#include "pipeline/mesh/cycle_fit.h"
#include "pipeline/mesh/mesh.h"
#include "pipeline/mesh/missed.h"
#include "pipeline/mesh/triangle_mesh.h"
#include "runtime/base/error.h"

namespace beatlas::mesh {
namespace {

constexpr double kNotThinDeg = 10;  ///< of a triangle that is not too thin
/// Share of triangles, of all phases, that may be thinner and the mesh is sound. Force comes from
/// the field and never from a triangle, and one in a thousand is not seen; to mesh another phase
/// takes as long again.
constexpr double kMostThin = 1e-3;
/// Of triangles, pairs that pass through each other, above which another mesh is looked for whose
/// shape may be farther off. A package is refused only at StructuralLimits::crossing_percent.
constexpr double kManyCrossings = 0.01;
constexpr double kFarOffMm = 0.1;  ///< of a mesh from its surfaces, mean of all phases
constexpr double kLostMm = 0.3;    ///< the same of one phase: a part of its shape is not there
constexpr double kLongEdgeMm = 2;  ///< longer ones cut farther through curved parts
/// Of the volume that a phase's surface encloses: a mesh may lie on the surface wherever it is and
/// still lack a part that it never reached. Nearly what a recipe refuses, 30 %: a pit that is open
/// in one phase alone and bridged there is less, and better than slivers in all others.
constexpr double kLostShare = 0.25;
/// Of the same, told. Edges of e cut 3 e^2 / (8 R^2) off a ball of radius R: of 5 mm 4 % of 15 mm.
constexpr double kToldShare = 0.1;
/// Of a phase's surface, told. A cap that stands an edge e out of a ball of radius R has e / (2 R)
/// of its surface: of 2 mm and 20 mm 5 %.
constexpr double kToldMissed = 0.05;
/// See flawed_at_a_glance: above this share other phases are looked at, too. Of 46 pairs of meshes
/// (four real exams, `adult`, two draws), .05 at a glance is about .015 of the finer mesh; of the
/// heart of `adult` slivers are left in the end of .037 and none of .012.
/// Of what a mesh misses, which weighs as what lies off its surface does, .5 % reaches it alone.
constexpr double kHopefulShare = 0.05;
/// Of the heart of `adult` with atria 1.1 % at end-diastole, which does not come through, and 0.3 %
/// in systole, which does; of ventricles and cavities less than 0.5 %.
constexpr double kManyPockets = 0.006;

std::string name_of(const FieldCycle& field) {
  return std::string(structure_name(field.structure));
}

std::string fixed(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

bool reaches_border(const Grid& grid, const std::vector<float>& distances) {
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      const bool all = k == 0 || k == grid.size[2] - 1 || j == 0 || j == grid.size[1] - 1;
      for (int i = 0; i < grid.size[0]; i += all ? 1 : std::max(1, grid.size[0] - 1)) {
        if (distances[grid.offset(i, j, k)] < 0) return true;
      }
    }
  }
  return false;
}

void check(const FieldCycle& field, const MeshOptions& options) {
  check_options(field, options);
  const std::vector<std::vector<float>>& phases = field.distance_mm.phases;
  for (std::size_t p = 0; p < phases.size(); ++p) {
    const std::string where = "phase " + std::to_string(p) + " of " + name_of(field);
    if (phases[p].size() != field.distance_mm.grid.count()) {
      throw_invalid(where + " does not have one distance for each lattice point");
    }
    const auto [least, most] = std::minmax_element(phases[p].begin(), phases[p].end());
    if (!(*least < 0 && *most > 0)) {
      throw_invalid(where + " has no surface; check the labels and seeds of that phase");
    }
    if (reaches_border(field.distance_mm.grid, phases[p])) {
      throw Error(ErrorCode::Quality,
                  where + " is not closed; the structure reaches the border of its lattice");
    }
  }
}

TriangleMesh reference_mesh(const FieldCycle& field, const field::Interpolant& surface,
                            std::size_t phase, double edge_mm, const StageContext& context) {
  field::TriangleSoup soup = field::extract_surface(field, static_cast<int>(phase));
  TriangleMesh raw{std::move(soup.points), std::move(soup.triangles)};
  const auto fail = [&](const std::string& why) {
    throw Error(ErrorCode::Quality, "the surface of " + name_of(field) + " in phase " +
                                        std::to_string(phase) + " " + why);
  };
  if (!inspect(raw.points.size(), raw.triangles).closed_manifold) fail("is no closed manifold");
  LargestComponent kept = largest_component(raw);
  if (kept.components > 1) {
    context.warn(name_of(field) + " falls into " + std::to_string(kept.components) +
                 " pieces; the largest is kept and " + fixed(kept.others_ml, 2) +
                 " ml in the others are left out");
  }
  const int euler_before = inspect(kept.mesh.points.size(), kept.mesh.triangles).euler_number;
  TriangleMesh mesh = remeshed(kept.mesh, edge_mm);
  constexpr std::size_t kFewestTriangles = 32;
  const Topology after = inspect(mesh.points.size(), mesh.triangles);
  if (!after.closed_manifold || after.euler_number != euler_before ||
      mesh.triangles.size() < kFewestTriangles) {
    fail("is too small for triangles of " + fixed(edge_mm, 2) +
         " mm and does not stay a closed manifold; choose a smaller edge_mm");
  }
  if (after.euler_number != 2) {
    const int handles = (2 - after.euler_number) / 2;
    context.warn("the surface of " + name_of(field) + " has " + std::to_string(handles) +
                 (handles == 1 ? " handle" : " handles") +
                 ": look for holes in thin places of its labels");
  }
  constexpr int kRelaxations = 5;
  for (Vec3& p : mesh.points) p = surface.project_to_zero(p, field.voxel_mm);
  relax_on_surface(mesh, surface, kRelaxations);
  return mesh;
}

/// A mesh of the reference phase in all phases: once around in both directions; each phase is the
/// mean of both, weighted by how near the reference is on either way, so that the cycle closes
/// without a seam.
Cycle carried(const TriangleMesh& mesh, const FieldCycle& field, std::size_t reference,
              const StageContext& context) {
  const std::size_t phases = field.distance_mm.phases.size();
  const Carrier carrier(mesh);
  std::array<Cycle, 2> tracks;
  std::atomic<std::size_t> done{0};
  parallel_for(2, [&](std::size_t way) {
    Cycle& track = tracks[way];
    track.resize(phases);
    track[reference] = mesh.points;
    std::size_t from = reference;
    for (std::size_t n = 1; n < phases; ++n) {
      context.check_cancelled();
      const std::size_t at = done++;
      context.progress(
          static_cast<double>(at) / static_cast<double>(2 * phases),
          "motion " + std::to_string(at + 1) + " of " + std::to_string(2 * (phases - 1)));
      const std::size_t to = (reference + (way == 0 ? n : phases - n)) % phases;
      track[to] = carrier.carry(track[from], field.distance_mm.grid, field.distance_mm.phases[from],
                                field.distance_mm.phases[to]);
      from = to;
    }
  });
  Cycle cycle(phases);
  for (std::size_t p = 0; p < phases; ++p) {
    const double share =
        static_cast<double>((p + phases - reference) % phases) / static_cast<double>(phases);
    cycle[p].reserve(mesh.points.size());
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      cycle[p].push_back((1.0 - share) * tracks[0][p][v] + share * tracks[1][p][v]);
    }
  }
  return cycle;
}

/// How much of a phase's surface are pockets and slits: of places outside, not far from it, the
/// share from which walls on two sides are about as near.
double pocket_share(const FieldCycle& field, std::size_t phase) {
  constexpr float kNearMm = 1;
  constexpr float kFarMm = 4;
  constexpr double kTwoSides = 0.6;  ///< of the gradient, below which walls on two sides are near
  const Grid& grid = field.distance_mm.grid;
  const std::vector<float>& d = field.distance_mm.phases[phase];
  const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(grid.size[0]),
                                          grid.slice_count()};
  std::size_t near = 0;
  std::size_t between = 0;
  for (int k = 1; k + 1 < grid.size[2]; ++k) {
    for (int j = 1; j + 1 < grid.size[1]; ++j) {
      for (int i = 1; i + 1 < grid.size[0]; ++i) {
        const std::size_t at = grid.offset(i, j, k);
        if (!(d[at] > kNearMm && d[at] < kFarMm)) continue;
        ++near;
        double steep2 = 0;
        for (const std::size_t way : stride) {
          steep2 += std::pow((d[at + way] - d[at - way]) / (2 * field.voxel_mm), 2);
        }
        between += steep2 < kTwoSides * kTwoSides ? 1 : 0;
      }
    }
  }
  return near > 0 ? static_cast<double>(between) / static_cast<double>(near) : 0;
}

/// A mesh that was fitted to all phases.
struct Fitted {
  std::vector<Triangle> triangles;
  Cycle cycle;
  int crossings = 0;           ///< of itself, all phases
  double thin_share = 0;       ///< of triangles of all phases, see kNotThinDeg
  std::vector<double> off_mm;  ///< [phase] of its surface, mean
  std::vector<double> lost;    ///< [phase] of the volume its surface encloses, the share it lacks
  double far = 0;              ///< both against what is too far: up to 1 the shape is kept

  [[nodiscard]] bool is_sound() const {
    return crossings == 0 && thin_share <= kMostThin && far <= 1;
  }
  /// A mesh that keeps the shape and hardly passes through itself comes before one that does not.
  [[nodiscard]] bool is_better_than(const Fitted& other) const {
    if (is_sound() != other.is_sound()) return is_sound();
    if (std::max(worst(), other.worst()) > 1) return worst() < other.worst();
    return crossings != other.crossings ? crossings < other.crossings
                                        : thin_share < other.thin_share;
  }

 private:
  /// Of the shape and of crossings, each against what is too much.
  [[nodiscard]] double worst() const {
    const auto all = static_cast<double>(triangles.size() * cycle.size());
    return std::max(far, crossings / (kManyCrossings * all));
  }
};

/// A mesh of one phase, carried to all and out of the slits that are closed there.
struct Begun {
  CycleFit fit;
  Cycle cycle;
  double flawed_share = 0;  ///< see CycleFit
};

Begun begun(const FieldCycle& field, const std::vector<field::Interpolant>& surface,
            std::size_t reference, double edge_mm, const StageContext& context) {
  context.progress(0, "triangles");
  const TriangleMesh mesh = reference_mesh(field, surface[reference], reference, edge_mm, context);
  Begun out{CycleFit(mesh.triangles, surface, edge_mm),
            carried(mesh, field, reference, context.part(0.2, 0.8))};
  context.progress(0.8, "fit to all phases");
  out.fit.leave_slits(out.cycle);
  out.flawed_share = out.fit.flawed_share(out.cycle);
  return out;
}

/// The share of a phase's volume that a mesh lacks or has too much. A sample's cell counts as far
/// as the surface, flat as far as the cell goes, leaves it inside.
double lost_share(const FieldCycle& field, std::size_t phase, const std::vector<Vec3>& points,
                  const std::vector<Triangle>& triangles) {
  double cells = 0;
  for (const float d : field.distance_mm.phases[phase]) {
    cells += std::clamp(0.5 - static_cast<double>(d) / field.voxel_mm, 0.0, 1.0);
  }
  const double inside_ml = cells * std::pow(field.voxel_mm, 3) * 1e-3;
  return std::abs(enclosed_ml(points, triangles) - inside_ml) / inside_ml;
}

/// [phase] See missed_share, with an edge as reach.
std::vector<double> missed_shares(const FieldCycle& field, const Cycle& cycle,
                                  const std::vector<Triangle>& triangles, double edge_mm) {
  std::vector<double> out(cycle.size());
  parallel_for(cycle.size(), [&](std::size_t p) {
    out[p] = missed_share(field.distance_mm.grid, field.distance_mm.phases[p], cycle[p], triangles,
                          edge_mm);
  });
  return out;
}

Fitted fitted(const FieldCycle& field, Begun begun, const std::vector<field::Interpolant>& surface,
              double edge_mm, const StageContext& context) {
  CycleFit& fit = begun.fit;
  Fitted out;
  out.cycle = std::move(begun.cycle);
  context.progress(0, "fit to all phases");
  fit.settle(out.cycle);
  context.progress(0.3, "motion along the surface");
  fit.calm(out.cycle);
  context.progress(0.5, "fit to all phases again");
  fit.leave_slits(out.cycle);
  fit.settle(out.cycle);
  context.progress(0.7, "thin triangles and crossings");
  out.crossings = fit.mend(out.cycle);
  out.triangles = fit.triangles();
  out.off_mm.resize(surface.size());
  out.lost.resize(surface.size());
  parallel_for(surface.size(), [&](std::size_t p) {
    out.off_mm[p] = off_surface(out.cycle[p], out.triangles, surface[p]).mean_mm();
    out.lost[p] = lost_share(field, p, out.cycle[p], out.triangles);
  });
  const double mean_mm = std::accumulate(out.off_mm.begin(), out.off_mm.end(), 0.0) /
                         static_cast<double>(surface.size());
  const double worst_mm = *std::max_element(out.off_mm.begin(), out.off_mm.end());
  out.far = std::max(mean_mm / kFarOffMm, worst_mm / kLostMm) /
            std::pow(std::max(1.0, edge_mm / kLongEdgeMm), 2);
  out.far = std::max(out.far, *std::max_element(out.lost.begin(), out.lost.end()) / kLostShare);
  std::size_t thin = 0;
  for (const std::vector<Vec3>& x : out.cycle) {
    thin += static_cast<std::size_t>(
        std::count_if(out.triangles.begin(), out.triangles.end(), [&](const Triangle& t) {
          return least_angle_deg(x[t[0]], x[t[1]], x[t[2]]) < kNotThinDeg;
        }));
  }
  out.thin_share =
      static_cast<double>(thin) / static_cast<double>(surface.size() * out.triangles.size());
  return out;
}

/// Phases to mesh, the likeliest first: the cycle's first and some others or, if that has many
/// pockets, those that have fewer before it. Of a pocket that is open where it is meshed and shut
/// in other phases triangles pile up in slivers.
std::vector<std::size_t> reference_phases(const FieldCycle& field) {
  constexpr std::array kFrom{0.0, 1.0 / 3, 1.0 / 2, 1.0 / 5};  // of the cycle
  const std::size_t count = field.distance_mm.phases.size();
  std::vector<std::size_t> out;
  for (const double from : kFrom) {
    const auto phase = static_cast<std::size_t>(std::lround(from * static_cast<double>(count)));
    if (phase < count && std::find(out.begin(), out.end(), phase) == out.end()) {
      out.push_back(phase);
    }
  }
  std::vector<double> share(count, 0);
  for (const std::size_t phase : out) share[phase] = pocket_share(field, phase);
  if (share[0] > kManyPockets) {
    std::stable_sort(out.begin(), out.end(),
                     [&](std::size_t a, std::size_t b) { return share[a] < share[b]; });
  }
  return out;
}

/// CycleFit::flawed_share of a mesh of coarser triangles, with what it misses of the surfaces,
/// which weighs as much as what lies off them. It ranks phases as a mesh of the edges that are
/// asked for does, in a tenth of the time. None if the phase cannot be meshed so.
std::optional<double> flawed_at_a_glance(const FieldCycle& field,
                                         const std::vector<field::Interpolant>& surface,
                                         std::size_t reference, double edge_mm,
                                         const StageContext& context) {
  constexpr double kCoarserBy = 2;
  edge_mm *= kCoarserBy;
  StageContext glance = context;
  glance.warn_sink = [](std::string_view) {};
  try {
    const Begun seen = begun(field, surface, reference, edge_mm, glance);
    const std::vector<double> missed =
        missed_shares(field, seen.cycle, seen.fit.triangles(), edge_mm);
    return seen.flawed_share + kLostWeighs * std::accumulate(missed.begin(), missed.end(), 0.0) /
                                   static_cast<double>(missed.size());
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Quality) throw;
    return std::nullopt;
  }
}

/// The phases of reference_phases in the order in which they are meshed: as they are or, where the
/// likeliest does not look hopeful at a glance, the least flawed first.
std::vector<std::size_t> phases_to_try(const FieldCycle& field,
                                       const std::vector<field::Interpolant>& surface,
                                       double edge_mm, const StageContext& context) {
  std::vector<std::size_t> out = reference_phases(field);
  std::vector<double> flawed(field.distance_mm.phases.size(), 0);
  for (const std::size_t phase : out) {
    context.check_cancelled();
    const auto seen = flawed_at_a_glance(field, surface, phase, edge_mm, context.part(0, 0));
    flawed[phase] = seen.value_or(std::numeric_limits<double>::infinity());
    if (phase == out.front() && (!seen || *seen <= kHopefulShare)) return out;
  }
  std::stable_sort(out.begin(), out.end(),
                   [&](std::size_t a, std::size_t b) { return flawed[a] < flawed[b]; });
  return out;
}

/// From the likeliest phase or, where triangles do not come through the cycle from there, the best
/// of some others.
Fitted best_fitted(const FieldCycle& field, const std::vector<field::Interpolant>& surface,
                   double edge_mm, const StageContext& context) {
  const std::vector<std::size_t> from =
      phases_to_try(field, surface, edge_mm, context.part(0, 0.1));
  const double each = 0.9 / static_cast<double>(from.size());
  std::optional<Fitted> best;
  for (std::size_t n = 0; n < from.size() && !(best && best->is_sound()); ++n) {
    const double at = 0.1 + static_cast<double>(n) * each;
    StageContext part = context.part(at, at + each);
    if (best) part.warn_sink = [](std::string_view) {};
    try {
      Begun start = begun(field, surface, from[n], edge_mm, part.part(0, 0.5));
      Fitted made = fitted(field, std::move(start), surface, edge_mm, part.part(0.5, 1));
      if (!best || made.is_better_than(*best)) best = std::move(made);
    } catch (const Error& error) {
      const bool last = n + 1 == from.size();
      if (error.code() != ErrorCode::Quality || (last && !best)) throw;
    }
  }
  return std::move(*best);
}

}  // namespace

double triangle_edge_mm(double voxel_mm, const MeshOptions& options) {
  constexpr double kOfVoxel = 10.0 / 9;
  constexpr double kFinestMm = 2;
  constexpr double kCoarsestMm = 10;
  return options.edge_mm.value_or(std::clamp(kOfVoxel * voxel_mm, kFinestMm, kCoarsestMm));
}

void check_options(const FieldCycle& field, const MeshOptions& options) {
  const double edge_mm = triangle_edge_mm(field.voxel_mm, options);
  if (!(edge_mm >= 0.5 && edge_mm <= 10)) {
    throw Error(ErrorCode::Usage, "edge_mm must lie between 0.5 and 10 mm");
  }
  const std::vector<std::vector<float>>& phases = field.distance_mm.phases;
  if (phases.empty()) throw_invalid(name_of(field) + " has no phases; build its field first");
  if (options.reference_phase < -1 || options.reference_phase >= static_cast<int>(phases.size())) {
    throw Error(ErrorCode::Usage, "reference_phase must be one of the " +
                                      std::to_string(phases.size()) +
                                      " phases, counted from 0, or -1");
  }
}

SurfaceCycle mesh_cycle(const FieldCycle& field, const MeshOptions& options,
                        StageContext& context) {
  check(field, options);
  const double edge_mm = triangle_edge_mm(field.voxel_mm, options);
  const std::size_t phases = field.distance_mm.phases.size();
  std::vector<field::Interpolant> surface;
  surface.reserve(phases);
  for (const std::vector<float>& samples : field.distance_mm.phases) {
    surface.emplace_back(field.distance_mm.grid, samples);
  }

  const Fitted made =
      options.reference_phase < 0
          ? best_fitted(field, surface, edge_mm, context)
          : fitted(field,
                   begun(field, surface, static_cast<std::size_t>(options.reference_phase), edge_mm,
                         context.part(0, 0.5)),
                   surface, edge_mm, context.part(0.5, 1));
  if (made.crossings > 0) {
    context.warn("the mesh of " + name_of(field) + " passes through itself at " +
                 counted(made.crossings, "pair") + " of triangles, all phases together");
  }

  SurfaceCycle out;
  out.structure = field.structure;
  out.triangles = made.triangles;
  for (const std::vector<Vec3>& phase : made.cycle) {
    std::vector<Vec3f>& points = out.positions.emplace_back();
    points.reserve(phase.size());
    for (const Vec3& x : phase) points.emplace_back(x.cast<float>());
  }
  const auto off = std::count_if(made.off_mm.begin(), made.off_mm.end(),
                                 [](double off_mm) { return off_mm > kFarOffMm; });
  if (off > 0) {
    const auto worst = std::max_element(made.off_mm.begin(), made.off_mm.end());
    context.warn("the mesh of " + name_of(field) + " lies off its surface in " +
                 std::to_string(off) + " of " + std::to_string(phases) + " phases, by " +
                 fixed(*worst, 2) + " mm on average in the worst, phase " +
                 std::to_string(worst - made.off_mm.begin()) +
                 "; the heart's shape there may differ too much from that of the reference phase");
  }
  const auto lost = std::max_element(made.lost.begin(), made.lost.end());
  if (*lost > kToldShare) {
    const auto phase = static_cast<std::size_t>(lost - made.lost.begin());
    context.warn("the mesh of " + name_of(field) + " and its surface differ by " +
                 fixed(100 * *lost, 0) + " % of volume in phase " + std::to_string(phase) +
                 ": its labels there do not hang together as in other phases; look for thin places "
                 "and pieces apart");
  }
  const std::vector<double> missed_of = missed_shares(field, made.cycle, made.triangles, edge_mm);
  const auto missed = std::max_element(missed_of.begin(), missed_of.end());
  if (*missed > kToldMissed) {
    context.warn("the mesh of " + name_of(field) + " misses " + fixed(100 * *missed, 0) +
                 " % of its surface in phase " + std::to_string(missed - missed_of.begin()) +
                 ": parts that are not there in other phases; look for labels that come and go");
  }
  context.progress(1.0);
  return out;
}

}  // namespace beatlas::mesh
