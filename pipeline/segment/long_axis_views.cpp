#include "pipeline/segment/long_axis_views.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "runtime/atlas/structures.h"

namespace beatlas::segment {
namespace {

constexpr double kMostAwayMm = 12;   ///< of the LV's middle from a view's plane
constexpr double kMostTiltDeg = 20;  ///< of the LV's axis against it
constexpr double kPixelMm = 0.75;    ///< of a straightened view
constexpr double kHalfWidthMm = 60;
constexpr double kBelowMm = 75;  ///< from the LV's middle
constexpr double kBeyondMm = 95;
constexpr double kNearSliceMm = 1.5;  ///< a slice's labels hold so far from its centre
constexpr std::array<double, 2> kStartBelowMm{15, 30};  ///< the LV's most basal slice
constexpr double kLeastContrast = 1.3;                  ///< blood over muscle
constexpr double kDark = 0.4;                           ///< of muscle: lung, air
constexpr double kThickOfWall = 0.5;  ///< a thinner wall is the atrium's, or a leaflet
constexpr double kUnknownWallMm = 9;
constexpr double kMostWallMm = 25;
constexpr double kInwardMm = 4;          ///< a wall's inside from one row to the next
constexpr double kOutwardMm = 10;        ///< farther: past a papillary muscle
constexpr double kGapMm = 4;             ///< in a wall
constexpr double kWindowMm = 8;          ///< hinges as near as this agree: a valve plane leans
constexpr double kSteadyOfCycle = 0.04;  ///< phases so near in time tell of each other
constexpr int kSmoothings = 2;           ///< of the settled heights, in time
constexpr double kLeastAgreement = 0.35;
constexpr double kNearAxisMm = 6;        ///< blood of the cavity on the way to the apex
constexpr double kMostCavityMm = 70;     ///< wider: the apex was passed
constexpr double kOffStackMm = 30;       ///< farthest from the LV's most basal slice
constexpr double kMostExcursionMm = 30;  ///< of a mitral plane: twice the usual

struct Axis {
  Vec3 middle = Vec3::Zero();
  Vec3 towards_base = Vec3::UnitZ();
};

Axis axis_of(const ViewSearch& s) {
  const Grid& grid = s.labels.grid;
  const std::vector<std::uint8_t>& labels =
      s.labels.phases[static_cast<std::size_t>(s.end_diastole)];
  std::vector<Vec3> centres;
  for (const int k : s.lv_slices) {
    Vec3 sum = Vec3::Zero();
    int count = 0;
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (labels[grid.offset(i, j, k)] != kLabelLvBlood) continue;
        sum += Vec3(i, j, k);
        ++count;
      }
    }
    if (count > 0) centres.emplace_back(grid.mm_from_index * Vec3(sum / count));
  }
  Axis axis;
  if (centres.size() < 2) return axis;
  for (const Vec3& c : centres) axis.middle += c / static_cast<double>(centres.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3& c : centres) spread += (c - axis.middle) * (c - axis.middle).transpose();
  axis.towards_base = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
  if (s.base_step * axis.towards_base.dot(centres.back() - centres.front()) < 0) {
    axis.towards_base = -axis.towards_base;
  }
  return axis;
}

/// A view cut anew: rows along the LV's axis toward the base, columns across it.
struct StraightView {
  static constexpr int kRows = static_cast<int>((kBelowMm + kBeyondMm) / kPixelMm);
  static constexpr int kColumns = static_cast<int>(2 * kHalfWidthMm / kPixelMm) + 1;
  static constexpr int kMiddleColumn = kColumns / 2;
  static constexpr int kMiddleRow = static_cast<int>(kBelowMm / kPixelMm);

  std::vector<cv::Mat> images;  ///< [phase of the stack]
  Affine index_from_pixel;      ///< (column, row, 0) -> index in the labels' grid
  double height_per_row = 0;    ///< along the LV's axis [mm]
  double threshold = 0;         ///< between muscle and blood
  double dark = 0;

  [[nodiscard]] static double height_mm(double row, double per_row) {
    return (row - kMiddleRow) * per_row;
  }
};

