#include "pipeline/segment/ventricle_ends.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "pipeline/core/lv_direction.h"
#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/segment/lv_section.h"
#include "pipeline/segment/valve_planes.h"
#include "pipeline/shape/apical_end.h"

namespace beatlas::segment {
namespace {

constexpr double kBinMm = 0.5;
constexpr double kLeastLengthMm = 20;  ///< of a ventricle that is one
/// The apex is told by the part of the LV's volume between these shares, from its apical end on.
constexpr double kTipFrom = 0.005;
constexpr double kTipTo = 0.08;
constexpr double kPlateauFromMm = 5;  ///< below the top of a structure, where its section is whole
constexpr double kPlateauToMm = 12;

/// The area of a structure's section at heights along the axis.
struct Profile {
  double low_mm = 0;  ///< middle of the first bin
  std::vector<double> area_mm2;

  [[nodiscard]] double height_mm(double bin) const { return low_mm + bin * kBinMm; }
  [[nodiscard]] double volume_mm3() const {
    double sum = 0;
    for (const double area : area_mm2) sum += area * kBinMm;
    return sum;
  }
};

/// Coverage of one phase, of the structures together.
class Body {
 public:
  Body(const Segmentation& segmentation, const std::vector<Structure>& structures,
       std::size_t phase)
      : coverage_(segmentation.coverage), structures_(structures), phase_(phase) {}

  /// visit(lps of the voxel's centre, covered share > 0)
  template <class Visit>
  void each(const Visit& visit) const {
    const Grid& grid = coverage_.grid;
    std::vector<const float*> voxels;
    for (const Structure structure : structures_) {
      voxels.push_back(coverage_.phases.at(structure)[phase_].data());
    }
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const std::size_t v = grid.offset(i, j, k);
          double share = 0;
          for (const float* of : voxels) share += static_cast<double>(of[v]);
          if (share > 0) visit(grid.mm(i, j, k), std::min(1.0, share));
        }
      }
    }
  }

 private:
  const CoverageCycle& coverage_;
  const std::vector<Structure>& structures_;
  std::size_t phase_;
};

Profile profile_of(const Segmentation& segmentation, const LongAxis& axis,
                   const std::vector<Structure>& structures, std::size_t phase) {
  const Grid& grid = segmentation.coverage.grid;
  const Vec3 along = grid.mm_from_index.linear().transpose() * axis.towards_base;
  const double half_mm = std::max(kBinMm, 0.5 * along.cwiseAbs().sum());  // of a voxel's height
  double low = 1e9;
  double high = -1e9;
  for (int corner = 0; corner < 8; ++corner) {
    const auto end = [&](std::size_t a) {
      return (corner >> a & 1) != 0 ? grid.size[a] - 1.0 : 0.0;
    };
    const double height = axis.height_mm(grid.mm(end(0), end(1), end(2)));
    low = std::min(low, height - half_mm - kBinMm);
    high = std::max(high, height + half_mm + kBinMm);
  }
  const auto bins = static_cast<std::size_t>((high - low) / kBinMm) + 2;
  // A voxel is spread over its height: two steps of what is then summed up.
  std::vector<double> steps(bins + 1, 0.0);
  const auto step = [&](double height, double area) {
    const double at = (height - low) / kBinMm;
    const auto bin = static_cast<std::size_t>(at);
    steps[bin] += area * (1 - (at - static_cast<double>(bin)));
    steps[bin + 1] += area * (at - static_cast<double>(bin));
  };
  const double density = grid.voxel_ml() * 1e3 / (2 * half_mm);
  Body(segmentation, structures, phase).each([&](const Vec3& lps, double share) {
    const double height = axis.height_mm(lps);
    step(height - half_mm, density * share);
    step(height + half_mm, -density * share);
  });
  Profile out{low + 0.5 * kBinMm, std::vector<double>(bins)};
  double area = 0;
  for (std::size_t b = 0; b < bins; ++b) {
    area += steps[b];
    out.area_mm2[b] = std::max(0.0, area);
  }
  return out;
}

