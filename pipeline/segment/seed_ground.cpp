#include "pipeline/segment/seed_ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "pipeline/core/distance_map.h"
#include "pipeline/core/parallel.h"
#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/segment/looks.h"
#include "pipeline/segment/lv_section.h"
#include "pipeline/segment/wall_layers.h"
#include "pipeline/tissue/tissue.h"

namespace beatlas::segment {
namespace {

constexpr std::array<std::uint8_t, 3> kHeart{kLabelRvBlood, kLabelLvMyocardium, kLabelLvBlood};
/// Of the logarithm of a wall's distance from a mark in the cavity, by direction: a mark a fifth of
/// the radius off the middle of a round wall sees it between 4/5 and 6/5 of its mean.
constexpr double kUneven = 0.2;
constexpr double kSureSeed = 0.9;  ///< probability of a seed of the second growing

/// A quantity known in some slices: between them it goes straight on, beyond them it stays.
template <class T>
class Along {
 public:
  std::map<int, T> at;

  [[nodiscard]] T operator()(int k) const {
    const auto after = at.lower_bound(k);
    if (after == at.end()) return std::prev(after)->second;
    if (after->first == k || after == at.begin()) return after->second;
    const auto before = std::prev(after);
    const double t = static_cast<double>(k - before->first) / (after->first - before->first);
    return before->second * (1 - t) + after->second * t;
  }
};

/// Places in a slice [mm] along its rows and columns.
using Place = Eigen::Vector2d;

/// What the marks' places say of the heart's.
struct Shape {
  std::array<Along<Place>, kLabels> middle;  ///< of a label's marks, by slice
  Along<double> wall_mm;  ///< from the middle of the LV's marks to those of its muscle
  double reach_mm = 0;    ///< farther from all marks is no heart
  double low_mm = 0;      ///< along the slices' axis, of the outermost marked ones
  double high_mm = 0;
  double gap_mm = 0;  ///< between marked slices
};

Shape shape_of(const Grid& grid, const LabelImages& marks) {
  Shape out;
  const Vec3 mm = grid.spacing_mm();
  std::array<std::map<int, std::pair<Place, double>>, kLabels> sums;
  for (const std::vector<std::uint8_t>& phase : marks) {
    for (std::size_t v = 0; v < phase.size(); ++v) {
      const std::uint8_t label = phase[v];
      if (label == kUnlabelled) continue;
      const Index3 at = index_of(grid, v);
      const Place place(at[0] * mm[0], at[1] * mm[1]);
      auto& [sum, count] = sums[label].try_emplace(at[2], Place::Zero(), 0.0).first->second;
      sum += place;
      count += 1;
    }
  }
  for (std::size_t l = 0; l < kLabels; ++l) {
    for (const auto& [k, sum] : sums[l]) out.middle[l].at[k] = sum.first / sum.second;
  }
  const Along<Place>& lv = out.middle[kLabelLvBlood];
  std::map<int, std::pair<double, double>> radii;
  for (const std::vector<std::uint8_t>& phase : marks) {
    for (std::size_t v = 0; v < phase.size(); ++v) {
      if (phase[v] != kLabelLvMyocardium) continue;
      const Index3 at = index_of(grid, v);
      auto& [sum, count] = radii[at[2]];
      sum += (Place(at[0] * mm[0], at[1] * mm[1]) - lv(at[2])).norm();
      count += 1;
    }
  }
  for (const auto& [k, radius] : radii) {
    out.wall_mm.at[k] = std::max(radius.first / radius.second, mm[0]);
    out.reach_mm = std::max(out.reach_mm, 2 * out.wall_mm.at[k]);
  }
  for (const auto& [k, rv] : out.middle[kLabelRvBlood].at) {
    out.reach_mm = std::max(out.reach_mm, (rv - lv(k)).norm());
  }
  std::vector<int> slices;
  for (const std::uint8_t label : kHeart) {
    for (const auto& [k, place] : out.middle[label].at) slices.push_back(k);
  }
  std::sort(slices.begin(), slices.end());
  slices.erase(std::unique(slices.begin(), slices.end()), slices.end());
  out.low_mm = slices.front() * mm[2];
  out.high_mm = slices.back() * mm[2];
  // A single marked slice tells nothing of the others: the heart is as long as it is wide then.
  out.gap_mm = slices.size() > 1
                   ? (out.high_mm - out.low_mm) / (static_cast<double>(slices.size()) - 1)
                   : out.reach_mm;
  return out;
}

/// Distance [mm] of each voxel to the nearest mark of the RV in the plane of its slice;
/// kNoDistance in slices without.
std::vector<float> from_rv_marks(const Grid& grid, const LabelImages& marks) {
  std::vector<std::uint8_t> rv(grid.count(), 0);
  for (const std::vector<std::uint8_t>& phase : marks) {
    for (std::size_t v = 0; v < phase.size(); ++v) rv[v] |= phase[v] == kLabelRvBlood;
  }
  return distance_map(grid, rv, false);
}

double below(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

/// Where a voxel can be by its place among the marks alone; the same in every phase.
struct ByPlace {
  float heart = 0;   ///< that it lies in slices of the heart, and so near the marks; 0: background
  float cavity = 0;  ///< of the LV, against its muscle and what is outside
  float muscle = 0;
  float outside = 0;
  float rv = 0;      ///< share of what is outside
  float sector = 0;  ///< about the LV's middle, 0 up to kSectors
};

std::vector<ByPlace> by_place(const Grid& grid, const Shape& shape, const LabelImages& marks) {
  std::vector<ByPlace> out(grid.count());
  const Vec3 mm = grid.spacing_mm();
  const bool has_rv = !shape.middle[kLabelRvBlood].at.empty();
  const std::vector<float> from_rv = from_rv_marks(grid, marks);
  parallel_for(static_cast<std::size_t>(grid.size[2]), [&](std::size_t slice) {
    const auto k = static_cast<int>(slice);
    const double z = k * mm[2];
    const double beyond =
        std::clamp(std::max(shape.low_mm - z, z - shape.high_mm) / shape.gap_mm, 0.0, 1.0);
    const Place middle = shape.middle[kLabelLvBlood](k);
    const double wall = shape.wall_mm(k);
    // A mark in the middle of the RV is as far from its free wall as from the septum.
    const double rv_mm = has_rv ? (shape.middle[kLabelRvBlood](k) - middle).norm() : wall;
    const double free_wall = std::max(2 * rv_mm - wall, wall);
    std::size_t v = grid.offset(0, 0, k);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++v) {
        const Place place(i * mm[0], j * mm[1]);
        const double from_lv = std::max((place - middle).norm(), 1e-3);
        const double u = std::log(from_lv / wall) / kUneven;
        double near_rv = 0;
        if (has_rv) {
          const double away = std::min(static_cast<double>(from_rv[v]),
                                       (shape.middle[kLabelRvBlood](k) - place).norm());
          near_rv = std::max(0.0, 1 - away / shape.reach_mm);
        }
        const bool near = from_lv < shape.reach_mm || near_rv > 0;
        ByPlace& of = out[v];
        of.heart = static_cast<float>(near ? 1 - beyond : 0);
        of.cavity = static_cast<float>(below(-u));
        of.muscle = static_cast<float>(std::exp(-0.5 * u * u));
        of.outside = static_cast<float>(below(u));
        const Place off = place - middle;
        of.sector = static_cast<float>((std::atan2(off[1], off[0]) / (2 * M_PI) + 0.5) * kSectors);
        of.rv = static_cast<float>(near_rv * below(std::log(free_wall / from_lv) / kUneven));
      }
    }
  });
  return out;
}

/// Levels of the marked tissues by slice, and what a tissue of such a level looks like. A tissue
/// varies by more than a ball of it shows; where half-way to the next one lies is where neither is
/// likely: two standard deviations from each.
class LevelsAlong {
 public:
  LevelsAlong(const Grid& grid, const ImageCycle<float>& images, const LabelImages& marks) {
    std::array<std::map<int, std::vector<float>>, kLabels> values;
    for (std::size_t p = 0; p < marks.size(); ++p) {
      for (std::size_t v = 0; v < marks[p].size(); ++v) {
        if (marks[p][v] == kUnlabelled) continue;
        values[marks[p][v]][static_cast<int>(v / grid.slice_count())].push_back(
            images.phases[p][v]);
      }
    }
    for (std::size_t l = 0; l < kLabels; ++l) {
      for (auto& [k, list] : values[l]) levels_[l].at[k] = tissue::median_of(list);
    }
    // Coils light blood and muscle alike, and a ball hardly fits into a wall: of the shares of
    // blood's level that the slices' muscle has, the middle one counts.
    std::vector<float> shares;
    for (const auto& [k, level] : levels_[kLabelLvMyocardium].at) {
      shares.push_back(static_cast<float>(level / levels_[kLabelLvBlood](k)));
    }
    const double share = tissue::median_of(shares);
    levels_[kLabelLvMyocardium].at.clear();
    for (const auto& [k, level] : levels_[kLabelLvBlood].at) {
      levels_[kLabelLvMyocardium].at[k] = share * level;
    }
  }
  /// From what grew: cavities' medians, and that of what lies right beyond the LV's, which is its
  /// muscle, wherever in the wall a ball was placed.
  /// @param from_cavity_mm [phase][voxel], see distance_from_cavity
  void refine(const ImageCycle<float>& images, const ImageCycle<std::uint8_t>& labels,
              const std::vector<std::vector<float>>& from_cavity_mm) {
    const std::size_t slice = images.grid.slice_count();
    // The outline's own pixel is a mixture.
    const auto pixel = static_cast<float>(images.grid.spacing_mm()[0]);
    const std::array<Along<double>, kLabels> marked = levels_;
    for (int k = 0; k < images.grid.size[2]; ++k) {
      std::array<std::vector<float>, kLabels> values;
      const double half_way = 0.5 * (marked[kLabelLvBlood](k) + marked[kLabelLvMyocardium](k));
      for (std::size_t p = 0; p < labels.phases.size(); ++p) {
        for (std::size_t v = slice * static_cast<std::size_t>(k);
             v < slice * (static_cast<std::size_t>(k) + 1); ++v) {
          const float away = from_cavity_mm[p][v];
          const std::uint8_t label = labels.phases[p][v];
          const float value = images.phases[p][v];
          const bool blood = value > half_way;  // what grew too far is not asked
          if (!blood && away > pixel && away < 3 * pixel) {
            values[kLabelLvMyocardium].push_back(value);
          } else if (blood && (label == kLabelLvBlood || label == kLabelRvBlood)) {
            values[label].push_back(value);
          }
        }
      }
      for (const std::uint8_t label : kHeart) {
        if (!values[label].empty()) levels_[label].at[k] = tissue::median_of(values[label]);
      }
    }
  }
  [[nodiscard]] bool has(std::size_t label) const { return !levels_[label].at.empty(); }
  [[nodiscard]] double operator()(std::size_t label, int k) const { return levels_[label](k); }

