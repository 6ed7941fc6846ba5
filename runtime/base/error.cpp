#include "runtime/base/error.h"

namespace beatlas {

Error::Error(ErrorCode code, const std::string& message)
    : std::runtime_error(message), code_(code) {}

Error Error::with_context(std::string_view context) const {
  return {code_, std::string(context) + ": " + what()};
}

void throw_invalid(const std::string& message) { throw Error(ErrorCode::InvalidInput, message); }

}  // namespace beatlas
