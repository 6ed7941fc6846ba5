/// Tables of what is made from images: segmentation of a phase, and the surface of a mask.
#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/cli/bench_probe.h"
#include "pipeline/field/field.h"
#include "pipeline/mesh/mesh.h"
#include "pipeline/segment/segment.h"
#include "pipeline/shape/workspace.h"
#include "tests/bench/alternatives.h"
#include "tests/learned.h"

namespace beatlas::bench {
namespace {

constexpr double kNoUpper = 1e6;
constexpr int kShell = 3;  // voxels around the heart whose signal is that of its surroundings

double middle_of(std::vector<float> values) {
  if (values.empty()) return 0;
  const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), half, values.end());
  return *half;
}

/// Median signal, in the first phase, of the voxels that `takes(i, j, k)`.
template <class Takes>
double signal_of(const Setting& setting, const Takes& takes) {
  const Grid& grid = setting.truth_labels.grid;
  std::vector<float> values;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (!takes(i, j, k)) continue;
        values.push_back(setting.exam.stack.images.phases[0][grid.offset(i, j, k)]);
      }
    }
  }
  return middle_of(std::move(values));
}

/// Windows half-way between the true levels: as good as a user can choose them.
struct Windows {
  double blood_from = 0;
  double heart_from = 0;
};

Windows windows_of(const Setting& setting) {
  const Grid& grid = setting.truth_labels.grid;
  const auto label = [&](int i, int j, int k) {
    return setting.truth_labels.phases[0][grid.offset(i, j, k)];
  };
  const auto in_shell = [&](int i, int j, int k) {
    if (label(i, j, k) != kLabelBackground) return false;
    for (int dj = -kShell; dj <= kShell; ++dj) {
      for (int di = -kShell; di <= kShell; ++di) {
        if (grid.contains(i + di, j + dj, k) && label(i + di, j + dj, k) != kLabelBackground) {
          return true;
        }
      }
    }
    return false;
  };
  const auto is = [&](Label wanted) {
    return signal_of(setting, [&](int i, int j, int k) { return label(i, j, k) == wanted; });
  };
  const double muscle = is(kLabelLvMyocardium);
  return {0.5 * (is(kLabelLvBlood) + muscle), 0.5 * (muscle + signal_of(setting, in_shell))};
}

/// The voxel of LV blood nearest its centroid: one click in a phase.
Index3 seed_of(const LabelCycle& labels, int phase) {
  const Grid& grid = labels.grid;
  const Mask mask = mask_of(labels, phase, Structure::LvBlood);
  const auto each = [&](const auto& look) {
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          if (mask[grid.offset(i, j, k)] != 0) look(Vec3(i, j, k));
        }
      }
    }
  };
  Vec3 sum = Vec3::Zero();
  double count = 0;
  each([&](const Vec3& index) {
    sum += index;
    count += 1;
  });
  const Vec3 centre = sum / count;
  Vec3 best = Vec3::Constant(std::numeric_limits<double>::infinity());
  each([&](const Vec3& index) {
    if ((index - centre).norm() < (best - centre).norm()) best = index;
  });
  return {static_cast<int>(best.x()), static_cast<int>(best.y()), static_cast<int>(best.z())};
}

double dice(const Mask& one, const Mask& other) {
  double both = 0;
  double sum = 0;
  for (std::size_t n = 0; n < one.size(); ++n) {
    both += one[n] & other[n];
    sum += one[n] + other[n];
  }
  return sum > 0 ? 2 * both / sum : 0;
}

/// |level| at points of the true surface, in frames: what a distance is off there.
double error_on_surface_mm(const Setting& setting, const Grid& grid, const Affine& grid_from_lps,
                           const std::vector<std::vector<float>>& levels) {
  const Affine index_from_lps = grid.mm_from_index.inverse() * grid_from_lps;
  double sum = 0;
  double count = 0;
  for (const assess::TruthPoint& point : setting.truth.surfaces.at(Structure::Heart)) {
    if (!point.in_frame) continue;
    const auto phase = static_cast<std::size_t>(std::lround(point.share * setting.phases()));
    const Vec3 index = index_from_lps * point.lps;
    const Vec3 whole = index.array().floor();
    double value = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      Index3 at{};
      for (int axis = 0; axis < 3; ++axis) {
        const int upper = corner >> axis & 1;
        const double u = index[axis] - whole[axis];
        weight *= upper == 1 ? u : 1 - u;
        at[static_cast<std::size_t>(axis)] = static_cast<int>(whole[axis]) + upper;
      }
      if (!grid.contains(at[0], at[1], at[2])) continue;
      value += weight * static_cast<double>(levels[phase][grid.offset(at[0], at[1], at[2])]);
    }
    sum += std::abs(value);
    count += 1;
  }
  return count > 0 ? sum / count : 0;
}

