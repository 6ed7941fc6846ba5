#include "runtime/atlas/surface_band.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace beatlas::atlas {

BandQuery::BandQuery(const Manifest& manifest, SurfaceBand band)
    : band_(std::move(band)),
      slice_from_workspace_(
          (manifest.workspace_from_lps * manifest.source_lps_from_index).inverse().matrix().row(2)),
      across_slices_(slice_from_workspace_.head<3>().transpose().normalized()) {}

double BandQuery::in_phase(const Vec3& place, const Vec3& normal, std::size_t phase) const {
  const auto last = static_cast<double>(band_.across_mm[phase].size() - 1);
  const double told = slice_from_workspace_.dot(place.homogeneous());
  const double slice = std::isnan(told) ? 0.0 : std::clamp(told, 0.0, last);
  const auto below = static_cast<std::size_t>(slice);
  const std::size_t above = std::min(below + 1, band_.across_mm[phase].size() - 1);
  const double share = slice - static_cast<double>(below);
  const auto at_slice = [&](const std::vector<std::vector<double>>& table) {
    return (1 - share) * table[phase][below] + share * table[phase][above];
  };
  const double along = std::abs(normal.dot(across_slices_));
  const double cosine = std::isnan(along) ? 0.0 : std::min(1.0, along);
  const double sine = std::sqrt(1 - cosine * cosine);
  return at_slice(band_.across_mm) * sine + at_slice(band_.along_mm) * cosine;
}

double BandQuery::half_width_mm(const Vec3& place, const Vec3& normal,
                                double share_of_cycle) const {
  const std::size_t phases = band_.across_mm.size();
  const double turned = std::isfinite(share_of_cycle) ? std::fmod(share_of_cycle, 1.0) : 0.0;
  const double phase = (turned < 0 ? turned + 1 : turned) * static_cast<double>(phases);
  const std::size_t before = std::min(static_cast<std::size_t>(phase), phases - 1);
  const double share = std::min(1.0, phase - static_cast<double>(before));
  return (1 - share) * in_phase(place, normal, before) +
         share * in_phase(place, normal, (before + 1) % phases);
}

std::optional<BandQuery> band_query(const Manifest& manifest, Structure structure) {
  for (const StructureEntry& entry : manifest.structures) {
    if (entry.band && entry.name == structure_name(structure)) {
      return BandQuery(manifest, *entry.band);
    }
  }
  return std::nullopt;
}

}  // namespace beatlas::atlas
