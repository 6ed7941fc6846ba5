#pragma once
/// Image headers made in memory: what a scan gives, without files.

#include <string>
#include <vector>

#include "pipeline/ingest/dicom_scan.h"
#include "pipeline/ingest/plane_groups.h"

namespace beatlas::ingest::test {

struct MadeStack {
  int slices = 6;
  int phases = 10;
  int first_series = 1;
  bool series_per_slice = true;
  double gap_mm = 8;
  double rr_ms = 900;
  Vec3 origin = Vec3::Zero();
  Vec3 row = Vec3::UnitX();
  Vec3 column = Vec3::UnitY();
  double echo_ms = 1.5;
  std::string sequence = "GR\nSS";
  Provenance provenance = Provenance::Original;
  int pixels = 64;
  bool magnitude = true;
  bool with_trigger = true;
  double step_ms = 0;  ///< between trigger times; 0: R-R / phases
  std::string patient = "ID\nNAME";
  std::string study = "study";
  std::string frame = "frame";
};

/// A stack of cines, all in the order of a scan.
inline std::vector<DicomImage> made_stack(const MadeStack& made) {
  std::vector<DicomImage> out;
  const Vec3 normal = made.row.cross(made.column);
  for (int k = 0; k < made.slices; ++k) {
    for (int p = 0; p < made.phases; ++p) {
      DicomImage image;
      image.series_number = made.first_series + (made.series_per_slice ? k : 0);
      image.series_uid = std::to_string(image.series_number);
      image.file = "s" + image.series_uid + "_" + std::to_string(p);
      image.columns = image.rows = made.pixels;
      image.row_lps = made.row;
      image.column_lps = made.column;
      image.position_lps = made.origin + normal * (made.gap_mm * k);
      image.column_step_mm = image.row_step_mm = 1.5;
      image.contrast = {.sequence = made.sequence, .echo_ms = made.echo_ms};
      image.provenance = made.provenance;
      image.magnitude = made.magnitude;
      const double step = made.step_ms > 0 ? made.step_ms : made.rr_ms / made.phases;
      if (made.with_trigger) image.stamp.trigger_ms = p * step;
      image.stamp.rr_ms = made.rr_ms;
      image.stamp.instance = p + 1 + (made.series_per_slice ? 0 : k * made.phases);
      image.patient = made.patient;
      image.study_uid = made.study;
      image.frame_of_reference_uid = made.frame;
      out.push_back(image);
    }
  }
  return out;
}

inline void append(std::vector<DicomImage>& all, const std::vector<DicomImage>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

/// Names as they are, no pixels.
inline ImageFiles no_files() {
  return {.shown = [](const std::filesystem::path& file) { return file.string(); },
          .fingerprint = {}};
}

inline bool told(const std::vector<std::string>& decisions, const std::string& words) {
  for (const std::string& decision : decisions) {
    if (decision.find(words) != std::string::npos) return true;
  }
  return false;
}

inline std::string joined(const std::vector<std::string>& decisions) {
  std::string out;
  for (const std::string& decision : decisions) out += decision + '\n';
  return out;
}

}  // namespace beatlas::ingest::test
