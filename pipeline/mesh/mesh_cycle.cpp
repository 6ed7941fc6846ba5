#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>

#include "pipeline/core/parallel.h"
#include "pipeline/core/words.h"
#include "pipeline/field/surface.h"
#include "pipeline/mesh/carry.h"
#include "pipeline/mesh/cycle_fit.h"
#include "pipeline/mesh/cycle_topology.h"
#include "pipeline/mesh/mesh.h"
#include "pipeline/mesh/triangle_mesh.h"
#include "runtime/base/error.h"

namespace beatlas::mesh {
namespace {

constexpr double kMeanOffSurfaceMm = 0.05;
constexpr double kLeastDeg = 10;  ///< of a sound mesh's triangles

std::string name_of(const FieldCycle& field) {
  return std::string(structure_name(field.structure));
}

std::string fixed(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
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
  }
}

TriangleMesh reference_mesh(const FieldCycle& field, const field::Interpolant& surface,
                            std::size_t phase, const MeshOptions& options,
                            const StageContext& context) {
  field::TriangleSoup soup = field::extract_surface(field, static_cast<int>(phase));
  TriangleMesh raw{std::move(soup.points), std::move(soup.triangles)};
  const auto fail = [&](const std::string& why) {
    throw Error(ErrorCode::Quality, "the surface of " + name_of(field) + " in phase " +
                                        std::to_string(phase) + " " + why);
  };
  if (!inspect(raw.points.size(), raw.triangles).closed_manifold) {
    fail("is not closed; the structure reaches the border of its lattice");
  }
  LargestComponent kept = largest_component(raw);
  if (kept.components > 1) {
    context.warn(name_of(field) + " falls into " + std::to_string(kept.components) +
                 " pieces; the largest is kept and " + fixed(kept.others_ml, 2) +
                 " ml in the others are left out");
  }
  const int euler_before = inspect(kept.mesh.points.size(), kept.mesh.triangles).euler_number;
  TriangleMesh mesh = remeshed(kept.mesh, options.edge_mm);
  constexpr std::size_t kFewestTriangles = 32;
  const Topology after = inspect(mesh.points.size(), mesh.triangles);
  if (!after.closed_manifold || after.euler_number != euler_before ||
      mesh.triangles.size() < kFewestTriangles) {
    fail("is too small for triangles of " + fixed(options.edge_mm, 2) +
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

/// Every phase's surface made one sphere; tells what was done.
void close_handles(FieldCycle& field, const StageContext& context) {
  const std::size_t phases = field.distance_mm.phases.size();
  const std::vector<Repair> repairs =
      make_balls(field.distance_mm.grid, field.distance_mm.phases, context.part(0, 0.15));
  std::size_t mended = 0;
  std::size_t changed = 0;
  std::size_t most = 0;
  for (std::size_t p = 0; p < phases; ++p) {
    const Repair& repair = repairs[p];
    if (repair.left_handles > 0) {
      context.warn("the surface of " + name_of(field) + " in phase " + std::to_string(p) +
                   " keeps " + counted(repair.left_handles, "handle") +
                   ": look for holes in thin places of its labels");
    }
    mended += repair.changed > 0 ? 1 : 0;
    changed += repair.changed;
    if (repair.changed > repairs[most].changed) most = p;
  }
  if (mended == 0) return;
  const BodyTopology& before = repairs[most].before;
  const double voxel_ml = std::pow(field.voxel_mm, 3) * 1e-3;
  context.warn(name_of(field) + " was mended in " + std::to_string(mended) + " of " +
               std::to_string(phases) + " phases, by " +
               fixed(static_cast<double>(changed) * voxel_ml / static_cast<double>(mended), 2) +
               " ml on average; most in phase " + std::to_string(most) + ", which had " +
               counted(before.pieces, "piece") + ", " + counted(before.hollows, "hollow") +
               " and " + counted(before.handles, "handle"));
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

/// A mesh that was fitted to all phases.
struct Fitted {
  std::vector<Triangle> triangles;
  Cycle cycle;
  int crossings = 0;  ///< of itself, all phases
  double least_deg = 180;

  [[nodiscard]] bool is_sound() const { return crossings == 0 && least_deg >= kLeastDeg; }
  [[nodiscard]] bool is_better_than(const Fitted& other) const {
    return crossings != other.crossings ? crossings < other.crossings : least_deg > other.least_deg;
  }
};

Fitted fitted(const FieldCycle& field, const std::vector<field::Interpolant>& surface,
              std::size_t reference, const MeshOptions& options, const StageContext& context) {
  context.progress(0, "triangles");
  const TriangleMesh mesh = reference_mesh(field, surface[reference], reference, options, context);
  Fitted out;
  out.cycle = carried(mesh, field, reference, context.part(0.1, 0.4));
  CycleFit fit(mesh.triangles, surface, options.edge_mm);
  context.progress(0.4, "fit to all phases");
  fit.leave_slits(out.cycle);
  fit.settle(out.cycle);
  context.progress(0.6, "motion along the surface");
  fit.calm(out.cycle);
  context.progress(0.7, "fit to all phases again");
  fit.leave_slits(out.cycle);
  fit.settle(out.cycle);
  context.progress(0.85, "thin triangles and crossings");
  out.crossings = fit.mend(out.cycle);
  out.triangles = fit.triangles();
  for (const std::vector<Vec3>& x : out.cycle) {
    for (const Triangle& t : out.triangles) {
      out.least_deg = std::min(out.least_deg, least_angle_deg(x[t[0]], x[t[1]], x[t[2]]));
    }
  }
  return out;
}

/// From the first phase or, where triangles do not come through the cycle from there, the best of
/// some others: of a pocket that is open in that phase and shut in others they pile up in slivers.
Fitted best_fitted(const FieldCycle& field, const std::vector<field::Interpolant>& surface,
                   const MeshOptions& options, const StageContext& context) {
  constexpr std::array kOthers{1.0 / 3, 1.0 / 2, 1.0 / 5};  // of the cycle
  constexpr double kShare = 0.4;                            // of the time, if there is no other
  Fitted best = fitted(field, surface, 0, options, context.part(0, kShare));
  StageContext quiet = context;
  quiet.warn_sink = [](std::string_view) {};
  for (std::size_t n = 0; n < kOthers.size() && !best.is_sound(); ++n) {
    const auto phase =
        static_cast<std::size_t>(std::lround(kOthers[n] * static_cast<double>(surface.size())));
    if (phase == 0 || phase >= surface.size()) continue;
    try {
      const double each = (1 - kShare) / kOthers.size();
      const double before = kShare + static_cast<double>(n) * each;
      Fitted other = fitted(field, surface, phase, options, quiet.part(before, before + each));
      if (other.is_better_than(best)) best = std::move(other);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::Quality) throw;  // that phase cannot be meshed
    }
  }
  return best;
}

double mean_off_surface_mm(const std::vector<Vec3>& points, const field::Interpolant& surface) {
  double sum = 0;
  for (const Vec3& p : points) sum += std::abs(surface.value(p));
  return sum / static_cast<double>(points.size());
}

}  // namespace

void check_options(const FieldCycle& field, const MeshOptions& options) {
  if (!(options.edge_mm >= 0.5 && options.edge_mm <= 10)) {
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

SurfaceCycle mesh_cycle(const FieldCycle& given, const MeshOptions& options,
                        StageContext& context) {
  check(given, options);
  FieldCycle field = given;
  if (options.handles == Handles::Close) close_handles(field, context);
  const std::size_t phases = field.distance_mm.phases.size();
  std::vector<field::Interpolant> surface;
  surface.reserve(phases);
  for (const std::vector<float>& samples : field.distance_mm.phases) {
    surface.emplace_back(field.distance_mm.grid, samples);
  }

  const StageContext fitting = context.part(0.15, 1);
  const Fitted made =
      options.reference_phase < 0
          ? best_fitted(field, surface, options, fitting)
          : fitted(field, surface, static_cast<std::size_t>(options.reference_phase), options,
                   fitting);
  if (made.crossings > 0) {
    context.warn("the mesh of " + name_of(field) + " passes through itself at " +
                 counted(made.crossings, "pair") + " of triangles, all phases together");
  }

  SurfaceCycle out;
  out.structure = field.structure;
  out.triangles = made.triangles;
  int off = 0;
  std::size_t worst = 0;
  double worst_mm = 0;
  for (std::size_t p = 0; p < phases; ++p) {
    const double off_mm = mean_off_surface_mm(made.cycle[p], surface[p]);
    off += off_mm > kMeanOffSurfaceMm ? 1 : 0;
    if (off_mm > worst_mm) {
      worst_mm = off_mm;
      worst = p;
    }
    std::vector<Vec3f>& points = out.positions.emplace_back();
    points.reserve(made.cycle[p].size());
    for (const Vec3& x : made.cycle[p]) points.emplace_back(x.cast<float>());
  }
  if (off > 0) {
    context.warn("the mesh of " + name_of(field) + " lies off its surface in " +
                 std::to_string(off) + " of " + std::to_string(phases) + " phases, by " +
                 fixed(worst_mm, 2) + " mm on average in the worst, phase " +
                 std::to_string(worst) +
                 "; the heart's shape there may differ too much from that of the reference phase");
  }
  context.progress(1.0);
  return out;
}

}  // namespace beatlas::mesh
