#include "pipeline/edges/along_slices.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include <opencv2/imgproc.hpp>

#include "pipeline/edges/magnitude.h"
#include "pipeline/edges/side_levels.h"
#include "pipeline/edges/slice_image.h"

namespace beatlas::edges {
namespace {

constexpr double kAlongWindowMm = 7;   ///< half width of the window that tells a side's level
constexpr int kWindowSlices = 3;       ///< from the surface on
constexpr double kPatchPx = 2;         ///< Gaussian along the surface
constexpr int kPatchRoomPx = 24;       ///< three of them, one after the other, look as far
constexpr double kSteepPx = 2;         ///< up to such a way from outline to outline they suffice
constexpr double kLevelPx = 4;         ///< and from this on, wider than their band, intensities do
constexpr float kLeastSquare = 1e-6F;  ///< of a difference from a patch's mean
constexpr float kBeyond = 0.5F;        ///< how far noise may leave the range of coverage
constexpr float kBrighter = 1.5F;      ///< of the way from outside to inside: something else
constexpr float kLeastWall = 0.2F;     ///< of the outer voxel of a wall before blood

using Slices = std::vector<cv::Mat>;

std::size_t at(int n) { return static_cast<std::size_t>(n); }

/// Mean over a window, from slice k on, away by `step`. @return whether it is told
bool mean_beyond(const WindowSums& sums, int k, int step, int j, int i, float& out) {
  float all = 0;
  float share = 0;
  for (int n = 0; n < kWindowSlices; ++n, k += step) {
    if (k < 0 || k >= static_cast<int>(sums.pixels.size())) break;
    all += sums.pixels[at(k)].at<float>(j, i);
    share += sums.weight[at(k)].at<float>(j, i);
  }
  out = all / std::max(share, 1e-6F);
  return share >= kLeastCore;
}

/// Empties slices of `mask` that are farther than `reach` slices from any of `inside`: no level is
/// asked for there.
void leave_far_slices(const Slices& inside, int reach, Slices& mask) {
  const int count = static_cast<int>(inside.size());
  std::vector<bool> near(inside.size(), false);
  for (int k = 0; k < count; ++k) {
    if (cv::countNonZero(inside[static_cast<std::size_t>(k)]) == 0) continue;
    for (int n = std::max(0, k - reach); n <= std::min(count - 1, k + reach); ++n) {
      near[static_cast<std::size_t>(n)] = true;
    }
  }
  for (std::size_t k = 0; k < mask.size(); ++k) {
    if (!near[k]) mask[k].setTo(cv::Scalar(0));
  }
}

/// The mask's own smooth surface: its gradient tells how level it is.
Slices smoothed(const Slices& in) {
  Slices plane;
  for (const cv::Mat& mask : in) {
    cv::Mat soft;
    mask.convertTo(soft, CV_32F, 1.0 / 255.0);
    if (cv::countNonZero(mask) == 0) {
      plane.push_back(soft);
      continue;
    }
    cv::GaussianBlur(soft, soft, {0, 0}, kPatchPx, kPatchPx, cv::BORDER_REPLICATE);
    plane.push_back(soft);
  }
  Slices out;
  for (std::size_t k = 0; k < plane.size(); ++k) {
    const cv::Mat& below = plane[k > 0 ? k - 1 : k];
    const cv::Mat& above = plane[std::min(k + 1, plane.size() - 1)];
    out.push_back(0.25 * below + 0.5 * plane[k] + 0.25 * above);
  }
  return out;
}

/// 0 where the surface is steep, 1 where it is level.
float levelness(const Slices& soft, int k, int j, int i) {
  const cv::Mat& here = soft[at(k)];
  const auto below = soft[at(std::max(0, k - 1))].at<float>(j, i);
  const auto above = soft[std::min(at(k + 1), soft.size() - 1)].at<float>(j, i);
  const int left = std::max(0, i - 1);
  const int right = std::min(here.cols - 1, i + 1);
  const int low = std::max(0, j - 1);
  const int high = std::min(here.rows - 1, j + 1);
  const double in_plane = std::hypot(here.at<float>(j, right) - here.at<float>(j, left),
                                     here.at<float>(high, i) - here.at<float>(low, i));
  // Pixels that the outline moves from slice to slice.
  const double lean_px = std::abs(above - below) / std::max(in_plane, 1e-6);
  const double u = std::clamp((lean_px - kSteepPx) / (kLevelPx - kSteepPx), 0.0, 1.0);
  return static_cast<float>(u * u * (3 - 2 * u));
}

/// What one slice shows of the surface above and below it.
struct Seen {
  cv::Mat share;   ///< coverage, in voxels beside the surface what their intensity says
  cv::Mat weight;  ///< 0..1, by how much that counts
  cv::Mat known;   ///< 0 in voxels beside a surface that intensities do not show, else 1
  cv::Mat within;  ///< slice of the voxel on the inner side
  cv::Mat inner;   ///< levels of either side, where weight is not 0
  cv::Mat outer;
  bool any = false;
};

class Columns {
 public:
  Columns(const BoundaryInput& input, const Sides& sides, const cv::Rect& part,
          const cv::Size& window)
      : grid_(input.grid),
        contrast_(input.contrast),
        inner_level_(static_cast<float>(sides.inner_level)),
        outer_level_(static_cast<float>(sides.outer_level)),
        in_(each(input.inside, part)),
        walls_(sides.walls != nullptr ? each(*sides.walls, part) : Slices{}),
        tells_outer_(each(input.tells_outer, part)),
        bare_(input.bare != nullptr ? each(*input.bare, part) : Slices{}),
        pixels_(each(input.image, part)),
        inner_(pixels_, whole(both(in_, each(input.tells_inner, part))), window),
        outer_(pixels_, whole(near(in_, both(inverse(in_), tells_outer_))), window),
        soft_(smoothed(in_)),
        window_(window) {}

