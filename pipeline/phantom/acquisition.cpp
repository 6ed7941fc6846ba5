#include "pipeline/phantom/acquisition.h"

#include <algorithm>
#include <cmath>

#include "pipeline/phantom/noise.h"

namespace beatlas::phantom {
namespace {

constexpr double kTickS = 1e-3;    // of the clock that triggers
constexpr double kMostSigmas = 4;  // beyond it a draw is cut off

/// Slices that drew the lowest numbers.
std::vector<bool> mistriggered(const ScannerSpec& scanner, int slices) {
  std::vector<std::pair<double, int>> drawn;
  for (int k = 0; k < slices; ++k) {
    drawn.emplace_back(uniform(static_cast<std::uint64_t>(k),
                               static_cast<std::uint32_t>(scanner.trigger_seed), Draw::MisTrigger),
                       k);
  }
  std::sort(drawn.begin(), drawn.end());
  std::vector<bool> out(static_cast<std::size_t>(slices), false);
  for (int n = 0; n < std::min(scanner.mistriggered_slices, slices); ++n) {
    out[static_cast<std::size_t>(drawn[static_cast<std::size_t>(n)].second)] = true;
  }
  return out;
}

}  // namespace

std::vector<SliceAcquisition> acquisition(const PhantomSpec& spec) {
  const ScannerSpec& scanner = spec.scanner;
  const int slices = spec.grid.size[2];
  const std::vector<bool> late = mistriggered(scanner, slices);
  std::vector<SliceAcquisition> out(static_cast<std::size_t>(slices));
  for (std::size_t k = 0; k < out.size(); ++k) {
    SliceAcquisition& slice = out[k];
    const auto drawn =
        normal_pair(k, 0, static_cast<std::uint32_t>(scanner.shift_seed), Draw::Shift);
    const double length = scanner.shift_sigma_mm * std::hypot(drawn[0], drawn[1]);
    const double shorter = length > scanner.shift_limit_mm ? scanner.shift_limit_mm / length : 1.0;
    slice.shift_i_mm = shorter * scanner.shift_sigma_mm * drawn[0];
    slice.shift_j_mm = shorter * scanner.shift_sigma_mm * drawn[1];
    slice.mistriggered = late[k];
    for (int p = 0; p < spec.phases; ++p) {
      const double jitter =
          std::clamp(normal_pair(k, static_cast<std::uint32_t>(p),
                                 static_cast<std::uint32_t>(scanner.trigger_seed), Draw::Jitter)[0],
                     -kMostSigmas, kMostSigmas);
      const double offset =
          scanner.jitter_sigma_s * jitter + (slice.mistriggered ? scanner.mistrigger_s : 0.0);
      slice.offset_s.push_back(std::round(offset / kTickS) * kTickS + 0.0);  // + 0: no -0
    }
  }
  return out;
}

nlohmann::json acquisition_json(const PhantomSpec& spec) {
  nlohmann::json slices = nlohmann::json::array();
  for (const SliceAcquisition& slice : acquisition(spec)) {
    slices.push_back({{"shift_mm", {slice.shift_i_mm, slice.shift_j_mm}},
                      {"mistriggered", slice.mistriggered},
                      {"offset_s", slice.offset_s}});
  }
  return {{"definition",
           "in slice k the whole anatomy is moved by shift_mm along the grid's axes i and j, and "
           "frame p shows the time times_s[p] + offset_s[p]; distances, volumes and labels of this "
           "truth are those of the unmoved anatomy at times_s"},
          {"slices", slices}};
}

Grid shifted_grid(const Grid& grid, const SliceAcquisition& slice) {
  Grid out = grid;
  const auto axes = grid.mm_from_index.linear();
  out.mm_from_index.translation() -=
      slice.shift_i_mm * axes.col(0).normalized() + slice.shift_j_mm * axes.col(1).normalized();
  return out;
}

std::vector<double> frame_moments_s(const PhantomSpec& spec, const SliceAcquisition& slice,
                                    int phase) {
  const double middle =
      spec.rr_interval_s * phase / spec.phases + slice.offset_s[static_cast<std::size_t>(phase)];
  const double window = spec.scanner.gating_window_s;
  if (window == 0.0) return {middle};
  const int count = spec.scanner.gating_subphases;
  std::vector<double> out;
  for (int n = 0; n < count; ++n) out.push_back(middle + window * ((n + 0.5) / count - 0.5));
  return out;
}

}  // namespace beatlas::phantom
