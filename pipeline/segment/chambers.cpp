#include "pipeline/segment/chambers.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/segment/lv_chain.h"
#include "pipeline/segment/rv_pools.h"

namespace beatlas::segment {
namespace {

constexpr double kSureWalledShare = 0.65;  ///< needed in the surest slice
constexpr double kMostSlope = 0.12;        ///< across a wall, of blood's height over muscle
constexpr double kLeastWallPx = 2.5;       ///< thinner rings are rims of mixed pixels
constexpr int kMostRounds = 3;             ///< of levels from a chain and a chain from levels
constexpr double kSettled = 0.1;           ///< of blood's height over muscle: no new chain
constexpr double kMinRvContact = 0.08;     ///< of the rays: about 30 degrees of septum

double median_of(std::vector<float> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

TissueLevels levels_at(double threshold, const std::vector<float>& values) {
  TissueLevels levels;
  levels.threshold = threshold;
  std::vector<float> bright;
  for (float value : values) {
    if (value > threshold) bright.push_back(value);
  }
  levels.blood = median_of(bright);
  levels.rv_blood = levels.blood;
  levels.dark = 0.12 * levels.blood;
  return levels;
}

std::vector<float> moving_values(const Setting& s) {
  std::vector<float> sorted = s.stats.swing;
  const auto at =
      sorted.begin() + static_cast<std::ptrdiff_t>(static_cast<double>(sorted.size()) * 0.9);
  std::nth_element(sorted.begin(), at, sorted.end());
  const float moving = *at;
  std::vector<std::size_t> voxels;
  for (std::size_t v = 0; v < s.stats.swing.size(); ++v) {
    if (s.stats.swing[v] >= moving) voxels.push_back(v);
  }
  std::vector<float> values(voxels.size() * s.smooth.size());
  parallel_for(s.smooth.size(), [&](std::size_t p) {
    std::transform(voxels.begin(), voxels.end(),
                   values.begin() + static_cast<std::ptrdiff_t>(voxels.size() * p),
                   [&](std::size_t v) { return s.smooth[p][v]; });
  });
  return values;
}

/// Blood against the rest from voxels that move: they are blood in one phase and wall in another.
TissueLevels first_levels(const std::vector<float>& moving) {
  return levels_at(otsu_threshold(moving), moving);
}

/// The same among what is brighter than a first threshold.
TissueLevels levels_above(std::vector<float> moving, const TissueLevels& first) {
  std::erase_if(moving, [&](float value) { return value <= first.threshold; });
  return levels_at(otsu_threshold(moving), moving);
}

/// Nearest pixel's value at `radius_mm` along ray `a`.
float ray_value(const Setting& s, const cv::Mat& image, const cv::Point2d& centre_px, int a,
                double radius_mm) {
  const cv::Point2d at = ray_point(centre_px, s.pixel_mm, a, radius_mm);
  return image.at<float>(std::clamp(static_cast<int>(std::lround(at.y)), 0, image.rows - 1),
                         std::clamp(static_cast<int>(std::lround(at.x)), 0, image.cols - 1));
}

/// Whether the rings are of muscle, not the rim of mixed pixels around any bright body: thicker
/// than that (two pixels), and level across the wall, not a slope from bright to dark.
bool has_wall(const std::vector<Candidate>& chain, const Setting& s, const TissueLevels& levels) {
  std::vector<float> walls;
  std::vector<float> slopes;
  for (const Candidate& c : chain) {
    for (std::size_t p = 0; p < c.rings.size(); ++p) {
      const Ring& ring = c.rings[p];
      walls.push_back(static_cast<float>(ring.median_wall_mm()));
      const cv::Mat image = s.slice(static_cast<int>(p), c.k);
      for (int a = 0; a < Ring::kRays; ++a) {
        const auto i = static_cast<std::size_t>(a);
        if (!ring.walled[i]) continue;
        const auto value = [&](double share) {
          const double radius = (1 - share) * ring.endo_mm[i] + share * ring.outer_mm[i];
          return ray_value(s, image, c.centre_px, a, radius);
        };
        slopes.push_back(value(0.25) - value(0.75));
      }
    }
  }
  return median_of(walls) >= kLeastWallPx * std::max(s.pixel_mm.x, s.pixel_mm.y) &&
         median_of(slopes) <= kMostSlope * (levels.blood - levels.muscle);
}

/// Muscle's level from mid-wall samples of the rings, then the thresholds that follow.
TissueLevels refine_levels(const Setting& s, const std::vector<Candidate>& chain,
                           TissueLevels levels) {
  std::vector<float> muscle;
  std::vector<float> blood;
  for (const Candidate& c : chain) {
    for (int p = 0; p < s.images.phase_count(); ++p) {
      const cv::Mat image = s.slice(p, c.k);
      const Ring& ring = c.rings[static_cast<std::size_t>(p)];
      for (int a = 0; a < Ring::kRays; ++a) {
        const auto i = static_cast<std::size_t>(a);
        if (!ring.walled[i]) continue;
        muscle.push_back(
            ray_value(s, image, c.centre_px, a, 0.5 * (ring.endo_mm[i] + ring.outer_mm[i])));
        blood.push_back(ray_value(s, image, c.centre_px, a, 0.5 * ring.endo_mm[i]));
      }
    }
  }
  levels.muscle = median_of(muscle);
  levels.blood = median_of(blood);
  levels.rv_blood = levels.blood;
  levels.threshold = 0.5 * (levels.muscle + levels.blood);
  levels.dark = 0.5 * levels.muscle;
  return levels;
}

/// Parts of a slice's always-bright mask whose rim moves: chambers of the heart, not fat or liver.
cv::Mat moving_parts(const cv::Mat& always, const cv::Mat& swing, double moving,
                     const cv::Point2d& pixel_mm) {
  cv::Mat parts = cv::Mat::zeros(always.size(), CV_8U);
  cv::Mat ids;
  const int count = cv::connectedComponents(always, ids, 4);
  const cv::Mat ball = disc(2.5, pixel_mm);
  for (int id = 1; id < count; ++id) {
    const cv::Mat part = ids == id;
    cv::Mat grown;
    cv::dilate(part, grown, ball);
    const cv::Mat rim = grown & ~part;
    const cv::Mat moving_rim = rim & (swing > moving);
    const int rim_size = cv::countNonZero(rim);
    if (rim_size > 0 && cv::countNonZero(moving_rim) > 0.45 * rim_size) parts |= part;
  }
  return parts;
}

/// RV at end-diastole: the blood that leans on the outside of the LV's ring.
cv::Mat find_rv(const Setting& s, const LvSlice& lv, const TissueLevels& levels, int phase,
                double* contact_share) {
  const cv::Mat image = s.slice(phase, lv.k);
  const Ring& ring = lv.rings[static_cast<std::size_t>(phase)];
  cv::Mat mask = (image > levels.threshold) & (image < 1.45 * levels.blood);
  std::vector<cv::Point> lv_polygon;
  for (int a = 0; a < Ring::kRays; ++a) {
    const auto i = static_cast<std::size_t>(a);
    const double wall = ring.walled[i] ? 0.5 * (ring.outer_mm[i] - ring.endo_mm[i]) : 2.0;
    const cv::Point2d at = ray_point(lv.centre_px, s.pixel_mm, a, ring.endo_mm[i] + wall);
    lv_polygon.emplace_back(static_cast<int>(std::lround(at.x)),
                            static_cast<int>(std::lround(at.y)));
  }
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{lv_polygon}, cv::Scalar(0));
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, disc(3.0, s.pixel_mm));
  cv::Mat ids;
  const int count = cv::connectedComponents(mask, ids, 4);
  std::vector<int> hits(static_cast<std::size_t>(count), 0);
  for (int a = 0; a < Ring::kRays; ++a) {
    const auto i = static_cast<std::size_t>(a);
    if (!ring.walled[i]) continue;
    for (double beyond = 1.0; beyond <= 5.0; beyond += 1.0) {
      const cv::Point2d at = ray_point(lv.centre_px, s.pixel_mm, a, ring.outer_mm[i] + beyond);
      const cv::Point px(static_cast<int>(std::lround(at.x)), static_cast<int>(std::lround(at.y)));
      if (px.x < 0 || px.y < 0 || px.x >= ids.cols || px.y >= ids.rows) break;
      const int id = ids.at<int>(px);
      if (id > 0) {
        ++hits[static_cast<std::size_t>(id)];
        break;
      }
    }
  }
  int best = 0;
  double best_rating = 0;
  for (int id = 1; id < count; ++id) {
    const double share = static_cast<double>(hits[static_cast<std::size_t>(id)]) / Ring::kRays;
    if (share < kMinRvContact) continue;
    const double area = cv::countNonZero(ids == id) * s.pixel_mm.x * s.pixel_mm.y;
    const double rating = share * std::sqrt(area);
    if (rating > best_rating) {
      best_rating = rating;
      best = id;
      *contact_share = share;
    }
  }
  return best > 0 ? cv::Mat(ids == best) : cv::Mat::zeros(mask.size(), CV_8U);
}

}  // namespace