std::optional<StraightView> straighten(const Cine& view, const Axis& axis, const Grid& stack,
                                       std::size_t phases) {
  const Grid& grid = view.grid();
  const Vec3 normal =
      grid.mm_from_index.linear().col(0).cross(grid.mm_from_index.linear().col(1)).normalized();
  const double away = normal.dot(axis.middle - grid.mm(0, 0, 0));
  const double lean = std::abs(normal.dot(axis.towards_base));
  if (grid.size[2] != 1 || view.phase_count() < 2 || std::abs(away) > kMostAwayMm ||
      lean > std::sin(kMostTiltDeg * CV_PI / 180)) {
    return {};
  }
  StraightView out;
  const Vec3 up = (axis.towards_base - normal * normal.dot(axis.towards_base)).normalized();
  const Vec3 across = normal.cross(up);
  const Vec3 middle = axis.middle - away * normal;
  out.height_per_row = kPixelMm * up.dot(axis.towards_base);
  Affine mm_from_pixel = Affine::Identity();
  mm_from_pixel.linear().col(0) = kPixelMm * across;
  mm_from_pixel.linear().col(1) = kPixelMm * up;
  mm_from_pixel.linear().col(2) = normal;
  mm_from_pixel.translation() =
      middle - kPixelMm * (StraightView::kMiddleColumn * across + StraightView::kMiddleRow * up);
  out.index_from_pixel = stack.mm_from_index.inverse(Eigen::Affine) * mm_from_pixel;
  const Affine from = grid.mm_from_index.inverse(Eigen::Affine) * mm_from_pixel;
  cv::Mat x(StraightView::kRows, StraightView::kColumns, CV_32F);
  cv::Mat y(x.size(), CV_32F);
  for (int r = 0; r < x.rows; ++r) {
    for (int c = 0; c < x.cols; ++c) {
      const Vec3 at = from * Vec3(c, r, 0);
      x.at<float>(r, c) = static_cast<float>(at[0]);
      y.at<float>(r, c) = static_cast<float>(at[1]);
    }
  }
  const auto n = static_cast<double>(view.phase_count());
  for (std::size_t p = 0; p < phases; ++p) {
    const double place = static_cast<double>(p) * n / static_cast<double>(phases);
    const auto q =
        static_cast<std::size_t>(std::lround(place)) % static_cast<std::size_t>(view.phase_count());
    const cv::Mat image(grid.size[1], grid.size[0], CV_32F,
                        const_cast<float*>(view.images.phases[q].data()));
    cv::Mat straight;
    cv::remap(image, straight, x, y, cv::INTER_LINEAR, cv::BORDER_CONSTANT, cv::Scalar(0));
    cv::GaussianBlur(straight, straight, {0, 0}, 1.0);
    out.images.push_back(straight);
  }
  return out;
}

/// Label of the stack at a pixel near one of its slices; background elsewhere.
std::uint8_t label_near_slice(const ViewSearch& s, const StraightView& view, std::size_t phase,
                              int row, int column, int* slice) {
  const Grid& grid = s.labels.grid;
  const Vec3 at = view.index_from_pixel * Vec3(column, row, 0);
  const int k = static_cast<int>(std::lround(at[2]));
  const int i = static_cast<int>(std::lround(at[0]));
  const int j = static_cast<int>(std::lround(at[1]));
  *slice = k;
  if (!grid.contains(i, j, k) || std::abs(at[2] - k) * grid.spacing_mm()[2] > kNearSliceMm) {
    return kLabelBackground;
  }
  return s.labels.phases[phase][grid.offset(i, j, k)];
}

/// Levels of the view from the slices apical of `below_k`; false if they tell no blood from muscle.
bool set_levels(const ViewSearch& s, int below_k, StraightView& view) {
  std::vector<float> blood;
  std::vector<float> muscle;
  for (std::size_t p = 0; p < view.images.size(); ++p) {
    for (int r = 0; r < StraightView::kRows; ++r) {
      for (int c = 0; c < StraightView::kColumns; ++c) {
        int k = 0;
        const std::uint8_t label = label_near_slice(s, view, p, r, c, &k);
        if (label == kLabelBackground || s.base_step * (k - below_k) > 0) continue;
        if (label == kLabelLvBlood) blood.push_back(view.images[p].at<float>(r, c));
        if (label == kLabelLvMyocardium) muscle.push_back(view.images[p].at<float>(r, c));
      }
    }
  }
  if (blood.empty() || muscle.empty()) return false;
  const auto middle = [](std::vector<float>& values) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), at, values.end());
    return static_cast<double>(*at);
  };
  const double b = middle(blood);
  const double m = middle(muscle);
  view.threshold = 0.5 * (b + m);
  view.dark = kDark * m;
  return b > kLeastContrast * m;
}

