#pragma once
/// What keeps images of a scan apart before they are grouped: frames of reference; and within a
/// series, which may hold a slice more than once, kinds of reconstruction and acquisitions.

#include <string>
#include <vector>

#include "pipeline/ingest/dicom_scan.h"

namespace beatlas::ingest {

/// Images of one place and contrast by kind (ImageType), in the order in which the kinds are met,
/// if each makes a cine of its own; else all in one. Kinds count that have half the images of the
/// largest and, where all have trigger times, show half the time; the images of others belong to
/// the largest.
/// @param indices into `images`
[[nodiscard]] std::vector<std::vector<int>> kinds_of(const std::vector<int>& indices,
                                                     const std::vector<DicomImage>& images);

/// Images of one place, contrast and kind by acquisition: by AcquisitionNumber or, if that tells
/// none apart, where AcquisitionTime pauses for seconds; in the order of time, else of number.
/// Acquisitions that show different parts of the cycle are one. Few images an acquisition (an
/// image a beat, say) tell none apart.
[[nodiscard]] std::vector<std::vector<int>> acquisitions_of(const std::vector<int>& indices,
                                                            const std::vector<DicomImage>& images);

/// Of acquisitions the one with most images, among equals the last; an index.
[[nodiscard]] std::size_t most_complete(const std::vector<std::vector<int>>& acquisitions);

struct Frames {
  std::vector<std::string> uids;  ///< one an image; empty: unknown
  bool one_a_series = false;      ///< they told nothing, for no two series share one
};

/// The frames of reference by which images are kept apart. A series has one (PS3.3 C.7.4.1): where
/// it names several they tell nothing, nor do they where each of three series and more names one of
/// its own: tools that take identity out of files write such.
[[nodiscard]] Frames frames_of_reference(const std::vector<DicomImage>& images);

}  // namespace beatlas::ingest
