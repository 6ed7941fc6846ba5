#pragma once
/// Walks JSON text in place, for messages that come a thousand times a second: no allocation, no
/// exception. Whatever the text, a call ends within it and says whether it was what it should be.

#include <string_view>

namespace beatlas::device {

class JsonScan {
 public:
  explicit JsonScan(std::string_view text) noexcept : text_(text) {}

  /// Calls visit(key, scan) for each member of the object that begins here; `visit` must consume
  /// the value (`skip` does) and return whether it could. Keys are raw: escapes are not resolved.
  template <class Visit>
  [[nodiscard]] bool object(Visit visit) noexcept {
    if (!take('{')) return false;
    if (take('}')) return true;
    do {
      std::string_view key;
      if (!string(key) || !take(':') || !visit(key, *this)) return false;
    } while (take(','));
    return take('}');
  }
  /// Calls visit(scan) for each element of the array that begins here.
  template <class Visit>
  [[nodiscard]] bool array(Visit visit) noexcept {
    if (!take('[')) return false;
    if (take(']')) return true;
    do {
      if (!visit(*this)) return false;
    } while (take(','));
    return take(']');
  }
  /// Raw text between the quotes.
  [[nodiscard]] bool string(std::string_view& out) noexcept;
  /// A finite number.
  [[nodiscard]] bool number(double& out) noexcept;
  /// Any value, nested no deeper than 32.
  [[nodiscard]] bool skip() noexcept { return skip(0); }
  /// Nothing but white space is left.
  [[nodiscard]] bool at_end() noexcept;

 private:
  [[nodiscard]] bool skip(int depth) noexcept;
  [[nodiscard]] bool take(char wanted) noexcept;
  [[nodiscard]] bool word(std::string_view wanted) noexcept;
  void white() noexcept;

  std::string_view text_;
};

}  // namespace beatlas::device
