#include "pipeline/segment/atria.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <optional>

#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/segment/distance_map.h"
#include "pipeline/segment/valves.h"

namespace beatlas::segment {
namespace {

constexpr double kFilmMm = 3;       ///< what is nowhere so deep is the half blood of a blurred wall
constexpr double kPoolMm = 8;       ///< shallower pools are bays of their neighbour
constexpr double kNeckShare = 0.6;  ///< of the smaller pool's depth: a wider neck parts nothing
constexpr double kLeastMl = 3;      ///< in any phase
constexpr double kFarMm = 35;       ///< from where a chamber is looked for it is no longer that one

/// A pool's middle beside the LV's axis, on its base plane: x towards the RV, y to the front and up
/// across it [mm], in a heart whose LV is kLvLengthMm long.
struct Site {
  std::optional<Structure> structure;  ///< none: rest of heart
  double x_mm = 0;
  double y_mm = 0;
};
constexpr std::array kSites{Site{Structure::LaBlood, -3, -15}, Site{Structure::RaBlood, 43, -5},
                            Site{Structure::Aorta, 8, 20},
                            Site{std::nullopt, 22, 40}};  // the pulmonary trunk

/// Voxels of all phases that may be of a pool, as nodes of a graph.
struct Nodes {
  std::vector<std::uint32_t> voxel;
  std::vector<std::uint16_t> phase;
  std::vector<float> depth_mm;
  std::vector<std::vector<std::int32_t>> at;  ///< [phase][voxel]; -1: none

  [[nodiscard]] std::size_t size() const { return voxel.size(); }
};

/// How deep each voxel lies in what is as bright as blood beyond the ventricles, films taken off; 0
/// outside.
std::vector<float> pool_depth(const Grid& grid, const std::vector<float>& image,
                              const std::vector<std::uint8_t>& labels, const TissueLevels& levels) {
  std::vector<std::uint8_t> bright(labels.size());
  for (std::size_t v = 0; v < labels.size(); ++v) {
    bright[v] =
        labels[v] == kLabelRestOfHeart && image[v] > levels.threshold && image[v] < levels.fat;
  }
  std::vector<float> depth = depth_within(grid, bright, true);
  std::vector<std::uint8_t> core(labels.size());
  for (std::size_t v = 0; v < labels.size(); ++v) core[v] = depth[v] >= kFilmMm;
  const std::vector<float> off = distance_near(grid, core, true, kFilmMm);
  for (std::size_t v = 0; v < labels.size(); ++v) {
    if (off[v] > kFilmMm) depth[v] = 0;
  }
  return depth;
}

Nodes nodes_of(const ImageCycle<float>& images, const TissueLevels& levels,
               const ImageCycle<std::uint8_t>& labels) {
  const auto n = static_cast<std::size_t>(images.phase_count());
  std::vector<std::vector<float>> depth(n);
  parallel_for(n, [&](std::size_t p) {
    depth[p] = pool_depth(images.grid, images.phases[p], labels.phases[p], levels);
  });
  Nodes nodes;
  std::vector<std::size_t> first(n + 1, 0);
  for (std::size_t p = 0; p < n; ++p) {
    const auto deep =
        std::count_if(depth[p].begin(), depth[p].end(), [](float d) { return d > 0; });
    first[p + 1] = first[p] + static_cast<std::size_t>(deep);
  }
  nodes.at.resize(n);
  nodes.voxel.resize(first[n]);
  nodes.phase.resize(first[n]);
  nodes.depth_mm.resize(first[n]);
  parallel_for(n, [&](std::size_t p) {
    nodes.at[p].assign(images.grid.count(), -1);
    std::size_t node = first[p];
    for (std::size_t v = 0; v < depth[p].size(); ++v) {
      if (depth[p][v] <= 0) continue;
      nodes.at[p][v] = static_cast<std::int32_t>(node);
      nodes.voxel[node] = static_cast<std::uint32_t>(v);
      nodes.phase[node] = static_cast<std::uint16_t>(p);
      nodes.depth_mm[node] = depth[p][v];
      ++node;
    }
    depth[p] = {};
  });
  return nodes;
}

/// Up to eight nodes beside one: along the axes, and the same voxel a phase before and after.
class Beside {
 public:
  Beside(const Grid& grid, const Nodes& nodes) : grid_(grid), nodes_(nodes) {}

