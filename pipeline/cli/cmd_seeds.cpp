#include <array>
#include <charconv>
#include <cstdio>
#include <set>

#include <CLI/CLI.hpp>

#include "pipeline/build/seeds.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/label_names.h"
#include "pipeline/cli/markups.h"
#include "pipeline/core/words.h"
#include "pipeline/segment/drawn_seeds.h"
#include "pipeline/study/json_values.h"
#include "pipeline/study/stage_files.h"
#include "pipeline/study/state.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace {

struct SeedsArguments {
  std::string study;
  bool json = false;
  bool slicer = false;
  std::string label;
  std::vector<std::string> lps;
  std::vector<std::string> ras;
  std::optional<int> slice;
  std::optional<int> row;
  std::optional<int> column;
  int phase = 0;
  double radius_mm = segment::Seed{}.radius_mm;
  std::vector<std::string> numbers;
};

[[noreturn]] void refuse_words(const std::string& what) { throw Error(ErrorCode::Usage, what); }

/// "X,Y,Z" in mm.
Vec3 place_from_word(const std::string& option, const std::string& word) {
  Vec3 place;
  std::string_view rest = word;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), place[axis]);
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    const bool ends = axis == 2 ? rest.empty() : rest.starts_with(',');
    if (error != std::errc() || !ends) {
      refuse_words(option + ": " + shown_word(word) + " is no place; give three numbers as in " +
                   "12.5,-30,4");
    }
    if (axis < 2) rest.remove_prefix(1);
  }
  return place;
}

std::string numbers_text(const Vec3& place, const char* format) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), format, place[0], place[1], place[2]);
  return text.data();
}

std::string voxel_range(const Grid& grid) {
  return "slices 0 to " + std::to_string(grid.size[2] - 1) + ", rows 0 to " +
         std::to_string(grid.size[1] - 1) + " and columns 0 to " + std::to_string(grid.size[0] - 1);
}

/// @param as_ras how the user gave it, and is told of it
void refuse_outside(const Vec3& lps_mm, const Grid& grid, bool as_ras) {
  const Vec3 index = grid.mm_from_index.inverse() * lps_mm;
  const Vec3 last(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
  if ((index.array() >= -0.5).all() && (index.array() <= last.array() + 0.5).all()) return;
  Vec3 low = Vec3::Constant(1e30);
  Vec3 high = -low;
  const Vec3 turn = as_ras ? Vec3(-1, -1, 1) : Vec3(1, 1, 1);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 at((corner & 1) != 0 ? last[0] : 0, (corner & 2) != 0 ? last[1] : 0,
                  (corner & 4) != 0 ? last[2] : 0);
    const Vec3 mm = (grid.mm_from_index * at).cwiseProduct(turn);
    low = low.cwiseMin(mm);
    high = high.cwiseMax(mm);
  }
  const std::string frame = as_ras ? " mm RAS" : " mm LPS";
  throw_invalid("(" + numbers_text(lps_mm.cwiseProduct(turn), "%g, %g, %g") + ")" + frame +
                " lies outside the images, in slice, row, column " +
                numbers_text(Vec3(index[2], index[1], index[0]), "%.0f, %.0f, %.0f") +
                "; they have " + voxel_range(grid) + ", within " +
                numbers_text(low, "(%.0f, %.0f, %.0f)") + " to " +
                numbers_text(high, "(%.0f, %.0f, %.0f)") + frame);
}

std::vector<Vec3> places_of(const SeedsArguments& arguments, const Grid& grid) {
  std::vector<Vec3> places;
  for (const std::string& word : arguments.lps) places.push_back(place_from_word("--lps", word));
  for (const std::string& word : arguments.ras) {
    places.emplace_back(place_from_word("--ras", word).cwiseProduct(Vec3(-1, -1, 1)));
  }
  const bool any = arguments.slice || arguments.row || arguments.column;
  const int ways =
      (arguments.lps.empty() ? 0 : 1) + (arguments.ras.empty() ? 0 : 1) + (any ? 1 : 0);
  if (ways != 1) refuse_words("say where: either --lps, --ras, or --slice, --row and --column");
  for (const Vec3& place : places) refuse_outside(place, grid, arguments.lps.empty());
  if (!any) return places;
  if (!arguments.slice || !arguments.row || !arguments.column) {
    refuse_words("a voxel has all three: --slice, --row and --column");
  }
  if (!grid.contains(*arguments.column, *arguments.row, *arguments.slice)) {
    throw_invalid("the images have " + voxel_range(grid));
  }
  places.push_back(grid.mm(*arguments.column, *arguments.row, *arguments.slice));
  return places;
}

