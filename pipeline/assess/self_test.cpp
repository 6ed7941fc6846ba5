#include "pipeline/assess/self_test.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "pipeline/core/parallel.h"
#include "pipeline/shape/slice_distance.h"
#include "runtime/base/error.h"

namespace beatlas::assess {
namespace {

constexpr int kFewestSlices = 4;
constexpr int kFewestPhases = 8;
constexpr int kMostHiddenPhases = 12;
constexpr std::size_t kMostWorst = 5;
constexpr int kFewestPoints = 12;                ///< of a contour: fewer are a pixel or two
constexpr double kFarMm = shape::kLevelReachMm;  ///< farther off is as far

using Phase = std::vector<float>;

/// A place of a contour in the plane of a slice, and the length that it stands for.
struct ContourPoint {
  double i = 0;
  double j = 0;
  double length_mm = 0;
};

/// Where a map of in-plane distances changes sign between two pixels. A curve meets the grid's
/// lines more often the steeper it runs across them: weighted by the normal, what it meets along
/// both axes sums up to its length.
std::vector<ContourPoint> contour_of(const Phase& distance, int nx, int ny, const Vec3& spacing) {
  std::vector<ContourPoint> out;
  const auto at = [&](int i, int j) {
    return static_cast<double>(distance[static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) +
                                        static_cast<std::size_t>(i)]);
  };
  const auto slope = [&](int i, int j) {
    const int left = std::max(i - 1, 0);
    const int right = std::min(i + 1, nx - 1);
    const int up = std::max(j - 1, 0);
    const int down = std::min(j + 1, ny - 1);
    const Vec2 gradient((at(right, j) - at(left, j)) / ((right - left) * spacing[0]),
                        (at(i, down) - at(i, up)) / ((down - up) * spacing[1]));
    return Vec2(gradient / std::max(gradient.norm(), 1e-9));
  };
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      const double here = at(i, j);
      if (i + 1 < nx && (here < 0) != (at(i + 1, j) < 0)) {
        const double share = here / (here - at(i + 1, j));
        out.push_back({i + share, double(j), std::abs(slope(i, j)[0]) * spacing[1]});
      }
      if (j + 1 < ny && (here < 0) != (at(i, j + 1) < 0)) {
        const double share = here / (here - at(i, j + 1));
        out.push_back({double(i), j + share, std::abs(slope(i, j)[1]) * spacing[0]});
      }
    }
  }
  return out;
}

/// Value and gradient of samples on a lattice, linear between them; at its edge those of the edge.
struct LinearSample {
  double value = 0;
  Vec3 gradient = Vec3::Zero();  ///< a unit of index
};
LinearSample linear_sample(const Grid& grid, const Phase& samples, const Vec3& index) {
  std::array<int, 3> low{};
  Vec3 share;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    const double inside = std::clamp(index[a], 0.0, grid.size[axis] - 1.0);
    low[axis] = std::min(static_cast<int>(inside), std::max(grid.size[axis] - 2, 0));
    share[a] = inside - low[axis];
  }
  LinearSample out;
  for (int corner = 0; corner < 8; ++corner) {
    std::array<int, 3> at{};
    Vec3 weight;
    Vec3 sign;
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<std::size_t>(a);
      const bool upper = ((corner >> a) & 1) != 0;
      at[axis] = std::min(low[axis] + (upper ? 1 : 0), grid.size[axis] - 1);
      weight[a] = upper ? share[a] : 1 - share[a];
      sign[a] = upper ? 1 : -1;
    }
    const double value = samples[grid.offset(at[0], at[1], at[2])];
    out.value += weight.prod() * value;
    out.gradient += value * Vec3(sign[0] * weight[1] * weight[2], sign[1] * weight[0] * weight[2],
                                 sign[2] * weight[0] * weight[1]);
  }
  return out;
}

/// How far a surface lies from a place where it should be, along its normal: > 0 too far out.
double outward_mm(double level, double steepness) {
  // Where levels are clamped there is no slope to go by.
  if (std::abs(level) >= kFarMm || steepness < 0.3) return -std::copysign(kFarMm, level);
  return std::clamp(-level / steepness, -kFarMm, kFarMm);
}