void adopt_lv_slice(Chambers& chambers, const ImageCycle<float>& images, int k,
                    const cv::Point2d& centre_px) {
  const auto at = std::find_if(chambers.lv.begin(), chambers.lv.end(),
                               [&](const LvSlice& slice) { return slice.k >= k; });
  if (!chambers.found_lv() || (at != chambers.lv.end() && at->k == k)) return;
  LvSlice slice{k, centre_px, {}};
  const Vec3 spacing = images.grid.spacing_mm();
  for (const std::vector<float>& phase : images.phases) {
    slice.rings.push_back(trace_ring(slice_of(images.grid, phase, k), {spacing[0], spacing[1]},
                                     centre_px, chambers.levels));
  }
  chambers.lv.insert(at, std::move(slice));
}

cv::Mat disc(double radius_mm, const cv::Point2d& pixel_mm) {
  const int rx = std::max(1, static_cast<int>(std::lround(radius_mm / pixel_mm.x)));
  const int ry = std::max(1, static_cast<int>(std::lround(radius_mm / pixel_mm.y)));
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * rx + 1, 2 * ry + 1});
}

cv::Rect rect_around(const cv::Mat& mask, int room_px) {
  const cv::Rect around = cv::boundingRect(mask);
  if (around.empty()) return {};
  return (around - cv::Point(room_px, room_px) + cv::Size(2 * room_px, 2 * room_px)) &
         cv::Rect({0, 0}, mask.size());
}