  [[nodiscard]] Seen seen(int k, const cv::Mat& coverage) const {
    bool empty = true;
    for (int n = std::max(0, k - 1); n <= std::min(grid_.size[2] - 1, k + 1); ++n) {
      empty = empty && cv::countNonZero(in_[at(n)]) == 0;
    }
    if (empty) return {};
    Seen out{coverage.clone(),
             cv::Mat::zeros(coverage.size(), CV_32F),
             cv::Mat(coverage.size(), CV_32F, cv::Scalar(1)),
             cv::Mat::zeros(coverage.size(), CV_32S),
             cv::Mat::zeros(coverage.size(), CV_32F),
             cv::Mat::zeros(coverage.size(), CV_32F)};
    for (int j = 0; j < coverage.rows; ++j) {
      for (int i = 0; i < coverage.cols; ++i) {
        for (const int step : {-1, 1}) {
          const int other = k + step;
          if (other >= 0 && other < grid_.size[2] && inside(other, j, i) != inside(k, j, i)) {
            look(k, step, j, i, out);
          }
        }
      }
    }
    return out;
  }

 private:
  template <class T>
  [[nodiscard]] Slices each(const std::vector<T>& image, const cv::Rect& part) const {
    Slices out;
    for (int k = 0; k < grid_.size[2]; ++k) {
      const cv::Mat slice = slice_of(grid_, image, k)(part);
      out.push_back(std::is_same_v<T, float> ? slice : cv::Mat(slice != 0));
    }
    return out;
  }
  static Slices inverse(const Slices& masks) {
    Slices out;
    for (const cv::Mat& mask : masks) out.push_back(~mask);
    return out;
  }
  /// Where levels of the outside are asked for, and what tells whether its voxels are whole.
  static Slices near(const Slices& in, Slices masks) {
    leave_far_slices(in, kWindowSlices + 2, masks);
    return masks;
  }
  static Slices whole(const Slices& masks) {
    return whole_voxels(masks, std::vector<cv::Rect>(masks.size(), {{0, 0}, masks[0].size()}));
  }
  static Slices both(const Slices& a, const Slices& b) {
    Slices out;
    for (std::size_t k = 0; k < a.size(); ++k) out.push_back(a[k] & b[k]);
    return out;
  }

  [[nodiscard]] bool inside(int k, int j, int i) const {
    return in_[at(k)].at<std::uint8_t>(j, i) != 0;
  }
  [[nodiscard]] bool is_bare(int k, int j, int i) const {
    return !bare_.empty() && k >= 0 && k < grid_.size[2] &&
           bare_[at(k)].at<std::uint8_t>(j, i) != 0;
  }

