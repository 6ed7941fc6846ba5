#include "pipeline/edges/boundary.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "pipeline/core/slices.h"
#include "pipeline/edges/magnitude.h"
#include "pipeline/edges/outline.h"
#include "pipeline/edges/side_levels.h"
#include "pipeline/edges/slice_image.h"
#include "pipeline/tissue/tissue.h"

namespace beatlas::edges {
namespace {

constexpr float kBandPx = 2.0F;        ///< where intensity is asked, on both sides
constexpr double kAlongPx = 2.0;       ///< Gaussian along the outline
constexpr float kMostShiftPx = 1.25F;  ///< labels are no farther off than this
constexpr int kBandRoomPx = 5;         ///< both, and the pixel that the differences take
constexpr int kFits = 2;
constexpr double kOfFits = 2;          ///< of a mean's variance: two fits are sharper, levels noisy
constexpr float kMostStepPx = 0.5F;    ///< of a fit
constexpr float kMostLeanPx = 4.0F;    ///< from slice to slice; more is another surface's
constexpr float kMostOff = 0.5F;       ///< of the levels' difference: it shows something else
constexpr float kMostNoise = 3.0F;     ///< standard deviations; unless it is noise
constexpr float kLeastAlong = 0.02F;   ///< outline, weighted, that has to be told of a place
constexpr double kUntoldPx = 0.625;    ///< standard deviation where no intensity tells the place
constexpr double kOfMisfit = 1.0;      ///< [px2] of the place's variance, for the misfit's
constexpr float kBlurredPx = 1.25F;    ///< about an edge
constexpr float kDeepPx = 3.0F;        ///< inside of most trabeculae
constexpr double kLabelsMm = 0.6;      ///< what pixels of 2 mm do not tell: 2 / sqrt(12)
constexpr double kFloorPx = 0.05;      ///< what no fit tells of
constexpr double kFloorOfLean = 0.03;  ///< the same, of what the outline moves between slices
constexpr double kLeastAcross = 0.35;  ///< a surface along the slices is known by its neighbours

/// Of each slice what matters of it: around its outlines and those of the slices next to it, that
/// tell how they lean and, with the next ones, which of its voxels are whole.
std::vector<cv::Rect> parts_of(const Grid& grid, const std::vector<std::uint8_t>& inside,
                               int room_px) {
  constexpr int kNext = 2;
  std::vector<cv::Rect> parts(static_cast<std::size_t>(grid.size[2]));
  for (int k = 0; k < grid.size[2]; ++k) {
    const cv::Rect here = rect_around(slice_of(grid, inside, k), room_px);
    if (here.empty()) continue;
    for (int n = std::max(0, k - kNext); n <= std::min(grid.size[2] - 1, k + kNext); ++n) {
      parts[static_cast<std::size_t>(n)] |= here;
    }
  }
  return parts;
}

/// What one slice shows of a boundary.
struct Edge {
  cv::Rect part;  ///< of the slice
  cv::Mat pixels;
  SideLevels sides;
  cv::Mat drawn_px;  ///< distance to the labels' outline; empty: the slice has none
  cv::Mat found_px;  ///< and to where intensities move it
  cv::Mat along;     ///< how much told that
  cv::Mat variance;  ///< of what the shift is made of, by the image's noise

