#pragma once
/// Where and when the speed-against-error sweep asks, with the exact answers: made once for a
/// phantom, and used for every run.

#include <map>
#include <vector>

#include "pipeline/assess/touch.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/phantom/phantom.h"

namespace beatlas::assess {

/// A point of a true surface.
struct TruthPoint {
  Vec3 lps = Vec3::Zero();      ///< [mm]
  Vec3 normal = Vec3::UnitZ();  ///< outward, LPS
  double share = 0;             ///< of the R-R interval, 0..1
  bool in_frame = false;        ///< at the time of a frame
};

struct TruthOptions {
  double spacing_mm = 7;           ///< [mm] 1..20: between points of a surface
  double crease_band_mm = 2;       ///< around creases nothing is asked
  double stiffness_n_per_m = 150;  ///< [N/m] 1..5000
  int palpated_places = 8;         ///< 1..1000
};

struct TruthSet {
  std::map<Structure, std::vector<TruthPoint>> surfaces;
  TrueForces forces;  ///< of the heart, at few places; see palpation_set.h
};

/// Surfaces are asked at 2 N + 1 moments for N phases, so that times between frames count as much
/// as frames. @throws Error{Machine} if stopped.
[[nodiscard]] TruthSet make_truth_set(const phantom::Phantom& phantom,
                                      const std::vector<Structure>& structures,
                                      const TruthOptions& options, StageContext& context);

/// Errors at the points of a true surface, where the exact distance is 0.
struct SurfaceErrors {
  double mean_mm = 0;         ///< of |distance|
  double p95_mm = 0;          ///< 95th percentile of |distance|
  double frames_mean_mm = 0;  ///< as mean_mm, of the points at times of frames: the error in space
  double bias_mm = 0;         ///< mean, + where the candidate's structure is larger
  double normal_p95_deg = 0;  ///< 95th percentile of the angle between normals
  int points = 0;
};

/// @param workspace_from_lps of the candidate  @param rr_interval_s of the candidate
[[nodiscard]] SurfaceErrors surface_errors(const MakeTouch& candidate,
                                           const std::vector<TruthPoint>& points,
                                           const Affine& workspace_from_lps, double rr_interval_s);

/// Errors of stored surfaces in their phases: corners and middles of triangles (at most about 4000
/// a phase, evenly taken) against the exact distance; normals of triangles at their middles. The
/// bias is + outside.
[[nodiscard]] SurfaceErrors mesh_errors(const std::vector<std::array<std::uint32_t, 3>>& triangles,
                                        const std::vector<std::vector<Vec3f>>& positions,
                                        Structure structure, const phantom::Phantom& phantom,
                                        const Affine& workspace_from_lps, double crease_band_mm);

}  // namespace beatlas::assess
