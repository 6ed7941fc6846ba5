#include <algorithm>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/coverage_words.h"
#include "pipeline/cli/phantom_words.h"
#include "pipeline/core/parallel.h"
#include "pipeline/core/phantom_mark.h"
#include "pipeline/formats/dicom_writer.h"
#include "pipeline/formats/nifti.h"
#include "pipeline/phantom/drawn_exam.h"
#include "pipeline/phantom/render.h"
#include "pipeline/phantom/true_coverage.h"
#include "pipeline/phantom/truth.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

struct PhantomArguments {
  CommonArguments common;
  std::shared_ptr<PhantomWords> phantom = std::make_shared<PhantomWords>();
  std::string output;
  std::string format = "dicom";
  bool coverage = false;
  std::optional<std::uint32_t> draw;
  int most_voxels = phantom::DrawnExamOptions().most_voxels;
  int views = 0;
};

/// One cine of an exam as DICOM.
void write_dicom_as(const std::string& format, const fs::path& folder, const Cine& cine,
                    const formats::DicomWriteOptions& options) {
  if (format == "dicom-enhanced") {
    formats::write_enhanced_dicom(folder, cine, options);
  } else {
    formats::write_dicom(folder, cine, options);
  }
}

/// Views beside the stack, as series of the same study that come after the stack's own.
void write_views(const fs::path& folder, const std::string& format,
                 const phantom::DrawnExam& exam) {
  formats::DicomWriteOptions options;
  options.comment = phantom_mark(exam.identity);
  options.exam = exam.identity;
  options.slice_thickness_mm = exam.view_thickness_mm;
  options.first_series = format == "dicom" ? exam.cine.grid().size[2] + 1 : 2;
  for (std::size_t n = 0; n < exam.views.size(); ++n, ++options.first_series) {
    const fs::path place = folder / "dicom" / ("view_" + std::to_string(n + 1));
    study::make_folder(place);
    write_dicom_as(format, place, exam.views[n], options);
  }
}

/// Writes the images and tells their place.
/// @param study what they have in common with views beside them; empty: there are none
fs::path write_images(const fs::path& folder, const std::string& format,
                      const std::string& identity, double slice_thickness_mm, const Cine& cine,
                      const std::string& study = {}) {
  const std::string mark = phantom_mark(identity);
  if (format == "nifti") {
    fs::path file = folder / "cine.nii.gz";
    formats::write_nifti(file, cine.images, cine.frame_interval_s(), formats::NiftiStorage::Int16,
                         mark);
    return file;
  }
  formats::DicomWriteOptions options;
  options.comment = mark;
  options.exam = study;
  options.series_per_slice = format == "dicom";
  options.slice_thickness_mm = slice_thickness_mm;
  write_dicom_as(format, folder / "dicom", cine, options);
  return folder / "dicom";
}

/// One image a structure, as --coverage reads them.
void write_coverage(const fs::path& folder, const CoverageCycle& coverage, double interval_s) {
  study::make_folder(folder);
  for (const auto& [structure, phases] : coverage.phases) {
    formats::write_nifti(folder / coverage_file_name(structure), coverage.grid, phases, interval_s,
                         formats::NiftiStorage::UInt16Fraction);
  }
}

fs::path new_folder(const std::string& named) {
  fs::path folder(named);
  std::error_code ignored;
  if (fs::is_directory(folder, ignored) && !fs::is_empty(folder, ignored)) {
    throw Error(ErrorCode::InvalidInput, "the folder " + folder.string() +
                                             " is not empty; name a new or empty folder with -o");
  }
  study::make_folder(folder);
  study::check_writable(folder / "truth.json");
  return folder;
}

int make_draw(const PhantomArguments& arguments) {
  if (arguments.views > 0 && arguments.format == "nifti") {
    throw Error(
        ErrorCode::Usage,
        "--views needs DICOM, since one NIfTI file holds one stack; leave --format nifti out");
  }
  const fs::path folder = new_folder(arguments.output);
  set_thread_count(arguments.common.threads);
  Console console(arguments.common.verbose);
  phantom::DrawnExam exam;
  console.stage("phantom", [&](StageContext& context) {
    exam = phantom::drawn_exam(
        *arguments.draw, {.most_voxels = arguments.most_voxels, .views = arguments.views}, context);
  });
  const double interval_s = exam.cine.frame_interval_s();
  fs::path images;
  console.stage("write", [&](StageContext&) {
    images = write_images(folder, arguments.format, exam.identity, exam.slice_thickness_mm,
                          exam.cine, exam.views.empty() ? std::string() : exam.identity);
    write_views(folder, arguments.format, exam);
    formats::write_nifti_labels(folder / "truth_labels.nii.gz", exam.labels, interval_s);
    formats::write_nifti_labels(folder / "truth_labels_source.nii.gz", exam.source_labels,
                                interval_s);
    study::write_json(folder / "truth.json", exam.truth);
  });
  print_data(images.string() + "\n");
  console.finish();
  return 0;
}