/// Errors of one contour.
struct Compared {
  Structure structure{};
  int slice = 0;  ///< of the coverage's grid
  int phase = 0;
  bool at_end = false;
  std::vector<Weighted> errors;
};

std::vector<HiddenError> pooled(const std::vector<Compared>& all, bool at_end) {
  std::map<Structure, std::pair<int, std::vector<Weighted>>> by_structure;
  for (const Compared& each : all) {
    if (each.at_end != at_end || each.errors.empty()) continue;
    auto& [count, errors] = by_structure[each.structure];
    ++count;
    errors.insert(errors.end(), each.errors.begin(), each.errors.end());
  }
  std::vector<HiddenError> out;
  out.reserve(by_structure.size());
  for (const auto& [structure, found] : by_structure) {
    out.push_back({structure, found.first, pooled_statistics(found.second, {})});
  }
  return out;
}

/// In-plane distances of every slice of the coverage, [phase][slice]; empty where it shows none.
using Sections = std::vector<std::vector<Phase>>;

Sections sections_of(const Segmentation& found, Structure structure,
                     const std::vector<int>& phases) {
  const std::vector<Phase>& shares = found.coverage.phases.at(structure);
  Sections out(shares.size());
  parallel_for(phases.size(), [&](std::size_t n) {
    const auto p = static_cast<std::size_t>(phases[n]);
    out[p] = shape::slice_distances(found.coverage.grid, shares[p]);
  });
  return out;
}

/// How far the shape of one phase lies from a slice's contour, all along it.
std::vector<Weighted> errors_along(const std::vector<ContourPoint>& contour, int k,
                                   const ShapeCycle& shape, std::size_t phase,
                                   const Affine& lattice_from_index) {
  const Eigen::Matrix3d mm_from_lattice_gradient =
      shape.level.grid.mm_from_index.linear().inverse().transpose();
  std::vector<Weighted> out;
  for (const ContourPoint& point : contour) {
    const LinearSample there = linear_sample(shape.level.grid, shape.level.phases[phase],
                                             lattice_from_index * Vec3(point.i, point.j, k));
    const double steepness = (mm_from_lattice_gradient * there.gradient).norm();
    out.push_back({outward_mm(there.value, steepness), point.length_mm});
  }
  return out;
}

/// What the slices of one parity foretell of the others.
void hide_slices(const Segmentation& found, const Grid& stack, int parity,
                 const std::vector<int>& phases, const std::map<Structure, Sections>& sections,
                 const shape::RegisterOptions& options, StageContext& context,
                 std::vector<Compared>& out) {
  const Grid& grid = found.coverage.grid;
  const Affine workspace = shape::workspace_from_lps(grid, found.coverage);
  const std::vector<ShapeCycle> shapes = shape::shapes_in_workspace(
      every_other_slice(found, stack, parity, phases), workspace, options, context);
  for (const ShapeCycle& shape : shapes) {
    const Affine lattice_from_index =
        shape.level.grid.mm_from_index.inverse() * workspace * grid.mm_from_index;
    const auto plane = found.valve_planes.find(shape.structure);
    const int base_step = plane != found.valve_planes.end() ? plane->second.base_step : 0;
    for (std::size_t n = 0; n < phases.size(); ++n) {
      const std::vector<Phase>& own = sections.at(shape.structure)[std::size_t(phases[n])];
      for (int k = 1 - parity; k < grid.size[2]; k += 2) {
        const auto shows = [&](int slice) {
          return slice >= 0 && slice < grid.size[2] &&
                 !own[static_cast<std::size_t>(slice)].empty();
        };
        if (!shows(k)) continue;
        // No slice foretells which one is the last before a valve.
        if (base_step != 0 && !shows(k + base_step)) continue;
        const std::vector<ContourPoint> contour = contour_of(
            own[static_cast<std::size_t>(k)], grid.size[0], grid.size[1], grid.spacing_mm());
        Compared compared{shape.structure, k, phases[n], !shows(k - 1) || !shows(k + 1),
                          errors_along(contour, k, shape, n, lattice_from_index)};
        if (compared.errors.size() >= kFewestPoints) out.push_back(std::move(compared));
      }
    }
  }
}