/// Mean and least of Dice over the phases.
struct Agreement {
  double mean = 0;
  double least = 1;
};

template <class MakeMask>
Agreement agreement(const Setting& setting, Structure structure, const MakeMask& make) {
  Agreement out;
  for (int p = 0; p < setting.phases(); ++p) {
    const double value = dice(make(p), mask_of(setting.truth_labels, p, structure));
    out.mean += value / setting.phases();
    out.least = std::min(out.least, value);
  }
  return out;
}

using Surfaces = std::vector<std::vector<Vec3>>;  // [phase][vertex], LPS

DistanceErrors errors_of(const Setting& setting, const Surfaces& surfaces) {
  std::vector<double> all;
  for (int p = 0; p < setting.phases(); ++p) {
    const std::vector<double> found =
        distances_to_truth(setting, p, surfaces[static_cast<std::size_t>(p)]);
    all.insert(all.end(), found.begin(), found.end());
  }
  return summed_errors(std::move(all));
}

std::vector<Vec3> in_lps(const Setting& setting, const std::vector<Vec3>& workspace) {
  const Affine lps_from_workspace = setting.workspace_from_lps.inverse(Eigen::Isometry);
  std::vector<Vec3> out;
  out.reserve(workspace.size());
  for (const Vec3& x : workspace) out.push_back(lps_from_workspace * x);
  return out;
}

Surfaces our_surfaces(const Setting& setting, const FieldCycle& cycle) {
  Surfaces out;
  for (int p = 0; p < setting.phases(); ++p) {
    out.push_back(in_lps(setting, field::extract_surface(cycle, p).points));
  }
  return out;
}

Surfaces our_meshes(const Setting& setting, const FieldCycle& cycle) {
  StageContext quiet;
  Surfaces out;
  for (const std::vector<Vec3f>& positions : mesh::mesh_cycle(cycle, {}, quiet).positions) {
    std::vector<Vec3> points;
    for (const Vec3f& x : positions) points.push_back(x.cast<double>());
    out.push_back(in_lps(setting, points));
  }
  return out;
}

}  // namespace

