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

/// One tick of a palpation. `share` goes on beyond 1 where a path lasts longer than a beat.
struct TruthTick {
  Vec3 lps = Vec3::Zero();      ///< where the finger is [mm]
  double share = 0;             ///< time in R-R intervals
  Vec3 force_n = Vec3::Zero();  ///< LPS: K max(0, -distance) n of the closed form
};

struct TruthOptions {
  double spacing_mm = 7;           ///< [mm] 1..20: between points of a surface
  double crease_band_mm = 2;       ///< around creases nothing is asked
  double stiffness_n_per_m = 150;  ///< [N/m] 1..5000
};

struct TruthSet {
  std::map<Structure, std::vector<TruthPoint>> surfaces;
  /// Eight palpations of the heart, each begun at another moment of the beat at a point of its
  /// surface then: in and out along the normal, 2 mm above to 8 mm below where the surface was,
  /// twice a second, for a beat and a half; the heart beats under the finger.
  std::vector<std::vector<TruthTick>> palpations;
  double stiffness_n_per_m = 150;
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

/// |F - F true| over the ticks of the palpations at which either is not 0.
struct ForceErrors {
  double mean_n = 0;
  double p95_n = 0;
  double max_n = 0;
  int ticks = 0;
};
[[nodiscard]] ForceErrors force_errors(const MakeTouch& candidate, const TruthSet& truth,
                                       const Affine& workspace_from_lps, double rr_interval_s);

/// Errors of stored surfaces in their phases: corners and middles of triangles (at most about 4000
/// a phase, evenly taken) against the exact distance; normals of triangles at their middles. The
/// bias is + outside.
[[nodiscard]] SurfaceErrors mesh_errors(const std::vector<std::array<std::uint32_t, 3>>& triangles,
                                        const std::vector<std::vector<Vec3f>>& positions,
                                        Structure structure, const phantom::Phantom& phantom,
                                        const Affine& workspace_from_lps, double crease_band_mm);

}  // namespace beatlas::assess
