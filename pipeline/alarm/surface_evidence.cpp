#include "pipeline/alarm/surface_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace beatlas::alarm {
namespace {

constexpr std::array kShiftsMm{-1.5, 0.0, 1.5};  ///< how far off its edge a surface may run
constexpr double kNearMm = 2.0;                  ///< first sample on either side
constexpr double kApartMm = 1.25;                ///< the second one beyond the first
constexpr double kSwingMm = 3.0;

float sampled(const Grid& grid, const std::vector<float>& image, const Vec3& index) {
  std::array<int, 3> low{};
  std::array<float, 3> share{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int last = grid.size[axis] - 1;
    const double at = std::clamp(index[static_cast<int>(axis)], 0.0, static_cast<double>(last));
    low[axis] = std::min(static_cast<int>(at), std::max(0, last - 1));
    share[axis] = static_cast<float>(at - low[axis]);
  }
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    std::array<int, 3> at = low;
    float weight = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool upper = ((corner >> axis) & 1) != 0;
      weight *= upper ? share[axis] : 1 - share[axis];
      if (upper) at[axis] = std::min(at[axis] + 1, grid.size[axis] - 1);
    }
    if (weight > 0) sum += weight * image[grid.offset(at[0], at[1], at[2])];
  }
  return sum;
}

float middle(std::vector<float>& values, double share = 0.5) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

double evidence_sigma_mm(const Grid& grid) {
  return std::max(1.0, 0.7 * grid.spacing_mm().head<2>().maxCoeff());
}

EvidenceLevels evidence_levels(const ImageCycle<float>& images,
                               const ImageCycle<std::uint8_t>& labels) {
  std::vector<float> blood;
  std::vector<float> muscle;
  std::vector<float> all;
  const std::size_t stride =
      std::max<std::size_t>(1, images.grid.count() * images.phases.size() / std::size_t{2000000});
  for (std::size_t p = 0; p < images.phases.size(); ++p) {
    for (std::size_t v = p % stride; v < images.grid.count(); v += stride) {
      const std::uint8_t label = labels.phases[p][v];
      const float value = images.phases[p][v];
      all.push_back(value);
      if (label == kLabelLvBlood || label == kLabelRvBlood) blood.push_back(value);
      if (label == kLabelLvMyocardium) muscle.push_back(value);
    }
  }
  EvidenceLevels out;
  if (all.empty()) return out;
  if (!blood.empty()) out.blood = middle(blood);
  if (!muscle.empty()) out.muscle = middle(muscle);
  if (!blood.empty() && !muscle.empty() && out.blood > out.muscle) {
    out.contrast = out.blood - out.muscle;
  } else {
    const float high = middle(all, 0.98);
    out.contrast = 0.5 * (high - middle(all, 0.02));
  }
  return out;
}

SurfaceEvidence surface_evidence(const Grid& grid, const std::vector<float>& image,
                                 const std::vector<float>& swing, double noise,
                                 const std::vector<SurfacePoint>& points) {
  const std::size_t n = points.size();
  const Vec3 spacing = grid.spacing_mm();
  // The square of the step at each shift, then inner and outer level, then the swing squared.
  constexpr std::size_t kInner = kShiftsMm.size();
  constexpr std::size_t kOuter = kInner + 1;
  constexpr std::size_t kSwing = kInner + 2;
  std::vector<std::vector<float>> values(kSwing + 1, std::vector<float>(n));
  for (std::size_t p = 0; p < n; ++p) {
    const SurfacePoint& point = points[p];
    const Vec3 per_mm = point.outward_mm.cwiseQuotient(spacing);
    // Across thick voxels an edge is as wide as they are.
    const double near_mm = std::max(kNearMm, 0.75 * point.outward_mm.cwiseProduct(spacing).norm());
    const auto level = [&](double from_mm, double side) {
      const double first = from_mm + side * near_mm;
      return 0.5F * (sampled(grid, image, point.index + first * per_mm) +
                     sampled(grid, image, point.index + (first + side * kApartMm) * per_mm));
    };
    for (std::size_t s = 0; s < kShiftsMm.size(); ++s) {
      const float inner = level(kShiftsMm[s], -1);
      const float outer = level(kShiftsMm[s], 1);
      values[s][p] = (outer - inner) * (outer - inner);
      if (kShiftsMm[s] != 0.0) continue;
      values[kInner][p] = inner;
      values[kOuter][p] = outer;
    }
    float sum = 0;
    for (int at = -2; at <= 2; ++at) {
      const float here = sampled(grid, swing, point.index + 0.5 * at * kSwingMm * per_mm);
      sum += here * here;
    }
    values[kSwing][p] = sum / 5;
  }
  values = averaged_over_surface(grid, points, std::move(values));
  // The smoothed noise of four samples that overlap by half is about that of one.
  const double sigma_px = evidence_sigma_mm(grid) / std::sqrt(spacing[0] * spacing[1]);
  const double of_noise = noise * noise / (4 * M_PI * sigma_px * sigma_px);
  SurfaceEvidence out;
  out.step.assign(n, 0);
  for (std::size_t s = 0; s < kShiftsMm.size(); ++s) {
    for (std::size_t p = 0; p < n; ++p) {
      const auto step = static_cast<float>(std::sqrt(std::max(0.0, values[s][p] - of_noise)));
      out.step[p] = std::max(out.step[p], step);
    }
  }
  out.inner = std::move(values[kInner]);
  out.outer = std::move(values[kOuter]);
  out.swing = std::move(values[kSwing]);
  for (float& value : out.swing) value = std::sqrt(std::max(0.0F, value));
  return out;
}

}  // namespace beatlas::alarm
