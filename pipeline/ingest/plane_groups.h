#pragma once
/// The images of an exam, grouped: plane (orientation, field of view, matrix, pixel size) > place >
/// image set.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/core/grid.h"
#include "pipeline/ingest/dicom_scan.h"
#include "pipeline/ingest/slice_timing.h"

namespace beatlas::ingest {

/// What grouping needs beyond the headers.
struct ImageFiles {
  /// A file's name as messages may show it.
  std::function<std::string(const std::filesystem::path&)> shown;
  /// Equal for images of equal pixels, "" for unreadable ones; may be empty: then frames that were
  /// stored twice without telling times are not recognised.
  std::function<std::string(const DicomImage&)> fingerprint;
  /// The R-R interval that the user gave, 0 if none: it tells several beats apart where the images
  /// name no interval.
  double given_rr_s = 0;
  /// Planes go across frames of reference.
  bool join_frames = false;
};

/// Images of one place that can be the phases of one cine: one series, one contrast.
struct ImageSet {
  std::vector<int> images;  ///< indices into the scan, in the order of the cycle
  SliceTiming timing;       ///< its `order` counts 0, 1, ... into `images`
  std::string series_uid;
  int series_number = 0;
  Contrast contrast;
  Provenance provenance = Provenance::Original;  ///< of most of its images
  std::string kind;                              ///< as DicomImage has it
  int kinds = 1;        ///< in which its series holds the images of this place
  bool merged = false;  ///< each image came from a series of its own
  bool flow = false;    ///< phase (velocity) images were made with these
  bool usual = true;    ///< of the contrast that the exam's cines have, as far as they have one

  [[nodiscard]] int frames() const { return static_cast<int>(images.size()); }
  /// A cine of the beating heart: neither flow nor one image a beat.
  [[nodiscard]] bool ordinary() const {
    return !flow && !timing.many_beats && !timing.beat_unknown;
  }
  [[nodiscard]] bool secondary() const { return provenance == Provenance::Secondary; }
};

/// One slice position.
struct Place {
  Vec3 position_lps = Vec3::Zero();  ///< of the first image met
  double along_mm = 0;               ///< of its plane's normal
  int images = 0;
  bool guest = false;           ///< seen by another plane than its own
  std::vector<ImageSet> cines;  ///< sets of two images and more, best first
};

/// Parallel slices of one field of view, matrix, pixel size and frame of reference.
struct Plane {
  int columns = 0;
  int rows = 0;
  double column_step_mm = 0;
  double row_step_mm = 0;
  double thickness_mm = 0;
  Vec3 row_lps = Vec3::UnitX();
  Vec3 column_lps = Vec3::UnitY();
  std::string frame;              ///< UID of its frame of reference; empty: unknown
  Vec3 first_lps = Vec3::Zero();  ///< of the first image met; first pixels lie on its normal
  std::vector<Place> places;      ///< ascending along row x column
  /// Places with cines of other planes that could be of one stack with this one, ascending;
  /// `along_mm` is this plane's, where the line through the middle of its images meets them.
  std::vector<Place> guests;

  [[nodiscard]] Vec3 normal_lps() const { return row_lps.cross(column_lps); }
};

inline constexpr double kSamePlaceMm = 0.1;  ///< far below any slice gap
inline constexpr int kMostSlicesOfView = 2;  ///< of one plane; more are a stack

/// The lattice of some slices of a plane. @param first_lps first pixel of the first
[[nodiscard]] Grid lattice_of(const Plane& plane, const Vec3& first_lps, double spacing_mm,
                              int slices);

/// Whether their normals are within kNearlyParallelDeg.
[[nodiscard]] bool nearly_parallel(const Plane& a, const Plane& b);

/// Whether slices of two planes could be of one stack, but for their fields of view: they are
/// nearly parallel, and of one frame of reference.
[[nodiscard]] bool could_be_one_stack(const Plane& a, const Plane& b);

/// Whether they are nearly parallel, of one matrix and pixel size: of one protocol, as far as that
/// tells.
[[nodiscard]] bool same_pixels(const Plane& a, const Plane& b);

/// Between the normals of slices that were planned as parallel. A slice of the left ventricle is at
/// most 50 mm wide about its middle, where this moves it by 2.6 mm: a third of a slice of 8 mm.
inline constexpr double kNearlyParallelDeg = 3;

/// Groups a scan. Best first among the sets of a place: ordinary cines, then no secondary copies,
/// then those of the contrast of the exam's cines, then originals, then those timed by trigger,
/// then most frames, then the later series (a repeat was taken because the first would not do).
/// @throws Error{InvalidInput} if the images of one slice and series differ in size.
[[nodiscard]] std::vector<Plane> group_planes(const std::vector<DicomImage>& images,
                                              const ImageFiles& files);

}  // namespace beatlas::ingest