/// The wall on one side where a slice shows it.
struct WallStart {
  int row = 0;
  int column = 0;  ///< outermost of the cavity
  double wall_mm = kUnknownWallMm;
};

std::optional<WallStart> wall_start(const ViewSearch& s, const StraightView& view,
                                    std::size_t phase, int start_k, int side) {
  std::optional<WallStart> out;
  double wall = 0;
  const auto scan = [&](const auto& visit) {
    for (int r = 0; r < StraightView::kRows; ++r) {
      for (int c = 0; c < StraightView::kColumns; ++c) {
        int k = 0;
        const std::uint8_t label = label_near_slice(s, view, phase, r, c, &k);
        if (label != kLabelBackground && k == start_k) visit(r, c, label);
      }
    }
  };
  scan([&](int r, int c, std::uint8_t label) {
    if (label == kLabelLvBlood && (!out || side * (c - out->column) > 0)) out = WallStart{r, c};
  });
  if (!out) return out;
  scan([&](int, int c, std::uint8_t label) {
    const double away = side * (c - out->column) * kPixelMm;
    if (label == kLabelLvMyocardium && away < kMostWallMm) wall = std::max(wall, away);
  });
  if (wall > 0) out->wall_mm = wall;
  return out;
}

/// Row at which the wall that begins at `start` is last as thick as a ventricle's.
int follow_wall(const StraightView& view, const cv::Mat& image, const WallStart& start, int side) {
  double inside = start.column;
  int last = start.row;
  const double least = kThickOfWall * start.wall_mm / kPixelMm;
  for (int r = start.row; r < image.rows && (r - last) * kPixelMm < kGapMm; ++r) {
    const auto* row = image.ptr<float>(r);
    double best = 1e9;
    double found = 0;
    int run = 0;
    for (int c = 0; c <= image.cols; ++c) {
      const bool muscle =
          c < image.cols && row[c] > view.dark && static_cast<double>(row[c]) < view.threshold;
      if (muscle) {
        ++run;
        continue;
      }
      if (run >= least) {
        const double inner = side > 0 ? c - run : c - 1;
        const double outward_mm = side * (inner - inside) * kPixelMm;
        if (outward_mm > -kInwardMm && outward_mm < kOutwardMm && std::abs(outward_mm) < best) {
          best = std::abs(outward_mm);
          found = inner;
        }
      }
      run = 0;
    }
    if (best > kOutwardMm) continue;
    inside = found;
    last = r;
  }
  return last;
}

/// Row at which the blood about the axis ends toward the apex; none if it does not.
std::optional<int> cavity_end(const StraightView& view, const cv::Mat& image) {
  double centre = StraightView::kMiddleColumn;
  for (int r = StraightView::kMiddleRow; r > 0; --r) {
    const auto* row = image.ptr<float>(r);
    const auto blood = [&](int c) { return static_cast<double>(row[c]) > view.threshold; };
    int at = -1;
    for (int d = 0; d * kPixelMm < kNearAxisMm && at < 0; ++d) {
      for (const int c : {static_cast<int>(centre) - d, static_cast<int>(centre) + d}) {
        if (c >= 0 && c < image.cols && blood(c)) at = c;
      }
    }
    if (at < 0) return r;
    int low = at;
    int high = at;
    while (low > 0 && blood(low - 1)) --low;
    while (high + 1 < image.cols && blood(high + 1)) ++high;
    if ((high - low) * kPixelMm > kMostCavityMm) return {};
    centre += 0.3 * (0.5 * (low + high) - centre);
  }
  return {};
}

/// Mean of the values in the window that holds most of them.
struct Mode {
  double value = 0;
  double share = 0;
};

std::optional<Mode> mode_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  std::size_t most = 0;
  Mode out;
  for (std::size_t first = 0; first < values.size(); ++first) {
    double sum = 0;
    std::size_t last = first;
    for (; last < values.size() && values[last] <= values[first] + kWindowMm; ++last) {
      sum += values[last];
    }
    if (last - first <= most) continue;
    most = last - first;
    out.value = sum / static_cast<double>(most);
  }
  out.share = static_cast<double>(most) / static_cast<double>(values.size());
  return out;
}

/// A height for every phase from those of all views, each phase's own counting twice, its
/// neighbours' once; smooth in time.
struct Settled {
  std::vector<double> height_mm;
  double agreement = 0;
};