  /// Whether the cavity that ends before slice k has a wall there.
  [[nodiscard]] bool is_walled(int k, int inward, int j, int i) const {
    if (walls_.empty()) return true;
    const auto of = [&](const Slices& masks, int slice) {
      return slice >= 0 && slice < grid_.size[2] && masks[at(slice)].at<std::uint8_t>(j, i) != 0;
    };
    return of(walls_, k) &&
           (of(tells_outer_, k) || of(tells_outer_, k - inward) || !of(walls_, k - inward));
  }

  /// Whether the outside holds, close by, what is neither side: where a thin layer of fat lies
  /// between muscle and lung a voxel of fat and lung is as grey as muscle.
  [[nodiscard]] bool other_tissue(int k, int beyond, int j, int i, float from, float to) const {
    const cv::Rect around =
        cv::Rect(i - window_.width / 2, j - window_.height / 2, window_.width, window_.height) &
        cv::Rect({0, 0}, in_[0].size());
    const float bound = from + kBrighter * (to - from);
    const float sign = to > from ? 1.0F : -1.0F;
    int seen = 0;
    for (const int slice : {k, beyond}) {
      for (int y = around.y; y < around.y + around.height; ++y) {
        const float* pixels = pixels_[at(slice)].ptr<float>(y);
        const std::uint8_t* inside = in_[at(slice)].ptr<std::uint8_t>(y);
        for (int x = around.x; x < around.x + around.width; ++x) {
          seen += inside[x] == 0 && sign * pixels[x] > sign * bound ? 1 : 0;
        }
      }
    }
    return static_cast<float>(seen) >= kLeastCore * static_cast<float>(window_.area());
  }

  /// At a voxel whose neighbour, a `step` on, lies on the other side of the surface.
  void look(int k, int step, int j, int i, Seen& out) const {
    float& weight = out.weight.at<float>(j, i);
    if (weight == 0) out.known.at<float>(j, i) = 0;
    const int k_in = inside(k, j, i) ? k : k + step;
    const int inward = inside(k, j, i) ? -step : step;
    if (is_bare(k_in, j, i) || !is_walled(k_in - inward, inward, j, i)) return;
    float from = 0;
    float to = 0;
    if (!mean_beyond(inner_, k_in + inward, inward, j, i, to)) to = inner_level_;
    if (!mean_beyond(outer_, k_in - 2 * inward, -inward, j, i, from)) {
      if (!(outer_level_ > 0)) return;
      from = outer_level_;
    }
    if (std::abs(to - from) <= contrast_) return;
    const auto share_at = [&](int slice) {
      const float share = (pixels_[at(slice)].at<float>(j, i) - from) / (to - from);
      return std::clamp(share, -kBeyond, 1 + kBeyond);
    };
    // From blood to the outside within a voxel: an open base. A wall takes two.
    if (is_bare(k_in + inward, j, i) && share_at(k_in - inward) < kLeastWall) return;
    const float share = share_at(k);
    if (k == k_in && share < kLeastInside) return;
    const float level = levelness(soft_, k, j, i);
    if (level <= weight || other_tissue(k_in, k_in - inward, j, i, from, to)) return;
    weight = level;
    out.known.at<float>(j, i) = 1;
    out.share.at<float>(j, i) = share;
    out.within.at<std::int32_t>(j, i) = k_in;
    out.inner.at<float>(j, i) = to;
    out.outer.at<float>(j, i) = from;
    out.any = true;
  }

