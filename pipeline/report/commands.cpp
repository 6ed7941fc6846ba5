// The commands that a report offers.

#include <algorithm>
#include <cstdio>

#include "pipeline/core/shapes.h"
#include "pipeline/core/words.h"
#include "pipeline/report/report_data.h"

namespace beatlas::report {
namespace {

/// Without a name it finds the package that the study made last.
std::string build_command(bool has_made_package) {
  return has_made_package ? "beatlas build --study ." : "beatlas build --study . -o heart.beatlas";
}

}  // namespace

std::vector<std::string> correcting_commands(const Place& place, bool drawn,
                                             bool has_made_package) {
  const std::string build = build_command(has_made_package);
  if (drawn) return {build};
  char text[160];
  if (place.seeds.empty()) {
    // Whether an uncertain boundary is wrong, and which way, only the image tells.
    std::snprintf(text, sizeof text,
                  "beatlas seeds . add --label LABEL --lps=%.1f,%.1f,%.1f --phase %d",
                  place.lps_mm[0], place.lps_mm[1], place.lps_mm[2], place.phase);
    return {text, build};
  }
  std::vector<std::string> out;
  for (const LeakSeed& seed : place.seeds) {
    std::snprintf(text, sizeof text,
                  "beatlas seeds . add --label %s --lps=%.1f,%.1f,%.1f --phase %d --radius %.1f",
                  std::string(kLabelWords.at(seed.label)).c_str(), seed.lps_mm[0], seed.lps_mm[1],
                  seed.lps_mm[2], seed.phase, seed.radius_mm);
    out.emplace_back(text);
  }
  out.push_back(build);
  return out;
}

WaysToFind ways_to_find(const std::vector<Structure>& missing, int phase, bool drawn,
                        bool has_made_package) {
  const std::string build = build_command(has_made_package);
  if (drawn) {
    return {
        "Labels were painted or given and stay as they are: paint what is missing into "
        "segment/labels.nii.gz, in every phase, with the editor that drew them, and build again.",
        {build}};
  }
  WaysToFind out;
  out.how =
      "Mark it, best in three slices: in the image of this page, at the phase below, click into it "
      "and run the command that is shown there; or give a place [mm, RAS] for X,Y,Z as a viewer of "
      "exam/stack.nii.gz shows it. Then build again.";
  for (const Structure structure : missing) {
    // The heart has no label of its own: it is all that has one.
    const std::uint8_t label =
        structure == Structure::Heart ? std::uint8_t{kLabelRestOfHeart} : label_of(structure);
    out.commands.push_back("beatlas seeds . add --label " + std::string(kLabelWords.at(label)) +
                           " --ras=X,Y,Z --phase " + std::to_string(phase));
  }
  out.commands.push_back(build);
  return out;
}

}  // namespace beatlas::report
