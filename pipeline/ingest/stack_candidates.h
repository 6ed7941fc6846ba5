#pragma once
/// The possible stacks of an exam, best first.

#include <string>
#include <utility>
#include <vector>

#include "pipeline/ingest/plane_groups.h"

namespace beatlas::ingest {

/// One image set a place, along the plane's normal.
using Slices = std::vector<std::pair<const Place*, const ImageSet*>>;

/// A possible stack: one image set a place, before its geometry is looked at closely.
struct Candidate {
  const Plane* plane = nullptr;
  Slices slices;
  bool ordinary = false;      ///< cines of the beating heart, neither flow nor perfusion
  bool good = false;          ///< trigger times, and frames enough to blend
  bool uniform = false;       ///< one contrast
  bool usual = true;          ///< most slices are of the contrast of the exam's cines
  bool secondary = false;     ///< a slice of it is a secondary copy
  std::size_t originals = 0;  ///< slices of original images
  bool one_series = false;
  bool one_field = true;    ///< of view; false: gathered from several
  double views_met = 0;     ///< how well long-axis views meet along its normal, 0 to 1
  bool short_axis = false;  ///< as far as views and the patient's axes tell
  bool mixed = false;       ///< R-R intervals differ much, and a place was imaged more than once
  int phases = 0;           ///< what most slices have
  double spacing_mm = 0;    ///< median gap
  double rr_s = 0;          ///< mean of the R-R intervals that its slices tell; 0 if none does

  /// "6 slices x 25 phases, 17.70 mm apart, oblique".
  [[nodiscard]] std::string shape_told() const;
  /// The same and behind it " (series 1, 2)".
  [[nodiscard]] std::string told() const;
};

inline constexpr std::size_t kLeastSlices = 3;

/// All possible stacks, of kLeastSlices slices and more: of each plane the best set of every place,
/// the best of one contrast, each series alone, series that follow each other at one heart rate,
/// all of one heart rate, and the even stacks that interleave; and what is gathered of contrasts
/// without any. Ranked as stack_rank.h tells.
[[nodiscard]] std::vector<Candidate> find_candidates(const std::vector<Plane>& planes);

/// The planes of an exam and its possible stacks.
struct Stacks {
  std::vector<Plane> planes;
  std::vector<Candidate> candidates;  ///< of the planes
  std::string frames_told;            ///< what was odd about frames of reference; may be empty
};

/// Slices of several frames of reference are in one plane only where no frame has a stack.
[[nodiscard]] Stacks find_stacks(const std::vector<DicomImage>& images, const ImageFiles& files);

/// What follows from a candidate's slices, all but its plane. @param candidate of two slices at
/// least
void finish(Candidate& candidate);

/// One contrast and one kind of image, and both originals or both secondary copies.
[[nodiscard]] bool same_contrast(const ImageSet& a, const ImageSet& b);

/// The highest series number among its slices.
[[nodiscard]] int latest_series(const Candidate& candidate);

/// "1 slice", "2 slices".
[[nodiscard]] std::string counted(std::size_t count, const std::string& one,
                                  const std::string& many);

}  // namespace beatlas::ingest
