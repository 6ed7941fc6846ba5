#include "runtime/app/probe_command.h"

#include <fstream>
#include <istream>
#include <ostream>
#include <set>
#include <sstream>
#include <string>

#include <CLI/CLI.hpp>

#include "runtime/app/probe.h"
#include "runtime/app/text.h"
#include "runtime/atlas/atlas.h"
#include "runtime/base/error.h"
#include "runtime/base/nearest_name.h"
#include "runtime/base/replace_file.h"

namespace beatlas::app {

CLI::App* add_probe(CLI::App& app, ProbeArguments& arguments) {
  CLI::App& probe = *app.add_subcommand(
      "probe", "distance, normal, velocity and force at points and times of a CSV, how well known");
  probe.add_option("PACKAGE", arguments.package, "a .beatlas file")->required();
  probe
      .add_option("--points", arguments.points,
                  "CSV with columns x_mm, y_mm, z_mm, t_s; - for standard input")
      ->required();
  probe.add_option("-o,--output", arguments.output, "CSV to write (default: standard output)");
  probe.add_option("--structure", arguments.structure, "whose surface")->capture_default_str();
  probe.add_option("--frame", arguments.frame, "axes of points, normals and forces")
      ->check(CLI::IsMember({"workspace", "lps"}))
      ->capture_default_str();
  probe.footer(
      "Example:\n  beatlas-play probe heart.beatlas --points points.csv -o felt.csv\n\n"
      "Method:\n  K x depth along the normal: Nakao et al., MEDINFO 2001");
  return &probe;
}

void run_probe(const ProbeArguments& arguments, std::istream& in, std::ostream& out) {
  const auto structure = structure_from_name(arguments.structure);
  if (!structure) {
    std::set<std::string> names;
    for (const Structure known : kAllStructures) names.emplace(structure_name(known));
    std::string all;
    for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
    const std::string meant = nearest_name(arguments.structure, names);
    throw Error(ErrorCode::Usage,
                "--structure: there is no structure " + arguments.structure +
                    (meant.empty() ? "; there are " + all : "; did you mean " + meant + "?"));
  }
  const atlas::Atlas atlas =
      atlas::Atlas::open(arguments.package, {.fields = {*structure}, .surfaces = {}});
  const atlas::Manifest& manifest = atlas.manifest();
  const field::FieldQuery field(atlas.field(*structure), manifest.rr_interval_s);
  const ProbeOptions options{.stiffness_n_per_m = manifest.stiffness_n_per_m,
                             .lps = arguments.frame == "lps",
                             .workspace_from_lps = manifest.workspace_from_lps,
                             .band = atlas::band_query(manifest, *structure)};
  std::ostringstream text;
  if (arguments.points == "-") {
    probe(field, options, in, "standard input", text);
  } else {
    std::ifstream points = open_text(arguments.points);
    probe(field, options, points, arguments.points, text);
  }
  if (arguments.output.empty()) {
    out << text.str();
  } else {
    refuse_other_kind(arguments.output, text.str());
    write_file(arguments.output, text.str());
  }
}

}  // namespace beatlas::app
