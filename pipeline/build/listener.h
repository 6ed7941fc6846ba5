#pragma once
/// To whom a build tells what it does. The command line's console is one; a program that embeds the
/// build brings its own.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/core/stage_context.h"
#include "pipeline/report/speed_table.h"

namespace beatlas::build {

class Listener {
 public:
  Listener() = default;
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  virtual ~Listener() = default;

  /// Runs one stage with a context of its own, and notes its times.
  virtual void stage(const std::string& name, const std::function<void(StageContext&)>& body) = 0;
  virtual void warn(std::string_view line) = 0;
  /// What the user must know that is no warning.
  virtual void tell(std::string_view line) = 0;
  /// What only who asks for it needs to know.
  virtual void log(std::string_view line) = 0;
  /// Of the stages that have ended, in their order.
  [[nodiscard]] virtual const std::vector<report::StageTime>& times() const = 0;
};

}  // namespace beatlas::build
