#include "pipeline/phantom/signals.h"

#include "runtime/base/error.h"

namespace beatlas::phantom {

Signals signals_preset(const std::string& name) {
  Signals out;
  if (name == "A") {
    out.myocardium = 0.60;
    out.fat = 0.75;
    out.liver = 0.75;
  } else if (name != "B") {
    throw_invalid("signals must be \"A\" or \"B\"");
  }
  return out;
}

std::vector<std::string> signals_names() { return {"A", "B"}; }

}  // namespace beatlas::phantom
