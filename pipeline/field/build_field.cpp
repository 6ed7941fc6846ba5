#include <algorithm>
#include <cmath>
#include <optional>

#include "pipeline/core/parallel.h"
#include "pipeline/field/closest_triangle.h"
#include "pipeline/field/field.h"
#include "pipeline/field/flicker.h"
#include "pipeline/field/interpolant.h"
#include "pipeline/field/surface.h"
#include "runtime/base/error.h"

namespace beatlas::field {
namespace {

constexpr int kBlock = 8;

std::string phase_of(const ShapeCycle& shape, std::size_t phase) {
  return "phase " + std::to_string(phase) + " of " + std::string(structure_name(shape.structure));
}

void check_range(const char* name, double value, double low, double high) {
  if (!(value >= low && value <= high)) {
    throw Error(ErrorCode::Usage, std::string(name) + " must lie between " + std::to_string(low) +
                                      " and " + std::to_string(high) + " mm, not " +
                                      std::to_string(value));
  }
}

void check(const FieldOptions& options) {
  check_range("voxel_mm", options.voxel_mm, 0.5, 4);
  check_range("inner_mm", options.inner_mm, 3, 40);
  check_range("outer_mm", options.outer_mm, 3, 40);
  // Interpolation near the surface must not see clamped samples.
  if (std::min(options.inner_mm, options.outer_mm) < 2 * options.voxel_mm) {
    throw Error(ErrorCode::Usage,
                "inner_mm and outer_mm must be at least two voxels of voxel_mm; widen the band or "
                "choose smaller voxels");
  }
}

void check(const ShapeCycle& shape) {
  const std::string name(structure_name(shape.structure));
  const Grid& grid = shape.level.grid;
  if (shape.level.phases.empty()) throw_invalid(name + " has no phases; segment it first");
  if (*std::min_element(grid.size.begin(), grid.size.end()) < 2) {
    throw_invalid("the lattice of " + name + " has fewer than two samples on an axis");
  }
  const Eigen::Matrix3d axes = grid.mm_from_index.linear();
  const double mm = grid.spacing_mm().x();
  if (!(mm > 0) || !std::isfinite(mm) ||
      !(axes.transpose() * axes).isApprox(mm * mm * Eigen::Matrix3d::Identity(), 1e-6)) {
    throw_invalid("the lattice of " + name +
                  " is not isotropic; resample it to cubic voxels before a distance is taken");
  }
  for (std::size_t p = 0; p < shape.level.phases.size(); ++p) {
    const std::vector<float>& level = shape.level.phases[p];
    if (level.size() != grid.count()) {
      throw_invalid(phase_of(shape, p) + " does not have one sample for each lattice point");
    }
    if (!std::all_of(level.begin(), level.end(), [](float v) { return std::isfinite(v); })) {
      throw_invalid(phase_of(shape, p) + " holds values that are not finite");
    }
  }
}

bool touches_border(const Grid& grid, const std::vector<float>& level) {
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      const bool whole_row = k == 0 || j == 0 || k == grid.size[2] - 1 || j == grid.size[1] - 1;
      const int step = whole_row ? 1 : grid.size[0] - 1;
      for (int i = 0; i < grid.size[0]; i += step) {
        if (level[grid.offset(i, j, k)] < 0) return true;
      }
    }
  }
  return false;
}