/// Height at which the body closes on its lower side; none if it has no volume.
std::optional<double> closing_mm(const Profile& profile) {
  const double whole = profile.volume_mm3();
  if (!(whole > 0)) return {};
  // root of the volume = a + b h + c h^2, by least squares
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Vec3 right = Vec3::Zero();
  double below = 0;
  double first = 0;
  int count = 0;
  for (std::size_t b = 0; b < profile.area_mm2.size() && below < kTipTo * whole; ++b) {
    below += profile.area_mm2[b] * kBinMm;
    if (below < kTipFrom * whole) continue;
    const double height = profile.height_mm(static_cast<double>(b) + 0.5);
    if (count++ == 0) first = height;
    const Vec3 powers(1, height - first, (height - first) * (height - first));
    normal += powers * powers.transpose();
    right += std::sqrt(below) * powers;
  }
  if (count < 4) return {};
  const Vec3 fit = normal.ldlt().solve(right);
  const double root = fit[1] * fit[1] - 4 * fit[2] * fit[0];
  if (!(fit[1] > 0) || !(root >= 0)) return first;
  // The root next to the data, in the form that stands a vanishing square.
  return first - 2 * fit[0] / (fit[1] + std::sqrt(root));
}

/// Height at which a body that ends flat on its upper side does so: where its section falls to half
/// of what it is a little below.
std::optional<double> flat_end_mm(const Profile& profile) {
  const std::vector<double>& area = profile.area_mm2;
  const double most = *std::max_element(area.begin(), area.end());
  if (!(most > 0)) return {};
  auto top = static_cast<std::ptrdiff_t>(area.size()) - 1;
  while (top > 0 && area[static_cast<std::size_t>(top)] < 0.25 * most) --top;
  std::vector<double> whole;
  for (auto b = top - static_cast<std::ptrdiff_t>(kPlateauToMm / kBinMm);
       b <= top - static_cast<std::ptrdiff_t>(kPlateauFromMm / kBinMm); ++b) {
    if (b >= 0) whole.push_back(area[static_cast<std::size_t>(b)]);
  }
  if (whole.empty()) return {};
  std::sort(whole.begin(), whole.end());
  const double half = 0.5 * whole[whole.size() / 2];
  auto b = static_cast<std::ptrdiff_t>(area.size()) - 2;
  while (b > 0 && area[static_cast<std::size_t>(b)] < half) --b;
  const double here = area[static_cast<std::size_t>(b)];
  const double next = area[static_cast<std::size_t>(b) + 1];
  const double share = here > next ? std::clamp((here - half) / (here - next), 0.0, 1.0) : 0.5;
  return profile.height_mm(static_cast<double>(b) + share);
}

const std::vector<Structure> kVentricle{Structure::LvBlood, Structure::LvMyocardium};

/// Height at which the axis meets a slice index; none if it runs along the slices.
std::optional<double> slice_mm(const Segmentation& segmentation, const LongAxis& axis, double k) {
  const Affine index_from_mm = segmentation.labels.grid.mm_from_index.inverse(Eigen::Affine);
  const double per_mm = (index_from_mm.linear() * axis.towards_base)[2];
  if (!(std::abs(per_mm) > 1e-3)) return {};
  return (k - (index_from_mm * axis.origin_mm)[2]) / per_mm;
}

std::optional<double> plane_mm(const Segmentation& segmentation, const LongAxis& axis,
                               Structure structure, std::size_t phase) {
  const auto plane = segmentation.valve_planes.find(structure);
  if (plane == segmentation.valve_planes.end()) return {};
  return slice_mm(segmentation, axis, plane->second.k[phase]);
}

