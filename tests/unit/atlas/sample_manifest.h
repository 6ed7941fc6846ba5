#pragma once
#include "runtime/atlas/manifest.h"

namespace beatlas::test {

/// Valid, with every list filled and no member at its default.
inline atlas::Manifest sample_manifest() {
  atlas::Manifest manifest;
  manifest.scene = "anatomy";
  manifest.rr_interval_s = 0.875;
  manifest.frame_times_s = {0.0, 0.31, 0.55};
  manifest.workspace_from_lps =
      Eigen::Translation3d(12.5, -3, 96) * Eigen::AngleAxisd(0.7, Vec3(1, -2, 0.5).normalized());
  manifest.source_size = {200, 180, 11};
  manifest.source_lps_from_index = Eigen::Translation3d(1, 2, 3) *
                                   Eigen::AngleAxisd(0.2, Vec3::UnitX()) *
                                   Eigen::Scaling(1.5, 1.25, -9.0);
  manifest.stiffness_n_per_m = 170;
  manifest.end_diastole = 2;
  manifest.end_systole = 1;
  manifest.structures = {{"heart", {500, 450.5, 510}}, {"lv_blood", {110, 50, 125}}};
  const std::vector<double> slices(11, 2.5);
  manifest.structures[0].band = {{slices, slices, slices}, {slices, slices, slices}};
  manifest.surface_edges_mm = {1.5, 4};
  manifest.items = {
      {"surfaces/heart.drc", "surface", "heart", 1234, std::string(64, 'a')},
      {"surfaces/heart.motion", "motion", "heart", 99, std::string(64, '0')},
      {"surfaces/heart.level1.drc", "surface", "heart", 234, std::string(64, 'b'), 1},
  };
  manifest.provenance = {{"beatlas", "0.1.0"}, {"stages", {{"mesh", {{"edge_mm", 2}}}}}};
  return manifest;
}

}  // namespace beatlas::test
