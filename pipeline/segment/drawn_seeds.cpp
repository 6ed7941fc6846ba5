#include "pipeline/segment/drawn_seeds.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <sstream>
#include <tuple>

#include "pipeline/core/words.h"
#include "runtime/base/error.h"

namespace beatlas::segment {
namespace {

constexpr double kMostSeedMm = 50;  ///< radius; a heart is hardly larger
/// Of a stroke at a time, so that the box around a slanting piece holds little else.
constexpr double kPieceVoxels = 12;

void check_seed(const Seed& seed, int phases) {
  if (seed.label > kLabelRestOfHeart) {
    throw_invalid("seed label " + std::to_string(seed.label) + " is not known; use 0 to 4");
  }
  if (!(seed.radius_mm > 0 && seed.radius_mm <= kMostSeedMm)) {
    throw_invalid("seed radius must be a number of mm above 0 and at most " +
                  std::to_string(static_cast<int>(kMostSeedMm)));
  }
  if (seed.phase < -1 || seed.phase >= phases) {
    throw_invalid("seed phase " + std::to_string(seed.phase) + " is not known; use 0 to " +
                  std::to_string(phases - 1) + ", or -1 for every phase");
  }
}

[[noreturn]] void refuse_outside(const Vec3& lps_mm) {
  std::ostringstream message;
  message << "seed at (" << lps_mm.transpose()
          << ") mm LPS lies outside the images; give its position in patient LPS mm";
  throw_invalid(message.str());
}

/// Whether the line from a to b passes through the box of half a voxel around the origin.
bool crosses_voxel(const Vec3& a, const Vec3& b) {
  constexpr double kHalf = 0.5;
  double enter = 0;
  double leave = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double step = b[axis] - a[axis];
    if (step == 0) {
      if (std::abs(a[axis]) > kHalf) return false;
      continue;
    }
    const double first = (-kHalf - a[axis]) / step;
    const double second = (kHalf - a[axis]) / step;
    enter = std::max(enter, std::min(first, second));
    leave = std::min(leave, std::max(first, second));
  }
  return enter <= leave;
}

/// Calls visit(offset) for the voxels around a straight piece from a to b [indices], those whose
/// centres lie within `reach` [voxels] of it and those that it crosses: a line between two thick
/// slices has no centre near. A piece without length is a ball.
template <class Visit>
void visit_piece(const Grid& grid, const Vec3& a, const Vec3& b, const Vec3& reach, Visit&& visit) {
  Index3 low{};
  Index3 high{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto n = static_cast<std::size_t>(axis);
    const double last = grid.size[n] - 1;
    const double first = std::min(a[axis], b[axis]) - reach[axis];
    const double end = std::max(a[axis], b[axis]) + reach[axis];
    // In doubles first: a place far outside fits no int.
    if (!(end >= 0 && first <= last)) return;
    low[n] = static_cast<int>(std::ceil(std::max(0.0, first)));
    high[n] = static_cast<int>(std::floor(std::min(last, end)));
  }
  const Vec3 along = (b - a).cwiseQuotient(reach);
  const double length2 = along.squaredNorm();
  for (int k = low[2]; k <= high[2]; ++k) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) {
        const Vec3 from_a = a - Vec3(i, j, k);
        const Vec3 scaled = from_a.cwiseQuotient(reach);
        const double t = length2 > 0 ? std::clamp(-scaled.dot(along) / length2, 0.0, 1.0) : 0.0;
        const bool near = (scaled + t * along).squaredNorm() <= 1.0 + 1e-9;
        if (near || crosses_voxel(from_a, b - Vec3(i, j, k))) visit(grid.offset(i, j, k));
      }
    }
  }
}

}  // namespace

std::vector<std::size_t> voxels_of(const Grid& grid, const Seed& seed) {
  const Affine index_from_lps = grid.mm_from_index.inverse();
  const Vec3 reach = (seed.radius_mm * grid.spacing_mm().cwiseInverse()).cwiseMax(0.5);
  std::vector<std::size_t> voxels;
  const auto add = [&](std::size_t v) { voxels.push_back(v); };
  Vec3 from = index_from_lps * seed.lps_mm;
  if (seed.stroke_lps_mm.empty()) visit_piece(grid, from, from, reach, add);
  for (const Vec3& place : seed.stroke_lps_mm) {
    const Vec3 to = index_from_lps * place;
    const double length = (to - from).cwiseAbs().maxCoeff();
    // A place that is no number or far away makes one piece, which is then outside.
    const int pieces = length <= 1e6 ? 1 + static_cast<int>(length / kPieceVoxels) : 1;
    for (int piece = 0; piece < pieces; ++piece) {
      visit_piece(grid, from + (to - from) * piece / pieces,
                  from + (to - from) * (piece + 1) / pieces, reach, add);
    }
    from = to;
  }
  if (!std::is_sorted(voxels.begin(), voxels.end())) std::sort(voxels.begin(), voxels.end());
  voxels.erase(std::unique(voxels.begin(), voxels.end()), voxels.end());
  return voxels;
}

std::string seed_told(const std::vector<Seed>& seeds, std::size_t at) {
  const Seed& seed = seeds[at];
  const Vec3& mm = seed.lps_mm;
  char text[200];
  const std::string named = seed.painted ? "what is painted" : "seed " + std::to_string(at + 1);
  std::snprintf(text, sizeof text, "%s, %s at (%.0f, %.0f, %.0f) mm LPS, %s,", named.c_str(),
                std::string(kLabelWords.at(seed.label)).c_str(), mm[0], mm[1], mm[2],
                seed.phase < 0 ? "every phase" : ("phase " + std::to_string(seed.phase)).c_str());
  return text;
}

