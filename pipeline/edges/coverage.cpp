#include "pipeline/edges/coverage.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>

#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/core/structure_mask.h"
#include "pipeline/edges/along_slices.h"
#include "pipeline/edges/boundary.h"

namespace beatlas::edges {
namespace {

constexpr double kMuscleShare = 0.5;  ///< of the way from muscle to the threshold to blood

constexpr int kBesidePx = 4;  ///< from beside an edge to what it bounds

constexpr double kSeamMm = 4;  ///< from the RV's wall, where labels of both are mixed

/// Whether the LV's wall is among the voxels around one in its slice and right above and below it.
bool beside_lv_wall(const Grid& grid, const std::vector<std::uint8_t>& labels, int i, int j,
                    int k) {
  const auto is_wall = [&](int a, int b, int c) {
    return labels[grid.offset(a, b, c)] == kLabelLvMyocardium;
  };
  if (k > 0 && is_wall(i, j, k - 1)) return true;
  if (k + 1 < grid.size[2] && is_wall(i, j, k + 1)) return true;
  for (int b = std::max(0, j - 1); b <= std::min(grid.size[1] - 1, j + 1); ++b) {
    for (int a = std::max(0, i - 1); a <= std::min(grid.size[0] - 1, i + 1); ++a) {
      if (is_wall(a, b, k)) return true;
    }
  }
  return false;
}

/// The wall is what lies between the cavity and its own outside, of which each has its edge. Where
/// the cavity ends at its valve there is no wall, and both edges are one.
/// @param outside coverage of cavity and wall together; becomes that of the wall
void take_cavity_out(const Grid& grid, const std::vector<std::uint8_t>& labels,
                     const std::vector<float>& blood, std::vector<float>& outside) {
  for_each_voxel(grid, [&](int i, int j, int k, std::size_t v) {
    if (!(outside[v] > 0)) return;
    outside[v] = beside_lv_wall(grid, labels, i, j, k) ? std::max(0.0F, outside[v] - blood[v]) : 0;
  });
}

/// The first voxel of the mask in ever wider squares around a voxel of its slice.
std::optional<std::uint32_t> nearest_inside(const Grid& grid,
                                            const std::vector<std::uint8_t>& inside,
                                            std::uint32_t voxel) {
  const auto nx = static_cast<std::size_t>(grid.size[0]);
  const auto i = static_cast<int>(voxel % nx);
  const auto j = static_cast<int>(voxel % grid.slice_count() / nx);
  const auto k = static_cast<int>(voxel / grid.slice_count());
  for (int reach = 0; reach <= kBesidePx; ++reach) {
    for (int b = std::max(0, j - reach); b <= std::min(grid.size[1] - 1, j + reach); ++b) {
      for (int a = std::max(0, i - reach); a <= std::min(grid.size[0] - 1, i + reach); ++a) {
        if (std::max(std::abs(a - i), std::abs(b - j)) != reach) continue;
        const std::size_t v = grid.offset(a, b, k);
        if (inside[v] != 0) return static_cast<std::uint32_t>(v);
      }
    }
  }
  return {};
}

/// Coverage and uncertainty of voxels beside an edge that is known.
void put_edges(const std::vector<FatEdge>& edges, Boundary& boundary) {
  std::vector<BoundaryPoint> points;
  for (const FatEdge& edge : edges) {
    boundary.coverage[edge.voxel] = edge.coverage;
    if (edge.coverage > 0 && edge.coverage < 1) points.push_back({edge.voxel, edge.sigma_mm});
  }
  const auto before = [](const BoundaryPoint& a, const BoundaryPoint& b) {
    return a.voxel < b.voxel;
  };
  std::vector<BoundaryPoint> all;
  std::set_union(points.begin(), points.end(), boundary.points.begin(), boundary.points.end(),
                 std::back_inserter(all), before);
  boundary.points = std::move(all);
}

/// 1 in the LV's wall and, where there is one, in its cavity.
std::vector<std::uint8_t> filled_wall(const std::vector<std::uint8_t>& labels) {
  std::vector<std::uint8_t> out = where(labels, Structure::LvMyocardium);
  if (std::find(out.begin(), out.end(), 1) == out.end()) return out;
  for (std::size_t v = 0; v < out.size(); ++v) {
    if (labels[v] == kLabelLvBlood) out[v] = 1;
  }
  return out;
}

/// Whether a voxel is of the LV's wall, and off the seam where the RV's wall leaves it.
bool in_lv(const Grid& grid, const std::vector<std::uint8_t>& labels, std::size_t voxel) {
  return labels[voxel] == kLabelLvMyocardium && !beside_others(grid, labels, voxel);
}

/// The wall's inner boundary is the cavity's, its uncertainty too.
std::vector<BoundaryPoint> points_of_wall(const std::vector<BoundaryPoint>& outer,
                                          const std::vector<BoundaryPoint>& inner,
                                          const std::vector<float>& myocardium) {
  std::vector<BoundaryPoint> out;
  const auto before = [](const BoundaryPoint& a, const BoundaryPoint& b) {
    return a.voxel < b.voxel;
  };
  // Of two points of one voxel the first range's is taken.
  std::set_union(inner.begin(), inner.end(), outer.begin(), outer.end(), std::back_inserter(out),
                 before);
  std::erase_if(out, [&](const BoundaryPoint& point) {
    return !(myocardium[point.voxel] > 0 && myocardium[point.voxel] < 1);
  });
  return out;
}

/// What the edges of all structures are looked for in.
struct EdgeSearch {
  const ImageCycle<float>& images;
  const ImageCycle<std::uint8_t>& labels;
  const tissue::TissueLevels& levels;
  double noise = 0;     ///< [intensity], as the next two
  double muscle = 0;    ///< below it a voxel is muscle and nothing else
  double contrast = 0;  ///< between both sides, less than which is no edge

