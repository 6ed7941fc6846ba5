#pragma once
/// Which words of a DICOM header may tell who the patient is.

#include "pipeline/ingest/shown_path.h"

class vtkDICOMMetaData;

namespace beatlas::ingest {

/// Takes in every text attribute (names, descriptions, codes, dates, times, UIDs, unknown and
/// private text), in sequences too, but for the few that say what kind of image it is.
void add_words(vtkDICOMMetaData& meta, IdentityWords& words);

}  // namespace beatlas::ingest
