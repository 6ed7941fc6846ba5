#pragma once
#include <atomic>
#include <cstddef>
#include <functional>
#include <string_view>

#include "pipeline/core/stage_context.h"

namespace beatlas {

/// Runs body(i) for i in [0, count), each exactly once, on the threads the process may use
/// (see set_thread_count). Bodies must write to separate places; then the result does not depend
/// on the number of threads. The first exception by index is rethrown.
/// @throws Error{Machine} if the stop flag is set, see set_stop_flag
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

/// The same, telling the context before each "`what` i of count" and the share that is done.
/// @throws as StageContext::check_cancelled
void parallel_for(std::size_t count, const StageContext& context, std::string_view what,
                  const std::function<void(std::size_t)>& body);

/// Threads for parallel_for and for the libraries that share its pool (TBB); 0 = all cores.
/// It can change speed, never a result.
void set_thread_count(int threads);

/// Has parallel_for begin no further body once `flag` is set, so that whatever works in parallel
/// stops soon, be it handed a StageContext or not; null: nothing stops it. With set_thread_count
/// the only process-wide setting of the pipeline.
void set_stop_flag(const std::atomic<bool>* flag);
/// For long work that is neither parallel nor has a StageContext. @throws Error{Machine} if set
void check_stop_flag();

}  // namespace beatlas
