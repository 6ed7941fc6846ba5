#include "pipeline/shape/workspace.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/shape/section_path.h"
#include "pipeline/shape/shape_level.h"
#include "pipeline/shape/shared_places.h"
#include "pipeline/shape/slice_distance.h"
#include "pipeline/shape/wall_thickness.h"
#include "runtime/base/error.h"

namespace beatlas::shape {
namespace {

/// Lattice that holds every voxel with coverage, with a margin, aligned to multiples of the step.
Grid lattice_around(const Grid& source, const std::vector<Phase>& phases,
                    const Affine& workspace_from_lps, double step, double margin_mm) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::max());
  Vec3 high = -low;
  const Affine workspace_from_index = workspace_from_lps * source.mm_from_index;
  for (int k = 0; k < source.size[2]; ++k) {
    for (int j = 0; j < source.size[1]; ++j) {
      for (int i = 0; i < source.size[0]; ++i) {
        const std::size_t v = source.offset(i, j, k);
        const bool covered = std::any_of(phases.begin(), phases.end(),
                                         [&](const Phase& phase) { return phase[v] >= 0.5F; });
        if (!covered) continue;
        for (const double side : {-0.5, 0.5}) {
          const Vec3 x = workspace_from_index * Vec3(i + side, j + side, k + side);
          low = low.cwiseMin(x);
          high = high.cwiseMax(x);
        }
      }
    }
  }
  Grid lattice;
  Vec3 origin;
  for (int a = 0; a < 3; ++a) {
    const double first = std::floor((low[a] - margin_mm) / step);
    const double last = std::ceil((high[a] + margin_mm) / step);
    origin[a] = first * step;
    lattice.size[static_cast<std::size_t>(a)] = static_cast<int>(last - first) + 1;
  }
  lattice.mm_from_index = Eigen::Translation3d(origin) * Eigen::Scaling(step);
  return lattice;
}

}  // namespace

double lattice_edge_mm(double slice_distance_mm, std::optional<double> wall_mm,
                       const RegisterOptions& options) {
  constexpr double kFinestMm = 1;
  constexpr double kCoarsestMm = 1.5;
  constexpr double kOfSliceDistance = 1.0 / 6;
  constexpr double kOfWall = 2.0 / 9;
  constexpr double kPerMm = 20;  // What rounding does to a distance must not show in a lattice.
  const double told_mm =
      std::min(kOfSliceDistance * slice_distance_mm, wall_mm ? kOfWall * *wall_mm : kCoarsestMm);
  return options.shape_mm.value_or(
      std::clamp(std::round(told_mm * kPerMm) / kPerMm, kFinestMm, kCoarsestMm));
}

Affine workspace_from_lps(const Grid& source, const CoverageCycle& coverage) {
  const Vec3 spacing = source.spacing_mm();
  Eigen::Matrix3d axes;
  axes.col(0) = source.mm_from_index.linear().col(0).normalized();
  axes.col(1) = source.mm_from_index.linear().col(1).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  Affine rotation = Affine::Identity();
  rotation.linear() = axes.transpose();

  const bool right_handed = source.mm_from_index.linear().determinant() > 0;
  const Vec3 published(kWorkspaceSpacingMm[0], kWorkspaceSpacingMm[1], kWorkspaceSpacingMm[2]);
  if (right_handed && source.size == kWorkspaceSize && (spacing - published).norm() < 1e-3) {
    const Vec3 corner = source.mm(-0.5, -0.5, -0.5);
    return Affine(rotation * Eigen::Translation3d(-corner));
  }
  const auto heart = coverage.phases.find(Structure::Heart);
  if (heart == coverage.phases.end()) throw_invalid("segmentation holds no heart to place");
  Vec3 sum = Vec3::Zero();
  double weight = 0;
  for (const Phase& phase : heart->second) {
    for (int k = 0; k < coverage.grid.size[2]; ++k) {
      for (int j = 0; j < coverage.grid.size[1]; ++j) {
        for (int i = 0; i < coverage.grid.size[0]; ++i) {
          const double c = phase[coverage.grid.offset(i, j, k)];
          if (c <= 0) continue;
          sum += c * Vec3(i, j, k);
          weight += c;
        }
      }
    }
  }
  if (!(weight > 0)) throw_invalid("segmentation holds no heart to place: its coverage is empty");
  const Vec3 centroid_lps = coverage.grid.mm_from_index * Vec3(sum / weight);
  const Vec3 centre(kWorkspaceCentreMm[0], kWorkspaceCentreMm[1], kWorkspaceCentreMm[2]);
  Affine out = rotation;
  out.translation() = centre - rotation.linear() * centroid_lps;
  return out;
}

