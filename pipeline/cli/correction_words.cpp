#include "pipeline/cli/correction_words.h"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include <CLI/CLI.hpp>

#include "pipeline/build/corrections.h"
#include "pipeline/build/seeds.h"
#include "pipeline/cli/coverage_words.h"
#include "pipeline/cli/label_names.h"
#include "pipeline/cli/markups.h"
#include "pipeline/formats/image_file.h"
#include "pipeline/formats/nifti.h"
#include "pipeline/ingest/shown_path.h"
#include "pipeline/segment/known_labels.h"
#include "pipeline/segment/painting.h"
#include "pipeline/study/files.h"
#include "pipeline/study/json_values.h"
#include "pipeline/study/stage_files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

constexpr auto kNone = "none";

[[noreturn]] void refuse_words(const std::string& what) { throw Error(ErrorCode::Usage, what); }

/// An error about a file of the user, which its message names once.
Error told_of(const fs::path& file, const Error& error) {
  std::string said = error.what();
  const std::string named = file.string() + ": ";
  if (said.starts_with(named)) said.erase(0, named.size());
  return Error(error.code(), said).with_context(ingest::shown_to({file}, file));
}

bool is_image(const fs::path& file) {
  const std::optional<formats::ImageFormat> format = formats::format_of(file);
  if (format && *format != formats::ImageFormat::Nifti) {
    throw_invalid(ingest::shown_to({file}, file) +
                  ": label images are read as NIfTI; save it as .nii.gz");
  }
  return format.has_value();
}

/// @param unnamed what 0 stands for
study::GivenLabels read_given_labels(const fs::path& file, const std::string& map_word,
                                     std::uint8_t unnamed) {
  const LabelMap map = map_word.empty() ? own_label_map() : label_map_from_word(map_word);
  try {
    study::GivenLabels out;
    out.images = mapped_labels(formats::read_nifti_labels(file), map, unnamed);
    const bool any =
        std::any_of(out.images.phases.begin(), out.images.phases.end(), [&](const auto& image) {
          return std::any_of(image.begin(), image.end(),
                             [&](std::uint8_t label) { return label != unnamed; });
        });
    if (!any) throw_invalid("it is empty: all its voxels are 0");
    out.file_sha256 = study::sha256_of_file(file);
    return out;
  } catch (const Error& error) {
    throw told_of(file, error);
  }
}

std::vector<int> phases_from_word(const std::string& word) {
  std::vector<int> phases;
  std::string_view rest = word;
  while (true) {
    const std::string_view text = rest.substr(0, rest.find(','));
    int phase = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), phase);
    if (error != std::errc() || end != text.data() + text.size() || phase < 0 ||
        phase > study::kLastPhase || (!phases.empty() && phase <= phases.back())) {
      refuse_words("--labels-phases: give phases from 0 in ascending order, as in 0,7");
    }
    phases.push_back(phase);
    if (text.size() == rest.size()) return phases;
    rest.remove_prefix(text.size() + 1);
  }
}

void take_seeds(const CorrectionWords& words, build::Orders& orders) {
  orders.seeds.clear();
  orders.painted.reset();
  orders.seeds_from = words.seeds;
  if (words.seeds == kNone) return;
  const fs::path file = words.seeds;
  orders.seeds_from = ingest::shown_to({file}, file);
  MarkingWords marking;
  marking.phase = words.seeds_phase.value_or(marking.phase);
  marking.radius_mm = words.seeds_radius_mm.value_or(marking.radius_mm);
  if (is_image(file)) {
    if (words.seeds_radius_mm) refuse_words("--seeds-radius: a painted image tells its own extent");
    study::GivenLabels painted = read_given_labels(file, words.label_map, segment::kNotPainted);
    if (painted.images.phase_count() == 1) {
      painted.phases = {marking.phase};
    } else if (words.seeds_phase) {
      refuse_words("--seeds-phase: the painted image has " +
                   std::to_string(painted.images.phase_count()) +
                   " images, one for each phase of the study");
    }
    painted.sha256 = study::given_sha256(painted.images, painted.phases);
    orders.painted = std::move(painted);
    return;
  }
  const nlohmann::json content = study::read_json(file);
  const bool markups = holds_markups(content);
  if (!markups && (words.seeds_phase || words.seeds_radius_mm)) {
    refuse_words(
        "--seeds-phase and --seeds-radius are for markups and painted images; a seeds file "
        "says its own");
  }
  try {
    orders.seeds = markups ? seeds_from_markups(content, marking) : build::seeds_from_json(content);
  } catch (const Error& error) {
    throw error.with_context(orders.seeds_from);
  }
}

void take_labels(const CorrectionWords& words, build::Orders& orders) {
  orders.labels.reset();
  orders.labels_from = words.labels;
  if (words.labels == kNone) return;
  const fs::path file = words.labels;
  orders.labels_from = ingest::shown_to({file}, file);
  if (!is_image(file)) {
    throw_invalid(orders.labels_from + ": labels are read from NIfTI files, .nii or .nii.gz");
  }
  study::GivenLabels labels = read_given_labels(file, words.label_map, kLabelBackground);
  if (!words.labels_phases.empty()) labels.phases = phases_from_word(words.labels_phases);
  const auto images = static_cast<std::size_t>(labels.images.phase_count());
  if (!words.labels_phases.empty() && labels.phases.size() != images) {
    throw_invalid(orders.labels_from + ": it holds " + std::to_string(images) +
                  (images == 1 ? " image" : " images") + ", but --labels-phases names " +
                  std::to_string(labels.phases.size()) + "; name the phase of each");
  }
  labels.sha256 = study::given_sha256(labels.images, labels.phases);
  orders.labels = std::move(labels);
}

}  // namespace

