#pragma once
/// The images of an exam, grouped: plane (orientation, matrix, pixel size) > place > image set.

#include <string>
#include <vector>

#include "pipeline/ingest/dicom_scan.h"
#include "pipeline/ingest/slice_timing.h"

namespace beatlas::ingest {

/// Images of one place that can be the phases of one cine: one series, one contrast.
struct ImageSet {
  std::vector<int> images;  ///< indices into the scan, in the order of the cycle
  SliceTiming timing;       ///< its `order` counts 0, 1, ... into `images`
  std::string series_uid;
  int series_number = 0;
  bool merged = false;  ///< each image came from a series of its own

  [[nodiscard]] int frames() const { return static_cast<int>(images.size()); }
};

/// One slice position.
struct Place {
  Vec3 position_lps = Vec3::Zero();  ///< of the first image met
  double along_mm = 0;               ///< of its plane's normal
  int images = 0;
  std::vector<ImageSet> cines;  ///< sets of two images and more, best first
};

/// Parallel slices of one matrix and pixel size.
struct Plane {
  int columns = 0;
  int rows = 0;
  double column_step_mm = 0;
  double row_step_mm = 0;
  double thickness_mm = 0;
  Vec3 row_lps = Vec3::UnitX();
  Vec3 column_lps = Vec3::UnitY();
  std::vector<Place> places;  ///< ascending along row x column

  [[nodiscard]] Vec3 normal_lps() const { return row_lps.cross(column_lps); }
};

/// Groups a scan. Best first among the sets of a place: timed by trigger, then most frames, then
/// the later series (a repeat was taken because the first would not do).
/// @throws Error{InvalidInput} if the images of one slice and series differ in size.
[[nodiscard]] std::vector<Plane> group_planes(const std::vector<DicomImage>& images);

}  // namespace beatlas::ingest