namespace {

/// Of all phases, see filled_lv.
std::vector<Phase> filled_lvs(const CoverageCycle& coverage) {
  std::vector<Phase> out(coverage.phases.at(Structure::LvMyocardium).size());
  for (std::size_t p = 0; p < out.size(); ++p) out[p] = filled_lv(coverage, p);
  return out;
}

/// What all structures of a stack share.
struct StackSlices {
  double gap_mm = 0;   ///< from slice to slice
  bool thick = false;  ///< too far apart for coverage to show where the surface runs between them
  int last_k = 0;      ///< of the whole stack
  int to_apex = 0;     ///< step of the slice index; 0: unknown, or not asked
  double lattice_mm = 0;  ///< edge of the lattice of the shapes
  SectionPath lv_path;    ///< of the LV's cavity and wall together; empty: there are not both
  /// [phase] slice_distances of the LV's blood where its wall is there too: both shapes need them.
  std::vector<std::vector<Phase>> cavity;
};

/// Makes levels of one structure's coverage on the lattice of its shape.
class LevelMaker {
 public:
  /// @param filled [phase] coverage of the structure, of the LV's wall with its cavity
  /// @param lattice must outlive this, as segmentation and stack must
  LevelMaker(const Segmentation& segmentation, const StackSlices& stack, Structure structure,
             const std::vector<Phase>& filled, const Grid& lattice,
             const Affine& workspace_from_lps)
      : source_(segmentation.coverage.grid),
        lattice_(lattice),
        structure_(structure),
        map_(axis_map(source_, lattice, workspace_from_lps)),
        stack_(stack),
        first_k_(segmentation.coverage.first[2]) {
    const auto found = segmentation.valve_planes.find(structure);
    if (found != segmentation.valve_planes.end()) open_step_ = found->second.base_step;
    if (!stack.thick) return;
    const bool of_lv = structure == Structure::LvMyocardium || structure == Structure::LvBlood;
    path_ = of_lv && !stack.lv_path.empty() ? stack.lv_path : section_path(source_, filled);
  }

  /// In-plane distances [mm] of each slice, of thick ones; else none.
  /// @param part coverage of phase p
  [[nodiscard]] std::vector<Phase> sections_of(const Phase& part, std::size_t p) const {
    if (!stack_.thick) return {};
    const bool known = structure_ == Structure::LvBlood && !stack_.cavity.empty();
    return known ? stack_.cavity[p] : slice_distances(source_, part);
  }

  /// @param part coverage of a phase  @param sections of it
  [[nodiscard]] Phase level_of(const Phase& part, const std::vector<Phase>& sections,
                               const ApicalEnd& apex, Creases creases) const {
    return stack_.thick
               ? level_from_slices(source_, sections, path_, lattice_, map_, open_step_, apex)
               : level_from_coverage(source_, part, lattice_, map_, creases);
  }

  /// Takes the cavity out of a level of wall and cavity together.
  /// @param sections of both  @param cavity its coverage in phase p
  void hollow(Phase& level, const std::vector<Phase>& sections, const Phase& cavity, std::size_t p,
              const ApicalEnd& apex) const {
    const std::vector<Phase> none;
    const std::vector<Phase>& within = stack_.thick ? stack_.cavity[p] : none;
    const Phase inner = level_of(cavity, within, apex, Creases::Keep);
    std::transform(level.begin(), level.end(), inner.begin(), level.begin(),
                   [](float outside, float inside) { return std::max(outside, -inside); });
    if (stack_.thick && open_step_ != 0) {
      open_toward_base(level, source_, sections, within, path_, lattice_, map_, open_step_);
    }
  }

  /// Ends a phase's level flat on the side of the base, and where images or coverage end.
  /// @param part coverage of what the level is of  @param own of the structure itself
  void end_flat(Phase& level, const Phase& part, const Phase& own) const {
    const auto cut_at = [&](double k, int step) {
      cut_flat(level, lattice_, map_, stack_.gap_mm, k, step);
    };
    if (open_step_ != 0) cut_at(base_end(own), open_step_);
    // Where the stack ends, so does the heart: half a gap beyond its last slice. So it does where
    // the coverage of thin slices ends within it: beyond its rim a coverage reads as at its rim.
    const int last = source_.size[2] - 1;
    const bool begins_within = !stack_.thick && holds(part, 0);
    const bool ends_within = !stack_.thick && holds(part, last);
    cut_at(-0.5 - (begins_within ? 0 : first_k_), -1);
    cut_at(0.5 + (ends_within ? last : stack_.last_k - first_k_), +1);
    if (stack_.thick) cut_beside(level, lattice_, map_, source_);
  }

 private:
  [[nodiscard]] bool holds(const Phase& part, int k) const {
    const auto from = part.begin() + static_cast<std::ptrdiff_t>(source_.offset(0, 0, k));
    return std::any_of(from, from + static_cast<std::ptrdiff_t>(source_.slice_count()),
                       [](float share) { return share > 0; });
  }

