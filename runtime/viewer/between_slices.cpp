#include "runtime/viewer/between_slices.h"

#include <algorithm>
#include <cmath>

namespace beatlas::viewer {
namespace {

constexpr double kStepOfPixel = 1.3;  ///< between images, at least 1.5 mm
constexpr double kLeastStepMm = 1.5;
constexpr int kMostParts = 16;
constexpr double kNearMm = 4;          ///< standard deviation of how far a surface has the say
constexpr double kLeastWeight = 0.01;  ///< of a surface; farther ones have none
constexpr double kStayWeight = 0.02;   ///< of staying where one is
constexpr int kSteps = 6;              ///< of Newton's method towards the same distance
constexpr double kMostStepMm = 5;
constexpr double kLeastSlope = 0.05;  ///< square of a gradient's part in the slice
constexpr double kEnoughMm = 0.1;     ///< distances that are the same
constexpr double kSameMm = 1;         ///< standard deviation of distances that may be

std::size_t n(int value) { return static_cast<std::size_t>(value); }

/// Where in the slices before and after what a place shows is found: so far from it [pixels], to be
/// trusted so much, 0..1.
struct Bearing {
  std::array<double, 2> i{};
  std::array<double, 2> j{};
  std::array<double, 2> trust{};
};

/// @param share of the way from one to the other, 0..1
Bearing straight_between(const Bearing& one, const Bearing& other, double share) {
  Bearing out;
  for (std::size_t s = 0; s < 2; ++s) {
    out.i[s] = (1 - share) * one.i[s] + share * other.i[s];
    out.j[s] = (1 - share) * one.j[s] + share * other.j[s];
    out.trust[s] = (1 - share) * one.trust[s] + share * other.trust[s];
  }
  return out;
}

}  // namespace

bool BetweenSlices::far_apart(const atlas::VolumePayload& volume) {
  const Vec3 edges = volume.workspace_from_index.linear().colwise().norm();
  return volume.size[2] > 1 && edges[2] >= std::max(kLeastGapMm, 2 * std::max(edges[0], edges[1]));
}

BetweenSlices::BetweenSlices(const atlas::VolumePayload& volume,
                             std::vector<std::shared_ptr<const field::FieldQuery>> fields,
                             const Vec3& low_mm, const Vec3& high_mm)
    : size_(volume.size), fields_(std::move(fields)) {
  shape_.size = volume.size;
  shape_.workspace_from_index = volume.workspace_from_index;
  shape_.phases = volume.phases;
  const Vec3 edges = volume.workspace_from_index.linear().colwise().norm();
  const double pixel = std::max(edges[0], edges[1]);
  if (fields_.empty() || !far_apart(volume)) return;
  rr_interval_s_ = fields_.front()->rr_interval_s();
  const double step = std::max(kLeastStepMm, kStepOfPixel * pixel);
  parts_ = std::clamp(static_cast<int>(std::lround(edges[2] / step)), 2, kMostParts);
  beyond_ = parts_ / 2;
  shape_.size[2] = (size_[2] - 1) * parts_ + 1 + 2 * beyond_;
  shape_.workspace_from_index = volume.workspace_from_index *
                                Eigen::Translation3d(0, 0, -static_cast<double>(beyond_) / parts_) *
                                Eigen::Scaling(Vec3(1, 1, 1.0 / parts_));
  const Affine index_from_workspace = volume.workspace_from_index.inverse();
  Vec3 least(size_[0], size_[1], 0);
  Vec3 most = Vec3::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 place((corner & 1) != 0 ? high_mm.x() : low_mm.x(),
                     (corner & 2) != 0 ? high_mm.y() : low_mm.y(),
                     (corner & 4) != 0 ? high_mm.z() : low_mm.z());
    least = least.cwiseMin(index_from_workspace * place);
    most = most.cwiseMax(index_from_workspace * place);
  }
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    first_px_[axis] = std::clamp(static_cast<int>(std::floor(least[a])) - kNodePx, 0, size_[axis]);
    const int end = std::clamp(static_cast<int>(std::ceil(most[a])) + kNodePx, 0, size_[axis] - 1);
    node_count_[axis] = end > first_px_[axis] ? (end - first_px_[axis]) / kNodePx + 1 : 0;
  }
}

