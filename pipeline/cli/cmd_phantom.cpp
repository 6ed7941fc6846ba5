#include <memory>

#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/coverage_words.h"
#include "pipeline/cli/phantom_words.h"
#include "pipeline/core/parallel.h"
#include "pipeline/core/phantom_mark.h"
#include "pipeline/formats/dicom_writer.h"
#include "pipeline/formats/nifti.h"
#include "pipeline/phantom/render.h"
#include "pipeline/phantom/true_coverage.h"
#include "pipeline/phantom/truth.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

struct Arguments {
  CommonArguments common;
  std::shared_ptr<PhantomWords> phantom = std::make_shared<PhantomWords>();
  std::string output;
  std::string format = "dicom";
  bool coverage = false;
};

/// Writes the images and tells their place.
fs::path write_images(const fs::path& folder, const std::string& format,
                      const phantom::Phantom& phantom, const Cine& cine) {
  const phantom::PhantomSpec& spec = phantom.spec();
  const std::string mark = phantom_mark(phantom.identity());
  if (format == "nifti") {
    const fs::path file = folder / "cine.nii.gz";
    formats::write_nifti(file, cine.images, spec.rr_interval_s / spec.phases,
                         formats::NiftiStorage::Int16, mark);
    return file;
  }
  formats::DicomWriteOptions options;
  options.comment = mark;
  options.series_per_slice = format == "dicom";
  options.slice_thickness_mm = spec.scanner.slice_thickness_mm;
  if (format == "dicom-enhanced") {
    formats::write_enhanced_dicom(folder / "dicom", cine, options);
  } else {
    formats::write_dicom(folder / "dicom", cine, options);
  }
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

int make_phantom(const Arguments& arguments) {
  const phantom::PhantomSpec spec = phantom_spec(*arguments.phantom);
  const phantom::Phantom phantom(spec);
  const fs::path folder(arguments.output);
  std::error_code ignored;
  if (fs::is_directory(folder, ignored) && !fs::is_empty(folder, ignored)) {
    throw Error(ErrorCode::InvalidInput, "the folder " + folder.string() +
                                             " is not empty; name a new or empty folder with -o");
  }
  study::make_folder(folder);
  study::check_writable(folder / "truth.json");
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
    images = write_images(folder, arguments.format, phantom, rendering.cine);
    // Beside the images and not among them, so that the exam's folder holds images only.
    formats::write_nifti_labels(folder / "truth_labels.nii.gz", rendering.labels, interval_s);
    if (arguments.coverage) write_coverage(folder / "truth_coverage", coverage, interval_s);
    study::write_json(folder / "truth.json", phantom::truth_json(phantom));
  });
  print_data(images.string() + "\n");
  console.finish();
  return 0;
}

}  // namespace

void add_phantom(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "phantom", "Make images of a beating heart whose every surface is known in closed form");
  command->footer(
      "Writes dicom/ or cine.nii.gz, truth.json (what 'beatlas validate --truth' reads) and\n"
      "truth_labels.nii.gz, and prints the name of the images for 'beatlas build'. Without an "
      "option\n"
      "the preset's or the spec's value holds; off is the default of every fault of the scanner.");
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
  add_phantom_words(*command, arguments->phantom);
  add_common(*command, arguments->common);
  command->callback([arguments, &run] { run = [arguments] { return make_phantom(*arguments); }; });
}

}  // namespace beatlas::cli