std::optional<Settled> settle(const std::vector<std::vector<double>>& seen) {
  const std::size_t n = seen.size();
  const auto reach = static_cast<std::size_t>(std::lround(kSteadyOfCycle * static_cast<double>(n)));
  Settled out;
  std::vector<double> raw;
  for (std::size_t p = 0; p < n; ++p) {
    std::vector<double> near = seen[p];
    for (std::size_t d = 0; d <= 2 * reach; ++d) {
      const std::vector<double>& other = seen[(p + n + d - reach) % n];
      near.insert(near.end(), other.begin(), other.end());
    }
    const std::optional<Mode> mode = mode_of(near);
    if (!mode) return {};
    raw.push_back(mode->value);
    out.agreement += mode->share / static_cast<double>(n);
  }
  // Each time half of the value, half of those beside it.
  for (int pass = 0; pass < kSmoothings; ++pass) {
    out.height_mm = raw;
    for (std::size_t p = 0; p < n; ++p) {
      const double beside = 0.5 * (raw[(p + n - reach) % n] + raw[(p + reach) % n]);
      out.height_mm[p] = 0.5 * (raw[p] + beside);
    }
    raw = out.height_mm;
  }
  return out;
}

}  // namespace

std::optional<LvEndsInViews> find_lv_ends_in_views(const ViewSearch& search, std::string& trouble) {
  trouble.clear();
  if (search.lv_slices.size() < 3) return {};
  const Grid& grid = search.labels.grid;
  const double slice_mm = grid.spacing_mm()[2];
  const int basal = search.base_step > 0 ? search.lv_slices.back() : search.lv_slices.front();
  const int apical = search.base_step > 0 ? search.lv_slices.front() : search.lv_slices.back();
  const Axis axis = axis_of(search);
  const std::size_t n = search.labels.phases.size();
  std::vector<int> starts;
  for (const double below_mm : kStartBelowMm) {
    const int k = basal - search.base_step * static_cast<int>(std::ceil(below_mm / slice_mm));
    if (search.base_step * (k - apical) > 0) starts.push_back(k);
  }
  if (starts.empty()) return {};

  LvEndsInViews out;
  std::vector<std::vector<double>> bases(n);
  std::vector<std::vector<double>> apexes(n);
  for (const Cine& cine : search.views) {
    std::optional<StraightView> view = straighten(cine, axis, grid, n);
    if (!view || !set_levels(search, starts.front(), *view)) continue;
    ++out.views;
    parallel_for(n, [&](std::size_t p) {
      const cv::Mat& image = view->images[p];
      for (const int start_k : starts) {
        for (const int side : {-1, 1}) {
          if (const auto start = wall_start(search, *view, p, start_k, side)) {
            bases[p].push_back(StraightView::height_mm(follow_wall(*view, image, *start, side),
                                                       view->height_per_row));
          }
        }
      }
      if (const auto row = cavity_end(*view, image)) {
        apexes[p].push_back(StraightView::height_mm(*row, view->height_per_row));
      }
    });
  }
  if (out.views == 0) return {};

  const Affine index_from_mm = grid.mm_from_index.inverse(Eigen::Affine);
  const auto to_slices = [&](const std::vector<double>& heights) {
    std::vector<double> k;
    for (const double h : heights) {
      k.push_back((index_from_mm * Vec3(axis.middle + h * axis.towards_base))[2]);
    }
    return k;
  };
  const std::optional<Settled> base = settle(bases);
  if (!base || base->agreement < kLeastAgreement) {
    trouble =
        "the long-axis views do not agree on where the mitral valve lies; the left ventricle's "
        "base was placed by rule";
    return {};
  }
  out.base_k = to_slices(base->height_mm);
  const auto [least, most] = std::minmax_element(base->height_mm.begin(), base->height_mm.end());
  const double off_mm =
      std::abs(out.base_k[static_cast<std::size_t>(search.end_diastole)] - basal) * slice_mm;
  if (off_mm > kOffStackMm || *most - *least > kMostExcursionMm) {
    trouble =
        "the mitral valve as the long-axis views show it is too far from the stack's most basal "
        "slice of the left ventricle, or moves too far; the base was placed by rule";
    return {};
  }
  const std::optional<Settled> apex = settle(apexes);
  if (apex && apex->agreement >= kLeastAgreement) out.apex_k = to_slices(apex->height_mm);
  return out;
}

}  // namespace beatlas::segment
