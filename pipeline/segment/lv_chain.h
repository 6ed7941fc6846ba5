#pragma once
/// The left ventricle followed through slices: rings of muscle around beating pools, rated, and the
/// best of them joined from slice to slice.

#include <vector>

#include <opencv2/core.hpp>

#include "pipeline/core/grid.h"
#include "pipeline/segment/chambers.h"

namespace beatlas::segment {

/// The images as find_chambers looks at them.
struct Setting {
  const ImageCycle<float>& images;
  const TemporalStats& stats;
  std::vector<std::vector<float>> smooth;  ///< [phase] images, lightly smoothed in plane
  cv::Point2d pixel_mm;
  double slice_mm = 0;

  [[nodiscard]] cv::Mat slice(int phase, int k) const {
    return slice_of(images.grid, smooth[static_cast<std::size_t>(phase)], k);
  }
};

/// A pool that may be the left ventricle's in one slice.
struct Candidate {
  int k = 0;
  cv::Point2d centre_px;
  double score = 0;  ///< 0: it is none
  double walled_share = 0;
  std::vector<Ring> rings;  ///< [phase]; of one that is none perhaps only the first ones
};

/// The pools of every slice, rated.
[[nodiscard]] std::vector<std::vector<Candidate>> lv_candidates(const Setting& s,
                                                                const TissueLevels& levels);

/// The best chain of candidates through neighbouring slices (dynamic programming).
[[nodiscard]] std::vector<Candidate> best_chain(const std::vector<std::vector<Candidate>>& slices,
                                                const Setting& s);

/// Walks on from an end of the chain through slices where the pool closes in systole (apex).
void extend_chain(std::vector<Candidate>& chain, const Setting& s, const TissueLevels& heart_levels,
                  int step, int reference_phase);

/// By how much each pool of the chain shrinks with all of them, 1: by the same share; about 0 or
/// less: it fills as the ventricle empties, so that it is an atrium, or a slice that the valve's
/// plane passes through.
[[nodiscard]] std::vector<double> beats(const std::vector<Candidate>& chain);

/// The ventricle is wide toward the base and narrow toward the apex: on which side of the chain it
/// widens, by all pools that beat as ventricles do, the sure ones more than others.
/// @return +1: the base lies at the chain's back, -1: at its front
[[nodiscard]] int side_of_base(const std::vector<Candidate>& chain, int end_diastole);

/// What the chain goes on into at either end: a wider pool, rated lower, beyond the apex, and at
/// the base atria and vessels, all but one pool that fills as the ventricle empties: that is where
/// the valve's plane passes.
void drop_others(std::vector<Candidate>& chain, int base_step, int end_diastole);

[[nodiscard]] double chain_score(const std::vector<Candidate>& chain);

/// Of the pools of a chain in one phase [mm2].
[[nodiscard]] double total_area(const std::vector<Candidate>& chain, int phase);

}  // namespace beatlas::segment