std::string seed_text(const segment::Seed& seed, const Grid& grid) {
  const Vec3 at = grid.mm_from_index.inverse() * seed.lps_mm;
  std::string out(name_of_label(seed.label));
  out += seed.phase < 0 ? ", every phase" : ", phase " + std::to_string(seed.phase);
  out += ", radius " + nlohmann::json(seed.radius_mm).dump() + " mm, at " +
         numbers_text(seed.lps_mm, "%.1f,%.1f,%.1f") + " LPS (slice, row, column " +
         numbers_text(Vec3(at[2], at[1], at[0]), "%.0f, %.0f, %.0f") + ")";
  if (!seed.stroke_lps_mm.empty()) {
    out += ", a stroke on through " + std::to_string(seed.stroke_lps_mm.size()) +
           (seed.stroke_lps_mm.size() == 1 ? " place" : " places");
  }
  return out;
}

int list(const SeedsArguments& arguments) {
  const study::Study study = study::Study::open(arguments.study);
  const build::Orders orders = build::orders_of(study);
  if (arguments.json || arguments.slicer) {
    print_data(
        (arguments.json ? build::seeds_to_json(orders.seeds) : seeds_to_markups(orders.seeds))
            .dump(2) +
        "\n");
    return 0;
  }
  std::string out;
  if (!orders.seeds.empty()) {
    const Grid grid = study::read_stack_lattice(study.folder()).grid;
    for (std::size_t at = 0; at < orders.seeds.size(); ++at) {
      out += std::to_string(at + 1) + "  " + seed_text(orders.seeds[at], grid) + "\n";
    }
  }
  if (orders.painted) out += "and a painted image, which 'segment --seeds none' gives up\n";
  if (out.empty()) out = "no seeds: all is automatic\n";
  print_data(out);
  return 0;
}

/// Changes the seeds that the study is built with, and says what the next build does.
int change(const SeedsArguments& arguments,
           const std::function<std::string(study::Study&, build::Orders&)>& body) {
  Console console(false);
  study::Study study = study_to_write(arguments.study, console, true);
  build::Orders orders = build::orders_of(study);
  const std::string said = body(study, orders);
  build::keep_orders(orders, study);
  study.save();
  const std::vector<std::string> edited = study::edited_outputs(study, study::Stage::Segment);
  if (!edited.empty()) {
    console.warn(edited.front() +
                 " was edited by hand, and all of segment is kept, so seeds change nothing; paint "
                 "segment/labels.nii.gz, or give the edits up: beatlas build --study " +
                 shell_word(arguments.study) + " --discard-edits");
  }
  print_data(said + "; build again: beatlas build --study " + shell_word(arguments.study) + "\n");
  return 0;
}

int add(const SeedsArguments& arguments) {
  const std::optional<std::uint8_t> label = label_from_name(arguments.label);
  if (!label) {
    refuse_words("--label: " + shown_word(arguments.label) + " is no known label; " +
                 what_it_may_be(arguments.label));
  }
  return change(arguments, [&](study::Study& study, build::Orders& orders) {
    if (study.find(study::Stage::Import) == nullptr) {
      throw_invalid("the study " + arguments.study + " holds no images yet; run: beatlas import " +
                    "SOURCE... --study " + shell_word(arguments.study));
    }
    const study::StackLattice stack = study::read_stack_lattice(study.folder());
    const std::vector<Vec3> places = places_of(arguments, stack.grid);
    segment::Seed seed{.label = ventricles_apart(*label),
                       .lps_mm = places.front(),
                       .radius_mm = arguments.radius_mm,
                       .phase = arguments.phase,
                       .stroke_lps_mm = {places.begin() + 1, places.end()}};
    segment::check_seeds({seed}, stack.grid, stack.phases);
    orders.seeds.push_back(seed);
    return "added seed " + std::to_string(orders.seeds.size()) + ", " + seed_text(seed, stack.grid);
  });
}