  [[nodiscard]] Look look(std::size_t label, int k, const Bins& bins, double noise) const {
    Look out;
    out.fill(1);
    if (!has(label)) return out;
    const double muscle = levels_[kLabelLvMyocardium](k);
    const double blood = levels_[kLabelLvBlood](k);
    const double level = levels_[label](k);
    const double contrast = std::max(std::abs(blood - muscle), noise);
    const double above = std::max(contrast / 4, noise);
    // Cavities hold trabeculae: half-way to muscle they are one deviation from blood alone.
    const double under = std::max(label == kLabelLvMyocardium ? muscle / 4 : contrast / 2, noise);
    Look counts{};
    for (std::size_t b = 0; b < counts.size(); ++b) {
      const double off = (static_cast<double>(b) + 0.5) * bins.width() - level;
      const double u = off / (off < 0 ? under : above);
      counts[b] = std::exp(-0.5 * u * u);
    }
    return density_of(counts);
  }

 private:
  std::array<Along<double>, kLabels> levels_;
};

/// What of images and marks is the same in all phases.
struct Scene {
  const ImageCycle<float>& images;
  std::vector<ByPlace> place;  ///< [voxel]
  Bins bins;
  std::vector<Looks> look;  ///< [slice]
};

/// Makes background of what lies far from all marks, and counts by slice what that looks like. A
/// mark of background tells where it is: liver that is marked as such looks like muscle.
std::vector<Look> mark_background(const Scene& scene, LabelImages& seeds) {
  const std::size_t slice = scene.images.grid.slice_count();
  std::vector<Look> counts(static_cast<std::size_t>(scene.images.grid.size[2]));
  for (std::size_t v = 0; v < scene.place.size(); ++v) {
    if (scene.place[v].heart > 0) continue;
    for (std::size_t p = 0; p < scene.images.phases.size(); ++p) {
      std::uint8_t& seed = seeds[p][v];
      if (seed == kUnlabelled) seed = kLabelBackground;
      counts[v / slice][scene.bins.of(scene.images.phases[p][v])] += 1;
    }
  }
  return counts;
}

/// What labels look like, by slice. @param background see mark_background
std::vector<Looks> looks_by_slice(const LevelsAlong& along, const std::vector<Look>& background,
                                  const Bins& bins, double noise) {
  std::vector<Looks> out(background.size());
  for (std::size_t k = 0; k < out.size(); ++k) {
    const auto slice = static_cast<int>(k);
    for (const std::uint8_t label : kHeart) out[k][label] = along.look(label, slice, bins, noise);
    // Tissues beyond the heart vary as those of it do, or muscle would seem to be liver.
    const double contrast = along(kLabelLvBlood, slice) - along(kLabelLvMyocardium, slice);
    out[k][kLabelBackground] =
        density_of(background[k], std::max(contrast, noise) / 4 / bins.width());
  }
  return out;
}

/// Of one phase [slice], each with half of the slices beside it.
/// @param away_mm [voxel], see distance_from_cavity
std::vector<WallLayers> layers_of(const Scene& scene, const std::vector<float>& image,
                                  const std::vector<float>& away_mm) {
  const std::size_t slice = scene.images.grid.slice_count();
  const int slices = scene.images.grid.size[2];
  const auto seen = [&](std::size_t v) {
    const Looks& here = scene.look[v / slice];
    const std::size_t bin = scene.bins.of(image[v]);
    const double rv = static_cast<double>(scene.place[v].rv);
    return WallLayers::Shares{
        here[kLabelLvBlood][bin], here[kLabelLvMyocardium][bin],
        rv * here[kLabelRvBlood][bin] + (1 - rv) * here[kLabelBackground][bin]};
  };
  std::vector<WallLayers> layers;
  for (int k = 0; k < slices; ++k) {
    std::vector<WallLayers::Voxel> voxels;
    for (int n = std::max(0, k - 1); n < std::min(slices, k + 2); ++n) {
      const auto begin = static_cast<std::size_t>(n) * slice;
      for (std::size_t v = begin; v < begin + slice; ++v) {
        if (scene.place[v].heart <= 0 || away_mm[v] >= kNoDistance) continue;
        WallLayers::Voxel voxel{.bin = WallLayers::bin_of(away_mm[v]), .look = seen(v)};
        voxel.weight = (n == k ? 1.0 : 0.5) * weights_by_sector(scene.place[v].sector);
        voxels.push_back(voxel);
      }
    }
    layers.emplace_back(voxels);
  }
  return layers;
}

/// Lays a phase's prices, and seeds where labels that grew before leave no doubt.
/// @param away_mm [voxel], see distance_from_cavity; empty where none grew
void lay_phase(const Scene& scene, std::size_t p, const std::vector<float>& away_mm, Ground& out) {
  const std::size_t slice = scene.images.grid.slice_count();
  const std::vector<float>& image = scene.images.phases[p];
  const bool grown = !away_mm.empty();
  const std::vector<WallLayers> layers =
      grown ? layers_of(scene, image, away_mm) : std::vector<WallLayers>{};
  std::vector<std::uint8_t>& prices = out.prices.phases[p];
  prices.resize(image.size() * kLabels);
  for (std::size_t v = 0; v < image.size(); ++v) {
    const ByPlace& at = scene.place[v];
    const bool layered = grown && away_mm[v] < kNoDistance;
    WallLayers::Shares share{static_cast<double>(at.cavity), static_cast<double>(at.muscle),
                             static_cast<double>(at.outside)};
    if (layered) share = layers[v / slice].at(at.sector, WallLayers::bin_of(away_mm[v]));
    const auto heart = static_cast<double>(at.heart);
    const auto rv = static_cast<double>(at.rv);
    const Looks& here = scene.look[v / slice];
    const std::size_t bin = scene.bins.of(image[v]);
    std::array<double, kLabels> weight{};
    weight[kLabelLvBlood] = heart * share[0] * here[kLabelLvBlood][bin];
    weight[kLabelLvMyocardium] = heart * share[1] * here[kLabelLvMyocardium][bin];
    weight[kLabelRvBlood] = heart * share[2] * rv * here[kLabelRvBlood][bin];
    weight[kLabelBackground] =
        (1 - heart + heart * share[2] * (1 - rv)) * here[kLabelBackground][bin];
    set_prices(weight, prices.data() + v * kLabels);
    if (!layered || out.seeds[p][v] != kUnlabelled) continue;
    const double sum = weight[0] + weight[1] + weight[2] + weight[3];
    for (std::uint8_t label = 0; label <= kLabelLvBlood; ++label) {
      if (weight[label] > kSureSeed * sum) out.seeds[p][v] = label;
    }
  }
}

}  // namespace

