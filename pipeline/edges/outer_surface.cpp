#include "pipeline/edges/outer_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pipeline/core/box.h"
#include "pipeline/core/box_share.h"
#include "pipeline/core/faces.h"
#include "pipeline/core/parallel.h"
#include "pipeline/edges/clefts.h"
#include "pipeline/edges/coverage.h"
#include "pipeline/edges/magnitude.h"
#include "pipeline/edges/slice_image.h"
#include "pipeline/edges/surfels.h"
#include "pipeline/edges/tissue_layers.h"
#include "runtime/atlas/structures.h"

namespace beatlas::edges {
namespace {

constexpr double kPitchMm = 3;
constexpr int kLookRounds = 2;       ///< the second from where the first one put the surface
constexpr double kPatchMm = 3;       ///< voxels so far from a piece's normal tell of it
constexpr double kPatchSigma = 1.8;  ///< [mm] Gaussian of their weights
constexpr double kOthersMm = 3;      ///< so far out labels are of another piece
constexpr double kMisfit = 0.04;     ///< of blood's contrast, by which a flat piece may be off
constexpr double kMisfitOut = 0.08;  ///< the same for each millimetre beyond:
constexpr double kTrustOutMm = 2.5;  ///< what lies farther out is of many levels
constexpr double kMisfitIn = 0.04;
constexpr double kTrustInMm = 4;
constexpr double kPoolMm = 5;       ///< Gaussian over which thickness is shared
constexpr double kPoolReach = 12;   ///< [mm]
constexpr double kPoolAlike = 0.8;  ///< cosine of the angle between normals
constexpr double kMostSay = 30;     ///< of one piece, in variances
constexpr double kShared = 6;       ///< pieces that see the same voxels
constexpr double kSureFat = 2;      ///< by which fat has to explain more than none, in variances
constexpr double kExplained = 24;   ///< variances a bin, up to which four tissues explain a piece
constexpr std::size_t kLeastBins = 10;
constexpr double kLungMixture = 0.8;  ///< of muscle's level: darker is a gap of lung, in part
constexpr double kAcrossLung = 0.3;   ///< of blood's contrast, by which it is brighter beyond
constexpr double kLungFromMm = -1;    ///< outside of a piece
constexpr double kReachMm = 4.2;      ///< from a piece to voxels whose coverage it tells
constexpr double kBlendMm = 2.2;      ///< Gaussian between pieces
constexpr double kSheetAlike = 0.75;  ///< cosine of the angle between normals of one sheet
constexpr double kStepMm = 1;         ///< inward, in search of the heart
constexpr int kSteps = 6;
constexpr std::array<std::size_t, 2> kFirstTries{0, 6};  ///< of kFatThicknessMm

/// A piece and what was found out about it.
struct Piece {
  Surfel surfel;
  LayersByThickness layers{};
  std::size_t bins = 0;
  std::size_t fat = 0;  ///< of kFatThicknessMm, the nearest to what was found
  double edge_mm = 0;   ///< outside of the surfel
  bool explained = false;
};

/// Pieces that face each other may dig hollows between them: what of the heart's labels does not
/// hang together with the outside is the heart's.
void fill_hollows(const Grid& grid, const std::vector<std::uint8_t>& labels,
                  std::vector<float>& coverage) {
  std::vector<std::uint8_t> waits(coverage.size(), 0);
  std::vector<std::uint32_t> waiting;
  for (std::size_t v = 0; v < coverage.size(); ++v) {
    if (coverage[v] >= 0.5F || labels[v] == kLabelBackground) continue;
    waits[v] = 1;
    waiting.push_back(static_cast<std::uint32_t>(v));
  }
  std::vector<std::uint32_t> front;
  for (const std::uint32_t v : waiting) {
    for_faces(grid, v, [&](std::size_t near) {
      if (coverage[near] >= 0.5F || labels[near] != kLabelBackground || waits[v] == 0) return;
      waits[v] = 0;
      front.push_back(v);
    });
  }
  while (!front.empty()) {
    const std::size_t from = front.back();
    front.pop_back();
    for_faces(grid, from, [&](std::size_t v) {
      if (waits[v] == 0) return;
      waits[v] = 0;
      front.push_back(static_cast<std::uint32_t>(v));
    });
  }
  for (std::size_t v = 0; v < coverage.size(); ++v) {
    if (waits[v] != 0) coverage[v] = 1;
  }
}

/// What lies beyond a gap of lung is of another wall, or fat on it: it tells nothing of this one.
/// @return how many bins that is
std::size_t leave_across_lung(const LayerLevels& levels, SurfaceProfile& profile) {
  const double most_lung = kLungMixture * levels.muscle;
  const double rise = kAcrossLung * (levels.blood - levels.muscle);
  double least = most_lung;
  std::size_t at = SurfaceProfile::kBins;
  for (std::size_t n = 0; n < SurfaceProfile::kBins; ++n) {
    if (SurfaceProfile::middle_mm(n) < kLungFromMm || !(profile.variance[n] > 0)) continue;
    if (profile.mean[n] < least) {
      least = profile.mean[n];
      at = n;
    }
    if (at < n && profile.mean[n] > least + rise) break;
    if (n + 1 == SurfaceProfile::kBins) return 0;
  }
  std::size_t left = 0;
  for (std::size_t n = at + 1; n < SurfaceProfile::kBins; ++n) {
    left += profile.variance[n] > 0 ? 1 : 0;
    profile.variance[n] = 0;
  }
  return left;
}

/// One phase.
class Outside {
 public:
  Outside(const Grid& grid, const std::vector<float>& image, const LayerLevels& levels,
          const std::vector<std::uint8_t>& labels)
      : grid_(grid), spacing_(grid.spacing_mm()), image_(image), levels_(levels), labels_(labels) {}