Table segmentation_table(const Setting& setting) {
  using Grow = Mask (*)(const Grid&, const std::vector<float>&, const Growing&);
  struct Method {
    std::string name;
    Grow grow;
  };
  const std::vector<Method> methods{
      {"ITK ConnectedThreshold", itk_connected_threshold},
      {"ITK ConfidenceConnected", itk_confidence_connected},
      {"ITK NeighborhoodConnected, radius 1", itk_neighborhood_connected},
      {"VTK ImageThresholdConnectivity", vtk_threshold_connectivity},
      {"VTK ImageConnectivityFilter", vtk_connectivity}};
  const Grid& grid = setting.exam.stack.grid();
  const auto& images = setting.exam.stack.images.phases;
  const Windows windows = windows_of(setting);
  std::vector<Index3> seeds;
  for (int p = 0; p < setting.phases(); ++p) seeds.push_back(seed_of(setting.truth_labels, p));
  const auto grown = [&](const Method& method, int phase, Structure structure) {
    const auto p = static_cast<std::size_t>(phase);
    const double from = structure == Structure::LvBlood ? windows.blood_from : windows.heart_from;
    return method.grow(grid, images[p], {seeds[p], from, kNoUpper});
  };

  std::vector<std::function<std::vector<double>()>> candidates;
  candidates.emplace_back([&]() -> std::vector<double> {
    StageContext quiet;
    return {clocked_ms([&] {
              const prior::PriorCycle prior = test::learned(setting.exam);
              (void)segment::segment_exam(setting.exam, {}, {}, quiet, {}, &prior);
            }) /
            setting.phases()};
  });
  for (const Method& method : methods) {
    candidates.emplace_back([&]() -> std::vector<double> {
      return {clocked_ms([&] {
                for (int p = 0; p < setting.phases(); ++p) {
                  (void)grown(method, p, Structure::LvBlood);
                  (void)grown(method, p, Structure::Heart);
                }
              }) /
              setting.phases()};
    });
  }
  const auto medians = interleaved(setting.repeats, candidates);
  const auto memory_mb = [](const std::function<void()>& work) {
    const cli::MemoryMeter meter;
    work();
    return meter.added_mb();
  };

  Table out;
  out.key = "segmentation";
  out.title = "Segmentation of one phase";
  out.note =
      "Growing: two runs a phase (LV blood, heart) from one seed in that phase, in the best window "
      "that the truth allows. Ours: no seed; four labels and their coverage, all phases at once, "
      "on "
      "all cores. Memory: resident beyond the images, result included.";
  out.columns = {{"ms_a_phase", "ms a phase", 1},
                 {"memory_mb", "memory MB", 1},
                 {"dice_lv_blood", "Dice LV blood", 3, false},
                 {"dice_lv_blood_min", "its least", 3, false},
                 {"dice_heart", "Dice heart", 3, false},
                 {"dice_heart_min", "its least", 3, false}};
  const auto add = [&](const std::string& name, double ms, std::optional<double> mb,
                       const Agreement& blood, const Agreement& heart) {
    out.rows.push_back({name, {ms, mb, blood.mean, blood.least, heart.mean, heart.least}});
  };
  const auto ours = [&](Structure structure) {
    return agreement(setting, structure,
                     [&](int p) { return mask_of(setting.found.labels, p, structure); });
  };
  const auto our_mb = memory_mb([&] {
    StageContext quiet;
    const prior::PriorCycle prior = test::learned(setting.exam);
    (void)segment::segment_exam(setting.exam, {}, {}, quiet, {}, &prior);
  });
  add("beatlas segment", medians[0][0], our_mb, ours(Structure::LvBlood), ours(Structure::Heart));
  for (std::size_t n = 0; n < methods.size(); ++n) {
    const auto theirs = [&](Structure structure) {
      return agreement(setting, structure, [&](int p) { return grown(methods[n], p, structure); });
    };
    const auto mb = memory_mb([&] { (void)grown(methods[n], 0, Structure::Heart); });
    add(methods[n].name, medians[n + 1][0], mb, theirs(Structure::LvBlood),
        theirs(Structure::Heart));
  }
  return out;
}

