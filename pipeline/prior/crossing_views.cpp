#include "pipeline/prior/crossing_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "pipeline/core/parallel.h"
#include "pipeline/prior/hearts.h"
#include "pipeline/prior/stored.h"
#include "pipeline/prior/window.h"
#include "runtime/atlas/structures.h"

namespace beatlas::prior {
namespace {

/// [mm] Standard deviation of how far a breath-hold moves a slice; McLeish 2002,
/// doi:10.1109/TMI.2002.804427, the largest of phantom/family.json.
constexpr double kShiftMm = 4;
/// [mm] Half of a view's thickness; Schulz-Menger 2020, doi:10.1186/s12968-020-00610-6: 6 to 10 mm.
/// With 8 mm draws lose up to .003.
constexpr double kHalfViewMm = 4;
/// Sine of the least angle between a view and the slices that it crosses.
constexpr double kLeastSine = 0.5;
/// Where the search for a mixture's weight begins, and the step at which it ends.
constexpr double kFirstUnknown = 0.1;
constexpr double kSettled = 1e-5;
constexpr int kMostRounds = 1000;
/// [mm] Of a line, see unknown_share. Chosen; with none draws are the same to .001 and volumes of a
/// real exam to 1 ml.
constexpr double kKnownMm = 10;
/// A view that does not know as often as it knows is none.
constexpr double kMostUnknown = 0.5;
/// A view that weighs less changes no stored probability.
constexpr double kLeastHeed = 1e-3;

/// What views and slices are compared by.
enum Kind : std::size_t { kOther, kMuscle, kLeftBlood, kRightBlood, kKinds };
using Kinds = std::array<double, kKinds>;
constexpr double kEven = 1 / static_cast<double>(kKinds);

Kind kind_of(std::uint8_t label) {
  if (label == kLabelLvMyocardium) return kMuscle;
  if (is_among(kLeftBloodLabels, label)) return kLeftBlood;
  return is_among(kRightBloodLabels, label) ? kRightBlood : kOther;
}

/// [output] probabilities of a place, 1 in sum.
using Likely = std::vector<double>;

void likely_at(const PriorCycle& prior, std::size_t phase, std::size_t voxel, Likely& out) {
  const std::size_t count = prior.grid.count();
  out.resize(prior.labels.size());
  for (std::size_t o = 0; o < out.size(); ++o) {
    const std::int8_t log = prior.phases[phase][o * count + voxel];
    out[o] = static_cast<double>(stored_probabilities()[static_cast<std::size_t>(-log)]);
  }
  const double all = std::accumulate(out.begin(), out.end(), 0.0);
  for (double& p : out) p /= all;
}

Kinds kinds_of(const std::vector<std::uint8_t>& labels, const Likely& likely) {
  Kinds out{};
  for (std::size_t o = 0; o < labels.size(); ++o) out[kind_of(labels[o])] += likely[o];
  return out;
}

/// [pixel][output]
using Image = std::vector<float>;

/// One way of a Gaussian blur; beyond the image is nothing to be told.
Image blurred_along(const Image& image, const Grid& grid, std::size_t outputs, const Index3& step,
                    double sigma_pixels) {
  const int reach = static_cast<int>(std::ceil(3 * sigma_pixels));
  Image out(image.size());
  Likely sum(outputs);
  for (int j = 0; j < grid.size[1]; ++j) {
    for (int i = 0; i < grid.size[0]; ++i) {
      std::fill(sum.begin(), sum.end(), 0.0);
      double weights = 0;
      for (int n = -reach; n <= reach; ++n) {
        const int a = i + n * step[0];
        const int b = j + n * step[1];
        if (!grid.contains(a, b, 0)) continue;
        const double weight = std::exp(-0.5 * n * n / (sigma_pixels * sigma_pixels));
        const float* from = image.data() + grid.offset(a, b, 0) * outputs;
        for (std::size_t o = 0; o < outputs; ++o) sum[o] += weight * static_cast<double>(from[o]);
        weights += weight;
      }
      float* to = out.data() + grid.offset(i, j, 0) * outputs;
      for (std::size_t o = 0; o < outputs; ++o) to[o] = static_cast<float>(sum[o] / weights);
    }
  }
  return out;
}

/// [phase] what a view says, as far as shifts leave it sure.
std::vector<Image> told_by(const PriorCycle& view) {
  std::vector<Image> out(view.phases.size());
  const std::size_t outputs = view.labels.size();
  const double sigma = kShiftMm / view.grid.spacing_mm()[0];
  parallel_for(out.size(), [&](std::size_t p) {
    Image image(view.grid.slice_count() * outputs);
    Likely likely;
    for (std::size_t v = 0; v < view.grid.slice_count(); ++v) {
      likely_at(view, p, v, likely);
      std::transform(likely.begin(), likely.end(),
                     image.begin() + static_cast<std::ptrdiff_t>(v * outputs),
                     [](double share) { return static_cast<float>(share); });
    }
    const Image along = blurred_along(image, view.grid, outputs, {1, 0, 0}, sigma);
    out[p] = blurred_along(along, view.grid, outputs, {0, 1, 0}, sigma);
  });
  return out;
}

/// A view, and the lines in which it meets the slices.
struct Crossing {
  Grid view;
  std::vector<Image> told;                      ///< [phase]
  double unknown = 0;                           ///< how often it does not know, over all slices
  Affine view_from_stack = Affine::Identity();  ///< indices
  Vec3 across = Vec3::Zero();   ///< step of the stack's index: 1 mm across the line, in the slice
  double mm_of_view_index = 1;  ///< such millimetres to the plane beside the view's own

