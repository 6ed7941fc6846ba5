#include "pipeline/segment/long_axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/segment/chambers.h"
#include "pipeline/segment/valves.h"

namespace beatlas::segment {
namespace {

constexpr double kPlaneMm = 150;       ///< edge of a section
constexpr double kPixelMm = 1.5;       ///< of a section
constexpr double kSureRing = 0.65;     ///< walled share of a ring that the axis is fitted to
constexpr double kLeastRing = 0.5;     ///< of the rays: what technicians ask for
constexpr double kThickOfWall = 0.6;   ///< of the ventricle's wall: thinner ones are an atrium's
constexpr double kStepMm = 1.0;        ///< between sections on the way to the base
constexpr double kMostShiftMm = 2.0;   ///< of the pool's centre from one millimetre to the next
constexpr double kLeastPool = 0.55;    ///< of the last rings' area: less is no cavity but a gap
constexpr double kBeyondMm = 6.0;      ///< past the base, where an atrium would be blood
constexpr double kLeastAtrium = 0.35;  ///< of the section of the pool, that has to be blood there

/// Linear between voxels, x in voxels; not a number outside the images.
float linear(const Grid& grid, const std::vector<float>& image, const Vec3& x) {
  Index3 low{};
  std::array<double, 3> w{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double at = x[static_cast<Eigen::Index>(a)];
    if (!(at >= 0 && at <= grid.size[a] - 1)) return std::numeric_limits<float>::quiet_NaN();
    low[a] = std::min(static_cast<int>(at), std::max(0, grid.size[a] - 2));
    w[a] = at - low[a];
  }
  // An axis of one voxel has no upper neighbour, and then no weight there.
  const std::size_t di = grid.size[0] > 1 ? 1 : 0;
  const std::size_t dj = grid.size[1] > 1 ? static_cast<std::size_t>(grid.size[0]) : 0;
  const std::size_t dk = grid.size[2] > 1 ? grid.slice_count() : 0;
  const float* corner = image.data() + grid.offset(low[0], low[1], low[2]);
  const double x0 = 1 - w[0];
  const double y0 = 1 - w[1];
  const double z0 = 1 - w[2];
  double sum = x0 * y0 * z0 * static_cast<double>(corner[0]);
  sum += w[0] * y0 * z0 * static_cast<double>(corner[di]);
  sum += x0 * w[1] * z0 * static_cast<double>(corner[dj]);
  sum += w[0] * w[1] * z0 * static_cast<double>(corner[di + dj]);
  sum += x0 * y0 * w[2] * static_cast<double>(corner[dk]);
  sum += w[0] * y0 * w[2] * static_cast<double>(corner[di + dk]);
  sum += x0 * w[1] * w[2] * static_cast<double>(corner[dj + dk]);
  sum += w[0] * w[1] * w[2] * static_cast<double>(corner[di + dj + dk]);
  return static_cast<float>(sum);
}

/// Sections across an axis.
struct Sections {
  const ImageCycle<float>& images;
  Vec3 origin_mm, along, u, v;
  Affine index_from_mm;

  Sections(const ImageCycle<float>& of, const Vec3& origin, const Vec3& direction)
      : images(of),
        origin_mm(origin),
        along(direction),
        u(direction.unitOrthogonal()),
        v(direction.cross(u)),
        index_from_mm(of.grid.mm_from_index.inverse(Eigen::Affine)) {}

  static int side() { return static_cast<int>(kPlaneMm / kPixelMm); }
  static cv::Point2d pixel_mm() { return {kPixelMm, kPixelMm}; }
  static cv::Point2d px(const Eigen::Vector2d& mm) {
    return {mm[0] / kPixelMm + 0.5 * side(), mm[1] / kPixelMm + 0.5 * side()};
  }
  static Eigen::Vector2d mm(const cv::Point2d& px) {
    return {(px.x - 0.5 * side()) * kPixelMm, (px.y - 0.5 * side()) * kPixelMm};
  }

