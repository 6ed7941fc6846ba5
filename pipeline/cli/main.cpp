#include <cstdio>
#include <exception>
#include <new>

#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/console.h"
#include "pipeline/cli/version.h"
#include "runtime/base/error.h"

namespace {

constexpr int kDone = 0;

int exit_code(beatlas::ErrorCode code) { return static_cast<int>(code); }

int fail(const char* message, beatlas::ErrorCode code) {
  std::fprintf(stderr, "beatlas: %s\n", message);
  return exit_code(code);
}

int run_command(int argc, char** argv) {
  using namespace beatlas::cli;
  CLI::App app("From ECG-gated cardiac MRI to a beating heart that can be touched.", "beatlas");
  app.set_version_flag("--version", std::string("beatlas ") + kVersion);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 2 usage, 3 bad input, 4 quality below demand, 5 machine trouble.");
  Run run;
  add_build(app, run);
  add_import(app, run);
  add_segment(app, run);
  add_register(app, run);
  add_field(app, run);
  add_mesh(app, run);
  add_pack(app, run);
  add_phantom(app, run);
  add_info(app, run);
  add_validate(app, run);
  add_export(app, run);
  add_status(app, run);
  add_defaults(app, run);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : exit_code(beatlas::ErrorCode::Usage);
  }
  catch_interrupts();
  return run();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run_command(argc, argv);
  } catch (const beatlas::Error& error) {
    return fail(error.what(), error.code());
  } catch (const std::bad_alloc&) {
    return fail("not enough memory; close other programs or use coarser options",
                beatlas::ErrorCode::Machine);
  } catch (const std::exception& error) {
    return fail((std::string("unexpected trouble: ") + error.what()).c_str(),
                beatlas::ErrorCode::Machine);
  }
}
