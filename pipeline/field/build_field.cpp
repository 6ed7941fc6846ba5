#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "pipeline/core/parallel.h"
#include "pipeline/field/closest_triangle.h"
#include "pipeline/field/field.h"
#include "pipeline/field/flicker.h"
#include "pipeline/field/interpolant.h"
#include "pipeline/field/repair_topology.h"
#include "pipeline/field/surface.h"
#include "runtime/base/error.h"

namespace beatlas::field {
namespace {

constexpr int kBlock = 8;
constexpr int kSmallBlock = 4;
// Of the patch that a vicinity holds: what its parts are as large as.
constexpr double kPartOfPatch = 0.5;
constexpr double kRoundingMm = 1e-3;  // more than single precision takes

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

void check(const FieldOptions& options, double voxel_mm) {
  check_range("voxel_mm", voxel_mm, 0.5, 4);
  check_range("inner_mm", options.inner_mm, 3, 40);
  check_range("outer_mm", options.outer_mm, 3, 40);
  // Interpolation near the surface must not see clamped samples.
  if (std::min(options.inner_mm, options.outer_mm) < 2 * voxel_mm) {
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

Grid lattice_around(const std::vector<TriangleSoup>& surfaces, double outer_mm, double voxel_mm) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const TriangleSoup& surface : surfaces) {
    for (const Vec3& p : surface.points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  const Vec3 first = ((low.array() - outer_mm) / voxel_mm).floor();
  const Vec3 last = ((high.array() + outer_mm) / voxel_mm).ceil();
  Grid grid;
  for (int axis = 0; axis < 3; ++axis) {
    grid.size[static_cast<std::size_t>(axis)] = static_cast<int>(last[axis] - first[axis]) + 1;
  }
  grid.mm_from_index.linear() = voxel_mm * Eigen::Matrix3d::Identity();
  grid.mm_from_index.translation() = voxel_mm * first;
  return grid;
}

// Signed distances of one phase. Blocks that no surface comes near are filled at once.
class PhaseSampler {
 public:
  PhaseSampler(const Grid& level_grid, const std::vector<float>& level, const TriangleSoup& surface,
               const Grid& grid, const FieldOptions& options)
      : level_grid_(level_grid),
        index_from_mm_(level_grid.mm_from_index.inverse(Eigen::Affine)),
        level_mm_(level_grid.spacing_mm().x()),
        samples_(level),
        level_(level_grid, level),
        tree_(surface),
        grid_(grid),
        inner_mm_(options.inner_mm),
        outer_mm_(options.outer_mm),
        out_(grid.count()) {}

  std::vector<float> run() {
    const auto layers = static_cast<std::size_t>((grid_.size[2] + kBlock - 1) / kBlock);
    parallel_for(layers, [&](std::size_t layer) {
      Around around;
      const int k = static_cast<int>(layer) * kBlock;
      for (int j = 0; j < grid_.size[1]; j += kBlock) {
        for (int i = 0; i < grid_.size[0]; i += kBlock)
          block({i, j, k}, kBlock, {}, nullptr, around);
      }
    });
    return std::move(out_);
  }

 private:
  using Hit = ClosestTriangle::Hit;
  // What of the surface is near a block and the part of it that is looked at.
  struct Around {
    ClosestTriangle::Vicinity block;
    ClosestTriangle::Vicinity small;
  };

  // The side of a place so far from the surface. Near it the interpolant tells; elsewhere that may
  // swing across zero beside a steep step, and the nearest sample tells.
  bool is_inside(const Vec3& mm, double away_mm) const {
    const Vec3 index = index_from_mm_ * mm;
    Index3 nearest{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = index[static_cast<Eigen::Index>(axis)];
      // Half a voxel beyond the lattice is where level_surface closes a cut shape.
      if (x < -0.5 || x > level_grid_.size[axis] - 0.5) return false;
      nearest[axis] = std::clamp(static_cast<int>(std::lround(x)), 0, level_grid_.size[axis] - 1);
    }
    if (away_mm < level_mm_) return level_.value(mm) < 0;
    return samples_[level_grid_.offset(nearest[0], nearest[1], nearest[2])] < 0;
  }

  double clamp_mm(bool inside) const { return inside ? inner_mm_ : outer_mm_; }

  // The nearer of a bound and of triangles that are near a neighbour.
  Hit nearer(const Vec3& mm, double bound_mm, std::uint32_t four) const {
    const Hit bound{static_cast<float>(bound_mm * bound_mm), kNone};
    return four == kNone ? bound : tree_.nearest_of(four, mm, bound);
  }

  void block(const Index3& first, int edge, const Hit& around,
             const ClosestTriangle::Vicinity* about, Around& room) {
    Index3 last{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      last[axis] = std::min(first[axis] + edge, grid_.size[axis]) - 1;
      if (last[axis] < first[axis]) return;
    }
    const Vec3 low = grid_.mm(first[0], first[1], first[2]);
    const Vec3 high = grid_.mm(last[0], last[1], last[2]);
    const Vec3 middle = 0.5 * (low + high);
    const double reach = 0.5 * (high - low).norm();
    const double widest = std::max(inner_mm_, outer_mm_);
    const Hit bound = nearer(middle, widest + reach, around.four);
    const Hit near =
        about != nullptr ? tree_.nearest(middle, bound, *about) : tree_.nearest(middle, bound);
    const double away = std::sqrt(near.distance2_mm2);
    const bool inside = is_inside(middle, away);
    const bool one_side = away > reach;
    // No sample of a block on one side that lies so far off is within the clamp.
    if (one_side && away >= clamp_mm(inside) + reach) {
      fill(first, last, static_cast<float>(inside ? -inner_mm_ : outer_mm_));
      return;
    }
    // A sample's nearest triangle is no farther from the middle than this.
    const double most = one_side ? clamp_mm(inside) : widest;
    const double within = std::min(away + 2 * reach, most + reach) + kRoundingMm;
    const double patch = std::sqrt(within * within - away * away);
    ClosestTriangle::Vicinity& vicinity = edge == kBlock ? room.block : room.small;
    tree_.gather(middle, within, kPartOfPatch * patch, about, vicinity);
    if (edge == kSmallBlock) {
      samples(first, last, one_side ? std::optional<bool>(inside) : std::nullopt, near.four,
              vicinity);
      return;
    }
    const int half = edge / 2;
    for (int part = 0; part < 8; ++part) {
      block({first[0] + (part & 1) * half, first[1] + (part >> 1 & 1) * half,
             first[2] + (part >> 2 & 1) * half},
            half, near, &vicinity, room);
    }
  }

  void fill(const Index3& first, const Index3& last, float value) {
    for (int k = first[2]; k <= last[2]; ++k) {
      for (int j = first[1]; j <= last[1]; ++j) {
        const auto from = out_.begin() + static_cast<std::ptrdiff_t>(grid_.offset(first[0], j, k));
        std::fill_n(from, last[0] - first[0] + 1, value);
      }
    }
  }

  // Sets the sample at a place, whose side is looked up where the caller does not know it.
  // @param start triangles that may be near  @return those nearest, or kNone
  std::uint32_t sample(const Vec3& mm, std::optional<bool> inside, std::uint32_t start,
                       const ClosestTriangle::Vicinity& about, float& out) {
    const double most = inside ? clamp_mm(*inside) : std::max(inner_mm_, outer_mm_);
    const Hit hit = tree_.nearest(mm, nearer(mm, most, start), about);
    const double away = std::sqrt(hit.distance2_mm2);
    if (!inside) inside = is_inside(mm, away);
    const auto kept = static_cast<float>(std::min(away, clamp_mm(*inside)));
    out = *inside ? -kept : kept;
    return hit.four;
  }

  // Each sample starts from its neighbour's triangle, and lies on its side if that is far enough.
  void samples(const Index3& first, const Index3& last, std::optional<bool> side,
               std::uint32_t four, const ClosestTriangle::Vicinity& about) {
    // A step along the lattice, and what rounding takes.
    const auto same_side = static_cast<float>(grid_.spacing_mm().x() + kRoundingMm);
    std::array<std::uint32_t, 3> start{four, four, four};  // of volume, plane and row
    for (int k = first[2]; k <= last[2]; ++k) {
      start[1] = start[0];
      for (int j = first[1]; j <= last[1]; ++j) {
        start[2] = start[1];
        for (int i = first[0]; i <= last[0]; ++i) {
          const std::size_t here = grid_.offset(i, j, k);
          std::optional<bool> inside = side;
          if (!inside && i > first[0] && std::abs(out_[here - 1]) > same_side) {
            inside = out_[here - 1] < 0;
          }
          const std::uint32_t found =
              sample(grid_.mm(i, j, k), inside, start[2], about, out_[here]);
          if (found == kNone) continue;
          start[2] = found;
          if (i == first[0]) start[1] = found;
          if (i == first[0] && j == first[1]) start[0] = found;
        }
      }
    }
  }

  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  const Grid& level_grid_;
  Affine index_from_mm_;
  double level_mm_;
  const std::vector<float>& samples_;
  Interpolant level_;
  ClosestTriangle tree_;
  const Grid& grid_;
  double inner_mm_;
  double outer_mm_;
  std::vector<float> out_;
};

}  // namespace

double voxel_edge_mm(double lattice_mm, const FieldOptions& options) {
  constexpr double kOfLattice = 1.5;
  constexpr double kFinestMm = 1.5;
  constexpr double kCoarsestMm = 4;
  return options.voxel_mm.value_or(std::clamp(kOfLattice * lattice_mm, kFinestMm, kCoarsestMm));
}

FieldCycle build_field(const ShapeCycle& shape, const FieldOptions& options,
                       StageContext& context) {
  check(shape);
  const double voxel_mm = voxel_edge_mm(shape.level.grid.spacing_mm().x(), options);
  check(options, voxel_mm);
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
  out.voxel_mm = voxel_mm;
  out.inner_mm = options.inner_mm;
  out.outer_mm = options.outer_mm;
  out.distance_mm.grid = lattice_around(surfaces, options.outer_mm, voxel_mm);
  out.distance_mm.phases.resize(phases);
  out.volume_ml.resize(phases);
  parallel_for(phases, context.part(0.1, 0.7), "distance in phase", [&](std::size_t p) {
    out.volume_ml[p] = enclosed_ml(surfaces[p]);
    out.distance_mm.phases[p] =
        PhaseSampler(level_grid, shape.level.phases[p], surfaces[p], out.distance_mm.grid, options)
            .run();
  });
  context.progress(0.7, "noise that flickers");
  if (options.flicker == Flicker::Remove) take_off_flicker(out);
  if (options.handles == Handles::Close) repair_topology(out, context.part(0.8, 1));
  return out;
}

}  // namespace beatlas::field
