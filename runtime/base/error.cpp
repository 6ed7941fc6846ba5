#include "runtime/base/error.h"

#include <new>
#include <ostream>

namespace beatlas {

Error::Error(ErrorCode code, const std::string& message)
    : std::runtime_error(message), code_(code) {}

Error Error::with_context(std::string_view context) const {
  return {code_, std::string(context) + ": " + what()};
}

void throw_invalid(const std::string& message) { throw Error(ErrorCode::InvalidInput, message); }

int tell_failure(std::ostream& to, std::string_view program) {
  try {
    throw;
  } catch (const Error& error) {
    to << program << ": " << error.what() << '\n';
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    to << program << ": there is not enough memory\n";
  } catch (const std::exception& error) {
    to << program << ": " << error.what() << '\n';
  }
  return static_cast<int>(ErrorCode::Machine);
}

}  // namespace beatlas