/// A phase as those one and three before and after it foretell it: the middle of a cubic.
void hide_phases(const Segmentation& found, const std::vector<int>& hidden,
                 const std::map<Structure, Sections>& sections, std::vector<Compared>& out) {
  const Grid& grid = found.coverage.grid;
  const auto phases = static_cast<int>(found.labels.phases.size());
  const auto wrapped = [&](int p) { return static_cast<std::size_t>((p + phases) % phases); };
  for (const auto& [structure, own] : sections) {
    for (const int p : hidden) {
      for (int k = 0; k < grid.size[2]; ++k) {
        const auto at = static_cast<std::size_t>(k);
        const std::array<const Phase*, 4> near{&own[wrapped(p - 1)][at], &own[wrapped(p + 1)][at],
                                               &own[wrapped(p - 3)][at], &own[wrapped(p + 3)][at]};
        const Phase& here = own[static_cast<std::size_t>(p)][at];
        const auto none = [](const Phase* phase) { return phase->empty(); };
        if (here.empty() || std::any_of(near.begin(), near.end(), none)) continue;
        Phase foretold(here.size());
        for (std::size_t v = 0; v < here.size(); ++v) {
          foretold[v] = ((*near[0])[v] + (*near[1])[v]) * (9.F / 16) -
                        ((*near[2])[v] + (*near[3])[v]) * (1.F / 16);
        }
        const Grid plane{{grid.size[0], grid.size[1], 1}, grid.mm_from_index};
        const Vec3 spacing = grid.spacing_mm();
        Compared compared{structure, k, p, false, {}};
        for (const ContourPoint& point : contour_of(here, grid.size[0], grid.size[1], spacing)) {
          const LinearSample there = linear_sample(plane, foretold, Vec3(point.i, point.j, 0));
          const Vec2 gradient(there.gradient[0] / spacing[0], there.gradient[1] / spacing[1]);
          compared.errors.push_back({outward_mm(there.value, gradient.norm()), point.length_mm});
        }
        if (compared.errors.size() >= kFewestPoints) out.push_back(std::move(compared));
      }
    }
  }
}

/// So many of the phases, evenly over the beat.
std::vector<int> evenly(int phases, int most) {
  const int count = std::min(phases, most);
  std::vector<int> out(static_cast<std::size_t>(count));
  for (int n = 0; n < count; ++n) out[static_cast<std::size_t>(n)] = n * phases / count;
  return out;
}

}  // namespace

Segmentation every_other_slice(const Segmentation& found, const Grid& stack, int parity,
                               const std::vector<int>& phases) {
  const CoverageCycle& all = found.coverage;
  Segmentation out;
  // Slice s of the new stack is slice 2 s + offset of the old one.
  const int offset = (all.first[2] + parity) % 2;
  const auto renumbered = [&](double k) { return (k - offset) / 2; };
  const int kept = (all.grid.size[2] - parity + 1) / 2;
  out.coverage.first = {all.first[0], all.first[1], (all.first[2] + parity - offset) / 2};
  out.coverage.grid = all.grid;
  out.coverage.grid.size[2] = kept;
  out.coverage.grid.mm_from_index.matrix().col(2) *= 2;
  out.coverage.grid.mm_from_index.translation() = all.grid.mm(0, 0, parity);
  for (const auto& [structure, shares] : all.phases) {
    std::vector<Phase> some;
    bool covered = false;
    for (const int p : phases) {
      Phase image;
      for (int k = parity; k < all.grid.size[2]; k += 2) {
        const auto from = shares[static_cast<std::size_t>(p)].begin() +
                          static_cast<std::ptrdiff_t>(all.grid.offset(0, 0, k));
        image.insert(image.end(), from, from + static_cast<std::ptrdiff_t>(all.grid.slice_count()));
      }
      covered =
          covered || std::any_of(image.begin(), image.end(), [](float c) { return c >= 0.5F; });
      some.push_back(std::move(image));
    }
    if (covered) out.coverage.phases[structure] = std::move(some);
  }
  out.labels.grid = out.coverage.grid;
  out.labels.grid.size[2] = static_cast<int>(std::floor(renumbered(stack.size[2] - 1))) + 1;
  const auto picked = [&](const std::vector<double>& of_all) {
    std::vector<double> some;
    for (const int p : phases) {
      if (!of_all.empty()) some.push_back(of_all[static_cast<std::size_t>(p)]);
    }
    return some;
  };
  for (const auto& [structure, plane] : found.valve_planes) {
    ValvePlane& moved = out.valve_planes[structure];
    moved.base_step = plane.base_step;
    for (const double k : picked(plane.k)) moved.k.push_back(renumbered(k));
  }
  if (found.axis) {
    out.axis = found.axis;
    out.axis->apex_mm = picked(found.axis->apex_mm);
    out.axis->lv_base_mm = picked(found.axis->lv_base_mm);
    out.axis->rv_base_mm = picked(found.axis->rv_base_mm);
  }
  return out;
}