bool tell_heart(const LabelImages& marks, const KnownLabels& known) {
  std::array<bool, 256> marked{};
  for (const LabelImages* told : {&marks, &known.labels.phases}) {
    for (const std::vector<std::uint8_t>& phase : *told) {
      for (const std::uint8_t label : phase) marked[label] = true;
    }
  }
  return marked[kLabelLvBlood] && marked[kLabelLvMyocardium] && marked[kLabelBackground];
}

Box box_of_marks(const Grid& stack, const LabelImages& marks) {
  std::vector<std::size_t> heart;
  for (const std::vector<std::uint8_t>& phase : marks) {
    for (std::size_t v = 0; v < phase.size(); ++v) {
      if (phase[v] != kLabelBackground && phase[v] != kUnlabelled) heart.push_back(v);
    }
  }
  const Shape shape = shape_of(stack, marks);
  const Vec3 mm = stack.spacing_mm();
  Index3 room{};
  for (int a = 0; a < 3; ++a) {
    const double reach = a == 2 ? shape.gap_mm : shape.reach_mm;
    room[static_cast<std::size_t>(a)] = static_cast<int>(std::ceil(reach / mm[a])) + 1;
  }
  return with_room(stack, box_around_voxels(stack, heart), room);
}

Ground lay_seed_ground(const ImageCycle<float>& images, const LabelImages& marks, double noise,
                       const ImageCycle<std::uint8_t>* first) {
  const Grid& grid = images.grid;
  Scene scene{images, by_place(grid, shape_of(grid, marks), marks), Bins(images), {}};
  LevelsAlong along(grid, images, marks);
  std::vector<std::vector<float>> away_mm(images.phases.size());
  if (first != nullptr) {
    parallel_for(away_mm.size(),
                 [&](std::size_t p) { away_mm[p] = distance_from_cavity(grid, first->phases[p]); });
    along.refine(images, *first, away_mm);
  }
  Ground out;
  out.seeds = marks;
  const std::vector<Look> background = mark_background(scene, out.seeds);
  scene.look = looks_by_slice(along, background, scene.bins, noise);
  const int middle = grid.size[2] / 2;
  out.levels.blood = along(kLabelLvBlood, middle);
  out.levels.muscle = along(kLabelLvMyocardium, middle);
  out.levels.rv_blood = !along.has(kLabelRvBlood) ? out.levels.blood : along(kLabelRvBlood, middle);
  part_marked(out.levels);
  out.prices.phases.resize(away_mm.size());
  parallel_for(away_mm.size(), [&](std::size_t p) { lay_phase(scene, p, away_mm[p], out); });
  return out;
}

}  // namespace beatlas::segment