  /// 0 as outside, 1 as inside.
  [[nodiscard]] float measured(int j, int i) const {
    const float outer = sides.outer.at<float>(j, i);
    return (pixels.at<float>(j, i) - outer) / difference(j, i);
  }
  [[nodiscard]] float difference(int j, int i) const {
    return sides.inner.at<float>(j, i) - sides.outer.at<float>(j, i);
  }
  [[nodiscard]] bool told(int j, int i) const { return sides.told.at<std::uint8_t>(j, i) != 0; }
  [[nodiscard]] bool far(int j, int i) const {
    return std::abs(drawn_px.at<float>(j, i)) > kBandPx + kMostShiftPx;
  }
};

cv::Mat mean_along(const cv::Mat& image) {
  cv::Mat out;
  cv::GaussianBlur(image, out, {0, 0}, kAlongPx, kAlongPx, cv::BORDER_ISOLATED);
  return out;
}

/// Geometry first: coverage g of the mask's own smooth outline. Intensity then tells by how much
/// that outline must move: across the boundary the excess of measured coverage over g adds up to
/// the shift, in pixels. Averaged along the outline, so that noise and single odd pixels cancel.
void move_by_excess(Edge& edge) {
  const cv::Size size = edge.pixels.size();
  cv::Mat geometric = 0.5F - edge.drawn_px;
  geometric = cv::min(cv::max(geometric, 0.0F), 1.0F);
  cv::Mat excess = cv::Mat::zeros(size, CV_32F);
  cv::Mat trusted = cv::Mat::zeros(size, CV_32F);
  for (int j = 0; j < size.height; ++j) {
    for (int i = 0; i < size.width; ++i) {
      const float d = edge.drawn_px.at<float>(j, i);
      if (std::abs(d) > kBandPx || !edge.told(j, i)) continue;
      const float measured = std::clamp(edge.measured(j, i), 0.0F, 1.0F);
      // A dark spot inside was taken in on purpose (papillary muscle): it says nothing.
      if (d < 0 && measured < kLeastInside) continue;
      trusted.at<float>(j, i) = 1;
      excess.at<float>(j, i) = measured - geometric.at<float>(j, i);
    }
  }
  cv::Mat dx;
  cv::Mat dy;
  cv::Sobel(geometric, dx, CV_32F, 1, 0, 1, 0.5);
  cv::Sobel(geometric, dy, CV_32F, 0, 1, 1, 0.5);
  cv::Mat length;
  cv::magnitude(dx, dy, length);
  const cv::Mat moved = mean_along(excess);
  const cv::Mat along = mean_along(length.mul(trusted));
  edge.found_px = edge.drawn_px.clone();
  for (int j = 0; j < size.height; ++j) {
    for (int i = 0; i < size.width; ++i) {
      const float weight = along.at<float>(j, i);
      if (edge.far(j, i) || weight <= kLeastAlong) continue;
      edge.found_px.at<float>(j, i) -=
          std::clamp(moved.at<float>(j, i) / weight, -kMostShiftPx, kMostShiftPx);
    }
  }
}

/// Then a step toward where the voxels that the outline crosses show on average what they are
/// expected to, noise and all. Levels a little off and noise beside the outline, which weigh in the
/// excess, hardly do here. Weights fall to 0 with the distance, for voxels that a step takes in
/// must not jolt it; they cost a tenth more noise than least squares.
void move_by_fit(const cv::Mat& lean_px, double noise, Edge& edge) {
  const cv::Size size = edge.pixels.size();
  const auto sigma = static_cast<float>(noise);
  cv::Mat moved = cv::Mat::zeros(size, CV_32F);
  cv::Mat moves = cv::Mat::zeros(size, CV_32F);
  edge.variance = cv::Mat::zeros(size, CV_32F);
  for (int j = 0; j < size.height; ++j) {
    for (int i = 0; i < size.width; ++i) {
      if (!edge.told(j, i)) continue;
      const float d = edge.found_px.at<float>(j, i);
      const float lean = lean_px.at<float>(j, i);
      const float weight = 1 - std::abs(d) / (1 + 0.5F * lean);
      if (!(weight > 0)) continue;
      const Ramp at = ramp(d, lean);
      const Mixture mixture(edge.sides.inner.at<float>(j, i), edge.sides.outer.at<float>(j, i),
                            sigma);
      const float off = edge.measured(j, i) - (at.coverage - mixture.missing(at.coverage));
      const float noise_here = std::abs(sigma / edge.difference(j, i));
      if (std::abs(off) > std::max(kMostOff, kMostNoise * noise_here)) continue;
      moved.at<float>(j, i) = weight * off;
      moves.at<float>(j, i) = weight * at.slope;
      edge.variance.at<float>(j, i) = weight * weight * noise_here * noise_here;
    }
  }
  moved = mean_along(moved);
  edge.along = mean_along(moves);
  for (int j = 0; j < size.height; ++j) {
    for (int i = 0; i < size.width; ++i) {
      const float told = edge.along.at<float>(j, i);
      if (edge.far(j, i) || told <= kLeastAlong) continue;
      const float step = std::clamp(moved.at<float>(j, i) / told, -kMostStepPx, kMostStepPx);
      const float drawn = edge.drawn_px.at<float>(j, i);
      float& d = edge.found_px.at<float>(j, i);
      d = std::clamp(d - step, drawn - kMostShiftPx, drawn + kMostShiftPx);
    }
  }
}

/// Level of what lies deep inside; none where nothing does.
std::optional<double> deep_level(const Edge& edge) {
  std::vector<float> deep;
  for (int j = 0; j < edge.pixels.rows; ++j) {
    for (int i = 0; i < edge.pixels.cols; ++i) {
      if (edge.drawn_px.at<float>(j, i) < -kDeepPx) deep.push_back(edge.pixels.at<float>(j, i));
    }
  }
  if (deep.empty()) return {};
  return tissue::median_of(deep);
}

/// What edges make of the outline of one slice.
struct SliceShift {
  double length_px = 0;
  double inward = 0;   ///< [px2] its shift, along its length
  double missing = 0;  ///< [px2] of the inside: what is darker than deep inside
};

SliceShift shift_of(const Edge& edge, double deep) {
  SliceShift out;
  for (int j = 0; j < edge.pixels.rows; ++j) {
    for (int i = 0; i < edge.pixels.cols; ++i) {
      if (edge.far(j, i) || !edge.told(j, i)) continue;
      const float d = edge.found_px.at<float>(j, i);
      const auto outer = static_cast<double>(edge.sides.outer.at<float>(j, i));
      if (d > kBlurredPx || !(deep > outer)) continue;
      if (std::abs(d) < 0.5F) {
        out.length_px += 1;
        out.inward += static_cast<double>(d - edge.drawn_px.at<float>(j, i));
      }
      const double measured =
          (static_cast<double>(edge.pixels.at<float>(j, i)) - outer) / (deep - outer);
      if (d < -kBlurredPx && measured < static_cast<double>(kLeastInside))
        continue;  // as in move_by_excess
      out.missing += static_cast<double>(std::clamp(0.5F - d, 0.0F, 1.0F)) - measured;
    }
  }
  return out;
}

/// How far the outlines of a cavity were moved inward among its trabeculae [pixels].
double among_trabeculae_px(const std::vector<Edge>& edges, double pixel_mm) {
  double length_px = 0;
  double inward = 0;
  std::vector<float> thick_mm;
  for (const Edge& edge : edges) {
    if (edge.drawn_px.empty()) continue;
    const std::optional<double> deep = deep_level(edge);
    if (!deep) continue;
    const SliceShift slice = shift_of(edge, *deep);
    if (!(slice.length_px > 0)) continue;
    length_px += slice.length_px;
    inward += slice.inward;
    thick_mm.push_back(static_cast<float>(pixel_mm * slice.missing / slice.length_px));
  }
  if (thick_mm.empty() || !(inward > 0)) return 0;
  // Papillary muscles lie inside as well, and tell nothing of the outline: most slices have none.
  const double middle = tissue::median_of(thick_mm);
  const auto slices = static_cast<double>(thick_mm.size());
  for (float& thick : thick_mm) thick = std::abs(thick - static_cast<float>(middle));
  // Of normal errors: the median deviation is 0.674 of the standard one, a median's error 1.253 of
  // a mean's. No fit tells of less than the floor. The square of what is known so badly is too
  // large by its square.
  const double error = std::hypot(1.253 / 0.674 * tissue::median_of(thick_mm) / std::sqrt(slices),
                                  kFloorPx * pixel_mm);
  const double square = std::max(0.0, middle * std::abs(middle) - error * error);
  return inward / length_px * square / (kLabelsMm * kLabelsMm + square);
}

/// [pixels] How far outlines were moved inward in the mean, all slices together.
double mean_inward_px(const std::vector<Edge>& edges) {
  double length = 0;
  double inward = 0;
  for (const Edge& edge : edges) {
    if (edge.drawn_px.empty()) continue;
    for (int j = 0; j < edge.pixels.rows; ++j) {
      for (int i = 0; i < edge.pixels.cols; ++i) {
        const float drawn = edge.drawn_px.at<float>(j, i);
        if (edge.far(j, i) || std::abs(drawn) >= 0.5F) continue;
        length += 1;
        inward += static_cast<double>(edge.found_px.at<float>(j, i) - drawn);
      }
    }
  }
  return length > 0 ? inward / length : 0;
}

void move_outward(double by_px, std::vector<Edge>& edges) {
  for (Edge& edge : edges) {
    if (edge.drawn_px.empty()) continue;
    for (int j = 0; j < edge.found_px.rows; ++j) {
      for (int i = 0; i < edge.found_px.cols; ++i) {
        if (!edge.far(j, i)) edge.found_px.at<float>(j, i) -= static_cast<float>(by_px);
      }
    }
  }
}

/// What a way in the plane of a slice, across the outline, is along the surface's normal: the
/// outline's way from slice to slice tells how the surface leans.
double along_normal(const std::vector<Edge>& edges, std::size_t k, const cv::Point& pixel,
                    double pixel_per_slice) {
  const auto at = [&](std::size_t slice) -> std::optional<float> {
    if (slice >= edges.size() || edges[slice].drawn_px.empty()) return {};
    return edges[slice].drawn_px.at<float>(pixel - edges[slice].part.tl());
  };
  const std::optional<float> below = k > 0 ? at(k - 1) : std::nullopt;
  const std::optional<float> above = at(k + 1);
  const float here = *at(k);
  const int steps = (below ? 1 : 0) + (above ? 1 : 0);
  if (steps == 0) return 1;
  const double lean = static_cast<double>(above.value_or(here) - below.value_or(here)) / steps;
  return std::max(kLeastAcross, 1 / std::hypot(1.0, lean * pixel_per_slice));
}

/// By how many pixels outlines move from slice to slice; none between thick ones, which stand
/// alone.
std::vector<cv::Mat> leans_px(const Grid& grid, const std::vector<Edge>& edges) {
  std::vector<cv::Mat> out(edges.size());
  const bool thin = !are_thick_slices(grid.spacing_mm()[2]);
  for (std::size_t k = 0; k < edges.size(); ++k) {
    if (edges[k].drawn_px.empty()) continue;
    const std::size_t below = k > 0 && !edges[k - 1].drawn_px.empty() ? k - 1 : k;
    const std::size_t above = k + 1 < edges.size() && !edges[k + 1].drawn_px.empty() ? k + 1 : k;
    out[k] = cv::Mat::zeros(edges[k].drawn_px.size(), CV_32F);
    if (!thin || above == below) continue;
    const auto found_px = [&](std::size_t slice) {
      return framed(edges[slice].found_px, edges[slice].part, edges[k].part);
    };
    out[k] =
        cv::abs(found_px(above) - found_px(below)) * (1.0 / static_cast<double>(above - below));
    out[k] = cv::min(out[k], kMostLeanPx);
  }
  return out;
}

/// Standard deviation [pixels] of the outline in plane, where `coverage` is neither 0 nor 1.
cv::Mat deviations_px(const Edge& edge, const cv::Mat& lean_px, const cv::Mat& coverage,
                      double noise) {
  cv::Mat misfit = cv::Mat::zeros(coverage.size(), CV_32F);
  for (int j = 0; j < coverage.rows; ++j) {
    for (int i = 0; i < coverage.cols; ++i) {
      if (std::abs(edge.drawn_px.at<float>(j, i)) > kBandPx || !edge.told(j, i)) continue;
      const float measured = std::clamp(edge.measured(j, i), 0.0F, 1.0F);
      const float off = measured - coverage.at<float>(j, i);
      // What is beyond a level counts as that level, noise and all.
      const float noise_here =
          measured > 0 && measured < 1 ? static_cast<float>(noise) / edge.difference(j, i) : 0;
      misfit.at<float>(j, i) = off * off - noise_here * noise_here;
    }
  }
  misfit = mean_along(misfit);
  // The square of a Gaussian is a narrower one.
  constexpr double kNarrowPx = kAlongPx / std::numbers::sqrt2;
  constexpr double kOfSquare = kOfFits / (4 * std::numbers::pi * kAlongPx * kAlongPx);
  cv::Mat variance;
  cv::GaussianBlur(edge.variance, variance, {0, 0}, kNarrowPx, kNarrowPx, cv::BORDER_ISOLATED);
  cv::Mat out(coverage.size(), CV_32F, cv::Scalar(kUntoldPx));
  for (int j = 0; j < coverage.rows; ++j) {
    for (int i = 0; i < coverage.cols; ++i) {
      const double weight = edge.along.at<float>(j, i);
      if (weight <= kLeastAlong) continue;
      const double by_noise = kOfSquare * variance.at<float>(j, i) / (weight * weight);
      const double by_fit = kOfMisfit * std::max(0.0F, misfit.at<float>(j, i)) / weight;
      const double floor =
          std::hypot(kFloorPx, kFloorOfLean * static_cast<double>(lean_px.at<float>(j, i)));
      out.at<float>(j, i) = static_cast<float>(std::sqrt(by_noise + by_fit + floor * floor));
    }
  }
  return out;
}

/// Outlines as labels draw them, moved by what intensities exceed; empty ones where a slice has
/// none.
/// @param coverage becomes that of the mask
std::vector<Edge> first_edges(const BoundaryInput& input, std::vector<float>& coverage) {
  const Grid& grid = input.grid;
  // The band along the outlines, and what its levels are told by and its distance is smoothed by.
  const int room = kBandRoomPx + std::max(level_reach_px(grid), kOutlineReachPx);
  const std::vector<cv::Rect> parts = parts_of(grid, input.inside, room);
  const LevelFinder finder(input, parts);
  std::vector<Edge> edges(parts.size());
  for (int k = 0; k < grid.size[2]; ++k) {
    Edge& edge = edges[static_cast<std::size_t>(k)];
    edge.part = parts[static_cast<std::size_t>(k)];
    if (edge.part.empty()) continue;
    const cv::Mat in = slice_of(grid, input.inside, k)(edge.part) != 0;
    const int within = cv::countNonZero(in);
    if (within == 0) continue;
    cv::Mat out = slice_of(grid, coverage, k)(edge.part);
    in.convertTo(out, CV_32F, 1.0 / 255.0);
    if (within == in.rows * in.cols) continue;
    edge.drawn_px = outline_distance_px(in);
    edge.pixels = slice_of(grid, input.image, k)(edge.part);
    edge.sides = finder.levels(k);
    move_by_excess(edge);
  }
  return edges;
}

/// Sets coverage near an outline by how far it was moved.
void cover_edge(const Edge& edge, const cv::Mat& lean_px, cv::Mat& coverage) {
  for (int j = 0; j < coverage.rows; ++j) {
    for (int i = 0; i < coverage.cols; ++i) {
      if (edge.far(j, i)) continue;
      coverage.at<float>(j, i) =
          ramp(edge.found_px.at<float>(j, i), lean_px.at<float>(j, i)).coverage;
    }
  }
}

/// The boundary's points in one slice, with their standard deviations.
/// @param coverage of the slice's part
void add_points(const BoundaryInput& input, const std::vector<Edge>& edges, int k,
                const cv::Mat& lean_px, const cv::Mat& coverage,
                std::vector<BoundaryPoint>& points) {
  const auto slice = static_cast<std::size_t>(k);
  const Vec3 spacing = input.grid.spacing_mm();
  const double pixel_mm = std::sqrt(spacing[0] * spacing[1]);
  const cv::Mat deviations = deviations_px(edges[slice], lean_px, coverage, input.noise);
  for (int j = 0; j < coverage.rows; ++j) {
    for (int i = 0; i < coverage.cols; ++i) {
      const float covered = coverage.at<float>(j, i);
      if (!(covered > 0 && covered < 1)) continue;
      const cv::Point pixel = edges[slice].part.tl() + cv::Point(i, j);
      const double sigma_px = static_cast<double>(deviations.at<float>(j, i)) *
                              along_normal(edges, slice, pixel, pixel_mm / spacing[2]);
      points.push_back({static_cast<std::uint32_t>(input.grid.offset(pixel.x, pixel.y, k)),
                        static_cast<float>(sigma_px * pixel_mm)});
    }
  }
}

}  // namespace

std::vector<float> outline_coverage(const Grid& grid, const std::vector<std::uint8_t>& inside) {
  std::vector<float> coverage(inside.size());
  for (int k = 0; k < grid.size[2]; ++k) {
    const cv::Mat in = slice_of(grid, inside, k) != 0;
    cv::Mat out = slice_of(grid, coverage, k);
    in.convertTo(out, CV_32F, 1.0 / 255.0);
    const int within = cv::countNonZero(in);
    if (within == 0 || within == in.rows * in.cols) continue;
    const cv::Mat covered = 0.5F - outline_distance_px(in);
    out = cv::min(cv::max(covered, 0.0F), 1.0F);  // assigns into `coverage`: same size and type
  }
  return coverage;
}

Boundary find_boundary(const BoundaryInput& input) {
  const Grid& grid = input.grid;
  Boundary found;
  found.coverage.resize(input.image.size());
  std::vector<Edge> edges = first_edges(input, found.coverage);
  for (int fit = 0; fit < kFits; ++fit) {
    const std::vector<cv::Mat> leans = leans_px(grid, edges);
    for (std::size_t k = 0; k < edges.size(); ++k) {
      if (!edges[k].drawn_px.empty()) move_by_fit(leans[k], input.noise, edges[k]);
    }
  }
  if (input.trabeculated) {
    const Vec3 spacing = grid.spacing_mm();
    const double pixel_mm = std::sqrt(spacing[0] * spacing[1]);
    move_outward(among_trabeculae_px(edges, pixel_mm), edges);
  }
  if (input.rimmed) move_outward(mean_inward_px(edges), edges);
  const std::vector<cv::Mat> leans = leans_px(grid, edges);
  for (int k = 0; k < grid.size[2]; ++k) {
    const Edge& edge = edges[static_cast<std::size_t>(k)];
    if (edge.drawn_px.empty()) continue;
    const cv::Mat& lean = leans[static_cast<std::size_t>(k)];
    cv::Mat out = slice_of(grid, found.coverage, k)(edge.part);
    cover_edge(edge, lean, out);
    add_points(input, edges, k, lean, out, found.points);
  }
  return found;
}

}  // namespace beatlas::edges
