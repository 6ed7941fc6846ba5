#pragma once
/// Which images belong together when one folder holds several patients or studies.

#include <functional>
#include <string>
#include <vector>

#include "pipeline/ingest/dicom_scan.h"
#include "pipeline/ingest/plane_groups.h"

namespace beatlas::ingest {

/// Images of one patient and study.
struct ExamGroup {
  std::vector<int> images;  ///< indices into the scan, ascending
  std::string patient;      ///< as DicomImage has it; never shown
};

/// Sorts images into exams; those with most images first, then by series number and UID, whatever
/// the files' names. Images are of one exam if they are of one patient (ID and name) and share the
/// study's UID or the frame of reference's (a blank ID or name contradicts none): some anonymisers
/// give every series a study of its own. Images that do not name a study belong to their patient's
/// only one; images that do not name a patient belong to the patient whose study or frame of
/// reference they share, if it is one.
[[nodiscard]] std::vector<ExamGroup> list_exams(const std::vector<DicomImage>& images);

/// The images to choose a stack from.
struct ExamChoice {
  std::vector<DicomImage> images;
  std::vector<std::string> decisions;
};

/// Chooses among the exams as `exam` says (from 1, as the message lists them; 0: not said), and
/// among their images those of the series numbers, if there are any.
/// Not said, and several: of one patient's studies the only one that holds a stack, or all together
/// if only they do; between patients there is no guess.
/// @param holds_stack tells of some images whether a stack can be made of them
/// @param files whose `shown` names a file or folder in the list of exams
/// @throws Error{InvalidInput} that lists the exams by what is no identity: images, series, pixels,
/// slices and phases of the best stack, and where the files lie; or the series.
[[nodiscard]] ExamChoice choose_exam(
    const std::vector<DicomImage>& images, int exam, const std::vector<int>& series,
    const std::function<bool(const std::vector<DicomImage>&)>& holds_stack,
    const ImageFiles& files);

}  // namespace beatlas::ingest