Table surface_table(const Setting& setting) {
  using Contour = std::function<field::TriangleSoup(const Grid&, const std::vector<float>&)>;
  using Distance = std::function<std::vector<float>(const Grid&, const Mask&)>;
  struct Method {
    std::string name;
    Distance distance;  // none: the mask itself is contoured
    Contour contour;
    bool smooth = false;
  };
  const std::vector<Method> methods{
      {"ITK SignedMaurer, VTK FlyingEdges3D", itk_signed_maurer, vtk_flying_edges},
      {"the same, Maurer symmetrised", itk_symmetric_maurer, vtk_flying_edges},
      {"symmetrised, VTK MarchingCubes", itk_symmetric_maurer, vtk_marching_cubes},
      {"VTK DiscreteFlyingEdges3D of the mask", {}, {}, false},
      {"the same + windowed sinc .01 x 40", {}, {}, true}};
  const Grid& grid = setting.found.labels.grid;

  struct Made {
    field::TriangleSoup surface;
    double distance_ms = 0;
    double surface_ms = 0;
  };
  const auto make = [&](const Method& method, const Mask& mask) {
    Made made;
    std::vector<float> level;
    if (method.distance) {
      made.distance_ms = clocked_ms([&] { level = method.distance(grid, mask); });
      made.surface_ms = clocked_ms([&] { made.surface = method.contour(grid, level); });
    } else {
      made.surface_ms =
          clocked_ms([&] { made.surface = vtk_discrete_surface(grid, mask, method.smooth); });
    }
    return made;
  };
  std::vector<Mask> found;
  std::vector<Mask> truth;
  for (int p = 0; p < setting.phases(); ++p) {
    found.push_back(mask_of(setting.found.labels, p, Structure::Heart));
    truth.push_back(mask_of(setting.truth_labels, p, Structure::Heart));
  }
  Segmentation heart_alone = setting.found;
  std::erase_if(heart_alone.coverage.phases,
                [](const auto& each) { return each.first != Structure::Heart; });

  std::vector<std::function<std::vector<double>()>> candidates;
  const auto ours = [&](bool meshed) -> std::vector<double> {
    StageContext quiet;
    FieldCycle cycle;
    const double distance_ms = clocked_ms([&] {
      const auto shapes =
          shape::shapes_in_workspace(heart_alone, setting.workspace_from_lps, {}, quiet);
      cycle = field::build_field(shapes.front(), {}, quiet);
    });
    const double surface_ms = clocked_ms(
        [&] { (void)(meshed ? our_meshes(setting, cycle) : our_surfaces(setting, cycle)); });
    return {distance_ms / setting.phases(), surface_ms / setting.phases()};
  };
  candidates.emplace_back([&] { return ours(false); });
  candidates.emplace_back([&] { return ours(true); });
  for (const Method& method : methods) {
    candidates.emplace_back([&]() -> std::vector<double> {
      std::vector<double> sum(2, 0.0);
      for (const Mask& mask : found) {
        const Made made = make(method, mask);
        sum[0] += made.distance_ms / setting.phases();
        sum[1] += made.surface_ms / setting.phases();
      }
      return sum;
    });
  }
  const auto medians = interleaved(setting.repeats, candidates);

  Table out;
  out.key = "surface";
  out.title = "Mask to distance to surface, of the heart";
  out.note =
      "Error of vertices against closed form, creases' 2 mm left out. From images: of the labels "
      "(ours: coverage) that beatlas found. From truth: of the true labels (ours: the exact "
      "shape). A mask gives a distance on the image's lattice, ours on 1.5 mm cubes; the last "
      "column "
      "is what the distance from truth, trilinear, says where it should say 0.";
  out.columns = {{"distance_ms_a_phase", "distance, ms a phase", 1},
                 {"surface_ms_a_phase", "surface, ms a phase", 1},
                 {"total_ms_a_phase", "both, ms a phase", 1},
                 {"images_mean_mm", "from images, mean mm", 3},
                 {"images_p95_mm", "p95 mm", 3},
                 {"images_bias_mm", "bias mm", 3, false},
                 {"truth_mean_mm", "from truth, mean mm", 3},
                 {"truth_p95_mm", "p95 mm", 3},
                 {"truth_bias_mm", "bias mm", 3, false},
                 {"truth_on_surface_mm", "distance on the true surface, mean mm", 3}};
  const auto add = [&](const std::string& name, std::size_t at, std::optional<double> on_surface_mm,
                       const Surfaces& of_images, const Surfaces& of_truth) {
    const std::vector<double>& ms = medians[at];
    const DistanceErrors images = errors_of(setting, of_images);
    const DistanceErrors exact = errors_of(setting, of_truth);
    out.rows.push_back({name,
                        {on_surface_mm ? std::optional(ms[0]) : std::nullopt, ms[1], ms[0] + ms[1],
                         images.mean_mm, images.p95_mm, images.bias_mm, exact.mean_mm, exact.p95_mm,
                         exact.bias_mm, on_surface_mm}});
  };
  const FieldCycle& exact_field = setting.exact_field;
  const double ours_on_surface_mm =
      error_on_surface_mm(setting, exact_field.distance_mm.grid, setting.workspace_from_lps,
                          exact_field.distance_mm.phases);
  add("beatlas field, its surface", 0, ours_on_surface_mm, our_surfaces(setting, setting.field),
      our_surfaces(setting, setting.exact_field));
  add("beatlas field, remeshed, one connectivity", 1, ours_on_surface_mm,
      our_meshes(setting, setting.field), our_meshes(setting, setting.exact_field));
  for (std::size_t n = 0; n < methods.size(); ++n) {
    const auto all = [&](const std::vector<Mask>& masks) {
      Surfaces surfaces;
      for (const Mask& mask : masks) surfaces.push_back(make(methods[n], mask).surface.points);
      return surfaces;
    };
    std::optional<double> on_surface_mm;
    if (methods[n].distance) {
      std::vector<std::vector<float>> levels;
      for (const Mask& mask : truth) levels.push_back(methods[n].distance(grid, mask));
      on_surface_mm = error_on_surface_mm(setting, grid, Affine::Identity(), levels);
    }
    add(methods[n].name, n + 2, on_surface_mm, all(found), all(truth));
  }
  return out;
}

}  // namespace beatlas::bench