int make_phantom(const PhantomArguments& arguments) {
  const phantom::PhantomSpec spec = phantom_spec(*arguments.phantom);
  const phantom::Phantom phantom(spec);
  const fs::path folder = new_folder(arguments.output);
  set_thread_count(arguments.common.threads);
  Console console(arguments.common.verbose);
  phantom::Rendering rendering;
  console.stage("phantom",
                [&](StageContext& context) { rendering = phantom::render(phantom, context); });
  CoverageCycle coverage;
  if (arguments.coverage) {
    console.stage("coverage", [&](StageContext& context) {
      coverage = phantom::true_coverage(phantom, context);
    });
  }
  const double interval_s = spec.rr_interval_s / spec.phases;
  fs::path images;
  console.stage("write", [&](StageContext&) {
    images = write_images(folder, arguments.format, phantom.identity(),
                          spec.scanner.slice_thickness_mm, rendering.cine);
    // Beside the images and not among them, so that the exam's folder holds images only.
    formats::write_nifti_labels(folder / "truth_labels.nii.gz", rendering.labels, interval_s);
    if (arguments.coverage) write_coverage(folder / "truth_coverage", coverage, interval_s);
    study::write_json(folder / "truth.json", phantom::truth_json(phantom));
  });
  print_data(images.string() + "\n");
  console.finish();
  return 0;
}

/// A draw is of everything: beside it no other word about heart or scanner has a meaning.
void add_draw(CLI::App& command, const std::shared_ptr<PhantomArguments>& arguments) {
  const std::vector<CLI::Option*> before = command.get_options();
  add_phantom_words(command, arguments->phantom);
  CLI::Option* draw =
      command
          .add_option(
              "--draw", arguments->draw,
              "An exam of a random heart of the family; excludes every option of the groups "
              "below")
          ->type_name("SEED")
          ->check(CLI::Range(std::uint32_t{0}, phantom::kMostDrawSeed));
  for (CLI::Option* option : command.get_options()) {
    const bool said_before = std::find(before.begin(), before.end(), option) != before.end();
    if (option != draw && !said_before) draw->excludes(option);
  }
  draw->excludes("--coverage");
  command
      .add_option(
          "--most-voxels", arguments->most_voxels,
          "Of the drawn exam, all slices and phases together: fewer frames or larger pixels, "
          "then a smaller field of view")
      ->check(CLI::Range(1100000, 200000000))
      ->needs(draw)
      ->capture_default_str();
  command
      .add_option("--views", arguments->views,
                  "Long-axis views beside the drawn stack, evenly turned about the left "
                  "ventricle's axis: of two a four- and a two-chamber view")
      ->check(CLI::Range(0, phantom::kMostDrawnViews))
      ->needs(draw)
      ->capture_default_str();
}

}  // namespace

void add_phantom(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<PhantomArguments>();
  CLI::App* command = app.add_subcommand(
      "phantom",
      "Make images of a beating heart whose every surface is known in closed form, or of "
      "one drawn at random");
  command->footer(
      "Writes dicom/ or cine.nii.gz, truth.json (what 'beatlas validate --truth' reads) and\n"
      "truth_labels.nii.gz, and prints the name of the images for 'beatlas build'. Without an "
      "option\n"
      "the preset's or the spec's value holds; off is the default of every fault of the scanner.\n"
      "With --draw the heart, the body, the scanner and the stack are of a family of ranges\n"
      "(pipeline/phantom/family.json); truth_labels_source.nii.gz holds the labels of the slices "
      "as\n"
      "acquired, moved by breath-holds, and 'validate --truth' does not apply. Seeds below 10000 "
      "are "
      "for\n"
      "training and tuning; judge with others.");
  command->add_option("-o,--output", arguments->output, "A new or empty folder")
      ->required()
      ->type_name("DIR");
  command
      ->add_option("--format", arguments->format,
                   "DICOM with a series a slice, with one series, or as one Enhanced MR object; or "
                   "4-D NIfTI")
      ->check(CLI::IsMember({"dicom", "dicom-volume", "dicom-enhanced", "nifti"}))
      ->capture_default_str();
  command->add_flag("--coverage", arguments->coverage,
                    "Also write truth_coverage/: the exact share of every voxel in each structure, "
                    "which 'beatlas build --labels truth_labels.nii.gz --coverage' takes");
  add_draw(*command, arguments);
  add_common(*command, arguments->common);
  command->callback([arguments, &run] {
    run = [arguments] {
      return arguments->draw ? make_draw(*arguments) : make_phantom(*arguments);
    };
  });
}

}  // namespace beatlas::cli
