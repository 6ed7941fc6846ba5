#include "pipeline/segment/lv_chain.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"

namespace beatlas::segment {
namespace {

constexpr double kMostWidening = 1.5;      ///< of the pool from slice to slice toward the apex
constexpr double kLeastBeat = 0.2;         ///< of the ventricle's own, relative to a pool's size
constexpr double kLeastChange = 0.05;      ///< of a pool's area: an LV that ejects a tenth has that
constexpr double kMinPoolMm = 3.0;         ///< inscribed radius of a pool worth looking at
constexpr double kMinApicalPoolMm = 1.2;   ///< the same near the apex, among trabeculae
constexpr double kMinWalledShare = 0.5;    ///< of the rays: a ring of muscle
constexpr double kSureWalledShare = 0.65;  ///< needed in the surest slice
constexpr double kMinExtendedShare = 0.25;  ///< with a visible outer edge, on the way to the apex
constexpr double kLvWallMm = 8.0;           ///< thinner median walls count less
constexpr double kLargeAreaMm2 = 1200.0;    ///< larger pools count no more

double area_of(const Candidate& c, int phase) {
  return c.rings[static_cast<std::size_t>(phase)].area_mm2;
}

/// A pool's centre, moved to the centroid of its polygon.
cv::Point2d recentre(const Ring& ring, const cv::Point2d& centre, const cv::Point2d& pixel_mm) {
  std::vector<cv::Point2f> polygon;
  polygon.reserve(Ring::kRays);
  for (int a = 0; a < Ring::kRays; ++a) {
    polygon.emplace_back(ray_point(centre, pixel_mm, a, ring.endo_mm[static_cast<std::size_t>(a)]));
  }
  const cv::Moments m = cv::moments(polygon);
  if (std::abs(m.m00) < 1) return centre;
  return {m.m10 / m.m00, m.m01 / m.m00};
}

/// @param leave_early once it is sure that the pool is none: its rings are not all traced then
Candidate rate(const Setting& s, int k, cv::Point2d centre, const TissueLevels& levels,
               bool leave_early) {
  Candidate c;
  c.k = k;
  const int n = s.images.phase_count();
  c.centre_px = recentre(trace_ring(s.slice(0, k), s.pixel_mm, centre, levels), centre, s.pixel_mm);
  double largest = 0;
  double smallest = 1e30;
  double roundness = 0;
  double thickness = 0;
  for (int p = 0; p < n; ++p) {
    c.rings.push_back(trace_ring(s.slice(p, k), s.pixel_mm, c.centre_px, levels));
    const Ring& ring = c.rings.back();
    c.walled_share += ring.walled_share / n;
    // Most pools are seen to be none before the last phase.
    const double most = c.walled_share + static_cast<double>(n - 1 - p) / n;
    if (leave_early && most < kMinWalledShare - 1e-9) return c;
    roundness += ring.roundness / n;
    thickness += std::min(1.0, ring.median_wall_mm() / kLvWallMm) / n;
    largest = std::max(largest, ring.area_mm2);
    smallest = std::min(smallest, ring.area_mm2);
  }
  const double change = largest > 0 ? 1 - smallest / largest : 0;
  // A round, thick-walled ring that beats: vessels have no ring, fat and liver do not beat, the RV
  // is neither round nor thick.
  c.score = c.walled_share * roundness * roundness * roundness * thickness *
            std::min(1.0, change / 0.3) * std::sqrt(std::min(largest, kLargeAreaMm2));
  if (c.walled_share < kMinWalledShare || change < kLeastChange || roundness < 0.5) c.score = 0;
  return c;
}

/// Centres of blood pools in a slice: well-separated peaks of the distance to its edge.
std::vector<cv::Point2d> pool_centres(const cv::Mat& mask, const cv::Point2d& pixel_mm,
                                      double least_radius_mm) {
  cv::Mat distance;
  cv::distanceTransform(mask, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  std::vector<cv::Point2d> centres;
  while (centres.size() < 12) {
    double value = 0;
    cv::Point at;
    cv::minMaxLoc(distance, nullptr, &value, nullptr, &at);
    if (value * pixel_mm.x < least_radius_mm) break;
    centres.emplace_back(at);
    const double clear_px = std::max(value, 8.0 / pixel_mm.x);
    cv::circle(distance, at, static_cast<int>(std::ceil(clear_px)), cv::Scalar(0), cv::FILLED);
  }
  return centres;
}

}  // namespace

std::vector<std::vector<Candidate>> lv_candidates(const Setting& s, const TissueLevels& levels) {
  const Grid& grid = s.images.grid;
  const auto slices = static_cast<std::size_t>(grid.size[2]);
  std::vector<std::vector<cv::Point2d>> centres(slices);
  parallel_for(slices, [&](std::size_t k) {
    const cv::Mat mask = slice_of(grid, s.stats.low, static_cast<int>(k)) > levels.threshold;
    centres[k] = pool_centres(mask, s.pixel_mm, kMinPoolMm);
  });
  std::vector<std::vector<Candidate>> candidates(slices);
  std::vector<std::pair<std::size_t, std::size_t>> all;  // slice, pool
  for (std::size_t k = 0; k < slices; ++k) {
    candidates[k].resize(centres[k].size());
    for (std::size_t pool = 0; pool < centres[k].size(); ++pool) all.emplace_back(k, pool);
  }
  parallel_for(all.size(), [&](std::size_t at) {
    const auto [k, pool] = all[at];
    candidates[k][pool] = rate(s, static_cast<int>(k), centres[k][pool], levels, true);
  });
  return candidates;
}

std::vector<Candidate> best_chain(const std::vector<std::vector<Candidate>>& slices,
                                  const Setting& s) {
  struct Link {
    double score = 0;
    int from = -1;
  };
  std::vector<std::vector<Link>> links(slices.size());
  double best = 0;
  std::pair<int, int> end{-1, -1};
  for (std::size_t k = 0; k < slices.size(); ++k) {
    for (const Candidate& c : slices[k]) {
      Link link{c.score, -1};
      for (std::size_t f = 0; k > 0 && f < slices[k - 1].size(); ++f) {
        const cv::Point2d d = c.centre_px - slices[k - 1][f].centre_px;
        const double shift = std::hypot(d.x * s.pixel_mm.x, d.y * s.pixel_mm.y);
        // An axis may lean; centres also jitter by a few millimetres.
        const double excess = std::max(0.0, shift - 1.2 * s.slice_mm - 2.0);
        const double total = links[k - 1][f].score + c.score * std::exp(-excess / 3.0);
        if (c.score > 0 && total > link.score && excess < 8) {
          link = {total, static_cast<int>(f)};
        }
      }
      links[k].push_back(link);
      if (c.score > 0 && link.score > best) {
        best = link.score;
        end = {static_cast<int>(k), static_cast<int>(links[k].size()) - 1};
      }
    }
  }
  std::vector<Candidate> chain;
  for (auto [k, c] = end; k >= 0 && c >= 0; --k) {
    const auto ks = static_cast<std::size_t>(k);
    chain.push_back(slices[ks][static_cast<std::size_t>(c)]);
    c = links[ks][static_cast<std::size_t>(c)].from;
  }
  std::reverse(chain.begin(), chain.end());
  return chain;
}

void extend_chain(std::vector<Candidate>& chain, const Setting& s, const TissueLevels& heart_levels,
                  int step, int reference_phase) {
  while (true) {
    const Candidate& last = step > 0 ? chain.back() : chain.front();
    const int k = last.k + step;
    if (k < 0 || k >= s.images.grid.size[2]) return;
    const cv::Mat image = s.slice(reference_phase, k);
    // Trabeculae and partial volume dim the apical pool: its own brightest part sets the level.
    cv::Mat near = cv::Mat::zeros(image.size(), CV_8U);
    cv::circle(near, cv::Point(last.centre_px), static_cast<int>(10.0 / s.pixel_mm.x),
               cv::Scalar(255), cv::FILLED);
    double pool = 0;
    cv::minMaxLoc(image, nullptr, &pool, nullptr, nullptr, near);
    TissueLevels levels = heart_levels;
    if (pool < levels.threshold) return;
    levels.blood = std::min(levels.blood, pool);
    levels.threshold = 0.5 * (levels.blood + levels.muscle);
    cv::Mat reach = cv::Mat::zeros(image.size(), CV_8U);
    cv::circle(reach, cv::Point(last.centre_px),
               static_cast<int>((1.2 * s.slice_mm + 12.0) / s.pixel_mm.x), cv::Scalar(255),
               cv::FILLED);
    const cv::Mat mask = (image > levels.threshold) & reach;
    cv::Point2d best;
    double best_share = 0;
    for (const cv::Point2d& centre : pool_centres(mask, s.pixel_mm, kMinApicalPoolMm)) {
      const cv::Point2d d = centre - last.centre_px;
      if (std::hypot(d.x * s.pixel_mm.x, d.y * s.pixel_mm.y) > 1.2 * s.slice_mm + 4.0) continue;
      const Ring ring = trace_ring(image, s.pixel_mm, centre, levels);
      if (ring.walled_share < kMinExtendedShare || ring.roundness < 0.5) continue;
      // Near the apex the liver or chest wall may hide the outer edge: dark is enough there.
      const double share = ring.muscle_share();
      if (share > best_share) {
        best_share = share;
        best = centre;
      }
    }
    const Ring& before = last.rings[static_cast<std::size_t>(reference_phase)];
    if (best_share < kSureWalledShare) return;
    Candidate next = rate(s, k, best, levels, false);
    // Towards the apex pools shrink; a pool that grows again is another one.
    if (next.rings[static_cast<std::size_t>(reference_phase)].area_mm2 > 1.3 * before.area_mm2) {
      return;
    }
    if (step > 0) {
      chain.push_back(std::move(next));
    } else {
      chain.insert(chain.begin(), std::move(next));
    }
  }
}

std::vector<double> beats(const std::vector<Candidate>& chain) {
  std::vector<double> out(chain.size(), 0);
  const std::size_t phases = chain.empty() ? 0 : chain.front().rings.size();
  std::vector<double> all(phases, 0);
  for (const Candidate& c : chain) {
    for (std::size_t p = 0; p < phases; ++p) all[p] += c.score * c.rings[p].area_mm2;
  }
  const auto count = static_cast<double>(phases);
  const double mean = std::accumulate(all.begin(), all.end(), 0.0) / count;
  double square = 0;
  for (const double area : all) square += (area - mean) * (area - mean);
  for (std::size_t n = 0; n < chain.size(); ++n) {
    double product = 0;
    double own = 0;
    for (std::size_t p = 0; p < phases; ++p) {
      product += (all[p] - mean) * chain[n].rings[p].area_mm2;
      own += chain[n].rings[p].area_mm2 / count;
    }
    if (square > 0 && own > 0) out[n] = product / square * mean / own;
  }
  return out;
}

int side_of_base(const std::vector<Candidate>& chain, int end_diastole) {
  const std::vector<double> beat = beats(chain);
  double sum = 0;
  double mean_k = 0;
  double mean_area = 0;
  const auto weight = [&](std::size_t n) { return beat[n] >= kLeastBeat ? chain[n].score : 0; };
  for (std::size_t n = 0; n < chain.size(); ++n) {
    sum += weight(n);
    mean_k += weight(n) * chain[n].k;
    mean_area += weight(n) * area_of(chain[n], end_diastole);
  }
  double widens = 0;
  for (std::size_t n = 0; n < chain.size(); ++n) {
    widens += weight(n) * (chain[n].k - mean_k / sum) *
              (area_of(chain[n], end_diastole) - mean_area / sum);
  }
  return widens >= 0 ? 1 : -1;
}

void drop_others(std::vector<Candidate>& chain, int base_step, int end_diastole) {
  if (base_step < 0) std::reverse(chain.begin(), chain.end());  // from the apex to the base
  while (chain.size() > 2 &&
         area_of(chain[0], end_diastole) > kMostWidening * area_of(chain[1], end_diastole) &&
         chain[0].score < chain[1].score) {
    chain.erase(chain.begin());
  }
  std::vector<double> beat = beats(chain);
  while (chain.size() > 2 && beat.back() < kLeastBeat && beat[beat.size() - 2] < kLeastBeat) {
    chain.pop_back();
    beat.pop_back();
  }
  if (base_step < 0) std::reverse(chain.begin(), chain.end());
}

double chain_score(const std::vector<Candidate>& chain) {
  return std::accumulate(chain.begin(), chain.end(), 0.0,
                         [](double sum, const Candidate& c) { return sum + c.score; });
}

double total_area(const std::vector<Candidate>& chain, int phase) {
  return std::accumulate(chain.begin(), chain.end(), 0.0, [&](double sum, const Candidate& c) {
    return sum + c.rings[static_cast<std::size_t>(phase)].area_mm2;
  });
}

}  // namespace beatlas::segment
