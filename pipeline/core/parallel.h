#pragma once
#include <cstddef>
#include <functional>

namespace beatlas {

/// Runs body(i) for i in [0, count), each exactly once, on the threads the process may use
/// (see set_thread_count). Bodies must write to separate places; then the result does not depend
/// on the number of threads. The first exception by index is rethrown.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

/// Threads for parallel_for and for the libraries that share its pool (TBB); 0 = all cores.
/// The only process-wide setting of the pipeline: it can change speed, never a result.
void set_thread_count(int threads);

}  // namespace beatlas