  /// Looks for the surface about a coverage's, and where it was called before, beginning with what
  /// was found then.
  void fit(const std::vector<float>& coverage) {
    const std::vector<Piece> last = std::move(pieces_);
    std::vector<Vec3> places(last.size());
    std::transform(last.begin(), last.end(), places.begin(), [](const Piece& piece) {
      return Vec3(piece.surfel.at + piece.edge_mm * piece.surfel.normal);
    });
    const PlacesNearby nearby(std::move(places), 2 * kPitchMm);
    const std::vector<Surfel> surfels = surfels_of(grid_, coverage, kPitchMm);
    pieces_.assign(surfels.size(), {});
    parallel_for(surfels.size(), [&](std::size_t at) {
      const Surfel& surfel = surfels[at];
      Piece& piece = pieces_[at];
      piece.surfel = surfel;
      std::vector<std::size_t> begin;
      double least = std::numeric_limits<double>::infinity();
      nearby.visit(surfel.at, [&](std::size_t n, const Vec3& off) {
        if (last[n].surfel.normal.dot(surfel.normal) < kPoolAlike) return;
        if (!last[n].explained || !(off.squaredNorm() < least)) return;
        least = off.squaredNorm();
        begin.assign(1, last[n].fat);
      });
      if (begin.empty()) begin.assign(kFirstTries.begin(), kFirstTries.end());
      const SurfaceProfile profile = across(surfel, piece.bins);
      piece.layers = fit_layers(profile, levels_, surfel.normal, spacing_, begin);
    });
    share_thickness();
  }

