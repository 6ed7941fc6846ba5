#include "pipeline/segment/anatomy.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/segment/connected.h"
#include "pipeline/segment/distance_map.h"
#include "pipeline/segment/known_outlines.h"

namespace beatlas::segment {
namespace {

constexpr double kPapillaryMm = 8.0;  ///< radius of the closing that takes papillary muscles in
constexpr double kSeptumMm = 6.0;  ///< farthest the RV lies from labelled LV muscle at the septum
/// Outer outlines in thick slices, where fat and liver blur into the wall, are smoothed this much
/// more.
constexpr double kThickOutsideFactor = 1.75;
constexpr double kAtrialWallMm = 3.0;
constexpr double kFarOfWall = 1.35;   ///< walls away from the cavity, and
constexpr double kFarBeyondMm = 1.0;  ///< this much: that is no muscle of the LV
constexpr double kAtriaBelowMm = 10;  ///< how far atria bulge down beside the ventricles
constexpr double kFatMm = 4.5;        ///< radius that no layer of fat on the heart holds
constexpr double kGivenSigmaPx = 1;   ///< takes the steps of pixels from a given outline
constexpr double kRvWallMm = 4.0;     ///< thickest RV wall where no outer edge shows
constexpr double kLeastRing = 0.5;    ///< of the rays that meet muscle: less is no ventricle
constexpr double kVesselShare = 0.1;  ///< of an atrium, the least section of a vessel beside it
constexpr double kGapShare = 0.5;     ///< of a gap, as dark as lung or as bright as fat
constexpr double kFarOutsideMm = 30;  ///< farther from an outline is as far

cv::Mat fill_holes(const cv::Mat& mask) {
  cv::Mat framed;
  cv::copyMakeBorder(mask, framed, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::floodFill(framed, {0, 0}, cv::Scalar(128));
  return cv::Mat(framed != 128)(cv::Rect(1, 1, mask.cols, mask.rows)).clone();
}

/// Of what filling adds, the parts that hold lung or fat: gaps between chambers that a slice cuts
/// all round.
cv::Mat gaps_between(const cv::Mat& added, const cv::Mat& pixels, const TissueLevels& levels) {
  cv::Mat ids;
  cv::Mat foreign;
  const int count = cv::connectedComponents(added, ids, 4);
  cv::bitwise_or(pixels<levels.dark, pixels> levels.fat, foreign);
  cv::Mat gaps = cv::Mat::zeros(added.size(), CV_8U);
  for (int id = 1; id < count; ++id) {
    const cv::Mat part = ids == id;
    if (cv::mean(pixels, part)[0] < levels.dark || cv::mean(foreign, part)[0] > kGapShare * 255) {
      gaps |= part;
    }
  }
  return gaps;
}

/// Closing that does not bleed over the image's border.
cv::Mat close_mask(const cv::Mat& mask, double radius_mm, const cv::Point2d& pixel_mm) {
  cv::Mat out;
  cv::morphologyEx(mask, out, cv::MORPH_CLOSE, disc(radius_mm, pixel_mm), {-1, -1}, 1,
                   cv::BORDER_CONSTANT, cv::Scalar(0));
  return out | mask;
}

cv::Mat distance_from(const cv::Mat& mask, const cv::Point2d& pixel_mm) {
  cv::Mat distance;
  if (cv::countNonZero(mask) == 0) return cv::Mat(mask.size(), CV_32F, cv::Scalar(1e6));
  cv::distanceTransform(mask == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance * std::sqrt(pixel_mm.x * pixel_mm.y);
}

/// Components of at least `share` of the largest one's area.
cv::Mat keep_large(const cv::Mat& mask, double share) {
  cv::Mat ids;
  cv::Mat stats;
  cv::Mat centroids;
  const int count = cv::connectedComponentsWithStats(mask, ids, stats, centroids, 4);
  int largest = 0;
  for (int id = 1; id < count; ++id)
    largest = std::max(largest, stats.at<int>(id, cv::CC_STAT_AREA));
  cv::Mat kept = cv::Mat::zeros(mask.size(), CV_8U);
  for (int id = 1; id < count; ++id) {
    if (stats.at<int>(id, cv::CC_STAT_AREA) >= share * largest) kept |= ids == id;
  }
  return kept;
}

/// Components that come near `mask` somewhere: the RV shares its septum with the LV.
cv::Mat keep_near(const cv::Mat& parts, const cv::Mat& mask, const cv::Point2d& pixel_mm) {
  const cv::Mat near = distance_from(mask, pixel_mm) <= kSeptumMm;
  cv::Mat ids;
  const int count = cv::connectedComponents(parts, ids, 4);
  cv::Mat kept = cv::Mat::zeros(parts.size(), CV_8U);
  for (int id = 1; id < count; ++id) {
    const cv::Mat part = ids == id;
    if (cv::countNonZero(part & near) > 0) kept |= part;
  }
  return kept;
}

cv::Mat convex_hull(const cv::Mat& mask) {
  cv::Mat hull = cv::Mat::zeros(mask.size(), CV_8U);
  std::vector<cv::Point> points;
  cv::findNonZero(mask, points);
  if (points.empty()) return hull;
  std::vector<cv::Point> outline;
  cv::convexHull(points, outline);
  cv::fillConvexPoly(hull, outline, cv::Scalar(255));
  return hull;
}

/// The cavity with its papillary muscles: its convex hull, unless that adds so much that the
/// section is not a convex one; then a closing.
cv::Mat take_in_papillaries(const cv::Mat& lv, const cv::Point2d& pixel_mm) {
  const cv::Mat closed = fill_holes(close_mask(lv, kPapillaryMm, pixel_mm));
  const cv::Mat hull = convex_hull(lv);
  return cv::countNonZero(hull) < 1.3 * cv::countNonZero(closed) ? hull : closed;
}

using Mask = std::vector<std::uint8_t>;

/// Adds to `region` what can be reached from it through `candidates` no farther than `reach_mm`
/// from where it began (`distance`), face to face, within slices or across them.
void grow_into(const Grid& grid, Mask& region, const Mask& candidates,
               const std::vector<float>& distance, double reach_mm, bool across_slices) {
  std::vector<std::size_t> front;
  for (std::size_t v = 0; v < region.size(); ++v) {
    if (region[v] != 0) front.push_back(v);
  }
  const auto nx = static_cast<std::size_t>(grid.size[0]);
  const std::size_t slice = grid.slice_count();
  while (!front.empty()) {
    const std::size_t v = front.back();
    front.pop_back();
    const auto visit = [&](std::size_t to) {
      if (region[to] != 0 || candidates[to] == 0 || distance[to] > reach_mm) return;
      region[to] = 255;
      front.push_back(to);
    };
    if (v % nx > 0) visit(v - 1);
    if (v % nx + 1 < nx) visit(v + 1);
    if (v % slice >= nx) visit(v - nx);
    if (v % slice + nx < slice) visit(v + nx);
    if (!across_slices) continue;
    if (v >= slice) visit(v - slice);
    if (v + slice < region.size()) visit(v + slice);
  }
}

/// Atria and great vessels: pools of the rest of the heart about the base planes and beyond. Fat on
/// the heart is as bright, but a thinner layer than a pool.
Mask find_atria(const Grid& grid, const std::vector<float>& image, const Chambers& chambers,
                int phase, const std::vector<std::uint8_t>& labels) {
  const auto p = static_cast<std::size_t>(phase);
  const double lowest =
      std::min(chambers.axis->lv_base_mm[p], chambers.axis->rv_base_mm[p]) - kAtriaBelowMm;
  Mask pools(labels.size());
  for (std::size_t v = 0; v < labels.size(); ++v) {
    const bool pool = labels[v] == kLabelRestOfHeart && image[v] > chambers.levels.threshold &&
                      static_cast<double>(chambers.height_mm[v]) > lowest;
    pools[v] = pool ? 255 : 0;
  }
  const std::vector<float> depth = depth_within(grid, pools, true);
  Mask cores(labels.size());
  for (std::size_t v = 0; v < labels.size(); ++v) cores[v] = depth[v] > kFatMm ? 255 : 0;
  const std::vector<float> to_core = distance_near(grid, cores, true, kFatMm + 1);
  for (std::size_t v = 0; v < labels.size(); ++v) {
    if (to_core[v] > kFatMm + 1) pools[v] = 0;
  }
  return pools;
}

}  // namespace

void tidy_phase(const Grid& grid, const std::vector<float>& image, const Chambers& chambers,
                int phase, const std::vector<std::uint8_t>& drawn,
                std::vector<std::uint8_t>& labels) {
  const Vec3 spacing = grid.spacing_mm();
  const cv::Point2d pixel_mm(spacing[0], spacing[1]);
  const TissueLevels& levels = chambers.levels;
  if (!chambers.found_lv()) {
    for (int k = 0; k < grid.size[2]; ++k) {
      cv::Mat slice = slice_of(grid, labels, k);
      cv::Mat heart = slice != kLabelBackground;
      cv::morphologyEx(heart, heart, cv::MORPH_OPEN, disc(2.0, pixel_mm), {-1, -1}, 1,
                       cv::BORDER_CONSTANT, cv::Scalar(0));
      heart = fill_holes(close_mask(heart, 3.0, pixel_mm));
      slice.setTo(cv::Scalar(kLabelBackground), heart == 0);
      slice.setTo(cv::Scalar(kLabelRestOfHeart), heart & (slice == kLabelBackground));
    }
    return;
  }
  const bool across = spacing[2] < kThickSlicesMm;
  const auto is_ventricle = [&](int k) {
    return std::any_of(chambers.lv.begin(), chambers.lv.end(),
                       [&](const LvSlice& s) { return s.k == k; });
  };
  // Walls as seen at this phase; oblique sections make them thicker, never thinner.
  const auto wall_mm = [&](int k) {
    const auto at = std::find_if(chambers.lv.begin(), chambers.lv.end(),
                                 [&](const LvSlice& s) { return s.k == k; });
    if (across || at == chambers.lv.end()) {
      return chambers.wall_by_phase_mm[static_cast<std::size_t>(phase)];
    }
    const Ring& ring = at->rings[static_cast<std::size_t>(phase)];
    return ring.walled_share >= 0.3 ? ring.median_wall_mm() : chambers.wall_mm;
  };

  // Whether blood shows no ring of muscle in a thick slice: beyond the base lie an atrium and the
  // aorta's root, which is the smaller of two pools.
  const auto opens = [&](int k) {
    const auto at = std::find_if(chambers.lv.begin(), chambers.lv.end(),
                                 [&](const LvSlice& s) { return s.k == k; });
    return !across && at != chambers.lv.end() &&
           at->rings[static_cast<std::size_t>(phase)].muscle_share() < kLeastRing;
  };

  // Blood: what the competition carried into dark voxels is wall; papillary muscles are cavity.
  for (int k = 0; k < grid.size[2]; ++k) {
    cv::Mat slice = slice_of(grid, labels, k);
    const cv::Mat pixels = slice_of(grid, image, k);
    const cv::Mat bright = pixels > levels.threshold;
    cv::Mat lv = (slice == kLabelLvBlood) & bright;
    slice.setTo(cv::Scalar(kLabelLvMyocardium), slice == kLabelLvBlood);
    if (cv::countNonZero(lv) > 0) {
      cv::morphologyEx(lv, lv, cv::MORPH_OPEN, disc(0.8, pixel_mm));
      lv = keep_large(lv, opens(k) ? kVesselShare : 0.3);
    }
    lv |= slice_of(grid, drawn, k) == kLabelLvBlood;
    if (cv::countNonZero(lv) > 0) {
      lv = take_in_papillaries(lv, pixel_mm) & ((slice == kLabelLvMyocardium) | lv);
      slice.setTo(cv::Scalar(kLabelLvBlood), lv);
    }
    cv::Mat rv = (slice == kLabelRvBlood) & bright & (pixels < levels.fat);
    slice.setTo(cv::Scalar(kLabelRestOfHeart), slice == kLabelRvBlood);
    if (cv::countNonZero(rv) > 0) {
      cv::Mat core;
      cv::morphologyEx(rv, core, cv::MORPH_OPEN, disc(2.8, pixel_mm));
      cv::morphologyEx(rv, rv, cv::MORPH_OPEN, disc(2.0, pixel_mm));
      if (!across && is_ventricle(k)) {
        // Thick slices blur fat into blood: what hangs on the RV by a thread is not of it.
        core = keep_near(core, (slice == kLabelLvBlood) | (slice == kLabelLvMyocardium), pixel_mm);
        cv::dilate(core, core, disc(9.0, pixel_mm));
        rv &= core;
      }
      rv = keep_large(rv, 0.15);
      const cv::Mat filled = fill_holes(close_mask(rv, 3.0, pixel_mm));
      rv = filled & (slice != kLabelLvBlood) & (slice != kLabelLvMyocardium);
      slice.setTo(cv::Scalar(kLabelRvBlood), rv);
    }
  }

  // Liver or fat hardly darker than blood is none of the ventricle, and gets no wall.
  if (across) (void)keep_connected_rv(grid, labels);

  // The LV's apex is the heart's: between thick slices nothing else carries labels past it.
  if (!across) {
    const int apex_k = chambers.base_step > 0 ? chambers.lv.front().k : chambers.lv.back().k;
    for (int k = 0; k < grid.size[2]; ++k) {
      if (chambers.base_step * (k - apex_k) >= 0) continue;
      cv::Mat slice = slice_of(grid, labels, k);
      slice.setTo(cv::Scalar(kLabelBackground),
                  (slice == kLabelRvBlood) | (slice == kLabelRestOfHeart));
    }
  }

  // Walls: muscle all around the cavities, of a wall's thickness.
  Mask lv(labels.size());
  Mask rv(labels.size());
  for (std::size_t v = 0; v < labels.size(); ++v) {
    lv[v] = labels[v] == kLabelLvBlood ? 255 : 0;
    rv[v] = labels[v] == kLabelRvBlood ? 255 : 0;
  }
  double widest_wall = wall_mm(-1);
  for (int k = 0; k < grid.size[2]; ++k) widest_wall = std::max(widest_wall, wall_mm(k));
  const std::vector<float> to_lv =
      distance_near(grid, lv, across, kFarOfWall * widest_wall + kFarBeyondMm);
  const double rim_mm = 1.5 * std::max(spacing[0], spacing[1]);
  const std::vector<float> to_rv = distance_near(grid, rv, across, std::max(kRvWallMm, rim_mm));
  const Mask atria =
      chambers.parts_atria() ? find_atria(grid, image, chambers, phase, labels) : Mask();
  const std::vector<float> to_atria = chambers.parts_atria()
                                          ? distance_near(grid, atria, across, kAtrialWallMm)
                                          : std::vector<float>();
  const auto lv_base =
      chambers.parts_atria()
          ? static_cast<float>(chambers.axis->lv_base_mm[static_cast<std::size_t>(phase)])
          : 0.F;
  Mask muscle(labels.size());
  for (int k = 0; k < grid.size[2]; ++k) {
    const double wall = wall_mm(k);
    const bool rv_wall_only = across || is_ventricle(k);
    for (std::size_t v = grid.offset(0, 0, k); v < grid.offset(0, 0, k) + grid.slice_count(); ++v) {
      std::uint8_t& label = labels[v];
      const bool lv_here = to_lv[v] < kNoDistance;
      if (label == kLabelLvMyocardium && lv_here && to_lv[v] > kFarOfWall * wall + kFarBeyondMm) {
        label = kLabelBackground;
      }
      const bool atrial = !to_atria.empty() && to_atria[v] <= kAtrialWallMm;
      // Beside the RV's rim of mixed pixels nothing of its wall is bright: that is fat.
      const bool fat = across && image[v] > levels.threshold && to_rv[v] > rim_mm;
      if (label == kLabelRestOfHeart && rv_wall_only && (to_rv[v] > kRvWallMm || fat) && !atrial) {
        label = kLabelBackground;
      }
      const bool free = label == kLabelBackground || label == kLabelRestOfHeart;
      muscle[v] = label == kLabelLvMyocardium ||
                          (free && image[v] > levels.dark && image[v] < levels.threshold)
                      ? 255
                      : 0;
    }
  }
  // Between thick slices a wall's own outline is seen in each; through thin ones the wall runs on
  // past the slices that have a ring, so it may fill up to its thickness there.
  Mask lv_muscle = muscle;
  for (std::size_t v = 0; chambers.parts_atria() && v < labels.size(); ++v) {
    if (chambers.height_mm[v] > lv_base) lv_muscle[v] = 0;
  }
  grow_into(grid, lv, lv_muscle, to_lv, (across ? 1.05 : 0.7) * wall_mm(-1), across);
  for (std::size_t v = 0; v < labels.size(); ++v) {
    const bool free = labels[v] == kLabelBackground || labels[v] == kLabelRestOfHeart;
    if (lv[v] != 0 && free) labels[v] = kLabelLvMyocardium;
    if (labels[v] == kLabelLvMyocardium || labels[v] == kLabelLvBlood) muscle[v] = 0;
  }
  grow_into(grid, rv, muscle, to_rv, kRvWallMm, across);
  if (chambers.parts_atria()) {
    Mask walled = atria;
    grow_into(grid, walled, muscle, to_atria, kAtrialWallMm, across);
    for (std::size_t v = 0; v < labels.size(); ++v) rv[v] |= walled[v];
  }
  for (std::size_t v = 0; v < labels.size(); ++v) {
    if (rv[v] != 0 && labels[v] == kLabelBackground) labels[v] = kLabelRestOfHeart;
  }

  // The outside of each slice.
  for (int k = 0; k < grid.size[2]; ++k) {
    cv::Mat slice = slice_of(grid, labels, k);
    const cv::Mat lv_blood = slice == kLabelLvBlood;
    const cv::Mat rv_blood = slice == kLabelRvBlood;
    cv::Mat lv_outer = lv_blood | (slice == kLabelLvMyocardium);
    if (cv::countNonZero(lv_blood) > 0) {
      cv::morphologyEx(lv_outer, lv_outer, cv::MORPH_OPEN, disc(3.0, pixel_mm), {-1, -1}, 1,
                       cv::BORDER_CONSTANT, cv::Scalar(0));
      lv_outer = keep_large(lv_outer | lv_blood, 0.5);
      slice.setTo(cv::Scalar(kLabelBackground), (slice == kLabelLvMyocardium) & ~lv_outer);
    }
    if (!across && is_ventricle(k) && cv::countNonZero(lv_blood) == 0) {
      // The apex after its cavity has closed: a cap of muscle, whatever trabeculae look like.
      const cv::Mat cap = convex_hull(keep_large(slice == kLabelLvMyocardium, 0.5));
      slice.setTo(cv::Scalar(kLabelLvMyocardium), cap & ~rv_blood);
    }
    cv::Mat heart = slice != kLabelBackground;
    const double opening_mm = across || is_ventricle(k) ? 2.0 : 6.0;
    cv::Mat opened;
    cv::morphologyEx(heart, opened, cv::MORPH_OPEN, disc(opening_mm, pixel_mm), {-1, -1}, 1,
                     cv::BORDER_CONSTANT, cv::Scalar(0));
    const cv::Mat solid = opened | lv_blood | rv_blood;
    heart = close_mask(solid, 3.0, pixel_mm);
    // Grooves between the chambers are filled with muscle, not with fat or lung.
    if (across) {
      const cv::Mat pixels = slice_of(grid, image, k);
      heart &= solid | ((pixels > levels.dark) & (pixels <= levels.threshold));
    }
    const cv::Mat filled = fill_holes(heart);
    heart =
        across ? filled & ~gaps_between(filled & ~heart, slice_of(grid, image, k), levels) : filled;
    slice.setTo(cv::Scalar(kLabelBackground), heart == 0);
    slice.setTo(cv::Scalar(kLabelRestOfHeart), heart & (slice == kLabelBackground));
  }
}

void smooth_outlines(ImageCycle<std::uint8_t>& labels, double sigma_mm, const KnownLabels& known,
                     const SmoothedBefore& before) {
  const Grid& grid = labels.grid;
  const auto n = static_cast<std::size_t>(labels.phase_count());
  const Vec3 spacing = grid.spacing_mm();
  const cv::Point2d pixel_mm(spacing[0], spacing[1]);
  const double step_mm = std::sqrt(spacing[0] * spacing[1]);
  const bool thick = spacing[2] >= kThickSlicesMm;
  // Nested sets, so that each surface is smoothed once: the heart, cavities and the aorta, the LV's
  // outside, its cavity. A later one is painted over those before it.
  struct Set {
    std::uint8_t label;                ///< that it is painted with
    std::vector<std::uint8_t> within;  ///< labels that it holds
  };
  const std::array<Set, 7> sets{{{kLabelRestOfHeart, {1, 2, 3, 4, 5, 6, 7}},
                                 {kLabelAorta, {kLabelAorta}},
                                 {kLabelLaBlood, {kLabelLaBlood}},
                                 {kLabelRaBlood, {kLabelRaBlood}},
                                 {kLabelRvBlood, {kLabelRvBlood}},
                                 {kLabelLvMyocardium, {kLabelLvMyocardium, kLabelLvBlood}},
                                 {kLabelLvBlood, {kLabelLvBlood}}}};
  parallel_for(static_cast<std::size_t>(grid.size[2]), [&](std::size_t k) {
    const std::size_t begin = k * grid.slice_count();
    const auto from = static_cast<std::ptrdiff_t>(begin);
    const auto to = from + static_cast<std::ptrdiff_t>(grid.slice_count());
    std::vector<char> done(n, 0);
    for (std::size_t p = 0; p < n && before.in != nullptr && known.phases.empty(); ++p) {
      std::vector<std::uint8_t>& phase = labels.phases[p];
      const std::vector<std::uint8_t>& then = (*before.in)[p];
      if (!std::equal(phase.begin() + from, phase.begin() + to, then.begin() + from)) continue;
      std::copy_n((*before.out)[p].begin() + from, to - from, phase.begin() + from);
      done[p] = 1;
    }
    std::array<std::vector<cv::Mat>, sets.size()> smooth;
    for (std::size_t set = 0; set < sets.size(); ++set) {
      const bool outside =
          sets[set].label == kLabelRestOfHeart || sets[set].label == kLabelLvMyocardium;
      const double sigma_px = sigma_mm * (thick && outside ? kThickOutsideFactor : 1.0) / step_mm;
      // Farther from the outline than the Gaussian reaches nothing can come below zero.
      const int room = 2 * static_cast<int>(std::ceil(4 * sigma_px + 1)) + 1;
      const auto outline = [&](const std::vector<std::uint8_t>& phase, double smoothing_px) {
        const cv::Mat slice = slice_of(grid, phase, static_cast<int>(k));
        cv::Mat mask = cv::Mat::zeros(slice.size(), CV_8U);
        for (const std::uint8_t label : sets[set].within) mask |= slice == label;
        cv::Mat out(slice.size(), CV_32F, cv::Scalar(kFarOutsideMm));
        const cv::Rect part =
            known.phases.empty() ? rect_around(mask, room) : cv::Rect({0, 0}, mask.size());
        if (part.empty()) return out;
        mask = mask(part);
        const cv::Mat d = distance_from(mask, pixel_mm) - distance_from(~mask, pixel_mm);
        cv::Mat smoothed;
        cv::GaussianBlur(cv::min(cv::max(d, -kFarOutsideMm), kFarOutsideMm), smoothed, {0, 0},
                         smoothing_px);
        smoothed.copyTo(out(part));
        return out;
      };
      std::vector<cv::Mat> signed_distance(n);
      for (std::size_t p = 0; p < n; ++p) {
        if (done[p] == 0) signed_distance[p] = outline(labels.phases[p], sigma_px);
      }
      if (!known.phases.empty()) {
        std::vector<cv::Mat> given;
        for (const std::vector<std::uint8_t>& phase : known.labels.phases) {
          given.push_back(outline(phase, kGivenSigmaPx));
        }
        follow_known_outlines(signed_distance, known.phases, given, step_mm);
      }
      smooth[set] = std::move(signed_distance);
    }
    for (std::size_t p = 0; p < n; ++p) {
      if (done[p] != 0) continue;
      cv::Mat slice = slice_of(grid, labels.phases[p], static_cast<int>(k));
      slice.setTo(cv::Scalar(kLabelBackground));
      for (std::size_t set = 0; set < sets.size(); ++set) {
        slice.setTo(cv::Scalar(sets[set].label), smooth[set][p] < 0);
      }
    }
  });
}

}  // namespace beatlas::segment
