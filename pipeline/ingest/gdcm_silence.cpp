#include "pipeline/ingest/gdcm_silence.h"

#include <gdcmTrace.h>

namespace beatlas::ingest {

void silence_decoder() {
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
}

}  // namespace beatlas::ingest