  /// Coverage as the pieces have it, elsewhere as it was.
  void cover(std::vector<float>& coverage, std::vector<FatEdge>* edges) const {
    std::vector<float> nearest(grid_.count(), std::numeric_limits<float>::infinity());
    std::vector<std::uint32_t> whose(grid_.count(), 0);
    std::vector<std::uint32_t> slot(grid_.count(), 0);
    std::vector<std::uint32_t> voxels;  // within reach of a piece
    for (std::size_t n = 0; n < pieces_.size(); ++n) {
      for_near(pieces_[n], [&](std::size_t voxel, const Vec3& off) {
        const auto d = static_cast<float>(off.squaredNorm());
        if (!(d < nearest[voxel])) return;
        if (std::isinf(nearest[voxel])) voxels.push_back(static_cast<std::uint32_t>(voxel));
        nearest[voxel] = d;
        whose[voxel] = static_cast<std::uint32_t>(n);
      });
    }
    std::sort(voxels.begin(), voxels.end());
    for (std::size_t n = 0; n < voxels.size(); ++n) {
      slot[voxels[n]] = static_cast<std::uint32_t>(n);
    }
    struct Blend {
      double told = 0;
      double untold = 0;
      double outside_mm = 0;
      double sigma_mm = 0;
      Vec3 normal = Vec3::Zero();
    };
    std::vector<Blend> blends(voxels.size());
    for (const Piece& piece : pieces_) {
      for_near(piece, [&](std::size_t voxel, const Vec3& off) {
        const Piece& owner = pieces_[whose[voxel]];
        if (owner.surfel.normal.dot(piece.surfel.normal) < kSheetAlike) return;
        const double beyond = off.squaredNorm() - static_cast<double>(nearest[voxel]);
        const double weight = std::exp(-0.5 * beyond / (kBlendMm * kBlendMm));
        Blend& blend = blends[slot[voxel]];
        if (!piece.explained) {
          blend.untold += weight;
          return;
        }
        blend.told += weight;
        blend.outside_mm += weight * piece.surfel.outside_mm(off);
        blend.sigma_mm += weight * piece.layers.edge_sigma_mm;
        blend.normal += weight * piece.surfel.normal;
      });
    }
    for (std::size_t n = 0; n < blends.size(); ++n) {
      const std::size_t voxel = voxels[n];
      const Blend& blend = blends[n];
      if (!(blend.told > 0)) continue;
      const Vec3 normal = blend.normal.normalized();
      const double share = box_share(0.5 * spacing_, blend.outside_mm / blend.told, normal);
      const double part = blend.told / (blend.told + blend.untold);
      coverage[voxel] += static_cast<float>(part * (share - static_cast<double>(coverage[voxel])));
      if (edges == nullptr || part < 0.5) continue;
      edges->push_back({static_cast<std::uint32_t>(voxel), within(voxel, normal, coverage),
                        coverage[voxel], static_cast<float>(blend.sigma_mm / blend.told)});
    }
    fill_hollows(grid_, labels_, coverage);
    if (edges == nullptr) return;
    for (FatEdge& edge : *edges) edge.coverage = coverage[edge.voxel];
  }

 private:
  [[nodiscard]] Vec3 middle(int i, int j, int k) const {
    return Vec3(i, j, k).cwiseProduct(spacing_);
  }

  /// Calls visit(i, j, k) for voxels within a box.
  template <class Visit>
  void for_box(const Vec3& low, const Vec3& high, const Visit& visit) const {
    Index3 first{};
    Index3 last{};
    for (int axis = 0; axis < 3; ++axis) {
      first[axis] = std::max(0, static_cast<int>(std::ceil(low[axis] / spacing_[axis])));
      last[axis] =
          std::min(grid_.size[axis] - 1, static_cast<int>(std::floor(high[axis] / spacing_[axis])));
    }
    for (int k = first[2]; k <= last[2]; ++k) {
      for (int j = first[1]; j <= last[1]; ++j) {
        for (int i = first[0]; i <= last[0]; ++i) visit(i, j, k);
      }
    }
  }

  /// Calls visit(voxel, off) for voxels within reach of where a piece was found to lie.
  template <class Visit>
  void for_near(const Piece& piece, const Visit& visit) const {
    const Vec3 at = piece.surfel.at + piece.edge_mm * piece.surfel.normal;
    const Vec3 reach = Vec3::Constant(kReachMm);
    for_box(at - reach, at + reach, [&](int i, int j, int k) {
      const Vec3 off = middle(i, j, k) - at;
      if (off.squaredNorm() < kReachMm * kReachMm) visit(grid_.offset(i, j, k), off);
    });
  }

