#include <limits>

#include <CLI/CLI.hpp>

#include "pipeline/cli/commands.h"
#include "pipeline/core/parallel.h"
#include "pipeline/core/phantom_mark.h"
#include "pipeline/formats/dicom_writer.h"
#include "pipeline/formats/nifti.h"
#include "pipeline/phantom/render.h"
#include "pipeline/phantom/truth.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::cli {
namespace fs = std::filesystem;
namespace {

struct Arguments {
  CommonArguments common;
  std::string output;
  std::string preset = "adult";
  std::string format = "dicom";
  double snr = -1;  // below 0: the preset's
  int seed = -1;    // below 0: the preset's
};

int make_phantom(const Arguments& arguments) {
  phantom::PhantomSpec spec = phantom::preset(arguments.preset);
  if (arguments.snr >= 0) {
    spec.snr_blood = arguments.snr == 0 ? std::numeric_limits<double>::infinity() : arguments.snr;
  }
  if (arguments.seed >= 0) spec.noise_seed = arguments.seed;
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
  const double interval_s = spec.rr_interval_s / spec.phases;
  console.stage("write", [&](StageContext&) {
    if (arguments.format == "dicom") {
      formats::DicomWriteOptions options;
      options.comment = phantom_mark(phantom.identity());
      formats::write_dicom(folder / "dicom", rendering.cine, options);
    } else {
      formats::write_nifti(folder / "cine.nii.gz", rendering.cine.images, interval_s,
                           formats::NiftiStorage::Int16, phantom_mark(phantom.identity()));
    }
    // Beside the images and not among them, so that the exam's folder holds images only.
    formats::write_nifti_labels(folder / "truth_labels.nii.gz", rendering.labels, interval_s);
    study::write_json(folder / "truth.json", phantom::truth_json(phantom));
  });
  print_data((arguments.format == "dicom" ? folder / "dicom" : folder / "cine.nii.gz").string() +
             "\n");
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
      "truth_labels.nii.gz, and prints the name of the images for 'beatlas build'.");
  command->add_option("-o,--output", arguments->output, "A new or empty folder")
      ->required()
      ->type_name("DIR");
  command->add_option("--preset", arguments->preset, "Heart and scanner")
      ->check(CLI::IsMember(phantom::preset_names()))
      ->capture_default_str();
  command->add_option("--format", arguments->format, "Format of the images")
      ->check(CLI::IsMember({"dicom", "nifti"}))
      ->capture_default_str();
  command
      ->add_option("--snr", arguments->snr,
                   "Signal of blood over the noise of a channel; 0 = no noise; without: the "
                   "preset's")
      ->check(CLI::Range(0.0, 1e6));
  command->add_option("--seed", arguments->seed, "Seed of the noise; without: the preset's")
      ->check(CLI::Range(0, std::numeric_limits<int>::max()));
  add_common(*command, arguments->common);
  command->callback([arguments, &run] { run = [arguments] { return make_phantom(*arguments); }; });
}

}  // namespace beatlas::cli