/// Where the stack ends in the apex, the place at which the shape is closed.
std::optional<double> apex_mm(const Segmentation& segmentation, const LongAxis& axis,
                              std::size_t phase) {
  if (are_thick_slices(segmentation.labels.grid.spacing_mm()[2])) {
    const std::optional<double> k =
        shape::lv_apex_k(segmentation, phase, shape::step_to_apex(segmentation, axis));
    if (k) return slice_mm(segmentation, axis, *k);
  }
  return closing_mm(profile_of(segmentation, axis, kVentricle, phase));
}

/// Whether a plane between slices is one of heights of a body so wide: where the axis leans, the
/// plane rises across the body, by half a slice at the most to tell its height better than labels.
bool tells_height(const Grid& grid, const LongAxis& axis, const Profile& body) {
  const double widest_mm2 = *std::max_element(body.area_mm2.begin(), body.area_mm2.end());
  const double radius_mm = std::sqrt(widest_mm2 / EIGEN_PI);
  const double cosine = grid.mm_from_index.linear().col(2).normalized().dot(axis.towards_base);
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  return radius_mm * sine <= 0.5 * grid.spacing_mm()[2] * std::abs(cosine);
}

std::optional<double> base_mm(const Segmentation& segmentation, const LongAxis& axis,
                              Structure structure, std::size_t phase) {
  const Profile body = profile_of(segmentation, axis, {structure}, phase);
  if (tells_height(segmentation.labels.grid, axis, body)) {
    if (const auto plane = plane_mm(segmentation, axis, structure, phase)) return plane;
  }
  return flat_end_mm(body);
}

bool holds(const Segmentation& segmentation, Structure structure) {
  return segmentation.coverage.phases.count(structure) != 0;
}

/// A structure's coverage at end-diastole; empty without it.
std::vector<float> at_end_diastole(const Segmentation& segmentation, Structure structure) {
  const auto found = segmentation.coverage.phases.find(structure);
  if (found == segmentation.coverage.phases.end()) return {};
  return found->second[static_cast<std::size_t>(segmentation.end_diastole)];
}

/// Of what the structures hold together, LPS; none if that is nothing.
std::optional<Vec3> centre_mm(const Segmentation& segmentation,
                              const std::vector<Structure>& structures, int phase) {
  double sum = 0;
  Vec3 first = Vec3::Zero();
  Body(segmentation, structures, static_cast<std::size_t>(phase))
      .each([&](const Vec3& lps, double share) {
        sum += share;
        first += share * lps;
      });
  if (!(sum > 0)) return {};
  return Vec3(first / sum);
}

/// Of the RV's blood at end-diastole, or where it was lost there, in the first phase after it that
/// has some.
std::optional<Vec3> rv_centre_mm(const Segmentation& segmentation) {
  const int phases = segmentation.labels.phase_count();
  std::optional<Vec3> out;
  for (int n = 0; n < phases && !out; ++n) {
    out = centre_mm(segmentation, {Structure::RvBlood}, (segmentation.end_diastole + n) % phases);
  }
  return out;
}

/// Origin and direction alone: the middle of the LV's blood and wall, and the way they lie.
std::optional<LongAxis> line_of_lv(const Segmentation& segmentation) {
  const std::optional<Vec3> along =
      lv_direction(segmentation.coverage.grid, at_end_diastole(segmentation, Structure::LvBlood),
                   at_end_diastole(segmentation, Structure::LvMyocardium));
  const auto middle = centre_mm(segmentation, kVentricle, segmentation.end_diastole);
  if (!along || !middle) return {};
  LongAxis axis;
  axis.origin_mm = *middle;
  axis.towards_base = *along;
  return axis;
}

}  // namespace