  /// Distance of a place of a slice from the line [mm], with a sign.
  [[nodiscard]] double distance_mm(const Vec3& index) const {
    return (view_from_stack * index)[2] * mm_of_view_index;
  }
  /// The view's pixel beside a place of a slice; none beyond the view.
  [[nodiscard]] std::optional<std::size_t> beside(const Vec3& index) const {
    const Vec3 at = view_from_stack * Vec3(index - distance_mm(index) * across);
    const int i = static_cast<int>(std::lround(at[0]));
    const int j = static_cast<int>(std::lround(at[1]));
    if (!view.contains(i, j, 0)) return {};
    return view.offset(i, j, 0);
  }
  void told_at(std::size_t phase, std::size_t pixel, Likely& out) const {
    const auto from = told[phase].begin() + static_cast<std::ptrdiff_t>(pixel * out.size());
    std::copy(from, from + static_cast<std::ptrdiff_t>(out.size()), out.begin());
  }
};

Vec3 normal_of(const Grid& grid) {
  const Eigen::Matrix3d axes = grid.mm_from_index.linear();
  return axes.col(0).cross(axes.col(1)).normalized();
}

Crossing crossing(const PriorCycle& view, const Grid& stack) {
  const Vec3 normal = normal_of(view.grid);
  const Vec3 of_slices = normal_of(stack);
  const Vec3 within = (normal - normal.dot(of_slices) * of_slices).normalized();
  Crossing out{.view = view.grid, .told = told_by(view)};
  out.view_from_stack = view.grid.mm_from_index.inverse() * stack.mm_from_index;
  out.across = stack.mm_from_index.linear().inverse() * within;
  out.mm_of_view_index = 1 / (out.view_from_stack.linear() * out.across)[2];
  return out;
}

/// How far what a place of the heart is tells what places beside it are.
class Sameness {
 public:
  /// Measured in the slices themselves, along their rows and columns.
  explicit Sameness(const PriorCycle& stack) : pixel_mm_(stack.grid.spacing_mm()[0]) {
    const Grid& grid = stack.grid;
    for (const int p : looked_at(stack.phase_count())) {
      std::vector<Kind> kinds(grid.count());
      for (std::size_t v = 0; v < kinds.size(); ++v) {
        kinds[v] = kind_of(stack.likeliest(static_cast<std::size_t>(p), v));
      }
      for (int k = 0; k < grid.size[2]; ++k) count_pairs(grid, kinds, k);
    }
  }

  /// 1 at the place itself, 0 from where it tells no more than chance does.
  [[nodiscard]] double at(double mm) const {
    const double pixels = std::min(std::abs(mm) / pixel_mm_, kPixels - 1.0);
    const auto below = static_cast<std::size_t>(pixels);
    const std::size_t above = std::min<std::size_t>(below + 1, kPixels - 1);
    const double part = pixels - static_cast<double>(below);
    const double share = (1 - part) * share_at(below) + part * share_at(above);
    return std::max(0.0, (share - kEven) / (1 - kEven));
  }