  /// Half a gap beyond the last slice, which is as far as volumes count; nearer to it, the less of
  /// the largest section it holds: that is what a leaning valve leaves, and no column.
  [[nodiscard]] double base_end(const Phase& own) const {
    const int n = source_.size[2];
    double largest = 1;
    double of_last = 0;
    int last = open_step_ > 0 ? -1 : n;
    for (int k = open_step_ > 0 ? 0 : n - 1; k >= 0 && k < n; k += open_step_) {
      const double section = section_voxels(source_, own, k);
      if (section == 0) continue;
      last = k;
      of_last = section;
      largest = std::max(largest, section);
    }
    return last + open_step_ * std::min(0.5, of_last / largest);
  }

  const Grid& source_;
  const Grid& lattice_;
  Structure structure_;
  AxisMap map_;
  const StackSlices& stack_;
  double first_k_;     ///< of the coverage in the whole stack
  int open_step_ = 0;  ///< of the slice index, towards the base, where it ends flat; 0: nowhere
  SectionPath path_;
};

void check_covered(Structure structure, const std::vector<Phase>& phases) {
  const bool covered = std::any_of(phases.begin(), phases.end(), [](const Phase& phase) {
    return std::any_of(phase.begin(), phase.end(), [](float c) { return c >= 0.5F; });
  });
  if (!covered) {
    throw_invalid("segmentation names " + std::string(structure_name(structure)) +
                  " but no voxel of any phase lies in it; leave the structure out");
  }
}

/// @param segmentation whose coverage is let go of, phase by phase, where nothing else needs it
ShapeCycle shape_of_structure(Structure structure, Segmentation& segmentation,
                              const StackSlices& stack, const Affine& workspace_from_lps,
                              double margin_mm, const StageContext& context) {
  CoverageCycle& coverage = segmentation.coverage;
  std::vector<Phase>& phases = coverage.phases.at(structure);
  // A wall is the space between two filled shapes: their contours interpolate, an annulus
  // whose centre wanders from slice to slice does not.
  const bool wall = structure == Structure::LvMyocardium;
  const auto cavity = coverage.phases.find(Structure::LvBlood);
  const bool with_cavity = wall && cavity != coverage.phases.end();
  std::vector<Phase> with_blood;
  if (with_cavity) with_blood = filled_lvs(coverage);
  std::vector<Phase>& filled = with_cavity ? with_blood : phases;
  // The LV's wall is made with its cavity, and both tell where other structures end.
  const bool done_with = with_cavity || (!wall && structure != Structure::LvBlood);
  ShapeCycle shape;
  shape.structure = structure;
  shape.level.grid =
      lattice_around(coverage.grid, filled, workspace_from_lps, stack.lattice_mm, margin_mm);
  shape.level.phases.resize(filled.size());
  const LevelMaker maker(segmentation, stack, structure, filled, shape.level.grid,
                         workspace_from_lps);
  parallel_for(filled.size(), context, "phase", [&](std::size_t p) {
    const ApicalEnds ends = apical_ends(segmentation, structure, p, stack.to_apex);
    const std::vector<Phase> sections = maker.sections_of(filled[p], p);
    // Between the LV's wall and the RV's runs a seam of labels.
    Phase level = maker.level_of(filled[p], sections,
                                 structure == Structure::LvBlood ? ends.cavity : ends.wall,
                                 wall ? Creases::Round : Creases::Keep);
    if (with_cavity) maker.hollow(level, sections, cavity->second[p], p, ends.cavity);
    maker.end_flat(level, filled[p], phases[p]);
    for (float& value : level) value = std::clamp(value, -kLevelReachMm, kLevelReachMm);
    shape.level.phases[p] = std::move(level);
    if (done_with) filled[p] = Phase();
  });
  return shape;
}

}  // namespace

std::vector<ShapeCycle> shapes_in_workspace(Segmentation segmentation,
                                            const Affine& workspace_from_lps,
                                            const RegisterOptions& options, StageContext& context) {
  const CoverageCycle& coverage = segmentation.coverage;
  StackSlices stack;
  stack.gap_mm = coverage.grid.spacing_mm()[2];
  stack.thick = are_thick_slices(stack.gap_mm);
  stack.lattice_mm = lattice_edge_mm(stack.gap_mm, wall_thickness_mm(coverage), options);
  stack.last_k = segmentation.labels.grid.size[2] - 1;
  stack.to_apex = stack.thick ? step_to_apex(segmentation, segmentation.axis) : 0;
  segmentation.labels.phases = {};
  // The cavity goes the same way as the wall about it.
  if (stack.thick && holds_lv(coverage)) {
    stack.lv_path = section_path(coverage.grid, filled_lvs(coverage));
    const std::vector<Phase>& blood = coverage.phases.at(Structure::LvBlood);
    stack.cavity.resize(blood.size());
    parallel_for(blood.size(), [&](std::size_t p) {
      stack.cavity[p] = slice_distances(coverage.grid, blood[p]);
    });
  }
  std::vector<ShapeCycle> shapes;
  for (const auto& [structure, phases] : coverage.phases) {
    check_covered(structure, phases);
    const auto each = 1.0 / static_cast<double>(coverage.phases.size());
    const double before = each * static_cast<double>(shapes.size());
    const StageContext part = context.part(before, before + each, structure_name(structure));
    shapes.push_back(shape_of_structure(structure, segmentation, stack, workspace_from_lps,
                                        options.margin_mm, part));
  }
  settle_shared_places(shapes);
  return shapes;
}

