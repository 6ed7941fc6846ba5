#include "pipeline/core/stage_context.h"

#include "runtime/base/error.h"

namespace beatlas {

void StageContext::check_cancelled() const {
  if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) {
    throw Error(ErrorCode::Machine, "stopped on request; nothing half written was left");
  }
}

StageContext StageContext::part(double from, double to, std::string_view name) const {
  StageContext out = *this;
  if (!progress_sink) return out;
  out.progress_sink = [outer = progress_sink, from, to, name = std::string(name)](
                          double share, std::string_view step) {
    std::string whole = name;
    if (!whole.empty() && !step.empty()) whole += ", ";
    outer(from + (to - from) * share, whole.append(step));
  };
  return out;
}

}  // namespace beatlas