  /// Linear in space; outside the images not a number, as trace_ring takes a border.
  [[nodiscard]] cv::Mat at(std::size_t phase, double height_mm) const {
    cv::Mat out(side(), side(), CV_32F);
    const Grid& grid = images.grid;
    const std::vector<float>& image = images.phases[phase];
    const Vec3 du = index_from_mm.linear() * (kPixelMm * u);
    const Vec3 dv = index_from_mm.linear() * (kPixelMm * v);
    const Vec3 middle = index_from_mm * Vec3(origin_mm + height_mm * along);
    for (int r = 0; r < side(); ++r) {
      for (int c = 0; c < side(); ++c) {
        const Vec3 x = middle + (c - 0.5 * side()) * du + (r - 0.5 * side()) * dv;
        out.at<float>(r, c) = linear(grid, image, x);
      }
    }
    return out;
  }
};

/// A pool's centre within its section, and its ring.
struct Seen {
  Eigen::Vector2d centre_mm = Eigen::Vector2d::Zero();
  Ring ring;
};

Seen look(const cv::Mat& section, const Eigen::Vector2d& near_mm, const TissueLevels& levels,
          double most_shift_mm) {
  Seen seen{near_mm, trace_ring(section, Sections::pixel_mm(), Sections::px(near_mm), levels)};
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double area = 0;
  for (int a = 0; a < Ring::kRays; ++a) {
    const auto corner = [&](int ray) {
      return Sections::mm(ray_point(Sections::px(near_mm), Sections::pixel_mm(), ray,
                                    seen.ring.endo_mm[static_cast<std::size_t>(ray)]));
    };
    const Eigen::Vector2d p = corner(a) - near_mm;
    const Eigen::Vector2d q = corner((a + 1) % Ring::kRays) - near_mm;
    const double cross = p[0] * q[1] - p[1] * q[0];
    sum += cross * (p + q) / 3;
    area += cross;
  }
  if (!(std::abs(area) > 1)) return seen;
  Eigen::Vector2d shift = sum / area;
  if (shift.norm() > most_shift_mm) shift *= most_shift_mm / shift.norm();
  seen.centre_mm = near_mm + shift;
  seen.ring = trace_ring(section, Sections::pixel_mm(), Sections::px(seen.centre_mm), levels);
  return seen;
}

struct Line {
  Vec3 at, along;
};

/// Mean and direction of greatest spread.
Line line_through(const std::vector<Vec3>& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3& p : points) spread += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solved(spread);
  return {mean, solved.eigenvectors().col(2)};
}

/// A first guess: of many directions through the pools that the slices show, the one whose sections
/// are rings of muscle and round, for a ventricle is round across its axis alone.
std::optional<Line> most_ring_like(const ImageCycle<float>& images, const Chambers& chambers) {
  constexpr int kDirections = 80;
  constexpr double kApartMm = 9;
  constexpr double kLeastScore = 0.4;  ///< a full, round ring is 1
  const auto ed = static_cast<std::size_t>(chambers.end_diastole);
  const std::size_t slices = chambers.lv.size();
  std::vector<Line> lines;
  for (const std::size_t s : {slices / 4, slices / 2, 3 * slices / 4}) {
    const LvSlice& slice = chambers.lv[s];
    const Vec3 at = images.grid.mm_from_index * Vec3(slice.centre_px.x, slice.centre_px.y, slice.k);
    for (int d = 0; d < kDirections; ++d) {
      // Evenly over a half of the sphere: a spiral of golden angles.
      const double z = (d + 0.5) / kDirections;
      const double turn = d * std::numbers::pi * (3 - std::sqrt(5.0));
      const double r = std::sqrt(1 - z * z);
      lines.push_back({at, {r * std::cos(turn), r * std::sin(turn), z}});
    }
  }
  std::vector<double> scores(lines.size());
  parallel_for(lines.size(), [&](std::size_t n) {
    const Sections sections(images, lines[n].at, lines[n].along);
    for (const double height : {-kApartMm, 0.0, kApartMm}) {
      const Ring ring =
          look(sections.at(ed, height), Eigen::Vector2d::Zero(), chambers.levels, 15).ring;
      scores[n] += ring.walled_share * ring.roundness * ring.roundness / 3;
    }
  });
  const auto best = std::max_element(scores.begin(), scores.end());
  if (best == scores.end() || *best < kLeastScore) return {};
  return lines[static_cast<std::size_t>(best - scores.begin())];
}

/// Where the ring is sure, from mid-ventricle on, upward (+1) or downward (-1).
struct Followed {
  std::vector<Vec3> centres;
  double last_height_mm = 0;
  double last_area_mm2 = 0;
};

Followed follow(const Sections& sections, std::size_t phase, const TissueLevels& levels,
                int direction, double step_mm) {
  Followed out;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (double height = 0; std::abs(height) < 80; height += direction * step_mm) {
    const Seen seen = look(sections.at(phase, height), centre, levels,
                           height == 0 ? 15.0 : kMostShiftMm * step_mm);
    if (seen.ring.walled_share < kSureRing) break;
    centre = seen.centre_mm;
    out.centres.emplace_back(sections.origin_mm + height * sections.along + centre[0] * sections.u +
                             centre[1] * sections.v);
    out.last_height_mm = height;
    out.last_area_mm2 = seen.ring.area_mm2;
  }
  return out;
}

struct Settled {
  Line line;
  double apex_mm = 0;  ///< height at which the pool closes
};

/// The axis of the pool's centres where the ring is sure, from a first guess; toward the base, for
/// there the pool is wide when the ring opens, and at the apex it closes.
std::optional<Settled> settle(const ImageCycle<float>& images, const Chambers& chambers,
                              Line line) {
  constexpr std::size_t kLeastSections = 6;
  constexpr double kSectionMm = 3;
  constexpr int kRounds = 5;
  const auto ed = static_cast<std::size_t>(chambers.end_diastole);
  for (int round = 0; round < kRounds; ++round) {
    const Sections sections(images, line.at, line.along);
    const Followed up = follow(sections, ed, chambers.levels, +1, kSectionMm);
    const Followed down = follow(sections, ed, chambers.levels, -1, kSectionMm);
    std::vector<Vec3> found = up.centres;
    if (!down.centres.empty()) {
      found.insert(found.end(), down.centres.begin() + 1, down.centres.end());
    }
    if (found.size() < kLeastSections) return {};
    const bool turned = up.last_area_mm2 < down.last_area_mm2;
    if (round + 1 == kRounds) {
      if (turned) line.along = -line.along;
      return Settled{line, (turned ? -up.last_height_mm : down.last_height_mm) - 0.5 * kSectionMm};
    }
    Line next = line_through(found);
    if ((next.along.dot(line.along) < 0) != turned) next.along = -next.along;
    line = next;
  }
  return {};
}

/// Share of the rays that meet a wall as thick as a ventricle's; an atrium's is a third of it.
double thick_share(const Ring& ring, double wall_mm) {
  int count = 0;
  for (std::size_t a = 0; a < ring.endo_mm.size(); ++a) {
    count += ring.outer_mm[a] - ring.endo_mm[a] >= kThickOfWall * wall_mm ? 1 : 0;
  }
  return static_cast<double>(count) / Ring::kRays;
}

/// Height at which the ring of muscle opens, from mid-ventricle on; none if it is no ring there.
std::optional<double> opening(const Sections& sections, std::size_t phase,
                              const TissueLevels& levels, double wall_mm) {
  constexpr int kInARow = 2;  ///< open sections that are not a gap in the wall
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double last_share = 0;
  std::array<double, 3> last_areas_mm2{};
  std::size_t rings = 0;
  std::optional<double> crossing;
  int open = 0;
  for (double height = 0; height < 90; height += kStepMm) {
    const Seen seen =
        look(sections.at(phase, height), centre, levels, crossing ? 0.0 : kMostShiftMm * kStepMm);
    // Past the base the way may lead out of blood, to where all around is dark and thick as a wall.
    const bool pool = seen.ring.area_mm2 >=
                      kLeastPool * *std::max_element(last_areas_mm2.begin(), last_areas_mm2.end());
    const double share = pool ? thick_share(seen.ring, wall_mm) : 0;
    if (share >= kLeastRing) {
      last_areas_mm2[rings++ % last_areas_mm2.size()] = seen.ring.area_mm2;
      crossing.reset();
      open = 0;
      centre = seen.centre_mm;
    } else {
      if (height == 0) return {};
      if (!crossing) {
        crossing = height - kStepMm * (kLeastRing - share) / std::max(1e-6, last_share - share);
      }
      if (++open == kInARow) return crossing;
    }
    last_share = share;
  }
  return {};
}

}  // namespace

