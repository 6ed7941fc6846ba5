#include "pipeline/segment/seeds.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <tuple>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/segment/distance_map.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

constexpr double kMostCost = 25;         ///< of a millimetre
constexpr double kBeyondPlane = 4;       ///< times harder does the RV travel beyond its plane
constexpr double kLvSeedsBelowMm = 1.5;  ///< the LV's base plane, which is seen
constexpr double kRvSeedsBelowMm = 4;    ///< the RV's, which is placed by rule
constexpr double kAtriaBeyondMm = 3;     ///< of both planes: that blood is surely no ventricle's
constexpr double kMostSeedMm = 50;       ///< radius; a heart is hardly larger

/// Filled polygon of a radius per ray.
template <class RadiusOfRay>
cv::Mat polygon(const cv::Size& size, const LvSlice& slice, const cv::Point2d& pixel_mm,
                const RadiusOfRay& radius_mm) {
  constexpr int kShift = 4;  // sub-pixel vertices
  std::vector<cv::Point> points;
  for (int a = 0; a < Ring::kRays; ++a) {
    const cv::Point2d at =
        ray_point(slice.centre_px, pixel_mm, a, radius_mm(static_cast<std::size_t>(a)));
    points.emplace_back(static_cast<int>(std::lround(at.x * (1 << kShift))),
                        static_cast<int>(std::lround(at.y * (1 << kShift))));
  }
  cv::Mat mask = cv::Mat::zeros(size, CV_8U);
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{points}, cv::Scalar(255), cv::LINE_8,
               kShift);
  return mask;
}

void paint(std::vector<std::uint8_t>& image, const Grid& grid, int k, const cv::Mat& mask,
           std::uint8_t label) {
  cv::Mat slice(grid.size[1], grid.size[0], CV_8U, image.data() + grid.offset(0, 0, k));
  slice.setTo(cv::Scalar(label), mask);
}

/// Wall of a slice in a phase: its own median, or the heart's where few rays have one.
double wall_of(const Ring& ring, double heart_wall_mm) {
  return ring.walled_share >= 0.3 ? ring.median_wall_mm() : heart_wall_mm;
}

/// The LV's cavity in one phase as its rings show it.
std::vector<std::uint8_t> cavities(const Grid& grid, const Chambers& chambers, std::size_t phase) {
  std::vector<std::uint8_t> mask(grid.count(), 0);
  const Vec3 spacing = grid.spacing_mm();
  for (const LvSlice& slice : chambers.lv) {
    const Ring& ring = slice.rings[phase];
    paint(mask, grid, slice.k,
          polygon({grid.size[0], grid.size[1]}, slice, {spacing[0], spacing[1]},
                  [&](std::size_t a) { return static_cast<double>(ring.endo_mm[a]); }),
          255);
  }
  return mask;
}

