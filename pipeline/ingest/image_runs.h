#pragma once
/// One series may hold a slice more than once: in several kinds of reconstruction, or acquired
/// again.

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

}  // namespace beatlas::ingest