cv::Mat slice_of(const Grid& grid, const std::vector<float>& image, int k) {
  return {grid.size[1], grid.size[0], CV_32F,
          const_cast<float*>(image.data() + grid.offset(0, 0, k))};
}

cv::Mat slice_of(const Grid& grid, const std::vector<std::uint8_t>& image, int k) {
  return {grid.size[1], grid.size[0], CV_8U,
          const_cast<std::uint8_t*>(image.data() + grid.offset(0, 0, k))};
}

Chambers find_chambers(const ImageCycle<float>& images, const TemporalStats& stats,
                       StageContext& context) {
  const Grid& grid = images.grid;
  const Vec3 spacing = grid.spacing_mm();
  Setting s{images, stats, {}, {spacing[0], spacing[1]}, spacing[2]};
  s.smooth.resize(images.phases.size());
  parallel_for(images.phases.size(), [&](std::size_t p) {
    s.smooth[p] = smooth_in_plane(grid, images.phases[p], 0.7 * std::max(spacing[0], spacing[1]));
  });
  Chambers out;
  std::vector<float> values = moving_values(s);
  out.levels = first_levels(values);

  // Moving voxels hold two edges, blood on muscle and muscle on lung; which of them Otsu's
  // threshold meets depends on the images, so the one above it is tried too.
  std::vector<Candidate> chain;
  const TissueLevels first = out.levels;
  for (const TissueLevels& levels : {first, levels_above(std::move(values), first)}) {
    std::vector<Candidate> found = best_chain(lv_candidates(s, levels), s);
    if (found.empty()) continue;
    // The first chain may be in another chamber, whose levels are not the LV's.
    TissueLevels refined = levels;
    for (int round = 0; round < kMostRounds && !found.empty(); ++round) {
      const TissueLevels before = refined;
      refined = refine_levels(s, found, before);
      const double moved = std::abs(refined.threshold - before.threshold);
      if (round > 0 && moved < kSettled * (refined.blood - refined.muscle)) break;
      found = best_chain(lv_candidates(s, refined), s);
    }
    if (chain_score(found) > chain_score(chain)) {
      chain = std::move(found);
      out.levels = refined;
    }
  }
  const bool sure = std::any_of(chain.begin(), chain.end(), [](const Candidate& c) {
    return c.walled_share >= kSureWalledShare;
  });
  if (!sure || !has_wall(chain, s, out.levels)) {
    chain.clear();
    out.levels = first;  // what was taken for muscle was none
  }

  std::vector<float> sorted = stats.swing;
  const auto top =
      sorted.begin() + static_cast<std::ptrdiff_t>(static_cast<double>(sorted.size()) * 0.99);
  std::nth_element(sorted.begin(), top, sorted.end());
  const double moving = 0.25 * *top;
  for (int k = 0; k < grid.size[2]; ++k) {
    out.always_blood.push_back(slice_of(grid, stats.low, k) > out.levels.threshold);
    out.always_blood_moving.push_back(
        moving_parts(out.always_blood.back(), slice_of(grid, stats.swing, k), moving, s.pixel_mm));
  }
  if (chain.empty()) {
    out.levels.dark = 0.35 * out.levels.blood;  // no muscle is known: half-way is the threshold
    out.wall_by_phase_mm.assign(images.phases.size(), 0);
    return out;
  }

  const int n = images.phase_count();
  const auto find_ends = [&] {
    for (int p = 0; p < n; ++p) {
      if (total_area(chain, p) > total_area(chain, out.end_diastole)) out.end_diastole = p;
      if (total_area(chain, p) < total_area(chain, out.end_systole)) out.end_systole = p;
    }
  };
  find_ends();
  out.base_step = side_of_base(chain, out.end_diastole);
  drop_others(chain, out.base_step, out.end_diastole);
  extend_chain(chain, s, out.levels, -out.base_step, out.end_diastole);
  find_ends();

  for (const Candidate& c : chain) {
    out.lv.push_back({c.k, c.centre_px, c.rings});
  }
  for (int p = 0; p < n; ++p) {
    std::vector<float> walls;
    for (const LvSlice& slice : out.lv) {
      const double wall = slice.rings[static_cast<std::size_t>(p)].median_wall_mm();
      if (wall > 0) walls.push_back(static_cast<float>(wall));
    }
    out.wall_by_phase_mm.push_back(median_of(walls));
  }
  out.wall_mm = out.wall_by_phase_mm[static_cast<std::size_t>(out.end_diastole)];

  std::vector<float> rv_blood;
  out.rv.assign(static_cast<std::size_t>(grid.size[2]), cv::Mat());
  const bool thick = s.slice_mm >= kThickSlicesMm;
  if (thick) out.rv = rv_at_end_diastole(s, out);
  for (const LvSlice& slice : out.lv) {
    cv::Mat& rv = out.rv[static_cast<std::size_t>(slice.k)];
    double contact = 0;
    if (!thick) rv = find_rv(s, slice, out.levels, out.end_diastole, &contact);
    if (cv::countNonZero(rv) == 0) {
      rv = cv::Mat();
      continue;
    }
    const cv::Mat image = s.slice(out.end_diastole, slice.k);
    for (int j = 0; j < rv.rows; ++j) {
      for (int i = 0; i < rv.cols; ++i) {
        if (rv.at<std::uint8_t>(j, i)) rv_blood.push_back(image.at<float>(j, i));
      }
    }
  }
  if (!rv_blood.empty()) out.levels.rv_blood = median_of(rv_blood);
  std::ostringstream line;
  line << "left ventricle in slices " << chain.front().k << ".." << chain.back().k
       << " of the heart's box, wall " << out.wall_mm << " mm, blood " << out.levels.blood
       << ", muscle " << out.levels.muscle;
  context.log(line.str());
  return out;
}

}  // namespace beatlas::segment
