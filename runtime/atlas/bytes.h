#pragma once
/// Little-endian bytes of the binary payloads, read within their bounds.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "runtime/base/error.h"

namespace beatlas::atlas {

static_assert(std::endian::native == std::endian::little, "payloads are little-endian");

using Bytes = std::vector<std::byte>;
using ByteView = std::span<const std::byte>;

/// Reads front to back. @throws Error{InvalidInput} at the end of the bytes.
class ByteReader {
 public:
  explicit ByteReader(ByteView bytes) : rest_(bytes) {}

  [[nodiscard]] std::size_t remaining() const noexcept { return rest_.size(); }

  [[nodiscard]] ByteView take(std::size_t count) {
    if (count > rest_.size()) throw_invalid("the payload ends too early; build the package again");
    const ByteView taken = rest_.first(count);
    rest_ = rest_.subspan(count);
    return taken;
  }

  template <class T>
  [[nodiscard]] T get() {
    static_assert(std::is_arithmetic_v<T>);
    T value;
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }

  /// Fills `count` values of a trivially copyable type.
  template <class T>
  void get_many(T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (count == 0) return;
    const ByteView taken = take(count * sizeof(T));
    std::memcpy(values, taken.data(), taken.size());
  }

  /// Takes `magic` off the front.
  /// @throws Error{InvalidInput} if something else stands there.
  void expect_magic(std::string_view magic) {
    const ByteView found = take(magic.size());
    if (std::memcmp(found.data(), magic.data(), magic.size()) != 0) {
      throw_invalid("the payload does not start with its mark; build the package again");
    }
  }

 private:
  ByteView rest_;
};

class ByteWriter {
 public:
  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    put_many(&value, 1);
  }

  template <class T>
  void put_many(const T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(values, count * sizeof(T));
  }

  void put_text(std::string_view text) { put_many(text.data(), text.size()); }

  [[nodiscard]] Bytes take() { return std::move(bytes_); }

 private:
  void append(const void* data, std::size_t size);

  Bytes bytes_;
};

}  // namespace beatlas::atlas
