// Segmentation in a build, its leak alarm and its pictures.

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "pipeline/alarm/alarm.h"
#include "pipeline/build/corrections.h"
#include "pipeline/build/incremental_build.h"
#include "pipeline/build/learned_prior.h"
#include "pipeline/build/tried_seeds.h"
#include "pipeline/report/doubt.h"
#include "pipeline/report/overlay.h"
#include "pipeline/segment/edited_labels.h"
#include "pipeline/segment/painting.h"
#include "pipeline/study/files.h"
#include "runtime/base/error.h"

namespace beatlas::build {
namespace fs = std::filesystem;
using study::Stage;
namespace {

constexpr double kPriorShare = 0.4;  // of the stage's time, if there is a prior
constexpr auto kOverlay = "pictures/overlay.png";
constexpr auto kVolumes = "pictures/volumes.svg";
constexpr auto kLeak = "pictures/leak";
constexpr auto kRefusedLeak = "pictures/refused_leak";  ///< of a segmentation that was not kept

/// Of the alarm `at`, counted from 0.
std::string leak_picture(const std::string& stem, std::size_t at) {
  return stem + (at < 9 ? "_0" : "_") + std::to_string(at + 1) + ".png";
}

/// Where the images are from, for a message; empty where nothing tells.
std::string source_of_images(const Exam& images, const std::optional<study::Study>& study) {
  if (!images.shown_source.empty()) return images.shown_source;
  return study ? study->folder().string() : std::string();
}

/// Labels given stay as they are, whatever a seed says: where they leak, they must be painted.
/// @param given phases, ascending
void offer_no_seeds(const std::vector<int>& given, std::vector<LeakAlarm>& alarms) {
  for (LeakAlarm& alarm : alarms) {
    if (std::binary_search(given.begin(), given.end(), alarm.phase)) alarm.seeds.clear();
  }
}

void remove_refused_leaks(const fs::path& study) {
  std::error_code ignored;
  for (std::size_t at = 0; fs::remove(study / leak_picture(kRefusedLeak, at), ignored); ++at) {
  }
}

}  // namespace

const Segmentation& IncrementalBuild::segmentation() {
  if (!segmentation_) {
    study::StoredSegmentation stored = study::read_segmentation(study_->folder());
    segmentation_ = std::move(stored.made);
    if (reads_uncertainty_) {
      segmentation_->uncertainty = study::read_uncertainty(study_->folder());
    }
    const bool edited = stored.labels.phases != segmentation_->labels.phases;
    StageContext context;
    if (edited) {
      try {
        segmentation_ =
            segment::with_edited_labels(std::move(*segmentation_), stored.labels, context);
      } catch (const Error& error) {
        segmentation_.reset();
        throw error.with_context((study_->folder() / "segment" / "labels.nii.gz").string());
      }
    }
    const LabelCycle& labels = segmentation_->labels;
    demand_fit(labels.grid, labels.phase_count(), "segment/labels.nii.gz");
    if (edited) {
      ask_for_leaks(context);
      // What was painted stays, whatever a seed says.
      for (LeakAlarm& alarm : segmentation_->alarms) alarm.seeds.clear();
    }
  }
  note_segmentation();
  return *segmentation_;
}

void IncrementalBuild::ask_for_leaks(StageContext& context) {
  const Cine& cine = exam().stack;
  const alarm::LeakOptions& options = orders_.recipe.segment.leak;
  segmentation_->alarms = alarm::leak_alarms(cine, *segmentation_, options, context);
  if (options.action == alarm::LeakAction::Warn || segmentation_->alarms.empty()) return;
  std::string look = "; name a folder with --study to get a picture";
  if (study_) {
    study::make_folder(study_->folder() / "pictures");
    remove_refused_leaks(study_->folder());
    for (std::size_t at = 0; at < segmentation_->alarms.size(); ++at) {
      study::write_bytes(study_->folder() / leak_picture(kRefusedLeak, at),
                         report::leak_png(cine, *segmentation_, segmentation_->alarms[at]));
    }
    look = "; see " + (study_->folder() / leak_picture(kRefusedLeak, 0)).string();
  }
  try {
    alarm::demand_no_leak(segmentation_->alarms, options.action);
  } catch (const Error& error) {
    // The study's own place does not enter it.
    note_refusal(Stage::Segment, std::string(error.what()) + "; see " +
                                     leak_picture(kRefusedLeak, 0) + " in the study");
    throw Error(error.code(), error.what() + look);
  }
}

void IncrementalBuild::note_segmentation() {
  if (std::exchange(segmentation_noted_, true)) return;
  take_segmentation(*segmentation_, facts_);
  if (segmentation_->axis) {
    const LongAxis& axis = *segmentation_->axis;
    const auto length = [&](int phase) {
      const auto p = static_cast<std::size_t>(phase);
      return std::lround(axis.lv_base_mm[p] - axis.apex_mm[p]);
    };
    listener_.log("segment: LV " + std::to_string(length(facts_.end_diastole)) +
                  " mm from apex to base at end-diastole, " +
                  std::to_string(length(facts_.end_systole)) + " mm at end-systole");
  }
  for (const std::string& warning : facts_.warnings) listener_.warn(warning);
  for (std::size_t at = 0; at < segmentation_->alarms.size(); ++at) {
    const LeakAlarm& alarm = segmentation_->alarms[at];
    const std::string look = study_ ? "; see " + leak_picture(kLeak, at) + " in the study" : "";
    // As in the report's verdict: where labels are as expected an alarm is a place to look at.
    if (report::is_borne_out(alarm, *segmentation_, report::ExpectedLimits{})) {
      facts_.warnings.push_back(alarm.sentence);
      listener_.warn(alarm.sentence + look);
    } else {
      listener_.log("segment: a place to look at, where labels are as expected: " + alarm.sentence +
                    look);
    }
  }
}

void IncrementalBuild::segment() {
  if (!keeps(Stage::Segment, wanted_of(Stage::Segment, orders_))) {
    run(Stage::Segment, [&](StageContext& context) { segment_anew(context); });
    note_segmentation();
  } else if (orders_.recipe.segment.leak.action == alarm::LeakAction::Error &&
             !study::edited_outputs(*study_, Stage::Segment).empty()) {
    (void)segmentation();  // the alarm on what was painted, though nothing is to be made from it
  }
  if (study_ && !keeps(Stage::Pictures, wanted_of(Stage::Pictures, orders_))) pictures();
}

void IncrementalBuild::segment_anew(StageContext& context) {
  const Exam& images = exam();
  const Corrections corrections = corrections_for(images, orders_, context);
  std::optional<prior::PriorCycle> learned;
  try {
    if (wants_prior(corrections, orders_.recipe, images.stack.phase_count())) {
      learned =
          prior_of(images, orders_.recipe, context.part(0, kPriorShare, "what voxels look like"));
    }
    StageContext growing = learned ? context.part(kPriorShare, 1) : context;
    segmentation_ = segment_with(images, corrections, orders_.recipe.segment, growing,
                                 learned ? &*learned : nullptr);
  } catch (const Error& error) {
    const std::string source = source_of_images(images, study_);
    if (error.code() != ErrorCode::InvalidInput || source.empty()) throw;
    throw error.with_context(source);
  }
  ask_for_leaks(context);
  offer_no_seeds(corrections.known.phases, segmentation_->alarms);
  if (study_) {  // without, no report offers them
    try_seeds(images, corrections, orders_.recipe.segment, learned ? &*learned : nullptr,
              *segmentation_, context);
  }
  leave(Stage::Segment, new_record(Stage::Segment), [&] {
    const double interval_s = exam().stack.frame_interval_s();
    return study::write_segmentation(study_->folder(), *segmentation_, interval_s,
                                     labels_as_acquired(segmentation_->labels, exam()));
  });
}

void IncrementalBuild::pictures() {
  run(Stage::Pictures, [&](StageContext&) {
    const Exam& images = exam();
    const Segmentation& found = segmentation();
    leave(Stage::Pictures, new_record(Stage::Pictures), [&] {
      study::make_folder(study_->folder() / "pictures");
      study::write_bytes(study_->folder() / kOverlay, report::overlay_png(images.stack, found));
      study::write_text(study_->folder() / kVolumes,
                        report::volume_curves_svg(facts_.volumes, images.stack.rr_interval_s,
                                                  facts_.end_diastole, facts_.end_systole));
      study::FileList files{kOverlay, kVolumes};
      remove_refused_leaks(study_->folder());
      for (std::size_t at = 0; at < found.alarms.size(); ++at) {
        files.push_back(leak_picture(kLeak, at));
        study::write_bytes(study_->folder() / files.back(),
                           report::leak_png(images.stack, found, found.alarms[at]));
      }
      return files;
    });
  });
}

}  // namespace beatlas::build