std::vector<std::string> cut_ends(const Segmentation& segmentation, int base_step) {
  if (!holds(segmentation, Structure::LvBlood) || !holds(segmentation, Structure::LvMyocardium)) {
    return {};
  }
  const auto told = [&](const char* end, int k) {
    return "the images end within the left ventricle: its " + std::string(end) +
           " lies beyond slice " + std::to_string(k) +
           ", the last one there; volumes, EF and mass are of the part in view, and their "
           "intervals know nothing of the rest";
  };
  const LabelCycle& labels = segmentation.labels;
  const auto phase = static_cast<std::size_t>(segmentation.end_diastole);
  const int last = labels.grid.size[2] - 1;
  std::vector<std::string> out;
  const int base = base_step > 0 ? last : 0;
  if (most_basal(labels, phase, Structure::LvBlood, base_step) == base &&
      is_closed(labels, phase, base)) {
    out.push_back(told("base", base));
  }
  // Of what closes nearer than that no slice was left out.
  if (shape::lv_gaps_beyond(segmentation, phase, -base_step) > 1) {
    out.push_back(told("apex", last - base));
  }
  return out;
}

std::optional<LongAxis> ventricle_axis(const Segmentation& segmentation) {
  if (!holds(segmentation, Structure::LvBlood) || !holds(segmentation, Structure::LvMyocardium)) {
    return {};
  }
  std::optional<LongAxis> axis = line_of_lv(segmentation);
  if (!axis) return {};
  const std::size_t n = segmentation.labels.phases.size();
  const bool rv = holds(segmentation, Structure::RvBlood);
  axis->atria = std::any_of(kBeyondBase.begin(), kBeyondBase.end(),
                            [&](Structure structure) { return holds(segmentation, structure); });
  const LongAxis direction = *axis;
  std::vector<std::optional<double>> apex(n);
  std::vector<std::optional<double>> left(n);
  std::vector<std::optional<double>> right(n);
  parallel_for(n, [&](std::size_t p) {
    apex[p] = apex_mm(segmentation, direction, p);
    left[p] = base_mm(segmentation, direction, Structure::LvBlood, p);
    if (rv) right[p] = base_mm(segmentation, direction, Structure::RvBlood, p);
  });
  axis->apex_mm.resize(n);
  axis->lv_base_mm.resize(n);
  axis->rv_base_mm.resize(rv ? n : 0);
  for (std::size_t p = 0; p < n; ++p) {
    if (!apex[p] || !left[p] || (rv && !right[p])) return {};
    if (*left[p] - *apex[p] < kLeastLengthMm) return {};
    axis->apex_mm[p] = *apex[p];
    axis->lv_base_mm[p] = *left[p];
    if (rv) axis->rv_base_mm[p] = *right[p];
  }
  if (rv) axis->rv_centre_mm = rv_centre_mm(segmentation);
  return axis;
}

void follow_changed_labels(Segmentation& segmentation, const std::vector<char>& changed) {
  if (!segmentation.axis || !holds(segmentation, Structure::LvBlood) ||
      !holds(segmentation, Structure::LvMyocardium)) {
    segmentation.axis = ventricle_axis(segmentation);
    return;
  }
  LongAxis& axis = *segmentation.axis;
  if (!holds(segmentation, Structure::RvBlood)) {
    axis.rv_base_mm.clear();
    axis.rv_centre_mm.reset();
  } else if (changed[static_cast<std::size_t>(segmentation.end_diastole)] != 0) {
    axis.rv_centre_mm = rv_centre_mm(segmentation);
  }
  const LongAxis direction = axis;
  parallel_for(changed.size(), [&](std::size_t p) {
    if (changed[p] == 0) return;
    const auto apex = apex_mm(segmentation, direction, p);
    const auto lv = base_mm(segmentation, direction, Structure::LvBlood, p);
    if (apex && lv && *lv - *apex >= kLeastLengthMm) {
      axis.apex_mm[p] = *apex;
      axis.lv_base_mm[p] = *lv;
    }
    if (axis.rv_base_mm.empty()) return;
    const auto right = base_mm(segmentation, direction, Structure::RvBlood, p);
    if (right) axis.rv_base_mm[p] = *right;
  });
}

}  // namespace beatlas::segment