  template <class Do>
  void each(std::size_t node, Do&& act) const {
    const std::size_t v = nodes_.voxel[node];
    const std::size_t p = nodes_.phase[node];
    const std::size_t phases = nodes_.at.size();
    const auto visit = [&](std::size_t phase, std::size_t voxel) {
      const std::int32_t there = nodes_.at[phase][voxel];
      if (there >= 0) act(static_cast<std::size_t>(there));
    };
    std::size_t step = 1;
    std::size_t rest = v;
    for (const int size : grid_.size) {
      const auto length = static_cast<std::size_t>(size);
      const std::size_t index = rest % length;
      if (index > 0) visit(p, v - step);
      if (index + 1 < length) visit(p, v + step);
      step *= length;
      rest /= length;
    }
    visit((p + phases - 1) % phases, v);
    visit((p + 1) % phases, v);
  }

 private:
  const Grid& grid_;
  const Nodes& nodes_;
};

/// The pool of every node, named by the node that lies deepest in it. From the deepest node down:
/// one that has no neighbour yet begins a pool, one between two pools is of the deeper neighbour's.
std::vector<std::uint32_t> pools_of(const Grid& grid, const Nodes& nodes) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  // Bits of positive floats are ordered as they are.
  std::vector<std::uint64_t> order(nodes.size());
  for (std::size_t node = 0; node < order.size(); ++node) {
    const auto depth = std::bit_cast<std::uint32_t>(nodes.depth_mm[node]);
    order[node] = static_cast<std::uint64_t>(~depth) << 32U | node;
  }
  std::sort(order.begin(), order.end());
  std::vector<std::uint32_t> parent(nodes.size(), kNone);
  const auto root = [&](std::uint32_t node) {
    while (parent[node] != node) node = parent[node] = parent[parent[node]];
    return node;
  };
  const Beside beside(grid, nodes);
  for (const std::uint64_t entry : order) {
    const auto node = static_cast<std::uint32_t>(entry);
    const float depth = nodes.depth_mm[node];
    std::uint32_t deepest = kNone;
    beside.each(node, [&](std::size_t there) {
      if (parent[there] == kNone) return;
      if (deepest == kNone || nodes.depth_mm[there] > nodes.depth_mm[deepest]) {
        deepest = static_cast<std::uint32_t>(there);
      }
    });
    parent[node] = deepest == kNone ? node : root(deepest);
    beside.each(node, [&](std::size_t there) {
      if (parent[there] == kNone) return;
      std::uint32_t a = root(node);
      std::uint32_t b = root(static_cast<std::uint32_t>(there));
      if (a == b) return;
      if (nodes.depth_mm[a] < nodes.depth_mm[b]) std::swap(a, b);
      const double smaller = nodes.depth_mm[b];
      if (smaller < kPoolMm || depth >= kNeckShare * smaller) parent[b] = a;
    });
  }
  for (std::uint32_t node = 0; node < parent.size(); ++node) parent[node] = root(node);
  return parent;
}

struct Pool {
  std::uint32_t root = 0;
  std::size_t voxels = 0;
  Vec3 sum_mm = Vec3::Zero();  ///< of places, each by its depth
  double depth_sum = 0;
  std::vector<std::size_t> by_phase;
};

std::vector<Pool> measured(const Grid& grid, const Nodes& nodes,
                           const std::vector<std::uint32_t>& root_of) {
  std::vector<Pool> pools;
  std::vector<std::int32_t> index(nodes.size(), -1);
  for (std::size_t node = 0; node < nodes.size(); ++node) {
    std::int32_t& at = index[root_of[node]];
    if (at < 0) {
      at = static_cast<std::int32_t>(pools.size());
      pools.push_back(
          {root_of[node], 0, Vec3::Zero(), 0, std::vector<std::size_t>(nodes.at.size(), 0)});
    }
    Pool& pool = pools[static_cast<std::size_t>(at)];
    const std::size_t v = nodes.voxel[node];
    const auto width = static_cast<std::size_t>(grid.size[0]);
    const std::size_t i = v % width;
    const std::size_t j = v / width % static_cast<std::size_t>(grid.size[1]);
    const std::size_t k = v / grid.slice_count();
    const Vec3 place =
        grid.mm(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
    ++pool.voxels;
    ++pool.by_phase[nodes.phase[node]];
    pool.depth_sum += nodes.depth_mm[node];
    pool.sum_mm += nodes.depth_mm[node] * place;
  }
  return pools;
}

std::optional<Vec3> middle_of(const Grid& grid, const std::vector<std::uint8_t>& labels,
                              std::uint8_t label) {
  Vec3 sum = Vec3::Zero();
  std::size_t count = 0;
  std::size_t v = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++v) {
        if (labels[v] != label) continue;
        sum += Vec3(i, j, k);
        ++count;
      }
    }
  }
  if (count == 0) return std::nullopt;
  return grid.mm_from_index * Vec3(sum / static_cast<double>(count));
}