/// Where the heart may be in each slice: beyond it, what is still is background.
std::vector<cv::Mat> heart_zones(const Grid& grid, const Chambers& chambers,
                                 const cv::Point2d& pixel_mm) {
  const cv::Size size(grid.size[0], grid.size[1]);
  const double slice_mm = grid.spacing_mm()[2];
  const auto n = static_cast<std::size_t>(grid.size[2]);
  std::vector<cv::Mat> zones(n);
  const auto ed = static_cast<std::size_t>(chambers.end_diastole);
  for (const LvSlice& slice : chambers.lv) {
    const Ring& ring = slice.rings[ed];
    const double wall = wall_of(ring, chambers.wall_mm);
    cv::Mat zone = polygon(size, slice, pixel_mm,
                           [&](std::size_t a) { return ring.endo_mm[a] + 1.6 * wall + 2.0; });
    // Where no RV was seen it may still begin: its outline one slice nearer the base holds it.
    cv::Mat rv = chambers.rv[static_cast<std::size_t>(slice.k)];
    const int towards_base = slice.k + chambers.base_step;
    if (rv.empty() && towards_base >= 0 && towards_base < grid.size[2]) {
      rv = chambers.rv[static_cast<std::size_t>(towards_base)];
    }
    if (!rv.empty()) {
      cv::Mat grown;
      cv::dilate(rv, grown, disc(8.0, pixel_mm));
      zone |= grown;
    }
    zones[static_cast<std::size_t>(slice.k)] = zone;
  }
  // Beyond the ventricle's slices: the nearest zone, widened, with every beating pool near it.
  const auto spread = [&](int from, int step) {
    const cv::Mat nearest = zones[static_cast<std::size_t>(from)];
    for (int k = from + step; k >= 0 && k < grid.size[2]; k += step) {
      const double away_mm = std::abs(k - from) * slice_mm;
      const bool basal = step == chambers.base_step;
      if (!basal && away_mm > 25) {
        zones[static_cast<std::size_t>(k)] = cv::Mat::zeros(size, CV_8U);
        continue;
      }
      cv::Mat zone;
      cv::dilate(nearest, zone, disc(std::min(basal ? 15.0 : 5.0, away_mm), pixel_mm));
      zones[static_cast<std::size_t>(k)] = zone;
    }
  };
  spread(chambers.lv.front().k, -1);
  spread(chambers.lv.back().k, +1);
  // Thin slices through a leaning ventricle: muscle lies around the cavity in space.
  if (slice_mm < kThickSlicesMm) {
    const std::vector<float> away = distance_map(grid, cavities(grid, chambers, ed), true);
    for (std::size_t k = 0; k < n; ++k) {
      const cv::Mat slice(size, CV_32F, const_cast<float*>(away.data()) + k * grid.slice_count());
      zones[k] |= slice <= 1.6 * chambers.wall_mm + 2.0;
    }
  }
  if (chambers.parts_atria()) {
    for (std::size_t k = 0; k < n; ++k) {
      cv::Mat atria;
      cv::dilate(chambers.always_blood_moving[k], atria, disc(8.0, pixel_mm));
      zones[k] |= atria;
    }
  }
  return zones;
}

/// Thin slices run through ventricles and atria alike: no seed of a ventricle beyond its base
/// plane, and of what beats beyond both, atria and great vessels, the cores are seeds of their own.
void part_at_base(const Grid& grid, const Chambers& chambers, LabelImages& seeds) {
  const Vec3 spacing = grid.spacing_mm();
  std::vector<std::uint8_t> cores(grid.count(), 0);
  for (int k = 0; k < grid.size[2]; ++k) {
    cv::Mat core;
    cv::erode(chambers.always_blood_moving[static_cast<std::size_t>(k)], core,
              disc(2.0, {spacing[0], spacing[1]}));
    paint(cores, grid, k, core, 1);
  }
  for (std::size_t p = 0; p < seeds.size(); ++p) {
    const double lv_base = chambers.axis->lv_base_mm[p];
    const double rv_base = chambers.axis->rv_base_mm[p];
    for (std::size_t v = 0; v < seeds[p].size(); ++v) {
      const auto height = static_cast<double>(chambers.height_mm[v]);
      std::uint8_t& seed = seeds[p][v];
      if ((seed == kLabelLvBlood || seed == kLabelLvMyocardium) &&
          height > lv_base - kLvSeedsBelowMm) {
        seed = kUnlabelled;
      }
      if (seed == kLabelRvBlood && height > rv_base - kRvSeedsBelowMm) seed = kUnlabelled;
      if (cores[v] != 0 && height > std::max(lv_base, rv_base) + kAtriaBeyondMm) {
        seed = kLabelRestOfHeart;
      }
    }
  }
}

void check_seed(const Seed& seed) {
  if (seed.label >= TravelCost::kLabels) {
    throw_invalid("seed label " + std::to_string(seed.label) + " is not known; use 0 to 4");
  }
  if (!(seed.radius_mm > 0 && seed.radius_mm <= kMostSeedMm)) {
    throw_invalid("seed radius must be a number of mm above 0 and at most " +
                  std::to_string(static_cast<int>(kMostSeedMm)));
  }
}

[[noreturn]] void refuse_outside(const Seed& seed) {
  std::ostringstream message;
  message << "seed at (" << seed.lps_mm.transpose()
          << ") mm LPS lies outside the images; give its position in patient LPS mm";
  throw_invalid(message.str());
}

