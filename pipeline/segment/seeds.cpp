#include "pipeline/segment/seeds.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/segment/distance_map.h"
#include "pipeline/segment/great_vessels.h"
#include "pipeline/segment/rv_pools.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

constexpr double kSurelyNoise = 3;       ///< brighter by so many deviations is no muscle's noise
constexpr double kLeastMuscleEnd = 0.2;  ///< of the way from muscle to blood
constexpr double kMostMuscleEnd = 0.35;
constexpr double kMostCost = 25;           ///< of a millimetre
constexpr double kBeyondPlane = 4;         ///< times harder does the RV travel beyond its plane
constexpr double kLvSeedsBelowMm = 1.5;    ///< the LV's base plane, which is seen
constexpr double kRvSeedsBelowMm = 4;      ///< the RV's, which is placed by rule
constexpr double kRvRimMm = 2;             ///< of an RV's pool that may be mixed with its wall
constexpr double kRvReachMm = 5;           ///< a wall, its motion and an outline's error
constexpr double kLeastBeyondWalls = 1.1;  ///< of the LV, from its cavity: as thick its wall may be
constexpr double kMostBeyondWalls = 1.5;   ///< where its outer edge is not seen
constexpr double kAtriaBeyondMm = 3;       ///< of both planes: that blood is surely no ventricle's

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
  slice_of(grid, image, k).setTo(cv::Scalar(label), mask);
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
  const auto widened = [&](int from, double by_mm) {
    cv::Mat zone;
    cv::dilate(zones[static_cast<std::size_t>(from)], zone, disc(by_mm, pixel_mm));
    return zone;
  };
  // A technician's seed may make a slice the LV's that is no neighbour of the others.
  for (std::size_t at = 1; at < chambers.lv.size(); ++at) {
    const int below = chambers.lv[at - 1].k;
    const int above = chambers.lv[at].k;
    for (int k = below + 1; k < above; ++k) {
      const int nearer = k - below <= above - k ? below : above;
      zones[static_cast<std::size_t>(k)] =
          widened(nearer, std::min(5.0, std::abs(k - nearer) * slice_mm));
    }
  }
  // Beyond the ventricle's slices: the nearest zone, widened, with every beating pool near it.
  const auto spread = [&](int from, int step) {
    for (int k = from + step; k >= 0 && k < grid.size[2]; k += step) {
      const double away_mm = std::abs(k - from) * slice_mm;
      const bool basal = step == chambers.base_step;
      if (!basal && away_mm > 25) {
        zones[static_cast<std::size_t>(k)] = cv::Mat::zeros(size, CV_8U);
        continue;
      }
      zones[static_cast<std::size_t>(k)] = widened(from, std::min(basal ? 15.0 : 5.0, away_mm));
    }
  };
  spread(chambers.lv.front().k, -1);
  spread(chambers.lv.back().k, +1);
  // Thin slices through a leaning ventricle: muscle lies around the cavity in space.
  if (slice_mm < kThickSlicesMm) {
    const std::vector<float> away =
        distance_near(grid, cavities(grid, chambers, ed), true, 1.6 * chambers.wall_mm + 2.0);
    for (std::size_t k = 0; k < n; ++k) {
      const cv::Mat slice(size, CV_32F, const_cast<float*>(away.data()) + k * grid.slice_count());
      zones[k] |= slice <= 1.6 * chambers.wall_mm + 2.0;
    }
  }
  if (slice_mm >= kThickSlicesMm) take_pools_whole(grid, chambers, zones);
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