void add_correction_words(CLI::App& command, CorrectionWords& words) {
  command
      .add_option("--seeds", words.seeds,
                  "Places marked by hand: a seeds file, markups of 3D Slicer (.mrk.json) or a "
                  "painted label image (NIfTI, any grid; 0 is not painted); none: automatic again")
      ->type_name("FILE");
  command
      .add_option("--seeds-phase", words.seeds_phase,
                  "Phase that markups or a painted 3-D image belong to, -1 = every phase; a "
                  "markup's name may end with its own, as in lv_blood@5 (default: 0)")
      ->check(CLI::Range(-1, study::kLastPhase))
      ->type_name("PHASE");
  command
      .add_option("--seeds-radius", words.seeds_radius_mm, "Radius of markups [mm] (default: 2)")
      ->check(CLI::Range(0.1, 50.0))
      ->type_name("MM");
  command
      .add_option("--labels", words.labels,
                  "A segmentation from elsewhere (NIfTI, any grid): of all phases, which is taken "
                  "as it is, or of those of --labels-phases, beside those given before, from which "
                  "the others are made; none: no longer")
      ->type_name("FILE");
  command
      .add_option("--labels-phases", words.labels_phases,
                  "Phases that the images of --labels are, as in 0,7")
      ->type_name("PHASE,...");
  command.add_flag("--labels-aligned", words.labels_aligned,
                   "The images of --labels were drawn on the study's own images, as export --to "
                   "slicer writes them, not on those that were imported, of which slices may have "
                   "been moved");
  command
      .add_option(
          "--coverage", words.coverage,
          "Of the labels of all phases that --labels names: a folder of images "
          "coverage_STRUCTURE.nii.gz, the share 0..1 of each voxel of the images, or of a "
          "part of them, in heart, lv_blood, rv_blood, lv_myocardium, la_blood, ra_blood or "
          "aorta; none: no longer")
      ->type_name("DIR");
  command
      .add_option(
          "--label-map", words.label_map,
          "What the numbers of a label image are: acdc (1 RV, 2 myocardium, 3 LV), mms (1 "
          "LV, 2 myocardium, 3 RV), or as in 3=lv_blood,7=background; else 1 RV blood, 2 "
          "LV myocardium, 3 LV blood, 4 rest of the heart, 5 LA blood, 6 RA blood, 7 aorta "
          "(in labels of some phases alone the last three count as rest of the heart), 255 unknown")
      ->type_name("MAP");
}

void take_back_alignment(const fs::path& study, const CorrectionWords& words,
                         const build::Orders& before, build::Orders& orders) {
  const bool all_aligned = orders.recipe.segment.labels_drawn_on == segment::LabelsDrawnOn::Aligned;
  if (!words.labels_aligned || !orders.labels || all_aligned) return;
  build::move_back(study::read_exam(study), before.labels, *orders.labels);
}

void keep_other_phases(const fs::path& study, const build::Orders& before, build::Orders& orders) {
  if (!before.labels || !orders.labels || orders.labels->phases.empty()) return;
  try {
    const int phases = study::read_stack_lattice(study).phases;
    if (orders.labels->phases.back() >= phases) {
      throw_invalid("phase " + std::to_string(orders.labels->phases.back()) +
                    " is not known; the study has the phases 0 to " + std::to_string(phases - 1));
    }
    if (!before.coverage.empty()) {
      throw_invalid(
          "labels of every phase were given with coverage, which those of one phase cannot change; "
          "give both anew, or first the coverage up with --coverage none");
    }
    orders.labels = build::with_other_phases(std::move(*orders.labels), *before.labels);
  } catch (const Error& error) {
    throw error.with_context(orders.labels_from);
  }
}

void take_corrections(const CorrectionWords& words, build::Orders& orders) {
  const auto image_named = [](const std::string& word) { return !word.empty() && word != kNone; };
  const bool seeds = image_named(words.seeds);
  const bool labels = image_named(words.labels);
  if (!seeds && (words.seeds_phase || words.seeds_radius_mm)) {
    refuse_words("--seeds-phase and --seeds-radius tell of a file that --seeds must name");
  }
  if (!labels && !words.labels_phases.empty()) {
    refuse_words("--labels-phases tells of a file that --labels must name");
  }
  if (!labels && words.labels_aligned) {
    refuse_words("--labels-aligned tells of a file that --labels must name");
  }
  const bool coverage = image_named(words.coverage);
  if (coverage && !labels) {
    refuse_words("--coverage tells of the labels that --labels must name");
  }
  if (coverage && !words.labels_phases.empty()) {
    refuse_words("--coverage goes with labels of every phase; leave --labels-phases out");
  }
  if (!words.label_map.empty()) {
    if (!labels && !(seeds && formats::format_of(words.seeds))) {
      refuse_words("--label-map tells of a label image that --labels or --seeds must name");
    }
    (void)label_map_from_word(words.label_map);
  }
  if (!words.seeds.empty()) take_seeds(words, orders);
  if (!words.labels.empty()) take_labels(words, orders);
  if (words.labels.empty() && words.coverage.empty()) return;
  // Other labels have coverage of their own, or none.
  orders.coverage.clear();
  orders.coverage_from = words.coverage;
  if (!coverage) return;
  orders.coverage_from = ingest::shown_to({words.coverage}, words.coverage);
  orders.coverage = read_coverage(words.coverage);
}

}  // namespace beatlas::cli