Grid lattice_around(const std::vector<TriangleSoup>& surfaces, const FieldOptions& options) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const TriangleSoup& surface : surfaces) {
    for (const Vec3& p : surface.points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  const double voxel = options.voxel_mm;
  const Vec3 first = ((low.array() - options.outer_mm) / voxel).floor();
  const Vec3 last = ((high.array() + options.outer_mm) / voxel).ceil();
  Grid grid;
  for (int axis = 0; axis < 3; ++axis) {
    grid.size[static_cast<std::size_t>(axis)] = static_cast<int>(last[axis] - first[axis]) + 1;
  }
  grid.mm_from_index.linear() = voxel * Eigen::Matrix3d::Identity();
  grid.mm_from_index.translation() = voxel * first;
  return grid;
}

// Signed distances of one phase. Blocks that no surface comes near are filled at once.
class PhaseSampler {
 public:
  PhaseSampler(const Grid& level_grid, const std::vector<float>& level, const TriangleSoup& surface,
               const Grid& grid, const FieldOptions& options)
      : level_grid_(level_grid),
        index_from_mm_(level_grid.mm_from_index.inverse(Eigen::Affine)),
        level_(level_grid, level),
        tree_(surface),
        grid_(grid),
        inner_mm_(options.inner_mm),
        outer_mm_(options.outer_mm) {}

  std::vector<float> run() const {
    std::vector<float> out(grid_.count());
    for (int k = 0; k < grid_.size[2]; k += kBlock) {
      for (int j = 0; j < grid_.size[1]; j += kBlock) {
        for (int i = 0; i < grid_.size[0]; i += kBlock) block({i, j, k}, out);
      }
    }
    return out;
  }

 private:
  bool is_inside(const Vec3& mm) const {
    const Vec3 index = index_from_mm_ * mm;
    for (int axis = 0; axis < 3; ++axis) {
      // Half a voxel beyond the lattice is where level_surface closes a cut shape.
      if (index[axis] < -0.5 ||
          index[axis] > level_grid_.size[static_cast<std::size_t>(axis)] - 0.5)
        return false;
    }
    return level_.value(mm) < 0;
  }

  void block(const Index3& first, std::vector<float>& out) const {
    Index3 last{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      last[axis] = std::min(first[axis] + kBlock, grid_.size[axis]) - 1;
    }
    const Vec3 low = grid_.mm(first[0], first[1], first[2]);
    const Vec3 high = grid_.mm(last[0], last[1], last[2]);
    const double reach = 0.5 * (high - low).norm();
    const double band = std::max(inner_mm_, outer_mm_) + reach;
    const ClosestTriangle::Hit near = tree_.nearest(0.5 * (low + high), {band * band, kNone});
    std::optional<bool> all_inside;
    if (near.triangle == kNone) all_inside = is_inside(low);

    ClosestTriangle::Hit last_hit = near;
    for (int k = first[2]; k <= last[2]; ++k) {
      for (int j = first[1]; j <= last[1]; ++j) {
        for (int i = first[0]; i <= last[0]; ++i) {
          const Vec3 mm = grid_.mm(i, j, k);
          const bool inside = all_inside ? *all_inside : is_inside(mm);
          const double clamp = inside ? inner_mm_ : outer_mm_;
          double distance = clamp;
          if (!all_inside) {
            // The neighbour's triangle is a good first bound: most of the tree falls away.
            ClosestTriangle::Hit bound{clamp * clamp, kNone};
            if (last_hit.triangle != kNone) {
              const double d2 = tree_.distance2_to(mm, last_hit.triangle);
              if (d2 < bound.distance2_mm2) bound = {d2, last_hit.triangle};
            }
            const ClosestTriangle::Hit hit = tree_.nearest(mm, bound);
            distance = std::sqrt(hit.distance2_mm2);
            if (hit.triangle != kNone) last_hit = hit;
          }
          out[grid_.offset(i, j, k)] = static_cast<float>(inside ? -distance : distance);
        }
      }
    }
  }

  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  const Grid& level_grid_;
  Affine index_from_mm_;
  Interpolant level_;
  ClosestTriangle tree_;
  const Grid& grid_;
  double inner_mm_;
  double outer_mm_;
};

}  // namespace

FieldCycle build_field(const ShapeCycle& shape, const FieldOptions& options,
                       StageContext& context) {
  check(options);
  check(shape);
  const std::size_t phases = shape.level.phases.size();
  const Grid& level_grid = shape.level.grid;

  std::vector<TriangleSoup> surfaces(phases);
  parallel_for(phases, context.part(0, 0.1), "surface of phase", [&](std::size_t p) {
    surfaces[p] = level_surface(level_grid, shape.level.phases[p]);
    if (surfaces[p].triangles.empty()) {
      throw_invalid(phase_of(shape, p) +
                    " has no surface; check the labels and seeds of that phase");
    }
  });
  for (std::size_t p = 0; p < phases; ++p) {
    if (touches_border(level_grid, shape.level.phases[p])) {
      context.warn(phase_of(shape, p) + " reaches the border of its lattice and is cut flat there");
    }
  }

  FieldCycle out;
  out.structure = shape.structure;
  out.voxel_mm = options.voxel_mm;
  out.inner_mm = options.inner_mm;
  out.outer_mm = options.outer_mm;
  out.distance_mm.grid = lattice_around(surfaces, options);
  out.distance_mm.phases.resize(phases);
  out.volume_ml.resize(phases);
  parallel_for(phases, context.part(0.1, 0.8), "distance in phase", [&](std::size_t p) {
    out.volume_ml[p] = enclosed_ml(surfaces[p]);
    out.distance_mm.phases[p] =
        PhaseSampler(level_grid, shape.level.phases[p], surfaces[p], out.distance_mm.grid, options)
            .run();
  });
  context.progress(0.8, "noise that flickers");
  if (options.flicker == Flicker::Remove) take_off_flicker(out);
  return out;
}

}  // namespace beatlas::field
