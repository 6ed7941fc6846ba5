#pragma once
/// Counts what this thread asks of the heap; the program's own operator new and delete.

namespace beatlas::testing {

extern thread_local bool counting;  ///< set it around what may not allocate
extern thread_local long allocations;
extern thread_local long frees;

}  // namespace beatlas::testing
