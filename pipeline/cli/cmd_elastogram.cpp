#include <algorithm>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/console.h"
#include "pipeline/formats/image_file.h"
#include "pipeline/identify/elastogram.h"
#include "pipeline/study/files.h"
#include "runtime/atlas/atlas.h"
#include "runtime/base/error.h"
#include "runtime/base/replace_file.h"
#include "runtime/palpation/lv_wall.h"

namespace beatlas::cli {
namespace {

using nlohmann::json;

struct ElastogramArguments {
  std::string package;
  std::string image;
  std::string output;
  std::string unit = "kpa";
  std::string modulus = "young";
  bool as_json = false;
};

std::vector<float> stiffness_of(const ElastogramArguments& arguments) {
  const atlas::Atlas atlas = atlas::Atlas::open(
      arguments.package,
      {.fields = {}, .surfaces = {Structure::LvBlood}, .maps = {Structure::LvBlood}});
  const auto wall = palpation::lv_wall_of(atlas);
  if (!wall) {
    throw_invalid(arguments.package +
                  " has no map of the LV's wall, on which stiffness could lie; build it again from "
                  "images");
  }
  const formats::ImageFile file = formats::read_image_file(arguments.image);
  if (file.images.phase_count() != 1) {
    throw_invalid(arguments.image + " holds " + std::to_string(file.images.phase_count()) +
                  " images one after another; give the one of end-diastole alone");
  }
  try {
    return identify::elastogram_of_wall(
        *wall, atlas.manifest().workspace_from_lps, file.images.grid, file.images.phases.front(),
        {.modulus =
             arguments.modulus == "shear" ? identify::Modulus::Shear : identify::Modulus::Young,
         .kpa_per_unit = arguments.unit == "pa" ? 1e-3 : 1});
  } catch (const Error& error) {
    throw error.with_context(arguments.image);
  }
}

int run_elastogram(const ElastogramArguments& arguments) {
  constexpr std::string_view kHeader = "vertex,kpa\n";
  refuse_other_kind(arguments.output, kHeader);
  const std::vector<float> kpa = stiffness_of(arguments);
  std::ostringstream table;
  table.precision(6);
  table << kHeader;
  std::vector<float> measured;
  for (std::size_t v = 0; v < kpa.size(); ++v) {
    if (!(kpa[v] > 0)) continue;
    table << v << ',' << kpa[v] << '\n';
    measured.push_back(kpa[v]);
  }
  study::write_text(arguments.output, table.str());
  std::sort(measured.begin(), measured.end());
  const auto at = [&](double share) {
    return static_cast<double>(
        measured[static_cast<std::size_t>(share * static_cast<double>(measured.size() - 1))]);
  };
  if (arguments.as_json) {
    print_data(json{{"vertices", kpa.size()},
                    {"measured", measured.size()},
                    {"kpa", {{"p5", at(0.05)}, {"median", at(0.5)}, {"p95", at(0.95)}}}}
                   .dump(2) +
               "\n");
    return 0;
  }
  std::ostringstream text;
  text.precision(3);
  text << "measured at " << measured.size() << " of " << kpa.size() << " vertices of lv_blood; "
       << at(0.05) << ", " << at(0.5) << ", " << at(0.95)
       << " kPa (5 %, median, 95 %)\nfelt with --model patch --parameters P.json, where P.json "
          "holds {\"regions\": [{\"measured\": \"...\"}]}\n";
  print_data(text.str());
  return 0;
}

}  // namespace

void add_elastogram(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<ElastogramArguments>();
  CLI::App* command = app.add_subcommand(
      "elastogram",
      "Stiffness of an atlas's LV wall from an image of stiffness at end-diastole, in the frame of "
      "its exam: a table for the regions of beatlas-play --parameters");
  command->add_option("PACKAGE", arguments->package, "A .beatlas file")->required();
  command->add_option("IMAGE", arguments->image, "NIfTI, NRRD or MetaImage; 0: not measured")
      ->required();
  command->add_option("-o,--output", arguments->output, "Write vertex and kpa here")
      ->type_name("MAP.csv")
      ->required();
  command->add_option("--unit", arguments->unit, "Of the image's voxels")
      ->check(CLI::IsMember({"kpa", "pa"}))
      ->capture_default_str();
  command
      ->add_option("--modulus", arguments->modulus,
                   "What they are: young, E; shear, G, of which E = 3 G is taken")
      ->check(CLI::IsMember({"young", "shear"}))
      ->capture_default_str();
  command->add_flag("--json", arguments->as_json, "What was measured as JSON");
  command->callback(
      [arguments, &run] { run = [arguments] { return run_elastogram(*arguments); }; });
}

}  // namespace beatlas::cli