  const Grid& grid_;
  double contrast_;
  float inner_level_;
  float outer_level_;
  Slices in_;
  Slices walls_;
  Slices tells_outer_;
  Slices bare_;
  Slices pixels_;
  WindowSums inner_;
  WindowSums outer_;
  Slices soft_;
  cv::Size window_;
};

cv::Mat blurred(const cv::Mat& image) {
  cv::Mat out;
  cv::GaussianBlur(image, out, {0, 0}, kPatchPx, kPatchPx, cv::BORDER_ISOLATED);
  return out;
}

/// The mean of what is known over a patch; where it is curved it stays, for twice a mean less its
/// own mean has no second moment. What noise hides of a share is added, by the share that a patch
/// shows: that of a voxel is noise itself. What voxels differ from the mean by more than by noise
/// is theirs (Lee, Digital image enhancement and noise filtering by use of local statistics, IEEE
/// PAMI 1980).
cv::Mat without_noise(const Seen& seen, double noise) {
  const cv::Mat weight = cv::max(blurred(seen.known), 1e-6F);
  const auto mean_of = [&](const cv::Mat& image) -> cv::Mat {
    return blurred(image.mul(seen.known)) / weight;
  };
  cv::Mat once = mean_of(seen.share);
  cv::Mat share = seen.share.clone();
  cv::Mat variance = cv::Mat::zeros(share.size(), CV_32F);
  for (int j = 0; j < share.rows; ++j) {
    for (int i = 0; i < share.cols; ++i) {
      if (seen.weight.at<float>(j, i) == 0) continue;
      const float inner = seen.inner.at<float>(j, i);
      const float outer = seen.outer.at<float>(j, i);
      const Mixture mixture(inner, outer, static_cast<float>(noise));
      share.at<float>(j, i) += mixture.missing(std::clamp(once.at<float>(j, i), 0.0F, 1.0F));
      const float of_share = static_cast<float>(noise) / (inner - outer);
      variance.at<float>(j, i) = of_share * of_share;
    }
  }
  once = mean_of(share);
  const cv::Mat mean = 2 * once - blurred(once);
  const cv::Mat off = (share - mean).mul(seen.known);
  const cv::Mat square = cv::max(mean_of(off.mul(off)), kLeastSquare);
  const cv::Mat own = cv::max(1 - mean_of(variance) / square, 0.0F);
  return cv::min(cv::max(mean + own.mul(off), 0.0F), 1.0F);
}

/// The same, of the part that matters of a slice.
cv::Mat without_noise_where_seen(const Seen& seen, double noise) {
  const cv::Rect part = rect_around(seen.weight != 0, kPatchRoomPx);
  const Seen there{.share = seen.share(part),
                   .weight = seen.weight(part),
                   .known = seen.known(part),
                   .within = {},
                   .inner = seen.inner(part),
                   .outer = seen.outer(part),
                   .any = true};
  cv::Mat out = seen.share.clone();
  without_noise(there, noise).copyTo(out(part));
  return out;
}

}  // namespace

std::vector<Settled> cover_along_slices(const BoundaryInput& input, const Sides& sides,
                                        std::vector<float>& coverage) {
  std::vector<Settled> settled;
  const Grid& grid = input.grid;
  const Vec3 spacing = grid.spacing_mm();
  const cv::Size window(
      2 * std::max(2, static_cast<int>(std::lround(kAlongWindowMm / spacing[0]))) + 1,
      2 * std::max(2, static_cast<int>(std::lround(kAlongWindowMm / spacing[1]))) + 1);
  const int room = 8 + std::max(window.width, window.height);
  cv::Rect part;
  for (int k = 0; k < grid.size[2]; ++k) part |= rect_around(slice_of(grid, input.inside, k), room);
  if (part.empty()) return settled;
  const Columns columns(input, sides, part, window);
  for (int k = 0; k < grid.size[2]; ++k) {
    cv::Mat out = slice_of(grid, coverage, k)(part);
    const Seen seen = columns.seen(k, out);
    if (!seen.any) continue;
    const cv::Mat share = without_noise_where_seen(seen, input.noise);
    for (int j = 0; j < out.rows; ++j) {
      for (int i = 0; i < out.cols; ++i) {
        const float weight = seen.weight.at<float>(j, i);
        if (weight == 0) continue;
        float& covered = out.at<float>(j, i);
        covered += weight * (share.at<float>(j, i) - covered);
        const auto offset = [&](int slice) {
          return static_cast<std::uint32_t>(grid.offset(part.x + i, part.y + j, slice));
        };
        settled.push_back({offset(k), offset(seen.within.at<std::int32_t>(j, i))});
      }
    }
  }
  return settled;
}

}  // namespace beatlas::edges