/// The voxels of a seed's ball: those whose centres lie in it, and the one that holds its middle,
/// for a ball between two thick slices holds no centre. Empty if the ball misses the grid.
std::vector<std::size_t> voxels_of(const Grid& grid, const Seed& seed) {
  const Vec3 centre = grid.mm_from_index.inverse() * seed.lps_mm;
  const Vec3 reach = (seed.radius_mm * grid.spacing_mm().cwiseInverse()).cwiseMax(0.5);
  Index3 low{};
  Index3 high{};
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    const double last = grid.size[axis] - 1;
    // In doubles first: a place far outside fits no int.
    if (!(centre[a] + reach[a] >= 0 && centre[a] - reach[a] <= last)) return {};
    low[axis] = static_cast<int>(std::ceil(std::max(0.0, centre[a] - reach[a])));
    high[axis] = static_cast<int>(std::floor(std::min(last, centre[a] + reach[a])));
  }
  std::vector<std::size_t> voxels;
  for (int k = low[2]; k <= high[2]; ++k) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) {
        const Vec3 d = Vec3(i, j, k) - centre;
        const bool in_ball = d.cwiseQuotient(reach).squaredNorm() <= 1.0 + 1e-9;
        if (in_ball || d.cwiseAbs().maxCoeff() <= 0.5) voxels.push_back(grid.offset(i, j, k));
      }
    }
  }
  return voxels;
}

}  // namespace

std::vector<std::uint8_t> classify_motion(const TemporalStats& stats) {
  std::vector<float> sorted = stats.swing;
  const auto top =
      sorted.begin() + static_cast<std::ptrdiff_t>(static_cast<double>(sorted.size()) * 0.99);
  std::nth_element(sorted.begin(), top, sorted.end());
  const double moving = std::max(0.2 * *top, 0.8 * stats.noise);
  const double still = 0.5 * moving;
  std::vector<std::uint8_t> classes(stats.swing.size());
  std::transform(stats.swing.begin(), stats.swing.end(), classes.begin(), [&](float swing) {
    return static_cast<std::uint8_t>(swing < still ? kStill : swing < moving ? kStirring : kMoving);
  });
  return classes;
}

LabelImages classify(const TemporalStats& stats, const Chambers& chambers, std::size_t phases) {
  LabelImages classes(phases, classify_motion(stats));
  if (!chambers.parts_atria()) return classes;
  for (std::size_t p = 0; p < phases; ++p) {
    for (std::size_t v = 0; v < classes[p].size(); ++v) {
      const auto height = static_cast<double>(chambers.height_mm[v]);
      if (height > chambers.axis->lv_base_mm[p]) classes[p][v] += kBeyondLv;
      if (height > chambers.axis->rv_base_mm[p]) classes[p][v] += kBeyondRv;
    }
  }
  return classes;
}

TravelCost travel_cost(const TissueLevels& levels) {
  TravelCost cost(2.5 * levels.blood);
  const double span = levels.blood - levels.muscle;
  for (int bin = 0; bin < TravelCost::kBins; ++bin) {
    const double intensity = cost.intensity_of(bin);
    const double f = (intensity - levels.muscle) / span;  // 0 muscle, 1 blood
    const bool dark = intensity < levels.dark;
    const double blood = f >= 1.6   ? 1.5
                         : f >= 0.6 ? 0.1
                         : f >= 0.4 ? 0.1 + 5 * (0.6 - f)
                                    : 1.1 + 25 * (0.4 - f);
    double muscle = f <= 0.35 ? 0.25 : std::min(8.0, 0.25 + 18 * (f - 0.35));
    if (dark) muscle = 1.0 + 4.0 * (levels.dark - intensity) / levels.dark;
    for (int index = 0; index < TravelCost::kClasses; ++index) {
      const int c = index % kBeyondLv;
      const bool beyond_lv = index / kBeyondLv % 2 != 0;
      const bool beyond_rv = index / kBeyondRv != 0;
      const double still_penalty = c == kStill ? 1.5 : 1.0;
      const double b = std::min(blood, kMostCost);
      const double rv = intensity > 1.45 * levels.rv_blood ? std::max(b, 1.5) : b;
      const double rest = std::min(b * 1.2, std::max(0.6, muscle) * still_penalty);
      cost.at(kLabelLvBlood, index, bin) = static_cast<float>(beyond_lv ? kMostCost : b);
      cost.at(kLabelLvMyocardium, index, bin) =
          static_cast<float>(beyond_lv ? kMostCost : muscle * still_penalty);
      cost.at(kLabelRvBlood, index, bin) =
          static_cast<float>(beyond_rv ? std::min(kMostCost, kBeyondPlane * rv) : rv);
      cost.at(kLabelRestOfHeart, index, bin) = static_cast<float>(rest);
      double background = 0.3;
      if (dark) {
        background = 0.1;
      } else if (f > 1.5) {
        background = 0.2;
      } else if (f > 0.5) {
        background = c == kStill ? 0.4 : c == kStirring ? 1.5 : 4.0;
      } else {
        background = c == kStill ? 0.4 : c == kStirring ? 0.6 : 1.0;
      }
      cost.at(kLabelBackground, index, bin) = static_cast<float>(background);
    }
  }
  return cost;
}