  /// What voxels across a piece hold. @param bins that tell something
  [[nodiscard]] SurfaceProfile across(const Surfel& surfel, std::size_t& bins) const {
    SurfaceProfile out;
    std::array<double, SurfaceProfile::kBins> sum{};
    std::array<double, SurfaceProfile::kBins> squares{};
    constexpr double kToMm =
        SurfaceProfile::kFromMm + SurfaceProfile::kBinMm * SurfaceProfile::kBins;
    const Vec3 inner = surfel.at + SurfaceProfile::kFromMm * surfel.normal;
    const Vec3 outer = surfel.at + kToMm * surfel.normal;
    Vec3 wide;
    for (int axis = 0; axis < 3; ++axis) {
      wide[axis] = kPatchMm * std::sqrt(std::max(0.0, 1 - std::pow(surfel.normal[axis], 2)));
    }
    for_box(inner.cwiseMin(outer) - wide, inner.cwiseMax(outer) + wide, [&](int i, int j, int k) {
      const Vec3 off = middle(i, j, k) - surfel.at;
      const double beside = off.squaredNorm() - std::pow(off.dot(surfel.normal), 2);
      if (beside > kPatchMm * kPatchMm) return;
      const double d = surfel.outside_mm(off);
      const double bin = (d - SurfaceProfile::kFromMm) / SurfaceProfile::kBinMm;
      if (!(bin >= 0) || bin >= static_cast<double>(SurfaceProfile::kBins)) return;
      const std::size_t voxel = grid_.offset(i, j, k);
      if (labels_[voxel] != 0 ? d > kOthersMm : d < -kOthersMm) return;
      const double weight = std::exp(-0.5 * beside / (kPatchSigma * kPatchSigma));
      const auto n = static_cast<std::size_t>(bin);
      out.mean[n] += weight * static_cast<double>(image_[voxel]);
      sum[n] += weight;
      squares[n] += weight * weight;
    });
    const double contrast = levels_.blood - levels_.muscle;
    bins = 0;
    for (std::size_t n = 0; n < SurfaceProfile::kBins; ++n) {
      if (!(sum[n] > 0)) continue;
      out.mean[n] = static_cast<double>(
          signal_of(static_cast<float>(out.mean[n] / sum[n]), static_cast<float>(levels_.noise)));
      const double d = SurfaceProfile::middle_mm(n);
      out.variance[n] = std::pow(levels_.noise, 2) * squares[n] / (sum[n] * sum[n]) +
                        std::pow(kMisfit * contrast, 2) +
                        std::pow(kMisfitOut * contrast * std::max(0.0, d - kTrustOutMm), 2) +
                        std::pow(kMisfitIn * contrast * std::max(0.0, -d - kTrustInMm), 2);
      ++bins;
    }
    bins -= leave_across_lung(levels_, out);
    return out;
  }

  /// A layer as thick as neighbours say together, and the edge that goes with it.
  void share_thickness() {
    std::vector<Vec3> places(pieces_.size());
    std::vector<std::array<double, kFatThicknessMm.size()>> costs(pieces_.size());
    for (std::size_t n = 0; n < pieces_.size(); ++n) {
      places[n] = pieces_[n].surfel.at;
      double least = std::numeric_limits<double>::infinity();
      for (const LayersAt& layers : pieces_[n].layers.at) least = std::min(least, layers.cost);
      for (std::size_t t = 0; t < costs[n].size(); ++t) {
        costs[n][t] = std::min(pieces_[n].layers.at[t].cost - least, kMostSay) / kShared;
      }
    }
    const PlacesNearby nearby(std::move(places), kPoolReach);
    for (Piece& piece : pieces_) {
      std::array<double, kFatThicknessMm.size()> cost{};
      nearby.visit(piece.surfel.at, [&](std::size_t n, const Vec3& off) {
        if (pieces_[n].surfel.normal.dot(piece.surfel.normal) < kPoolAlike) return;
        const double weight = std::exp(-0.5 * off.squaredNorm() / (kPoolMm * kPoolMm));
        for (std::size_t t = 0; t < cost.size(); ++t) cost[t] += weight * costs[n][t];
      });
      choose(cost, piece);
    }
  }

  static void choose(const std::array<double, kFatThicknessMm.size()>& cost, Piece& piece) {
    const auto best =
        static_cast<std::size_t>(std::min_element(cost.begin() + 1, cost.end()) - cost.begin());
    piece.fat = cost[best] + kSureFat < cost[0] ? best : 0;
    const LayersAt& layers = piece.layers.at[piece.fat];
    piece.edge_mm = layers.edge_mm;
    piece.explained =
        piece.bins >= kLeastBins && layers.cost < kExplained * static_cast<double>(piece.bins);
    if (!piece.explained) piece.edge_mm = 0;
    if (!piece.explained || piece.fat == 0 || piece.fat + 1 == cost.size()) return;
    // Least of the parabola through three thicknesses; the edge between two of them.
    const std::array<double, 3> t{kFatThicknessMm[piece.fat - 1], kFatThicknessMm[piece.fat],
                                  kFatThicknessMm[piece.fat + 1]};
    const double down = (cost[piece.fat] - cost[piece.fat - 1]) / (t[1] - t[0]);
    const double up = (cost[piece.fat + 1] - cost[piece.fat]) / (t[2] - t[1]);
    if (!(up > down)) return;
    const double least =
        std::clamp(0.5 * (t[0] + t[1] - down * (t[2] - t[0]) / (up - down)), t[0], t[2]);
    const std::size_t other = least < t[1] ? piece.fat - 1 : piece.fat + 1;
    const double share = std::abs(least - t[1]) / std::abs(kFatThicknessMm[other] - t[1]);
    piece.edge_mm += share * (piece.layers.at[other].edge_mm - piece.edge_mm);
  }