std::optional<LongAxis> find_long_axis(const ImageCycle<float>& images, const Chambers& chambers,
                                       double tricuspid_excursion_mm) {
  const Grid& grid = images.grid;
  if (!chambers.found_lv() || grid.spacing_mm()[2] >= kThickSlicesMm) return {};
  const std::optional<Line> guess = most_ring_like(images, chambers);
  if (!guess) return {};
  const std::optional<Settled> settled = settle(images, chambers, *guess);
  if (!settled) return {};

  LongAxis out;
  out.origin_mm = settled->line.at;
  out.towards_base = settled->line.along;
  const Sections sections(images, out.origin_mm, out.towards_base);
  const std::size_t n = images.phases.size();
  std::vector<std::optional<double>> opens(n);
  parallel_for(n, [&](std::size_t p) {
    opens[p] = opening(sections, p, chambers.levels, chambers.wall_by_phase_mm[p]);
  });
  if (!std::all_of(opens.begin(), opens.end(), [](const auto& at) { return at.has_value(); })) {
    return {};
  }
  for (const auto& at : opens) out.lv_base_mm.push_back(*at);
  // The apical wall is thinner than the rest by about this share.
  const double apex_mm = settled->apex_mm - 0.7 * chambers.wall_mm;
  out.apex_mm.assign(n, apex_mm);

  const auto ed = static_cast<std::size_t>(chambers.end_diastole);
  const auto [least, most] = std::minmax_element(out.lv_base_mm.begin(), out.lv_base_mm.end());
  const double range = *most - *least;
  const double scale = std::min(1.3, (out.lv_base_mm[ed] - apex_mm) / kLvLengthMm);
  for (const double at : out.lv_base_mm) {
    const double loss = range > 0 ? (*most - at) / range : 0;
    out.rv_base_mm.push_back(*most - loss * scale * tricuspid_excursion_mm);
  }

  // Without blood beyond the opening there is nothing to part.
  const cv::Mat beyond = sections.at(ed, out.lv_base_mm[ed] + kBeyondMm);
  const Seen at_base =
      look(sections.at(ed, out.lv_base_mm[ed] - kBeyondMm), {0, 0}, chambers.levels, 15);
  const double pool_mm2 = at_base.ring.area_mm2;
  cv::Mat near = cv::Mat::zeros(beyond.size(), CV_8U);
  cv::circle(near, cv::Point(Sections::px(at_base.centre_mm)),
             static_cast<int>(std::sqrt(pool_mm2 / std::numbers::pi) / kPixelMm), cv::Scalar(255),
             cv::FILLED);
  const int blood = cv::countNonZero((beyond > chambers.levels.threshold) & near);
  out.atria = blood >= kLeastAtrium * cv::countNonZero(near);
  return out;
}

