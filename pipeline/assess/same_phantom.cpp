#include "pipeline/assess/same_phantom.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "pipeline/assess/compare.h"
#include "pipeline/core/phantom_mark.h"
#include "runtime/base/error.h"
#include "runtime/field/field_query.h"

namespace beatlas::assess {
namespace {

constexpr double kGridMm = 0.1;  // what rounding in a file may move a voxel by
constexpr double kRrS = 2e-3;    // R-R intervals are written in whole milliseconds
constexpr double kVolumeRatio = 2.0;
constexpr double kCentreMm = 25.0;
constexpr double kMomentShare = 0.3;     // of the cycle
constexpr double kBeatingShare = 0.15;   // a smaller ejection fraction has no clear end systole
constexpr double kCentroidStepMm = 4.0;  // lattice on which the true centroid is summed

[[noreturn]] void refuse(const std::string& why) {
  throw_invalid("the truth is that of another phantom: " + why +
                "; give the truth written with the images this package was made from");
}

std::array<Vec3, 8> corners(const Grid& grid) {
  std::array<Vec3, 8> out;
  for (int n = 0; n < 8; ++n) {
    out[n] = grid.mm((n & 1) ? grid.size[0] - 1 : 0, (n & 2) ? grid.size[1] - 1 : 0,
                     (n & 4) ? grid.size[2] - 1 : 0);
  }
  return out;
}

/// The same voxels, in whatever order of rows, columns and slices a file brought them.
bool same_lattice(const Grid& a, const Grid& b) {
  Index3 size_a = a.size;
  Index3 size_b = b.size;
  std::sort(size_a.begin(), size_a.end());
  std::sort(size_b.begin(), size_b.end());
  if (size_a != size_b) return false;
  const std::array<Vec3, 8> corners_b = corners(b);
  const std::array<Vec3, 8> corners_a = corners(a);
  return std::all_of(corners_a.begin(), corners_a.end(), [&](const Vec3& corner) {
    return std::any_of(corners_b.begin(), corners_b.end(),
                       [&](const Vec3& other) { return (corner - other).norm() < kGridMm; });
  });
}

void demand_same_imaging(const atlas::Manifest& manifest, const phantom::PhantomSpec& spec) {
  if (!same_lattice(source_grid(manifest), spec.imaging_grid())) {
    refuse("its image grid is not the package's source grid");
  }
  if (manifest.frame_times_s.size() != static_cast<std::size_t>(spec.phases)) {
    refuse("it has " + std::to_string(spec.phases) + " frames and the package's source " +
           std::to_string(manifest.frame_times_s.size()));
  }
  if (!(std::abs(manifest.rr_interval_s - spec.rr_interval_s) <= kRrS)) {
    refuse("its R-R interval is not the package's");
  }
}

std::size_t smallest(const std::vector<double>& curve) {
  return static_cast<std::size_t>(std::min_element(curve.begin(), curve.end()) - curve.begin());
}

double ejected_share(const std::vector<double>& curve) {
  const auto [low, high] = std::minmax_element(curve.begin(), curve.end());
  return *high > 0.0 ? 1.0 - *low / *high : 0.0;
}

void demand_like_volumes(const atlas::Manifest& manifest, const phantom::Phantom& truth) {
  for (const atlas::StructureEntry& entry : manifest.structures) {
    const auto structure = structure_from_name(entry.name);
    const std::vector<double>& curve = entry.volume_ml;
    if (!structure || curve.empty()) continue;
    std::vector<double> true_curve;
    const auto phases = static_cast<double>(curve.size());
    for (std::size_t p = 0; p < curve.size(); ++p) {
      true_curve.push_back(truth.volume_ml(
          *structure, truth.spec().rr_interval_s * static_cast<double>(p) / phases));
    }
    const double largest = *std::max_element(curve.begin(), curve.end());
    const double true_largest = *std::max_element(true_curve.begin(), true_curve.end());
    if (!(largest < kVolumeRatio * true_largest && largest * kVolumeRatio > true_largest)) {
      refuse("its " + entry.name + " holds " + std::to_string(std::lround(true_largest)) +
             " ml and the package's " + std::to_string(std::lround(largest)) + " ml");
    }
    if (*structure != Structure::LvBlood || ejected_share(curve) < kBeatingShare ||
        ejected_share(true_curve) < kBeatingShare) {
      continue;
    }
    const double apart =
        std::abs(static_cast<double>(smallest(curve)) - static_cast<double>(smallest(true_curve))) /
        phases;
    if (std::min(apart, 1.0 - apart) > kMomentShare) {
      refuse("its end systole is at another time of the cycle than the package's");
    }
  }
}

/// Of the true structure over the cycle, weighted by volume as FieldQuery::centre_mm is.
Vec3 true_centroid_lps(const phantom::Phantom& truth, Structure structure, int phases) {
  Vec3 sum = Vec3::Zero();
  double count = 0.0;
  for (int p = 0; p < phases; ++p) {
    const auto frame = truth.frame(truth.spec().rr_interval_s * p / phases);
    Eigen::AlignedBox3d box;
    for (const Vec3& x : frame->sample_surface(structure, kCentroidStepMm)) box.extend(x);
    for (double z = box.min().z(); z <= box.max().z(); z += kCentroidStepMm) {
      for (double y = box.min().y(); y <= box.max().y(); y += kCentroidStepMm) {
        for (double x = box.min().x(); x <= box.max().x(); x += kCentroidStepMm) {
          if (!frame->contains(structure, Vec3(x, y, z))) continue;
          sum += Vec3(x, y, z);
          count += 1.0;
        }
      }
    }
  }
  return count > 0.0 ? Vec3(sum / count) : sum;
}

/// Whether any sample of the field is inside; without one there is no centre.
bool holds_anything(const atlas::FieldPayload& payload) {
  return std::any_of(payload.coefficients.begin(), payload.coefficients.end(),
                     [](std::int16_t c) { return c < 0; }) ||
         std::find(payload.blocks.begin(), payload.blocks.end(), atlas::FieldPayload::kInside) !=
             payload.blocks.end();
}

void demand_like_place(const atlas::Manifest& manifest,
                       const std::vector<std::shared_ptr<const atlas::FieldPayload>>& fields,
                       const phantom::Phantom& truth) {
  constexpr int kMoments = 4;
  if (fields.empty() || !holds_anything(*fields.front())) return;
  const field::FieldQuery query(fields.front(), manifest.rr_interval_s);
  const Vec3 expected =
      manifest.workspace_from_lps * true_centroid_lps(truth, fields.front()->structure, kMoments);
  const double apart = (query.centre_mm() - expected).norm();
  if (apart > kCentreMm) {
    refuse("its " + std::string(structure_name(fields.front()->structure)) + " lies " +
           std::to_string(std::lround(apart)) + " mm from the package's");
  }
}

}  // namespace

void demand_same_phantom(const atlas::Manifest& manifest,
                         const std::vector<std::shared_ptr<const atlas::FieldPayload>>& fields,
                         const phantom::Phantom& truth) {
  const auto found = manifest.provenance.find("phantom_identity");
  if (found != manifest.provenance.end() && found->is_string() &&
      is_phantom_identity(found->get<std::string>())) {
    if (found->get<std::string>() == truth.identity()) return;
    refuse("the package's images carry the identity of another one (heart, scanner or noise)");
  }
  demand_same_imaging(manifest, truth.spec());
  demand_like_volumes(manifest, truth);
  demand_like_place(manifest, fields, truth);
}

void demand_same_draw(const atlas::Manifest& manifest, const phantom::DrawnTruth& truth) {
  const auto found = manifest.provenance.find("phantom_identity");
  if (found == manifest.provenance.end() || !found->is_string() ||
      found->get<std::string>() != truth.identity()) {
    throw_invalid(
        "the truth is that of another draw: the package's images do not carry its identity; give "
        "the truth written with the images this package was made from");
  }
  if (manifest.frame_times_s.size() != static_cast<std::size_t>(truth.phases())) {
    throw_invalid("the truth has " + std::to_string(truth.phases()) + " phases and the package " +
                  std::to_string(manifest.frame_times_s.size()) +
                  ": only phases that are the images' own can be compared");
  }
}

}  // namespace beatlas::assess
