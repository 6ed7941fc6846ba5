#pragma once
/// What every payload asks of its own numbers.

#include <string>

#include "runtime/base/error.h"

namespace beatlas::atlas {

/// @param what a sentence without its end, such as "field has a step out of range"
/// @throws Error{InvalidInput} with it and what to do, unless `ok`
inline void require(bool ok, const char* what) {
  if (!ok) throw_invalid(std::string(what) + "; build the package again");
}

/// False for what is no number.
inline bool within(double value, double low, double high) { return value >= low && value <= high; }

}  // namespace beatlas::atlas