/// Where a pool's middle lies beside the axis, see Site.
class Compass {
 public:
  Compass(const LongAxis& axis, const Vec3& lv, const Vec3& rv, int end_diastole)
      : lv_(lv), z_(axis.towards_base) {
    const auto ed = static_cast<std::size_t>(end_diastole);
    scale_ = kLvLengthMm / (axis.lv_base_mm[ed] - axis.apex_mm[ed]);
    const Vec3 towards_rv = rv - lv;
    x_ = (towards_rv - z_.dot(towards_rv) * z_).normalized();
    y_ = z_.cross(x_);
  }
  [[nodiscard]] double from_site_mm(const Vec3& lps, const Site& site) const {
    const Vec3 offset = scale_ * (lps - lv_);
    return std::hypot(x_.dot(offset) - site.x_mm, y_.dot(offset) - site.y_mm);
  }

 private:
  Vec3 lv_;
  Vec3 z_;
  Vec3 x_ = Vec3::UnitX();
  Vec3 y_ = Vec3::UnitY();
  double scale_ = 1;
};

}  // namespace

std::vector<Structure> part_atria(const ImageCycle<float>& images, const TissueLevels& levels,
                                  const LongAxis& axis, int end_diastole,
                                  ImageCycle<std::uint8_t>& labels) {
  const Grid& grid = images.grid;
  if (grid.spacing_mm()[2] >= kThickSlicesMm) return {};
  const auto& at_ed = labels.phases[static_cast<std::size_t>(end_diastole)];
  const std::optional<Vec3> lv = middle_of(grid, at_ed, kLabelLvBlood);
  const std::optional<Vec3> rv = middle_of(grid, at_ed, kLabelRvBlood);
  if (!lv || !rv) return {};
  const Compass compass(axis, *lv, *rv, end_diastole);

  const Nodes nodes = nodes_of(images, levels, labels);
  const std::vector<std::uint32_t> root_of = pools_of(grid, nodes);
  std::array<const Pool*, kSites.size()> chosen{};
  const std::vector<Pool> pools = measured(grid, nodes, root_of);
  for (const Pool& pool : pools) {
    const std::size_t least = *std::min_element(pool.by_phase.begin(), pool.by_phase.end());
    if (static_cast<double>(least) * grid.voxel_ml() < kLeastMl) continue;
    const Vec3 middle = pool.sum_mm / pool.depth_sum;
    std::size_t nearest = 0;
    for (std::size_t s = 1; s < kSites.size(); ++s) {
      if (compass.from_site_mm(middle, kSites[s]) < compass.from_site_mm(middle, kSites[nearest])) {
        nearest = s;
      }
    }
    if (compass.from_site_mm(middle, kSites[nearest]) > kFarMm) continue;
    if (chosen[nearest] == nullptr || chosen[nearest]->voxels < pool.voxels) {
      chosen[nearest] = &pool;
    }
  }

  std::vector<std::uint8_t> label_of_root(nodes.size(), kLabelRestOfHeart);
  std::vector<Structure> found;
  for (std::size_t s = 0; s < kSites.size(); ++s) {
    if (chosen[s] == nullptr || !kSites[s].structure) continue;
    found.push_back(*kSites[s].structure);
    label_of_root[chosen[s]->root] = label_of(*kSites[s].structure);
  }
  for (std::size_t node = 0; node < nodes.size(); ++node) {
    labels.phases[nodes.phase[node]][nodes.voxel[node]] = label_of_root[root_of[node]];
  }
  return found;
}

}  // namespace beatlas::segment