/// Where in the slices before and after a place its distances from the nearest surfaces are found.
BetweenSlices::Way BetweenSlices::way_at(const Vec3& index, double t) const {
  const Affine& place = shape_.workspace_from_index;
  const Vec3 x = place * index;
  const Vec3 edges = place.linear().colwise().norm();
  const Vec3 right = place.linear().col(0) / edges[0];
  const Vec3 up = place.linear().col(1) / edges[1];
  const double above = (index.z() - beyond_) / parts_;
  const int before = std::clamp(static_cast<int>(std::floor(above)), 0, size_[2] - 2);
  Way way;
  for (std::size_t side = 0; side < 2; ++side) {
    const double k = beyond_ + (before + static_cast<double>(side)) * parts_;
    const Vec3 from = place * Vec3(index.x(), index.y(), k);
    Vec2 sum = Vec2::Zero();
    double found = kStayWeight;
    double wanted = kStayWeight;
    for (const auto& field : fields_) {
      const double distance = field->sample(x, t).distance_mm;
      const double weight = std::exp(-0.5 * distance * distance / (kNearMm * kNearMm));
      if (weight < kLeastWeight || distance >= field->payload().outer_mm ||
          distance <= -field->payload().inner_mm) {
        continue;
      }
      wanted += weight;
      Vec2 moved = Vec2::Zero();
      double off = 0;
      for (int n = 0;; ++n) {
        const Vec3 at = from + moved.x() * right + moved.y() * up;
        const field::FieldSample here = field->sample(at, t);
        off = distance - here.distance_mm;
        if (n == kSteps || std::abs(off) < kEnoughMm) break;
        const Vec3 gradient =
            here.gradient.squaredNorm() > 0.25 ? here.gradient : field->normal(here, at);
        const Vec2 slope(gradient.dot(right), gradient.dot(up));
        Vec2 step = off / std::max(slope.squaredNorm(), kLeastSlope) * slope;
        if (step.norm() > kMostStepMm) step *= kMostStepMm / step.norm();
        moved += step;
      }
      // By degrees: where some places are found and their neighbours are not, walls get ragged.
      const double same = std::exp(-0.5 * off * off / (kSameMm * kSameMm));
      sum += weight * same * moved;
      found += weight * same;
    }
    sum /= found;
    way.px[side] = {static_cast<std::int16_t>(std::lround(kUnits * sum.x() / edges[0])),
                    static_cast<std::int16_t>(std::lround(kUnits * sum.y() / edges[1]))};
    way.trust[side] = static_cast<std::uint8_t>(std::lround(255 * found / wanted));
  }
  return way;
}

const std::vector<BetweenSlices::Way>& BetweenSlices::kept_at(int moment) {
  std::vector<Way>& kept = kept_[n(moment)];
  if (!kept.empty()) return kept;
  const double t = rr_interval_s_ * moment / kKept;
  kept.reserve(n(node_count_[0]) * n(node_count_[1]) * n(shape_.size[2]));
  for (int k = 0; k < shape_.size[2]; ++k) {
    for (int j = 0; j < node_count_[1]; ++j) {
      for (int i = 0; i < node_count_[0]; ++i) {
        kept.push_back(
            (k - beyond_) % parts_ == 0 && k >= beyond_ && k < shape_.size[2] - beyond_
                ? Way{}
                : way_at(Vec3(first_px_[0] + kNodePx * i, first_px_[1] + kNodePx * j, k), t));
      }
    }
  }
  return kept;
}

/// A place of the slices, in pixels, held within them.
struct BetweenSlices::Blend {
  const std::uint8_t* slice;
  int nx;
  int ny;
  [[nodiscard]] double at(double i, double j) const {
    i = std::clamp(i, 0.0, nx - 1.0);
    j = std::clamp(j, 0.0, ny - 1.0);
    const int x = std::min(static_cast<int>(i), std::max(0, nx - 2));
    const int y = std::min(static_cast<int>(j), std::max(0, ny - 2));
    const double u = i - x;
    const double v = j - y;
    const std::uint8_t* row = slice + n(y) * n(nx) + n(x);
    const std::size_t right = nx > 1 ? 1 : 0;
    const std::size_t down = ny > 1 ? n(nx) : 0;
    return (1 - v) * ((1 - u) * row[0] + u * row[right]) +
           v * ((1 - u) * row[down] + u * row[down + right]);
  }
};