LabelImages automatic_seeds(const ImageCycle<float>& images, const TemporalStats& stats,
                            const Chambers& chambers) {
  const Grid& grid = images.grid;
  const Vec3 spacing = grid.spacing_mm();
  const cv::Point2d pixel_mm(spacing[0], spacing[1]);
  const cv::Size size(grid.size[0], grid.size[1]);
  const auto n = static_cast<std::size_t>(images.phase_count());
  LabelImages seeds(n, std::vector<std::uint8_t>(grid.count(), kUnlabelled));
  const std::vector<std::uint8_t> motion = classify_motion(stats);

  // Background, the same in every phase.
  std::vector<std::uint8_t> still(grid.count(), kUnlabelled);
  const std::vector<cv::Mat> zones =
      chambers.found_lv() ? heart_zones(grid, chambers, pixel_mm) : std::vector<cv::Mat>();
  for (int k = 0; k < grid.size[2]; ++k) {
    cv::Mat border = cv::Mat::zeros(size, CV_8U);
    cv::rectangle(border, {0, 0}, {size.width - 1, size.height - 1}, cv::Scalar(255), 1);
    paint(still, grid, k, border, kLabelBackground);
    const cv::Mat high = slice_of(grid, stats.high, k);
    const cv::Mat quiet =
        cv::Mat(size, CV_8U, const_cast<std::uint8_t*>(motion.data() + grid.offset(0, 0, k))) !=
        kMoving;
    cv::Mat seed = high < chambers.levels.dark + stats.noise;  // lung in every phase
    if (!zones.empty()) {
      // Between thick slices nothing can be followed, so beyond the zone even what moves is out:
      // vessels that leave the heart.
      const cv::Mat beyond = ~zones[static_cast<std::size_t>(k)];
      seed |= spacing[2] >= kThickSlicesMm ? beyond : cv::Mat(quiet & beyond);
    }
    paint(still, grid, k, seed, kLabelBackground);
  }
  for (std::vector<std::uint8_t>& phase : seeds) phase = still;

  if (!chambers.found_lv()) {
    for (int k = 0; k < grid.size[2]; ++k) {
      cv::Mat core;
      cv::erode(chambers.always_blood_moving[static_cast<std::size_t>(k)], core,
                disc(2.0, pixel_mm));
      for (std::vector<std::uint8_t>& phase : seeds) {
        paint(phase, grid, k, core, kLabelRestOfHeart);
      }
    }
    return seeds;
  }

  // Atria and great vessels: beating pools in slices beyond the base. Only where slices are so
  // thick that the next one cannot hold the ventricle's own open end.
  const int base_k = chambers.base_step > 0 ? chambers.lv.back().k : chambers.lv.front().k;
  if (spacing[2] >= kThickSlicesMm) {
    for (int k = base_k + chambers.base_step; k >= 0 && k < grid.size[2]; k += chambers.base_step) {
      if (std::abs(k - base_k) * spacing[2] < 9) continue;
      cv::Mat pools;
      cv::erode(chambers.always_blood_moving[static_cast<std::size_t>(k)], pools,
                disc(2.0, pixel_mm));
      for (std::vector<std::uint8_t>& phase : seeds) {
        paint(phase, grid, k, pools, kLabelRestOfHeart);
      }
    }
  }

  const bool across = spacing[2] < kThickSlicesMm;
  std::vector<std::vector<float>> away(n);
  parallel_for(
      n, [&](std::size_t p) { away[p] = distance_map(grid, cavities(grid, chambers, p), across); });
  for (const LvSlice& slice : chambers.lv) {
    const auto k = static_cast<std::size_t>(slice.k);
    for (std::size_t p = 0; p < n; ++p) {
      const Ring& ring = slice.rings[p];
      const double wall = wall_of(ring, chambers.wall_mm);
      const cv::Mat bright = slice_of(grid, images.phases[p], slice.k) > chambers.levels.threshold;
      // Beyond a wall whose outer edge cannot be seen, a wall and a half is surely outside.
      const auto radius = [&](double walls) {
        return [&, walls](std::size_t a) { return ring.endo_mm[a] + walls * wall; };
      };
      cv::Mat outside = polygon(size, slice, pixel_mm, radius(1.9)) &
                        ~polygon(size, slice, pixel_mm, radius(1.45));
      cv::Mat unseen = cv::Mat::zeros(size, CV_8U);
      cv::Mat seen = cv::Mat::zeros(size, CV_8U);
      for (int a = 0; a < Ring::kRays; ++a) {
        const auto i = static_cast<std::size_t>(a);
        const double run = ring.outer_mm[i] - ring.endo_mm[i];
        const bool hidden = run > 1.6 * wall;
        if (!hidden) continue;
        const cv::Point2d from = ray_point(slice.centre_px, pixel_mm, a, ring.endo_mm[i]);
        const cv::Point2d to = ray_point(slice.centre_px, pixel_mm, a, ring.endo_mm[i] + 2 * wall);
        cv::line(unseen, from, to, cv::Scalar(255), 2);
      }
      const double real_wall = across ? chambers.wall_by_phase_mm[p] : wall;
      const cv::Mat clear = slice_of(grid, away[p], slice.k) > 1.4 * real_wall;
      paint(seeds[p], grid, slice.k, outside & unseen & clear & ~bright, kLabelBackground);

      cv::Mat muscle =
          polygon(size, slice, pixel_mm,
                  [&](std::size_t a) {
                    return ring.endo_mm[a] +
                           (ring.walled[a]
                                ? 0.65 * std::min(wall * 1.3, static_cast<double>(ring.outer_mm[a] -
                                                                                  ring.endo_mm[a]))
                                : 0.6 * wall);
                  }) &
          ~polygon(size, slice, pixel_mm,
                   [&](std::size_t a) { return ring.endo_mm[a] + 0.3 * wall; });
      // Rays with no wall at all (valves, other chambers) give no muscle.
      for (int a = 0; a < Ring::kRays; ++a) {
        const auto i = static_cast<std::size_t>(a);
        if (ring.walled[i] || ring.outer_mm[i] - ring.endo_mm[i] > 1.6 * wall) {
          cv::line(seen, slice.centre_px,
                   ray_point(slice.centre_px, pixel_mm, a, ring.endo_mm[i] + 2 * wall),
                   cv::Scalar(255), 2);
        }
      }
      const cv::Mat not_dark = slice_of(grid, images.phases[p], slice.k) > chambers.levels.dark;
      paint(seeds[p], grid, slice.k, muscle & seen & ~bright & not_dark, kLabelLvMyocardium);
      paint(seeds[p], grid, slice.k,
            polygon(size, slice, pixel_mm, [&](std::size_t a) { return 0.6 * ring.endo_mm[a]; }) &
                bright,
            kLabelLvBlood);

      if (!chambers.rv[k].empty()) {
        cv::Mat core;
        cv::erode(chambers.rv[k], core, disc(2.0, pixel_mm));
        const int apart = std::abs(static_cast<int>(p) - chambers.end_diastole);
        const int cyclic = std::min(apart, static_cast<int>(n) - apart);
        const cv::Mat here = cyclic * 12 <= static_cast<int>(n) ? bright : chambers.always_blood[k];
        paint(seeds[p], grid, slice.k, core & here & bright, kLabelRvBlood);
      }
    }
  }
  if (chambers.parts_atria()) part_at_base(images.grid, chambers, seeds);
  return seeds;
}

