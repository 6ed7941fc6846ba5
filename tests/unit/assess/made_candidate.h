#pragma once
/// Fields sampled from a closed form, encoded as a package holds them, in a turned workspace so
/// that a frame mistaken for another shows.

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "pipeline/assess/validate.h"
#include "pipeline/core/parallel.h"
#include "pipeline/pack/pack.h"
#include "pipeline/phantom/phantom.h"

namespace beatlas::assess::test {

using Level = std::function<double(const Vec3& workspace, double share_of_cycle)>;

/// Samples a level on a lattice as the field room would, and encodes it as the pack room does.
inline std::shared_ptr<const atlas::FieldPayload> encoded(Structure structure, const Level& level,
                                                          const Vec3& centre, double half_mm,
                                                          double voxel_mm, int phases) {
  FieldCycle field;
  field.structure = structure;
  field.voxel_mm = voxel_mm;
  field.inner_mm = 12.0;
  field.outer_mm = 6.0;
  const int side = static_cast<int>(std::ceil(2.0 * half_mm / voxel_mm)) + 1;
  Grid grid;
  grid.size = {side, side, side};
  grid.mm_from_index.linear() *= voxel_mm;
  grid.mm_from_index.translation() = centre - Vec3::Constant(half_mm);
  field.distance_mm.grid = grid;
  field.distance_mm.phases.assign(static_cast<std::size_t>(phases),
                                  std::vector<float>(grid.count()));
  parallel_for(static_cast<std::size_t>(phases), [&](std::size_t p) {
    for (int k = 0; k < side; ++k) {
      for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
          const double value = level(grid.mm(i, j, k), static_cast<double>(p) / phases);
          field.distance_mm.phases[p][grid.offset(i, j, k)] =
              static_cast<float>(std::clamp(value, -field.inner_mm, field.outer_mm));
        }
      }
    }
  });
  field.volume_ml.assign(static_cast<std::size_t>(phases), 1.0);
  return std::make_shared<const atlas::FieldPayload>(pack::encode_field(field, {0.002}));
}

/// Triangles about a middle from which all of a body is seen, in every phase.
/// @param inside whether a place, LPS [mm], lies in the body in a phase
inline std::shared_ptr<const atlas::SurfacePayload> seen_from_within(
    Structure structure, const std::vector<Vec3>& middles, const Affine& workspace_from_lps,
    const std::function<bool(std::size_t phase, const Vec3& lps)>& inside) {
  constexpr int kRings = 48;
  constexpr int kSpokes = 96;
  auto out = std::make_shared<atlas::SurfacePayload>();
  out->structure = structure;
  for (std::size_t p = 0; p < middles.size(); ++p) {
    const auto vertex = [&](double polar, double turn) {
      const Vec3 way(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn),
                     std::cos(polar));
      double low = 0;
      double high = 80;
      while (high - low > 1e-6) {
        const double half = 0.5 * (low + high);
        (inside(p, middles[p] + half * way) ? low : high) = half;
      }
      return (workspace_from_lps * Vec3(middles[p] + low * way)).cast<float>().eval();
    };
    std::vector<Vec3f> positions{vertex(0, 0), vertex(std::numbers::pi, 0)};
    for (int ring = 1; ring < kRings; ++ring) {
      for (int spoke = 0; spoke < kSpokes; ++spoke) {
        positions.push_back(
            vertex(std::numbers::pi * ring / kRings, 2 * std::numbers::pi * spoke / kSpokes));
      }
    }
    out->positions.push_back(positions);
  }
  const auto at = [](int ring, int spoke) {
    if (ring == 0) return 0U;
    if (ring == kRings) return 1U;
    return static_cast<unsigned>(2 + (ring - 1) * kSpokes + spoke % kSpokes);
  };
  for (int ring = 0; ring < kRings; ++ring) {
    for (int spoke = 0; spoke < kSpokes; ++spoke) {
      if (ring + 1 < kRings) {
        out->triangles.push_back({at(ring, spoke), at(ring + 1, spoke), at(ring + 1, spoke + 1)});
      }
      if (ring > 0) {
        out->triangles.push_back({at(ring, spoke), at(ring + 1, spoke + 1), at(ring, spoke + 1)});
      }
    }
  }
  return out;
}

/// A phantom and what a package made from its images without any error would hold.
class Made {
 public:
  explicit Made(const phantom::PhantomSpec& spec) : truth(spec) {
    workspace_from_lps.linear() = truth.spec().imaging_grid().mm_from_index.linear();
    workspace_from_lps.linear().colwise().normalize();
    workspace_from_lps.linear().transposeInPlace();
    workspace_from_lps.translation() = Vec3(128, 128, 96);
    lps_from_workspace = workspace_from_lps.inverse();
    manifest.rr_interval_s = truth.spec().rr_interval_s;
    manifest.frame_times_s.assign(static_cast<std::size_t>(spec.phases), 0.0);
    manifest.workspace_from_lps = workspace_from_lps;
    manifest.source_size = truth.spec().imaging_grid().size;
    manifest.source_lps_from_index = truth.spec().imaging_grid().mm_from_index;
    for (Structure structure : kAllStructures) {
      atlas::StructureEntry entry{std::string(structure_name(structure)), {}};
      for (int p = 0; p < spec.phases; ++p) {
        entry.volume_ml.push_back(truth.volume_ml(structure, truth.phase_time_s(p)));
      }
      manifest.structures.push_back(entry);
    }
  }

  /// The small phantom of 4 phases, imaged obliquely.
  static phantom::PhantomSpec small() {
    phantom::PhantomSpec out = phantom::preset("small");
    out.phases = 4;
    out.oblique_deg = {4.0, -3.0, 10.0};
    return out;
  }
  /// The same with a heart that stands still: what moves in a field is then its own.
  static phantom::PhantomSpec still() {
    phantom::PhantomSpec out = small();
    out.anatomy.lv_end_systole = out.anatomy.lv_end_diastole;
    out.anatomy.rv_end_systole = out.anatomy.rv_end_diastole;
    return out;
  }

  [[nodiscard]] double distance_mm(Structure structure, const Vec3& workspace, double share) const {
    return truth.distance_mm(structure, lps_from_workspace * workspace,
                             share * truth.spec().rr_interval_s);
  }

  /// The middle of the LV in the workspace.
  [[nodiscard]] Vec3 centre() const {
    return workspace_from_lps *
           (phantom::lps_from_heart(truth.spec().anatomy) * Vec3(0.0, 0.0, -16.0));
  }

  /// The field of an LV structure, by default the exact one.
  [[nodiscard]] std::shared_ptr<const atlas::FieldPayload> field(Structure structure,
                                                                 const Level& level = {}) const {
    const Level exact = [&](const Vec3& x, double share) {
      return distance_mm(structure, x, share);
    };
    const double half_mm = structure == Structure::LvBlood ? 60.0 : 72.0;
    return encoded(structure, level ? level : exact, centre(), half_mm, 2.0, truth.spec().phases);
  }

  phantom::Phantom truth;
  Affine workspace_from_lps = Affine::Identity();
  Affine lps_from_workspace = Affine::Identity();
  atlas::Manifest manifest;
};

}  // namespace beatlas::assess::test