/// Thick slices: the RV's pool, and what is too far from it and from the LV to be of the heart.
void paint_rv(std::vector<std::uint8_t>& seeds, const Grid& grid, int k, const cv::Mat& pool,
              const cv::Mat& of_lv) {
  const Vec3 spacing = grid.spacing_mm();
  const cv::Point2d pixel_mm(spacing[0], spacing[1]);
  cv::Mat core;
  cv::Mat near;
  cv::erode(pool, core, disc(kRvRimMm, pixel_mm));
  cv::dilate(pool, near, disc(kRvReachMm, pixel_mm));
  paint(seeds, grid, k, ~(near | of_lv), kLabelBackground);
  paint(seeds, grid, k, core, kLabelRvBlood);
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

LabelImages classify(const std::vector<std::uint8_t>& motion, const Chambers& chambers,
                     std::size_t phases) {
  LabelImages classes(phases, motion);
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

TravelCost travel_cost(const TissueLevels& levels, double noise) {
  TravelCost cost(2.5 * levels.blood);
  const double span = levels.blood - levels.muscle;
  const double muscle_end =
      std::clamp(kSurelyNoise * noise / span, kLeastMuscleEnd, kMostMuscleEnd);
  for (int bin = 0; bin < TravelCost::kBins; ++bin) {
    const double intensity = cost.intensity_of(bin);
    const double f = (intensity - levels.muscle) / span;  // 0 muscle, 1 blood
    const bool dark = intensity < levels.dark;
    const double blood = f >= 1.6   ? 1.5
                         : f >= 0.6 ? 0.1
                         : f >= 0.4 ? 0.1 + 5 * (0.6 - f)
                                    : 1.1 + 25 * (0.4 - f);
    double muscle = f <= muscle_end ? 0.25 : std::min(8.0, 0.25 + 18 * (f - muscle_end));
    if (dark) muscle = 1.0 + 4.0 * (levels.dark - intensity) / levels.dark;
    for (int index = 0; index < TravelCost::kClasses; ++index) {
      const int c = index % kBeyondLv;
      const bool beyond_lv = index / kBeyondLv % 2 != 0;
      const bool beyond_rv = index / kBeyondRv != 0;
      const double still_penalty = c == kStill ? 1.5 : 1.0;
      const double b = std::min(blood, kMostCost);
      const bool fat = intensity > levels.fat;
      const double pool = fat ? std::max(b, 1.5) : b;
      const double rest = std::min(pool * 1.2, std::max(0.6, muscle) * still_penalty);
      cost.at(kLabelLvBlood, index, bin) = static_cast<float>(beyond_lv ? kMostCost : b);
      cost.at(kLabelLvMyocardium, index, bin) =
          static_cast<float>(beyond_lv ? kMostCost : muscle * still_penalty);
      cost.at(kLabelRvBlood, index, bin) =
          static_cast<float>(beyond_rv ? std::min(kMostCost, kBeyondPlane * pool) : pool);
      cost.at(kLabelRestOfHeart, index, bin) = static_cast<float>(rest);
      double background = 0.3;
      if (dark) {
        background = 0.1;
      } else if (fat || f > 1.5) {
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
    const cv::Mat quiet = slice_of(grid, motion, k) != kMoving;
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
      pools &= zones[static_cast<std::size_t>(k)];
      for (std::vector<std::uint8_t>& phase : seeds) {
        paint(phase, grid, k, pools, kLabelRestOfHeart);
      }
    }
  }

  const bool across = spacing[2] < kThickSlicesMm;
  double widest_wall = chambers.wall_mm;
  for (const LvSlice& slice : chambers.lv) {
    for (const Ring& ring : slice.rings) widest_wall = std::max(widest_wall, wall_of(ring, 0));
  }
  for (const double wall : chambers.wall_by_phase_mm) widest_wall = std::max(widest_wall, wall);
  std::vector<std::vector<float>> away(n);
  parallel_for(n, [&](std::size_t p) {
    away[p] = distance_near(grid, cavities(grid, chambers, p), across, 1.4 * widest_wall);
  });
  const std::vector<std::vector<cv::Mat>> rv =
      across ? std::vector<std::vector<cv::Mat>>() : rv_through_the_beat(images, chambers);
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

      const auto near_lv = [&] {
        return polygon(size, slice, pixel_mm, [&](std::size_t a) {
          const double run = ring.outer_mm[a] - ring.endo_mm[a] + kRvReachMm;
          return ring.endo_mm[a] + std::clamp(run, kLeastBeyondWalls * wall + kRvReachMm,
                                              kMostBeyondWalls * wall + kRvReachMm);
        });
      };
      if (!across && !rv[p][k].empty()) {
        paint_rv(seeds[p], grid, slice.k, rv[p][k], near_lv());
      } else if (!chambers.rv[k].empty()) {
        if (!across && std::abs(base_k - slice.k) * spacing[2] >= kBaseDescendsMm) {
          // Lost in this phase; but nowhere does it reach farther than in diastole.
          cv::Mat near;
          cv::dilate(chambers.rv[k], near, disc(kRvReachMm, pixel_mm));
          paint(seeds[p], grid, slice.k, ~(near | near_lv()), kLabelBackground);
        }
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

}  // namespace beatlas::segment
