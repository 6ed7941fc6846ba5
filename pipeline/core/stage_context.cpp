#include "pipeline/core/stage_context.h"

#include "runtime/base/error.h"

namespace beatlas {

void StageContext::check_cancelled() const {
  if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) {
    throw Error(ErrorCode::Machine, "stopped on request; nothing half written was left");
  }
}

}  // namespace beatlas