void BetweenSlices::fill_slice(int k, const std::array<const Way*, 2>& ways, double between,
                               std::span<const std::uint8_t> slices,
                               std::span<std::uint8_t> to) const {
  const double above = static_cast<double>(k - beyond_) / parts_;
  const int before = std::clamp(static_cast<int>(std::floor(above)), 0, size_[2] - 2);
  const double share = std::clamp(above - before, 0.0, 1.0);
  const std::size_t count = n(size_[0]) * n(size_[1]);
  const std::array<Blend, 2> sides{
      Blend{slices.data() + n(before) * count, size_[0], size_[1]},
      Blend{slices.data() + n(before + 1) * count, size_[0], size_[1]}};
  std::uint8_t* const out = to.data() + n(k) * count;
  for (std::size_t v = 0; v < count; ++v) {
    out[v] = static_cast<std::uint8_t>(
        std::lround((1 - share) * sides[0].slice[v] + share * sides[1].slice[v]));
  }
  if (std::abs(above - std::round(above)) < 1e-9 && above >= 0 && above <= size_[2] - 1) return;
  const std::array<double, 2> weights{1 - share, share};
  // Bilinear between the nodes, straight between two moments.
  const auto node = [&](int a, int b) {
    Bearing here;
    const std::size_t at = n(b) * n(node_count_[0]) + n(a);
    for (std::size_t m = 0; m < 2; ++m) {
      const Way& way = ways[m][at];
      const double part = m == 0 ? 1 - between : between;
      for (std::size_t s = 0; s < 2; ++s) {
        here.i[s] += part * way.px[s][0] / kUnits;
        here.j[s] += part * way.px[s][1] / kUnits;
        here.trust[s] += part * way.trust[s] / 255;
      }
    }
    return here;
  };
  std::vector<Bearing> row(n(node_count_[0]));
  for (int j = 0; j < (node_count_[1] - 1) * kNodePx; ++j) {
    const int b = j / kNodePx;
    const double v = static_cast<double>(j % kNodePx) / kNodePx;
    for (int a = 0; a < node_count_[0]; ++a) {
      row[n(a)] = straight_between(node(a, b), node(a, b + 1), v);
    }
    const int py = first_px_[1] + j;
    for (int i = 0; i < (node_count_[0] - 1) * kNodePx; ++i) {
      const Bearing& low = row[n(i / kNodePx)];
      const Bearing& high = row[n(i / kNodePx + 1)];
      const double u = static_cast<double>(i % kNodePx) / kNodePx;
      const int px = first_px_[0] + i;
      double sum = 0;
      double whole = 0;
      for (std::size_t s = 0; s < 2; ++s) {
        const double weight =
            weights[s] * std::max(1e-3, (1 - u) * low.trust[s] + u * high.trust[s]);
        if (weight == 0) continue;
        sum += weight * sides[s].at(px + (1 - u) * low.i[s] + u * high.i[s],
                                    py + (1 - u) * low.j[s] + u * high.j[s]);
        whole += weight;
      }
      out[n(py) * n(size_[0]) + n(px)] = static_cast<std::uint8_t>(std::lround(sum / whole));
    }
  }
}

void BetweenSlices::fill(double beats, std::span<const std::uint8_t> slices,
                         std::span<std::uint8_t> to) {
  if (!needed()) {
    std::copy(slices.begin(), slices.end(), to.begin());
    return;
  }
  const double at = kKept * (beats - std::floor(beats));
  const int moment = static_cast<int>(at) % kKept;
  const std::vector<Way>& now = kept_at(moment);
  const std::vector<Way>& next = kept_at((moment + 1) % kKept);
  const std::size_t nodes = n(node_count_[0]) * n(node_count_[1]);
  for (int k = 0; k < shape_.size[2]; ++k) {
    fill_slice(k, {now.data() + n(k) * nodes, next.data() + n(k) * nodes}, at - std::floor(at),
               slices, to);
  }
}

}  // namespace beatlas::viewer