  /// The first voxel of the heart inward of one.
  [[nodiscard]] std::uint32_t within(std::size_t voxel, const Vec3& normal,
                                     const std::vector<float>& coverage) const {
    const Index3 begin = index_of(grid_, voxel);
    const Vec3 from = middle(begin[0], begin[1], begin[2]);
    for (int step = 0; step <= kSteps; ++step) {
      const Vec3 at = (from - step * kStepMm * normal).cwiseQuotient(spacing_);
      const Index3 index{static_cast<int>(std::lround(at[0])), static_cast<int>(std::lround(at[1])),
                         static_cast<int>(std::lround(at[2]))};
      if (!grid_.contains(index[0], index[1], index[2])) break;
      const std::size_t inside = grid_.offset(index[0], index[1], index[2]);
      if (coverage[inside] >= 0.5F && labels_[inside] != 0) {
        return static_cast<std::uint32_t>(inside);
      }
    }
    return FatEdge::kNowhere;
  }

  const Grid& grid_;
  Vec3 spacing_;
  const std::vector<float>& image_;
  const LayerLevels& levels_;
  const std::vector<std::uint8_t>& labels_;
  std::vector<Piece> pieces_;
};

/// Voxels that the surface leaves outside are none of the heart; those that it takes in are of the
/// LV's wall where that alone is near, else of the rest. What is as bright there as blood may be
/// fat and lung in one voxel, which atria must not grow into; what is as dark as lung is no wall.
void relabel(const Grid& grid, const std::vector<float>& image, const LayerLevels& levels,
             const std::vector<FatEdge>& edges, std::vector<std::uint8_t>& labels) {
  const double threshold = 0.5 * (levels.blood + levels.muscle);
  std::vector<std::uint8_t> taken_in(edges.size(), 0);
  for (std::size_t n = 0; n < edges.size(); ++n) {
    const FatEdge& edge = edges[n];
    if (edge.coverage < 0.5F || labels[edge.voxel] != 0) continue;
    const auto seen = static_cast<double>(image[edge.voxel]);
    if (seen > threshold || seen < kLungShare * levels.muscle) continue;
    const bool lv = edge.within != FatEdge::kNowhere && labels[edge.within] == kLabelLvMyocardium &&
                    !beside_others(grid, labels, edge.voxel);
    taken_in[n] = lv ? kLabelLvMyocardium : kLabelRestOfHeart;
  }
  for (std::size_t n = 0; n < edges.size(); ++n) {
    if (edges[n].coverage < 0.5F) labels[edges[n].voxel] = kLabelBackground;
    if (taken_in[n] != 0) labels[edges[n].voxel] = taken_in[n];
  }
}

}  // namespace

std::vector<std::vector<FatEdge>> fit_outer_surface(const ImageCycle<float>& images,
                                                    const LayerLevels& levels,
                                                    const std::vector<std::uint8_t>& stay,
                                                    ImageCycle<std::uint8_t>& labels) {
  std::vector<std::vector<FatEdge>> edges(images.phases.size());
  parallel_for(images.phases.size(), [&](std::size_t p) {
    std::vector<std::uint8_t>& phase = labels.phases[p];
    if (stay[p] != 0) return;
    if (levels.fat > levels.blood) let_others_in(images.grid, images.phases[p], levels, phase);
    std::vector<float> coverage(phase.size());
    std::transform(phase.begin(), phase.end(), coverage.begin(),
                   [](std::uint8_t label) { return label != 0 ? 1.0F : 0.0F; });
    Outside outside(images.grid, images.phases[p], levels, phase);
    for (int round = 0; round < kLookRounds; ++round) {
      outside.fit(coverage);
      outside.cover(coverage, round + 1 == kLookRounds ? &edges[p] : nullptr);
    }
    relabel(images.grid, images.phases[p], levels, edges[p], phase);
  });
  return edges;
}

}  // namespace beatlas::edges
