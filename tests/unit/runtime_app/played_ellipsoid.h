#pragma once
/// A package of a beating ellipsoid in closed form, and `beatlas-play` run on it.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include <unistd.h>

#include "pipeline/pack/pack.h"
#include "tests/unit/runtime_app/played.h"
#include "tests/unit/runtime_field/test_fields.h"

namespace beatlas::app::test {

inline constexpr double kPeriod = 0.8;
inline constexpr int kPhases = 10;
inline const Vec3 kCentre(128, 128, 96);
inline const Vec3 kAxes(26, 22, 30);

inline double growth(double t) { return 1.5 * std::sin(2 * std::numbers::pi * t / kPeriod); }
inline double distance_mm(const Vec3& x, double t) {
  return testing::ellipsoid_distance(kAxes + Vec3::Constant(growth(t)), x - kCentre);
}

// Patient axes: the workspace turned by 90 degrees about two axes and moved.
inline Affine workspace_from_lps() {
  Affine out = Affine::Identity();
  out.linear() << 0, 1, 0, 0, 0, -1, -1, 0, 0;
  out.translation() = Vec3(100, 150, 60);
  return out;
}

// A package of a beating ellipsoid, written once.
inline const std::filesystem::path& folder() {
  static const struct Folder {
    std::filesystem::path path = std::filesystem::temp_directory_path() /
                                 ("beatlas_play_test_" + std::to_string(::getpid()));
    Folder() {
      std::filesystem::create_directories(path);
      FieldCycle field;
      field.structure = Structure::Heart;
      field.voxel_mm = 1.5;
      field.inner_mm = 10;
      field.outer_mm = 6;
      const Vec3 half(37, 33, 41);
      Grid& grid = field.distance_mm.grid;
      for (std::size_t a = 0; a < 3; ++a) {
        grid.size[a] = static_cast<int>(2 * half[static_cast<Eigen::Index>(a)] / 1.5) + 1;
      }
      grid.mm_from_index = Eigen::Translation3d(kCentre - half) * Eigen::Scaling(1.5);
      for (int p = 0; p < kPhases; ++p) {
        auto& samples = field.distance_mm.phases.emplace_back();
        for (int k = 0; k < grid.size[2]; ++k) {
          for (int j = 0; j < grid.size[1]; ++j) {
            for (int i = 0; i < grid.size[0]; ++i) {
              const double d = distance_mm(grid.mm(i, j, k), kPeriod * p / kPhases);
              samples.push_back(static_cast<float>(std::clamp(d, -10.0, 6.0)));
            }
          }
        }
        const Vec3 axes = kAxes + Vec3::Constant(growth(kPeriod * p / kPhases));
        field.volume_ml.push_back(4 * std::numbers::pi / 3 * axes.prod() / 1000);
      }
      pack::PackageContent content;
      atlas::Manifest& manifest = content.manifest;
      manifest.scene = "palpation";
      manifest.rr_interval_s = kPeriod;
      for (int p = 0; p < kPhases; ++p) manifest.frame_times_s.push_back(kPeriod * p / kPhases);
      manifest.workspace_from_lps = workspace_from_lps();
      manifest.stiffness_n_per_m = 180;
      manifest.structures = {{"heart", field.volume_ml}};
      content.fields = {pack::encode_field(field, {})};
      pack::write_package(path / "heart.beatlas", content);
      manifest.stiffness_n_per_m = 300;
      pack::write_package(path / "stiff.beatlas", content);
      // The same, known to 2 mm across slices that lie across z, and to 5 mm along it.
      atlas::Manifest known = manifest;
      known.source_size = {8, 8, 40};
      known.source_lps_from_index = workspace_from_lps().inverse() * Eigen::Scaling(1.0, 1.0, 5.0);
      const std::vector<double> across(40, 2);
      const std::vector<double> along(40, 5);
      known.structures[0].band = {std::vector(kPhases, across), std::vector(kPhases, along)};
      std::swap(manifest, known);
      pack::write_package(path / "known.beatlas", content);
      std::swap(manifest, known);
      // The same ellipsoid as a cavity.
      field.structure = Structure::LvBlood;
      manifest.stiffness_n_per_m = 180;
      manifest.scene = "full";
      manifest.structures.push_back({"lv_blood", field.volume_ml});
      content.fields.push_back(pack::encode_field(field, {}));
      pack::write_package(path / "cavity.beatlas", content);
    }
    ~Folder() { std::filesystem::remove_all(path); }
  } folder;
  return folder.path;
}

inline std::string package() { return (folder() / "heart.beatlas").string(); }

}  // namespace beatlas::app::test
