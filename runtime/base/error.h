#pragma once
/// One error type for the whole project.
/// Bad input is thrown as an Error where it is met, gains context on its way up and is caught
/// once, in main, where its code becomes the exit code. Bugs are asserts, not Errors.

#include <iosfwd>
#include <stdexcept>
#include <string>
#include <string_view>

namespace beatlas {

/// What kind of trouble; the numeric value is the exit code of the commands.
enum class ErrorCode : int {
  Usage = 2,         ///< the call's words are wrong
  InvalidInput = 3,  ///< a file, image or package cannot be used
  Quality = 4,       ///< the result is below what the recipe demands
  Machine = 5,       ///< disk full, unwritable, out of memory
};

/// An error a user can act on: `message` is one sentence that says what is wrong, where, and what
/// to do. It never contains text taken from a patient's file other than the file's name.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message);

  [[nodiscard]] ErrorCode code() const noexcept { return code_; }

  /// The same error with "`context`: " put before its message.
  [[nodiscard]] Error with_context(std::string_view context) const;

 private:
  ErrorCode code_;
};

/// Throws Error{InvalidInput, message}.
[[noreturn]] void throw_invalid(const std::string& message);

/// For the catch (...) of a program: tells what was thrown in a line after "`program`: ".
/// @return the exit code; of what is no Error, that of Machine
[[nodiscard]] int tell_failure(std::ostream& to, std::string_view program);

}  // namespace beatlas