ImageCycle<float> across_axis(const ImageCycle<float>& images, const LongAxis& axis) {
  constexpr double kSliceMm = 3;
  constexpr double kHalfMm = 95;  ///< beside the axis; the RV reaches out farthest
  constexpr double kBelowMm = 25;
  constexpr double kBeyondBaseMm = 60;
  const Vec3 spacing = images.grid.spacing_mm();
  const double pixel = std::max(1.0, std::min(spacing[0], spacing[1]));
  const double low = *std::min_element(axis.apex_mm.begin(), axis.apex_mm.end()) - kBelowMm;
  const double high =
      *std::max_element(axis.lv_base_mm.begin(), axis.lv_base_mm.end()) + kBeyondBaseMm;
  const Vec3 u = axis.towards_base.unitOrthogonal();
  ImageCycle<float> out;
  out.grid.size = {static_cast<int>(2 * kHalfMm / pixel), static_cast<int>(2 * kHalfMm / pixel),
                   static_cast<int>((high - low) / kSliceMm)};
  out.grid.mm_from_index.linear().col(0) = pixel * u;
  out.grid.mm_from_index.linear().col(1) = pixel * axis.towards_base.cross(u);
  out.grid.mm_from_index.linear().col(2) = kSliceMm * axis.towards_base;
  out.grid.mm_from_index.translation() =
      axis.origin_mm + low * axis.towards_base - kHalfMm * (u + axis.towards_base.cross(u));
  const Affine from_out = images.grid.mm_from_index.inverse(Eigen::Affine) * out.grid.mm_from_index;
  out.phases.resize(images.phases.size());
  parallel_for(images.phases.size(), [&](std::size_t p) {
    std::vector<float>& to = out.phases[p];
    to.reserve(out.grid.count());
    for (int k = 0; k < out.grid.size[2]; ++k) {
      for (int j = 0; j < out.grid.size[1]; ++j) {
        for (int i = 0; i < out.grid.size[0]; ++i) {
          const float value = linear(images.grid, images.phases[p], from_out * Vec3(i, j, k));
          to.push_back(std::isnan(value) ? 0.F : value);
        }
      }
    }
  });
  return out;
}

}  // namespace beatlas::segment