void check_seeds(const std::vector<Seed>& seeds, const Grid& grid, int phases) {
  for (const Seed& seed : seeds) {
    check_seed(seed);
    if (seed.phase < -1 || seed.phase >= phases) {
      throw_invalid("seed phase " + std::to_string(seed.phase) + " is not known; use 0 to " +
                    std::to_string(phases - 1) + ", or -1 for every phase");
    }
    if (voxels_of(grid, seed).empty()) refuse_outside(seed);
  }
}

Box box_with_seeds(const Grid& grid, const Box& box, std::vector<Seed>& seeds) {
  constexpr double kMarginMm = 20;
  Box out = box;
  std::erase_if(seeds, [&](const Seed& seed) {
    const std::vector<std::size_t> voxels = voxels_of(grid, seed);
    Index3 low = grid.size;
    Index3 high{-1, -1, -1};
    bool reaches = false;
    for (const std::size_t v : voxels) {
      const std::size_t in_slice = v % grid.slice_count();
      const auto nx = static_cast<std::size_t>(grid.size[0]);
      const Index3 at{static_cast<int>(in_slice % nx), static_cast<int>(in_slice / nx),
                      static_cast<int>(v / grid.slice_count())};
      bool inside = true;
      for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], at[a]);
        high[a] = std::max(high[a], at[a]);
        inside = inside && at[a] >= box.first[a] && at[a] < box.first[a] + box.size[a];
      }
      reaches = reaches || inside;
    }
    if (seed.label == kLabelBackground) return !reaches;
    for (std::size_t a = 0; a < 3; ++a) {
      const int margin =
          static_cast<int>(std::ceil(kMarginMm / grid.spacing_mm()[static_cast<int>(a)]));
      int first = out.first[a];
      int last = first + out.size[a] - 1;
      if (low[a] < first) first = std::max(0, low[a] - margin);
      if (high[a] > last) last = std::min(grid.size[a] - 1, high[a] + margin);
      out.first[a] = first;
      out.size[a] = last - first + 1;
    }
    return false;
  });
  return out;
}