namespace {

Grid published_grid() {
  Grid grid;
  grid.size = kWorkspaceSize;
  const Vec3 spacing(kWorkspaceSpacingMm[0], kWorkspaceSpacingMm[1], kWorkspaceSpacingMm[2]);
  grid.mm_from_index = Eigen::Translation3d(0.5 * spacing) * Eigen::Scaling(spacing);
  return grid;
}

/// Whether an index lies more than `rim` beyond the outermost centres.
bool out_of(double index, int size, double rim) { return index < -rim || index > size - 1 + rim; }

/// An image, linear between its voxels, read in every voxel of another grid that lies in it.
/// @param rim [voxels of the image] beyond its outermost centres, within which it stays as there
/// @param put called with (offset in `to`, value)
template <class Put>
void read_on_grid(const Grid& source, const Phase& image, const Grid& to, const AxisMap& map,
                  double rim, const Put& put) {
  const auto [nx, ny, nz] = source.size;
  for (int z = 0; z < to.size[2]; ++z) {
    const double k = map.index(2, z);
    if (out_of(k, nz, rim)) continue;
    const double inside_k = std::clamp(k, 0.0, nz - 1.0);
    const int k0 = std::min(static_cast<int>(inside_k), std::max(0, nz - 2));
    const auto w = static_cast<float>(inside_k - k0);
    const float* slice0 = image.data() + source.offset(0, 0, k0);
    const float* slice1 = nz > 1 ? slice0 + source.slice_count() : slice0;
    for (int y = 0; y < to.size[1]; ++y) {
      const double j = map.index(1, y);
      if (out_of(j, ny, rim)) continue;
      for (int x = 0; x < to.size[0]; ++x) {
        const double i = map.index(0, x);
        if (out_of(i, nx, rim)) continue;
        put(to.offset(x, y, z),
            (1 - w) * sample_plane(slice0, nx, ny, i, j) + w * sample_plane(slice1, nx, ny, i, j));
      }
    }
  }
}

}  // namespace

ImageCycle<float> cine_in_workspace(Cine cine, const Affine& workspace_from_lps) {
  ImageCycle<float> out;
  out.grid = published_grid();
  out.phases.resize(cine.images.phases.size());
  const AxisMap map = axis_map(cine.grid(), out.grid, workspace_from_lps);
  const Grid& source = cine.grid();
  parallel_for(out.phases.size(), [&](std::size_t p) {
    Phase& to = out.phases[p];
    to.assign(out.grid.count(), 0);
    read_on_grid(source, cine.images.phases[p], out.grid, map, 0.5,
                 [&](std::size_t voxel, float value) { to[voxel] = value; });
    cine.images.phases[p] = Phase();
  });
  return out;
}

LabelCycle labels_in_workspace(const std::vector<ShapeCycle>& shapes) {
  LabelCycle out;
  out.grid = published_grid();
  if (shapes.empty()) return out;
  out.phases.assign(shapes.front().level.phases.size(),
                    std::vector<std::uint8_t>(out.grid.count(), kLabelBackground));
  // Later labels lie on earlier ones.
  static constexpr std::array kOrder{Structure::Heart,  Structure::LaBlood,      Structure::RaBlood,
                                     Structure::Aorta,  Structure::LvMyocardium, Structure::RvBlood,
                                     Structure::LvBlood};
  for (const Structure structure : kOrder) {
    const std::uint8_t label = label_of(structure);
    const auto shape = std::find_if(shapes.begin(), shapes.end(),
                                    [&](const ShapeCycle& s) { return s.structure == structure; });
    if (shape == shapes.end()) continue;
    const Grid& lattice = shape->level.grid;
    const AxisMap map = axis_map(lattice, out.grid, Affine::Identity());
    parallel_for(out.phases.size(), [&](std::size_t p) {
      std::vector<std::uint8_t>& labels = out.phases[p];
      read_on_grid(lattice, shape->level.phases[p], out.grid, map, 0,
                   [&](std::size_t voxel, float level) {
                     if (level < 0) labels[voxel] = label;
                   });
    });
  }
  return out;
}

}  // namespace beatlas::shape