namespace {

/// What the image is instead of what the label is; null where it fits or nothing can be told.
const char* looks_wrong(std::uint8_t label, double level, const tissue::TissueLevels& levels) {
  constexpr double kThird = 1.0 / 3;
  if (!(levels.blood > levels.muscle && levels.muscle > 0)) return nullptr;
  if (label == kLabelBackground) return nullptr;
  const bool blood = label == kLabelLvBlood || label == kLabelRvBlood;
  const double share = (level - levels.muscle) / (levels.blood - levels.muscle);
  if (level < levels.dark) return "as dark as lung";
  if (blood && share < kThird) return "as dark as muscle";
  if (label == kLabelLvMyocardium && share > 1 - kThird) return "as bright as blood";
  return nullptr;
}

}  // namespace

void check_seeds(const std::vector<Seed>& seeds, const Grid& grid, int phases) {
  for (const Seed& seed : seeds) {
    check_seed(seed, phases);
    Seed place = seed;
    place.stroke_lps_mm.clear();
    if (voxels_of(grid, place).empty()) refuse_outside(place.lps_mm);
    for (const Vec3& lps_mm : seed.stroke_lps_mm) {
      place.lps_mm = lps_mm;
      if (voxels_of(grid, place).empty()) refuse_outside(lps_mm);
    }
  }
}

Box box_with_seeds(const Grid& grid, const Box& box, std::vector<Seed>& seeds) {
  Box out = box;
  for (const Seed& seed : seeds) {
    if (seed.label == kLabelBackground) continue;
    out = widened(grid, out, box_around_voxels(grid, voxels_of(grid, seed)));
  }
  // Only now is it known how far the box reaches.
  std::erase_if(seeds, [&](const Seed& seed) {
    if (seed.label != kLabelBackground) return false;
    const std::vector<std::size_t> voxels = voxels_of(grid, seed);
    return std::none_of(voxels.begin(), voxels.end(),
                        [&](std::size_t v) { return out.contains(index_of(grid, v)); });
  });
  return out;
}

void draw_seeds(const Grid& grid, const std::vector<Seed>& seeds, LabelImages& images) {
  std::vector<std::vector<std::size_t>> marked;
  for (const Seed& seed : seeds) {
    check_seed(seed, static_cast<int>(images.size()));
    marked.push_back(voxels_of(grid, seed));
    if (marked.back().empty()) refuse_outside(seed.lps_mm);
  }
  const auto for_each_place = [&](const auto& visit) {
    for (std::size_t s = 0; s < seeds.size(); ++s) {
      for (std::size_t p = 0; p < images.size(); ++p) {
        if (seeds[s].phase >= 0 && static_cast<std::size_t>(seeds[s].phase) != p) continue;
        for (std::size_t v : marked[s]) visit(seeds[s], p, v);
      }
    }
  };
  // First what the drawn seeds replace, then the seeds, so that no seed erases another. A ball of
  // background says what lies there, not that all else around the heart is no longer background.
  std::set<std::tuple<std::size_t, std::size_t, std::uint8_t>> cleared;
  for_each_place([&](const Seed& seed, std::size_t p, std::size_t v) {
    if (seed.label == kLabelBackground) return;
    const std::size_t k = v / grid.slice_count();
    if (!cleared.emplace(p, k, seed.label).second) return;
    const auto from = images[p].begin() + static_cast<std::ptrdiff_t>(k * grid.slice_count());
    std::replace(from, from + static_cast<std::ptrdiff_t>(grid.slice_count()), seed.label,
                 kUnlabelled);
  });
  for_each_place(
      [&](const Seed& seed, std::size_t p, std::size_t v) { images[p][v] = seed.label; });
}

void part_marked(tissue::TissueLevels& levels) {
  if (!(levels.blood > levels.muscle)) {
    throw_invalid(
        "seeds of muscle lie on tissue that is no darker than blood; move them, or those of "
        "blood");
  }
  levels.part();
}

std::vector<std::string> doubtful_seeds(const ImageCycle<float>& images,
                                        const std::vector<Seed>& seeds,
                                        const tissue::TissueLevels& levels) {
  constexpr std::size_t kMost = 5;
  std::vector<std::string> out;
  std::size_t more = 0;
  std::vector<std::size_t> numbered;  // of the sentences
  for (std::size_t s = 0; s < seeds.size(); ++s) {
    const Seed& seed = seeds[s];
    double sum = 0;
    std::size_t count = 0;
    const std::vector<std::size_t> marked = voxels_of(images.grid, seed);
    for (std::size_t p = 0; p < images.phases.size(); ++p) {
      if (seed.phase >= 0 && static_cast<std::size_t>(seed.phase) != p) continue;
      for (const std::size_t v : marked) {
        sum += images.phases[p][v];
        ++count;
      }
    }
    if (count == 0) continue;
    const char* looks = looks_wrong(seed.label, sum / static_cast<double>(count), levels);
    if (looks == nullptr) continue;
    if (out.size() == kMost) {
      ++more;
      continue;
    }
    const std::string told = seed_told(seeds, s) + " lies where the image is " + looks;
    if (seed.painted) {
      out.push_back(told + "; if that is a slip, paint it anew");
      continue;
    }
    numbered.push_back(out.size());
    out.push_back(told + "; if that is a slip, take it out with 'beatlas seeds STUDY remove " +
                  std::to_string(s + 1) + "'");
  }
  if (numbered.size() > 1) {
    out[numbered.back()] += "; name all that are to go at once, for numbers move up";
  }
  if (more > 0) out.back() += "; the same of " + counted(more, "more seed");
  return out;
}

}  // namespace beatlas::segment