int remove(const SeedsArguments& arguments) {
  return change(arguments, [&](study::Study&, build::Orders& orders) {
    std::set<std::size_t> gone;
    for (const std::string& word : arguments.numbers) {
      std::size_t number = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
      if (word == "all") {
        for (std::size_t at = 1; at <= orders.seeds.size(); ++at) gone.insert(at);
      } else if (error != std::errc() || end != word.data() + word.size()) {
        refuse_words(shown_word(word) + " is no number of a seed; see: beatlas seeds " +
                     shell_word(arguments.study) + " list");
      } else if (number < 1 || number > orders.seeds.size()) {
        throw_invalid("there is no seed " + word + " in the study " + arguments.study +
                      ", which has " + std::to_string(orders.seeds.size()));
      } else {
        gone.insert(number);
      }
    }
    std::vector<segment::Seed> kept;
    for (std::size_t at = 0; at < orders.seeds.size(); ++at) {
      if (!gone.contains(at + 1)) kept.push_back(orders.seeds[at]);
    }
    orders.seeds = std::move(kept);
    return "removed " + std::to_string(gone.size()) + " of " +
           counted(gone.size() + orders.seeds.size(), "seed");
  });
}

void add_place_words(CLI::App& command, SeedsArguments& words) {
  command
      .add_option("--label", words.label,
                  "What lies there: background, rv_blood, lv_myocardium, lv_blood, rest_of_heart")
      ->required();
  const auto place = [&](const char* option, std::vector<std::string>& to, const char* text) {
    command.add_option(option, to, text)->allow_extra_args(false)->type_name("X,Y,Z");
  };
  place("--lps", words.lps,
        "Place in the patient as DICOM has it [mm]; given again, a stroke goes on to that place");
  place("--ras", words.ras, "The same as 3D Slicer shows it [mm]");
  command.add_option("--slice", words.slice, "Voxel of exam/stack.nii.gz, counted from 0");
  command.add_option("--row", words.row, "The same");
  command.add_option("--column", words.column, "The same");
  command.add_option("--phase", words.phase, "Phase from 0, or -1: every phase")
      ->check(CLI::Range(-1, study::kLastPhase))
      ->capture_default_str();
  command.add_option("--radius", words.radius_mm, "Radius of the ball or stroke [mm]")
      ->check(CLI::Range(0.1, 50.0))
      ->type_name("MM")
      ->capture_default_str();
}

}  // namespace

void add_seeds(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<SeedsArguments>();
  CLI::App* command =
      app.add_subcommand("seeds", "List, add and remove the seeds that a study is segmented with");
  command->footer(
      "Numbers are those of 'list'. A seeds file, markups of 3D Slicer or a painted image as a "
      "whole:\nbeatlas segment --seeds FILE --study STUDY.");
  command->require_subcommand(1);
  command->add_option("STUDY", arguments->study, "The study's folder")->required();
  const auto sub = [&](const char* name, const char* text, int (*body)(const SeedsArguments&)) {
    CLI::App* one = command->add_subcommand(name, text);
    one->callback(
        [arguments, &run, body] { run = [arguments, body] { return body(*arguments); }; });
    return one;
  };
  CLI::App* listing = sub("list", "Print the study's seeds", list);
  listing->add_flag("--json", arguments->json, "As a seeds file, see seeds.schema.json");
  listing->add_flag("--slicer", arguments->slicer, "As markups that 3D Slicer opens (.mrk.json)")
      ->excludes("--json");
  CLI::App* adding = sub("add", "Add a seed: a ball, or a stroke through several places", add);
  add_place_words(*adding, *arguments);
  CLI::App* removing = sub("remove", "Remove seeds", remove);
  removing->add_option("NUMBER", arguments->numbers, "Numbers of 'list', or all")->required();
}

}  // namespace beatlas::cli