 private:
  static constexpr int kPixels = 25;

  void count_pairs(const Grid& grid, const std::vector<Kind>& kinds, int k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Kind here = kinds[grid.offset(i, j, k)];
        if (here == kOther) continue;
        for (int d = 0; d < kPixels; ++d) {
          if (i + d < grid.size[0]) count_pair(d, here == kinds[grid.offset(i + d, j, k)]);
          if (j + d < grid.size[1]) count_pair(d, here == kinds[grid.offset(i, j + d, k)]);
        }
      }
    }
  }

  void count_pair(int pixels, bool same) {
    const auto d = static_cast<std::size_t>(pixels);
    ++pairs_[d];
    if (same) ++same_[d];
  }

  [[nodiscard]] double share_at(std::size_t pixels) const {
    return pairs_[pixels] > 0 ? same_[pixels] / pairs_[pixels] : 0;
  }

  double pixel_mm_;
  std::array<double, kPixels> pairs_{};  ///< places of the heart, and others so many pixels away
  std::array<double, kPixels> same_{};   ///< of them, of one kind
};

/// Adds, of the places of a line in a slice, how much likelier what slice and view say is if both
/// know than if one of them does not. Where both say that nothing is there, nothing is compared.
void compare(const Crossing& line, const PriorCycle& stack, int k, std::vector<double>& out) {
  const Grid& grid = stack.grid;
  const double on_line = 0.5 * grid.spacing_mm()[0];
  Likely likely;
  Likely view(stack.labels.size());
  for (int j = 0; j < grid.size[1]; ++j) {
    for (int i = 0; i < grid.size[0]; ++i) {
      const Vec3 index(i, j, k);
      if (std::abs(line.distance_mm(index)) > on_line) continue;
      const auto beside = line.beside(index);
      if (!beside) continue;
      for (std::size_t p = 0; p < stack.phases.size(); ++p) {
        likely_at(stack, p, grid.offset(i, j, k), likely);
        line.told_at(p, *beside, view);
        const Kinds said = kinds_of(stack.labels, likely);
        const Kinds told = kinds_of(stack.labels, view);
        if (told[kOther] > 0.5 && said[kOther] > 0.5) continue;
        const double both = std::inner_product(told.begin(), told.end(), said.begin(), 0.0);
        out.push_back(line.unknown + (1 - line.unknown) * both / kEven);
      }
    }
  }
}

/// The likeliest share of places at which one of them does not know. Both are taken to know until
/// places of one centimetre of a line speak against it, in all phases.
double unknown_share(const std::vector<double>& agreement, const PriorCycle& stack) {
  if (agreement.empty()) return 0;
  const double known_before = kKnownMm / stack.grid.spacing_mm()[0] * stack.phase_count();
  const double all = known_before + static_cast<double>(agreement.size());
  double unknown = kFirstUnknown;
  for (int round = 0; round < kMostRounds; ++round) {
    double sum = 0;
    for (const double known : agreement) sum += unknown / (unknown + (1 - unknown) * known);
    const double before = std::exchange(unknown, sum / all);
    if (std::abs(unknown - before) < kSettled) break;
  }
  return unknown;
}

double unknown_in_view(const Crossing& line, const PriorCycle& stack) {
  std::vector<double> agreement;
  for (int k = 0; k < stack.grid.size[2]; ++k) compare(line, stack, k, agreement);
  return unknown_share(agreement, stack);
}

double unknown_in_slice(const std::vector<Crossing>& crossings, const PriorCycle& stack, int k) {
  std::vector<double> agreement;
  for (const Crossing& line : crossings) compare(line, stack, k, agreement);
  return unknown_share(agreement, stack);
}

/// Whether the network sees an atrium in a slice, in any phase.
bool holds_atrium(const PriorCycle& stack, int k) {
  const std::size_t first = stack.grid.offset(0, 0, k);
  for (std::size_t p = 0; p < stack.phases.size(); ++p) {
    for (std::size_t v = first; v < first + stack.grid.slice_count(); ++v) {
      const std::uint8_t label = stack.likeliest(p, v);
      if (label == kLabelLaBlood || label == kLabelRaBlood) return true;
    }
  }
  return false;
}

/// The view that is nearest to a place of a slice.
struct Nearest {
  const Crossing* line = nullptr;
  std::size_t beside = 0;
  double mm = 0;
};

