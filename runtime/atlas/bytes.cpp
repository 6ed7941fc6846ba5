#include "runtime/atlas/bytes.h"

namespace beatlas::atlas {

void ByteWriter::append(const void* data, std::size_t size) {
  const auto* first = static_cast<const std::byte*>(data);
  bytes_.insert(bytes_.end(), first, first + size);
}

}  // namespace beatlas::atlas
