#pragma once

namespace beatlas::ingest {

/// Keeps the decoder that vtk-dicom uses from printing, in the whole process: its messages could
/// hold text of the file, and whether it failed is known without them.
void silence_decoder();

}  // namespace beatlas::ingest