void draw_seeds(const Grid& grid, const std::vector<Seed>& seeds, LabelImages& images) {
  check_seeds(seeds, grid, static_cast<int>(images.size()));
  const auto for_each_place = [&](const auto& visit) {
    for (const Seed& seed : seeds) {
      const std::vector<std::size_t> voxels = voxels_of(grid, seed);
      for (std::size_t p = 0; p < images.size(); ++p) {
        if (seed.phase >= 0 && static_cast<std::size_t>(seed.phase) != p) continue;
        for (std::size_t v : voxels) visit(seed, p, v);
      }
    }
  };
  // First what the drawn seeds replace, then the seeds, so that no seed erases another.
  std::set<std::tuple<std::size_t, std::size_t, std::uint8_t>> cleared;
  for_each_place([&](const Seed& seed, std::size_t p, std::size_t v) {
    const std::size_t k = v / grid.slice_count();
    if (!cleared.emplace(p, k, seed.label).second) return;
    const auto from = images[p].begin() + static_cast<std::ptrdiff_t>(k * grid.slice_count());
    std::replace(from, from + static_cast<std::ptrdiff_t>(grid.slice_count()), seed.label,
                 kUnlabelled);
  });
  for_each_place(
      [&](const Seed& seed, std::size_t p, std::size_t v) { images[p][v] = seed.label; });
}

void adopt_seeds(const ImageCycle<float>& images, const std::vector<Seed>& seeds,
                 Chambers& chambers) {
  const Affine index_from_lps = images.grid.mm_from_index.inverse();
  for (const Seed& seed : seeds) {
    if (seed.label != kLabelLvBlood) continue;
    const Vec3 at = index_from_lps * seed.lps_mm;
    const int k = static_cast<int>(std::lround(at[2]));
    if (images.grid.contains(static_cast<int>(std::lround(at[0])),
                             static_cast<int>(std::lround(at[1])), k)) {
      adopt_lv_slice(chambers, images, k, {at[0], at[1]});
    }
  }
}

}  // namespace beatlas::segment