  [[nodiscard]] bool thin() const { return !are_thick_slices(images.grid.spacing_mm()[2]); }
};

bool is_ventricle(Structure structure) {
  return structure == Structure::LvBlood || structure == Structure::RvBlood;
}

/// Voxels of a phase by what they tell of a structure's boundary, 1 where they do.
struct EdgeVoxels {
  std::vector<std::uint8_t> inside;  ///< of it
  std::vector<std::uint8_t> inner;   ///< tell what its inside looks like
  std::vector<std::uint8_t> outer;   ///< tell what lies beyond
  std::vector<std::uint8_t> bare;    ///< of the heart's outside: blood
  std::vector<std::uint8_t> walls;   ///< of a cavity: the heart
};

EdgeVoxels edge_voxels(const EdgeSearch& search, Structure structure, std::size_t p) {
  const std::vector<std::uint8_t>& labels = search.labels.phases[p];
  EdgeVoxels out;
  out.inside = where(labels, structure);
  out.inner = out.inside;
  out.outer.assign(out.inside.size(), 1);
  if (structure == Structure::Heart && search.levels.muscle > 0) {
    // Under the outer surface lies muscle; blood behind a thin wall must not tell its level.
    for (std::size_t v = 0; v < out.inner.size(); ++v) {
      out.inner[v] =
          static_cast<std::uint8_t>(out.inside[v] && search.images.phases[p][v] < search.muscle);
    }
    out.bare.resize(out.inside.size());
    std::transform(labels.begin(), labels.end(), out.bare.begin(), [](std::uint8_t label) {
      return static_cast<std::uint8_t>(label == kLabelLvBlood || label == kLabelRvBlood);
    });
  } else if (structure == Structure::LvMyocardium) {
    // Of the wall its outside alone: what is averaged along one edge of a thin wall must not take
    // in what is seen at the other.
    out.inside = filled_wall(labels);
  } else {
    // Beside a cavity lies its wall; lung or fat beyond a thin one must not tell its level.
    out.walls = where(labels, Structure::Heart);
    out.outer = out.walls;
  }
  return out;
}

/// Coverage where surfaces run along thin slices. What tells of a cavity's edge is narrowed down in
/// `voxels`, which `input` looks at. @return voxels of the heart's surface that it settled
std::vector<Settled> cover_along(const EdgeSearch& search, Structure structure, std::size_t p,
                                 const BoundaryInput& input, EdgeVoxels& voxels,
                                 std::vector<float>& coverage) {
  const tissue::TissueLevels& levels = search.levels;
  if (structure == Structure::Heart) {
    return cover_along_slices(input, {.inner_level = levels.muscle}, coverage);
  }
  if (!is_ventricle(structure)) return {};
  // The other ventricle's blood, which this looks as far as, must not tell the wall's level, nor
  // papillary muscles, taken in on purpose, the blood's.
  for (std::size_t v = 0; v < voxels.outer.size(); ++v) {
    const float pixel = search.images.phases[p][v];
    voxels.outer[v] = static_cast<std::uint8_t>(voxels.outer[v] && pixel < search.muscle);
    voxels.inner[v] = static_cast<std::uint8_t>(voxels.inner[v] && pixel >= levels.threshold);
  }
  (void)cover_along_slices(
      input,
      {.inner_level = structure == Structure::LvBlood ? levels.blood : levels.rv_blood,
       .outer_level = levels.muscle,
       .walls = &voxels.walls},
      coverage);
  return {};
}

/// @param under_fat null: nothing is known of it  @param settled voxels of the heart's surface are
/// added to it
Boundary cover_phase(const EdgeSearch& search, Structure structure, std::size_t p,
                     const std::vector<FatEdge>* under_fat, std::vector<Settled>& settled) {
  EdgeVoxels voxels = edge_voxels(search, structure, p);
  const BoundaryInput input{.grid = search.images.grid,
                            .image = search.images.phases[p],
                            .inside = voxels.inside,
                            .tells_inner = voxels.inner,
                            .tells_outer = voxels.outer,
                            .bare = voxels.bare.empty() ? nullptr : &voxels.bare,
                            .trabeculated = is_ventricle(structure),
                            .rimmed = structure == Structure::LvMyocardium && !search.thin(),
                            .contrast = search.contrast,
                            .noise = search.noise};
  Boundary found = find_boundary(input);
  if (search.thin() && search.levels.muscle > 0) {
    const std::vector<Settled> along =
        cover_along(search, structure, p, input, voxels, found.coverage);
    settled.insert(settled.end(), along.begin(), along.end());
  }
  if (structure == Structure::Heart && under_fat != nullptr) {
    put_edges(*under_fat, found);
    for (const FatEdge& edge : *under_fat) {
      const auto within = edge.within != FatEdge::kNowhere
                              ? std::optional(edge.within)
                              : nearest_inside(search.images.grid, voxels.inside, edge.voxel);
      if (within) settled.push_back({edge.voxel, *within});
    }
  }
  // What intensities along slices settled may be whole or empty now.
  std::erase_if(found.points, [&](const BoundaryPoint& point) {
    const float share = found.coverage[point.voxel];
    return !(share > 0 && share < 1);
  });
  return found;
}

/// The LV's wall ends where its cavity begins and, where the heart's surface is settled, with that.
void fit_wall(const EdgeSearch& search, const std::vector<std::vector<Settled>>& settled,
              Covered& made) {
  auto& by_structure = made.coverage.phases;
  const auto myocardium = by_structure.find(Structure::LvMyocardium);
  const auto blood = by_structure.find(Structure::LvBlood);
  const auto heart = by_structure.find(Structure::Heart);
  if (myocardium == by_structure.end()) return;
  const Grid& grid = search.images.grid;
  if (heart != by_structure.end()) {
    parallel_for(settled.size(), [&](std::size_t p) {
      for (const Settled& at : settled[p]) {
        if (!in_lv(grid, search.labels.phases[p], at.within)) continue;
        myocardium->second[p][at.voxel] = heart->second[p][at.voxel];
      }
    });
  }
  if (blood == by_structure.end()) return;
  std::vector<std::vector<BoundaryPoint>>& walls = made.uncertainty[Structure::LvMyocardium];
  const std::vector<std::vector<BoundaryPoint>>& pools = made.uncertainty[Structure::LvBlood];
  parallel_for(settled.size(), [&](std::size_t p) {
    take_cavity_out(grid, search.labels.phases[p], blood->second[p], myocardium->second[p]);
    walls[p] = points_of_wall(walls[p], pools[p], myocardium->second[p]);
  });
}

}  // namespace

bool beside_others(const Grid& grid, const std::vector<std::uint8_t>& labels, std::size_t voxel) {
  const Index3 at = index_of(grid, voxel);
  const Vec3 spacing = grid.spacing_mm();
  const int across = static_cast<int>(std::lround(kSeamMm / spacing[0]));
  const int along = static_cast<int>(std::lround(kSeamMm / spacing[1]));
  const int through = static_cast<int>(kSeamMm / spacing[2]);
  for (int k = std::max(0, at[2] - through); k <= std::min(grid.size[2] - 1, at[2] + through);
       ++k) {
    for (int j = std::max(0, at[1] - along); j <= std::min(grid.size[1] - 1, at[1] + along); ++j) {
      for (int i = std::max(0, at[0] - across); i <= std::min(grid.size[0] - 1, at[0] + across);
           ++i) {
        const std::uint8_t label = labels[grid.offset(i, j, k)];
        if (label == kLabelRvBlood || label == kLabelRestOfHeart) return true;
      }
    }
  }
  return false;
}

Covered cover(const ImageCycle<float>& images, const ImageCycle<std::uint8_t>& labels,
              const Box& box, const tissue::TissueLevels& levels, double noise,
              const std::vector<std::vector<FatEdge>>& under_fat,
              const std::vector<Structure>& structures) {
  const EdgeSearch search{
      .images = images,
      .labels = labels,
      .levels = levels,
      .noise = noise,
      // Under a thin wall most voxels are half blood.
      .muscle = std::min(
          levels.threshold,
          levels.muscle + std::max(2 * noise, kMuscleShare * (levels.threshold - levels.muscle))),
      .contrast = std::max(2.5 * noise, 0.08 * (levels.blood - levels.muscle))};
  Covered made;
  made.coverage.grid = images.grid;
  made.coverage.first = box.first;
  const auto n = static_cast<std::size_t>(images.phase_count());
  std::vector<std::vector<Settled>> settled(n);
  for (const Structure structure : structures) {
    std::vector<std::vector<float>> phases(n);
    std::vector<std::vector<BoundaryPoint>> points(n);
    parallel_for(n, [&](std::size_t p) {
      Boundary found = cover_phase(search, structure, p,
                                   under_fat.empty() ? nullptr : &under_fat[p], settled[p]);
      phases[p] = std::move(found.coverage);
      points[p] = std::move(found.points);
    });
    const bool empty = std::all_of(phases.begin(), phases.end(), [](const auto& phase) {
      return std::none_of(phase.begin(), phase.end(), [](float c) { return c >= 0.5F; });
    });
    if (empty) continue;
    made.coverage.phases[structure] = std::move(phases);
    made.uncertainty[structure] = std::move(points);
  }
  fit_wall(search, settled, made);
  return made;
}

void follow_coverage(const CoverageCycle& covered, ImageCycle<std::uint8_t>& labels) {
  const auto heart = covered.phases.find(Structure::Heart);
  if (heart == covered.phases.end()) return;
  std::array<bool, kLastLabel + 1> has{};  // a coverage of its own
  for (const auto& [structure, phases] : covered.phases) {
    if (structure != Structure::Heart) has.at(label_of(structure)) = true;
  }
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    std::vector<std::uint8_t>& phase = labels.phases[p];
    for (std::size_t v = 0; v < phase.size(); ++v) {
      float most = 0.5F;
      std::uint8_t best = kLabelBackground;
      for (const auto& [structure, phases] : covered.phases) {
        if (structure == Structure::Heart || phases[p][v] < most) continue;
        most = phases[p][v];
        best = label_of(structure);
      }
      const std::uint8_t before = phase[v];
      if (best != kLabelBackground) {
        phase[v] = best;
      } else if (heart->second[p][v] < 0.5F) {
        phase[v] = kLabelBackground;
      } else if (before == kLabelLvBlood && has[kLabelLvMyocardium]) {
        phase[v] = kLabelLvMyocardium;
      } else if (before == kLabelBackground || has[before]) {
        phase[v] = kLabelRestOfHeart;
      }
    }
  });
}

}  // namespace beatlas::edges
