#include "tests/realtime/allocations.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace beatlas::testing {
thread_local bool counting = false;
thread_local long allocations = 0;
thread_local long frees = 0;
}  // namespace beatlas::testing

namespace {
using beatlas::testing::allocations;
using beatlas::testing::counting;
using beatlas::testing::frees;

void* count_and_allocate(std::size_t size, std::size_t alignment) {
  if (counting) ++allocations;
  const std::size_t rounded = (std::max<std::size_t>(size, 1) + alignment - 1) / alignment;
  void* memory = alignment <= alignof(std::max_align_t)
                     ? std::malloc(std::max<std::size_t>(size, 1))
                     : std::aligned_alloc(alignment, rounded * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void count_and_free(void* memory) noexcept {
  if (counting && memory != nullptr) ++frees;
  std::free(memory);
}
}  // namespace

// GCC sees free() through an inlined delete but not malloc() behind new, and takes them for a
// mismatch.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
void* operator new(std::size_t size) { return count_and_allocate(size, 1); }
void* operator new[](std::size_t size) { return count_and_allocate(size, 1); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return count_and_allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return count_and_allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { count_and_free(memory); }
void operator delete[](void* memory) noexcept { count_and_free(memory); }
void operator delete(void* memory, std::size_t) noexcept { count_and_free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { count_and_free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { count_and_free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { count_and_free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  count_and_free(memory);
}
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
  count_and_free(memory);
}
#pragma GCC diagnostic pop