SelfTest self_test(const Segmentation& found, const Grid& stack, double rr_interval_s,
                   const shape::RegisterOptions& options, StageContext& context) {
  const Grid& grid = found.coverage.grid;
  const auto phases = static_cast<int>(found.labels.phases.size());
  SelfTest out;
  out.slices_apart_mm = 2 * grid.spacing_mm()[2];
  out.slice_phases = {found.end_diastole};
  if (found.end_systole != found.end_diastole) out.slice_phases.push_back(found.end_systole);
  std::vector<int> hidden;
  if (phases >= kFewestPhases) hidden = evenly(phases, kMostHiddenPhases);

  std::vector<int> wanted = out.slice_phases;
  for (const int p : hidden) {
    for (const int by : {-3, -1, 0, 1, 3}) wanted.push_back((p + by + phases) % phases);
  }
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  std::map<Structure, Sections> sections;
  for (const auto& [structure, shares] : found.coverage.phases) {
    context.check_cancelled();
    sections[structure] = sections_of(found, structure, wanted);
  }
  const auto heart = sections.find(Structure::Heart);
  const auto shown = heart == sections.end() ? 0 : [&] {
    const std::vector<Phase>& own = heart->second[std::size_t(found.end_diastole)];
    return std::count_if(own.begin(), own.end(), [](const Phase& s) { return !s.empty(); });
  }();
  if (shown < kFewestSlices) {
    throw_invalid("the heart is in " + std::to_string(shown) +
                  " slices; slices foretell each other from " + std::to_string(kFewestSlices) +
                  " on");
  }
  std::vector<Compared> of_slices;
  for (const int parity : {0, 1}) {
    StageContext part = context.part(0.45 * parity + 0.1, 0.45 * parity + 0.55, "hidden slices");
    hide_slices(found, stack, parity, out.slice_phases, sections, options, part, of_slices);
  }
  out.between_slices = pooled(of_slices, false);
  out.at_ends = pooled(of_slices, true);
  if (!hidden.empty()) {
    out.phases_apart_s = 2 * rr_interval_s / phases;
    std::vector<Compared> of_phases;
    hide_phases(found, hidden, sections, of_phases);
    out.between_phases = pooled(of_phases, false);
  }
  for (const Compared& each : of_slices) {
    if (each.at_end) continue;
    out.worst.push_back({each.structure, each.slice + found.coverage.first[2], each.phase,
                         pooled_statistics(each.errors, {})});
  }
  std::stable_sort(
      out.worst.begin(), out.worst.end(),
      [](const HiddenPlace& a, const HiddenPlace& b) { return a.mm.mean > b.mm.mean; });
  if (out.worst.size() > kMostWorst) out.worst.resize(kMostWorst);
  return out;
}

}  // namespace beatlas::assess