std::optional<Nearest> nearest_view(const std::vector<Crossing>& crossings, const Vec3& index) {
  std::optional<Nearest> out;
  for (const Crossing& line : crossings) {
    const double mm = std::abs(line.distance_mm(index));
    if (out && mm >= out->mm) continue;
    if (const auto beside = line.beside(index)) out = Nearest{&line, *beside, mm};
  }
  return out;
}

/// What is known of a slice.
struct Known {
  double unknown = 0;  ///< how often it does not know
  bool base = false;   ///< it shows an atrium
};

/// Where ventricles end a view is asked for blood of the right heart alone.
void leave_left_heart(Kinds& told) {
  const double even = (told[kOther] + told[kMuscle] + told[kLeftBlood]) / 3;
  told[kOther] = told[kMuscle] = told[kLeftBlood] = even;
}

/// Makes one of what a slice says of a place and what the view beside it tells.
/// @param within,alone weights of the view: where the slice knows, and where it does not
void heed(const std::vector<std::uint8_t>& labels, const Likely& view, bool base, double within,
          double alone, Likely& likely) {
  const Kinds said = kinds_of(labels, likely);
  Kinds told = kinds_of(labels, view);
  if (base) leave_left_heart(told);
  Kinds both{};
  for (std::size_t c = 0; c < kKinds; ++c) {
    both[c] = said[c] * (within * told[c] / kEven + 1 - within);
  }
  const double sum = std::accumulate(both.begin(), both.end(), 0.0);
  for (std::size_t o = 0; o < likely.size(); ++o) {
    const Kind c = kind_of(labels[o]);
    likely[o] = (1 - alone) * likely[o] / said[c] * both[c] / sum + alone * view[o];
  }
}

void heed_in_slice(const std::vector<Crossing>& crossings, const Sameness& sameness,
                   const Known& known, int k, PriorCycle& stack) {
  const Grid& grid = stack.grid;
  Likely likely;
  Likely view(stack.labels.size());
  for (int j = 0; j < grid.size[1]; ++j) {
    for (int i = 0; i < grid.size[0]; ++i) {
      const auto nearest = nearest_view(crossings, Vec3(i, j, k));
      if (!nearest) continue;
      const double sure = 1 - nearest->line->unknown;
      const double within = sure * std::exp(-0.5 * std::pow(nearest->mm / kHalfViewMm, 2));
      const double alone = sure * known.unknown * sameness.at(nearest->mm);
      if (std::max(within, alone) < kLeastHeed) continue;
      const std::size_t voxel = grid.offset(i, j, k);
      for (std::size_t p = 0; p < stack.phases.size(); ++p) {
        likely_at(stack, p, voxel, likely);
        nearest->line->told_at(p, nearest->beside, view);
        heed(stack.labels, view, known.base, within, alone, likely);
        for (std::size_t o = 0; o < likely.size(); ++o) {
          stack.phases[p][o * grid.count() + voxel] = stored_log(static_cast<float>(likely[o]));
        }
      }
    }
  }
}

}  // namespace

bool crosses(const Grid& view, const Grid& stack) {
  return normal_of(view).cross(normal_of(stack)).norm() >= kLeastSine;
}

HeededViews heed_views(const std::vector<PriorCycle>& views, PriorCycle& stack) {
  HeededViews out;
  out.unknown.assign(static_cast<std::size_t>(stack.grid.size[2]), 0);
  std::vector<Crossing> crossings;
  for (const PriorCycle& view : views) {
    if (!crosses(view.grid, stack.grid)) continue;
    Crossing line = crossing(view, stack.grid);
    line.unknown = unknown_in_view(line, stack);
    if (line.unknown < kMostUnknown) crossings.push_back(std::move(line));
  }
  out.views = static_cast<int>(crossings.size());
  if (crossings.empty()) return out;
  const Sameness sameness(stack);
  parallel_for(out.unknown.size(), [&](std::size_t k) {
    const int slice = static_cast<int>(k);
    const bool base = holds_atrium(stack, slice);
    if (!base) out.unknown[k] = unknown_in_slice(crossings, stack, slice);
    heed_in_slice(crossings, sameness, {out.unknown[k], base}, slice, stack);
  });
  return out;
}

}  // namespace beatlas::prior
