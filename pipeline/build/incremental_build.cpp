#include "pipeline/build/incremental_build.h"

#include <algorithm>
#include <utility>

#include "pipeline/build/fingerprint.h"
#include "pipeline/build/version.h"
#include "pipeline/core/words.h"
#include "pipeline/field/repair_topology.h"
#include "pipeline/motion/acquisition_faults.h"
#include "pipeline/study/files.h"
#include "pipeline/tissue/tissue.h"
#include "runtime/base/error.h"

namespace beatlas::build {
namespace fs = std::filesystem;
using nlohmann::json;
using study::Stage;
namespace {

/// "a was", "a and b were", "a, b and 7 more were".
std::string listed(const std::vector<std::string>& names) {
  std::string out = names.front();
  if (names.size() == 2) out += " and " + names.back();
  if (names.size() > 2) {
    out += ", " + names[1] + " and " + std::to_string(names.size() - 2) + " more";
  }
  return out;
}

std::string names_of(const std::vector<Stage>& stages) {
  std::string out;
  for (const Stage stage : stages) {
    if (!out.empty()) out += ", ";
    out += study::stage_name(stage);
  }
  return out;
}

/// Of a stage that makes one structure after another.
StageContext part_of(const StageContext& context, Structure structure, std::size_t at,
                     std::size_t count) {
  const double each = IncrementalBuild::kMade / static_cast<double>(count);
  const auto before = static_cast<double>(at);
  return context.part(before * each, (before + 1) * each, structure_name(structure));
}

}  // namespace

IncrementalBuild::IncrementalBuild(Listener& listener, Orders orders,
                                   std::optional<study::Study> study)
    : listener_(listener), orders_(std::move(orders)), study_(std::move(study)) {}

void IncrementalBuild::make(const Scene& scene, const fs::path& file) {
  plan_ = study_ ? plan_of_study(scene) : plan_of(scene);
  if (!plan_.atria) orders_.recipe.segment.atria = false;
  segment();
  demand_heart(scene, file);
  registration();
  fields();
  surfaces();
  pack(scene, file);
}

bool IncrementalBuild::keeps(Stage stage, const study::Wanted& wanted) {
  if (!study_) return false;
  const study::StageState state = study::state_of(*study_, stage, wanted);
  if (!state.ran) return false;
  const std::vector<std::string> unused = study::edited_for_the_eye(*study_, stage);
  if (!unused.empty() && orders_.discard_edits) return false;
  const std::string name(study::stage_name(stage));
  if (state.edited.empty() || orders_.discard_edits) {
    if (!state.up_to_date() || !state.edited.empty()) return false;
  } else {
    if (!state.missing.empty()) {
      throw_invalid("in the study " + study_->folder().string() + " the file " +
                    state.missing.front() + " is gone or changed while " + state.edited.front() +
                    " was edited by hand; put it back, or have all of " + name +
                    " made anew with --discard-edits");
    }
    listener_.warn(listed(state.edited) + " edited by hand and kept" +
                   (state.changed.empty()
                        ? std::string()
                        : ", though " + listed(state.changed) + " changed since") +
                   "; --discard-edits makes " + name + " anew");
  }
  if (stage == Stage::Register) {
    for (const std::string& file : unused) {
      listener_.warn(file +
                     " was edited, but nothing is made from it; edit segment/labels.nii.gz, " +
                     "and have this made anew with --discard-edits");
    }
  }
  const study::StageRecord& record = *study_->find(stage);
  if (stage != Stage::Pictures && stage != Stage::Pack) {
    facts_.stages[stage] = {record.version, record.options};
  }
  if (stage == Stage::Import) facts_.input_sha256 = record.inputs.at(study::kSourceStack);
  kept_.push_back(stage);
  if (study_->refusal() && study_->refusal()->stage == stage) forget_refusal();
  return true;
}

study::StageRecord IncrementalBuild::new_record(Stage stage) const {
  return new_record(wanted_of(stage, orders_));
}

study::StageRecord IncrementalBuild::new_record(study::Wanted with) {
  study::StageRecord record;
  record.version = std::move(with.version);
  record.sources_sha256 = std::move(with.sources_sha256);
  record.options = std::move(with.options);
  return record;
}

void IncrementalBuild::run(Stage stage, const std::function<void(StageContext&)>& body) {
  warnings_.clear();
  listener_.stage(std::string(study::stage_name(stage)), [&](StageContext& context) {
    StageContext noting = context;
    noting.warn_sink = [&](std::string_view line) {
      warnings_.emplace_back(line);
      context.warn(line);
    };
    try {
      body(noting);
    } catch (const Error& error) {
      if (error.code() == ErrorCode::Quality) note_refusal(stage, error.what());
      throw;
    }
  });
}

void IncrementalBuild::note_refusal(Stage stage, const std::string& reason) {
  if (!study_ || std::exchange(refused_, true)) return;
  study_->set_refusal(study::Refusal{stage, reason});
  study_->save();
}

void IncrementalBuild::forget_refusal() {
  if (!study_ || !study_->refusal()) return;
  study_->set_refusal(std::nullopt);
  study_->save();
}

void IncrementalBuild::leave(Stage stage, study::StageRecord record,
                             const std::function<study::FileList()>& write) {
  if (stage != Stage::Pictures && stage != Stage::Pack) {
    facts_.stages[stage] = {record.version, record.options};
  }
  made_.push_back(stage);
  if (!study_) return;
  forget_refusal();
  // What import warns of may name a file.
  if (stage != Stage::Import) record.warnings = warnings_;
  if (stage != Stage::Import && stage != Stage::Pack) record.inputs = study_->inputs_now(stage);
  study_->begin(stage);
  const study::FileList files = write();
  study_->commit(stage, std::move(record), files);
}

void IncrementalBuild::finish() {
  if (study_) study_->save();
  if (kept_.empty()) return;
  std::string line = "study: kept " + names_of(kept_);
  line += made_.empty() ? "; nothing has changed" : "; made " + names_of(made_);
  listener_.tell(line);
}

void IncrementalBuild::require(Stage stage) {
  const fs::path& folder = study_->folder();
  const std::string name(study::stage_name(stage));
  const std::string run = "; run: beatlas " + name + " --study " + shell_word(folder.string());
  if (!study_->find(stage)) {
    throw_invalid("the study " + folder.string() + " has no result of the stage " + name +
                  (stage == Stage::Import
                       ? "; run: beatlas import SOURCE... --study " + shell_word(folder.string())
                       : run));
  }
  const bool discard = std::exchange(orders_.discard_edits, false);
  const study::StageState state = study::state_of(*study_, stage, wanted_of(stage, orders_));
  if (state.edited.empty() && !state.up_to_date()) {
    const std::vector<std::string>& why = state.missing.empty() ? state.changed : state.missing;
    const bool gone = !state.missing.empty();
    if (stage == Stage::Import) {
      throw_invalid("in the study " + folder.string() + " " + why.front() +
                    (gone ? " is gone" : " changed since the import") +
                    "; name the images again: beatlas build SOURCE... --study " +
                    shell_word(folder.string()));
    }
    throw_invalid("in the study " + folder.string() + " the stage " + name + " must run again (" +
                  why.front() + (gone ? " is gone)" : " changed)") + run);
  }
  if (stage == Stage::Import && state.edited.empty() &&
      study_->find(stage)->sources_sha256 != sources_sha256()) {
    listener_.warn(
        "the import is another build's of this program; name the images again to have them read "
        "anew");
  }
  (void)keeps(stage, wanted_of(stage, orders_));
  orders_.discard_edits = discard;
}

const Exam& IncrementalBuild::exam() {
  if (!exam_) exam_ = study::read_exam(study_->folder());
  note_exam();
  return *exam_;
}

const std::vector<ShapeCycle>& IncrementalBuild::shapes() {
  if (!shapes_) {
    study::Registration stored = study::read_registration(study_->folder());
    shapes_ = std::move(stored.shapes);
    facts_.workspace_from_lps = stored.workspace_from_lps;
  }
  return *shapes_;
}

const std::vector<FieldCycle>& IncrementalBuild::field_cycles() {
  if (!fields_) fields_ = study::read_fields(study_->folder());
  return *fields_;
}

const std::vector<SurfaceCycle>& IncrementalBuild::surface_cycles() {
  if (!surfaces_) surfaces_ = study::read_surfaces(study_->folder());
  return *surfaces_;
}

const std::vector<SurfaceMap>& IncrementalBuild::surface_maps() {
  if (!maps_) maps_ = study::read_surface_maps(study_->folder(), surface_cycles());
  return *maps_;
}

void IncrementalBuild::note_exam() {
  if (std::exchange(exam_noted_, true)) return;
  take_exam(*exam_, facts_);
}

void IncrementalBuild::note_for_package() {
  if (!exam_noted_) (void)exam();
  if (!segmentation_noted_) (void)segmentation();
  if (!facts_.workspace_from_lps) {
    facts_.workspace_from_lps = study::read_workspace_from_lps(study_->folder());
  }
}

void IncrementalBuild::refuse_another_source() const {
  for (Stage stage : study::kAllStages) {
    const std::vector<std::string> edited = study::edited_outputs(*study_, stage);
    if (edited.empty()) continue;
    throw_invalid("the study " + study_->folder().string() + " was made from another source, and " +
                  edited.front() +
                  " was edited by hand; name a new folder, or give the edits up with "
                  "--discard-edits");
  }
}

bool IncrementalBuild::is_of_same_exam(const study::Wanted& with) const {
  constexpr auto kExam = "exam";  // of several in the same files
  const study::StageRecord& record = *study_->find(Stage::Import);
  const auto before = record.inputs.find(study::kSourceFiles);
  return before != record.inputs.end() && before->second == with.source_files &&
         record.options.value(kExam, 0) == with.options.value(kExam, 0);
}

bool IncrementalBuild::is_of_same_images(const study::Wanted& with) const {
  // Another option changes the stack but not the files; a view that is added, a copy or a report
  // the files but not the stack.
  if (is_of_same_exam(with)) return true;
  const auto& inputs = study_->find(Stage::Import)->inputs;
  const auto stack = inputs.find(study::kSourceStack);
  return stack != inputs.end() && stack->second == facts_.input_sha256;
}

void IncrementalBuild::refuse_unless_from(const study::Wanted& with) const {
  if (!study_ || !study_->find(Stage::Import) || orders_.discard_edits) return;
  if (!is_of_same_images(with)) refuse_another_source();
}

void IncrementalBuild::refuse_unless_edits_fit() {
  if (!study_ || orders_.discard_edits) return;
  const std::vector<std::string> edited = study::edited_outputs(*study_, Stage::Segment);
  if (edited.empty() || !study_->find(Stage::Import)) return;
  const study::StackLattice before = study::read_stack_lattice(study_->folder());
  demand_fit(before.grid, before.phases, edited.front());
}

void IncrementalBuild::demand_fit(const Grid& grid, int phases, const std::string& file) {
  const Grid& now = exam().stack.grid();
  if (grid.size == now.size && grid.mm_from_index.isApprox(now.mm_from_index, 1e-9) &&
      phases == exam_->stack.phase_count()) {
    return;
  }
  const std::string folder = study_->folder().string();
  const std::string other = "is of other slices or phases than the images as they are imported now";
  const std::vector<std::string> by_hand = study::edited_outputs(*study_, Stage::Segment);
  if (std::find(by_hand.begin(), by_hand.end(), file) == by_hand.end()) {
    throw_invalid("in the study " + folder + " " + file + " is stale: it " + other +
                  "; build again: beatlas build --study " + shell_word(folder));
  }
  throw_invalid("in the study " + folder + " " + file + ", edited by hand, " + other +
                "; import as before, or make it anew with --discard-edits");
}

void IncrementalBuild::part_with_corrections(const study::Wanted& with) {
  if (!study_ || !study_->find(Stage::Import)) return;
  if (!orders_.keeps_seeds && !orders_.keeps_labels) return;
  if (is_of_same_images(with)) return;
  const std::string what = !orders_.keeps_labels  ? "seeds"
                           : !orders_.keeps_seeds ? "labels that were given"
                                                  : "seeds and labels that were given";
  if (!orders_.discard_edits) {
    throw_invalid("the study " + study_->folder().string() + " holds " + what +
                  " for other images than these; name a new folder, or give them up with "
                  "--discard-edits");
  }
  if (orders_.keeps_seeds) {
    orders_.seeds.clear();
    orders_.painted.reset();
  }
  if (orders_.keeps_labels) {
    orders_.labels.reset();
    orders_.coverage.clear();
  }
  keep_orders(orders_, *study_);
  study_->save();
  listener_.tell("import: given up with the images before: " + what);
}

void IncrementalBuild::leave_import(const study::Wanted& with) {
  note_exam();
  study::StageRecord record = new_record(Stage::Import);
  record.inputs[study::kSourceStack] = facts_.input_sha256;
  if (with.source_files) record.inputs[study::kSourceFiles] = *with.source_files;
  leave(Stage::Import, std::move(record),
        [&] { return study::write_exam(study_->folder(), *exam_); });
}

void IncrementalBuild::import_made(Exam exam, const std::vector<fs::path>& files) {
  study::Wanted with = wanted_of(Stage::Import, orders_);
  if (study_) with.source_files = files_sha256(files);
  if (with.source_files && keeps(Stage::Import, with)) return;
  exam_ = std::move(exam);
  facts_.input_sha256 = stack_sha256(exam_->stack);
  refuse_unless_from(with);
  part_with_corrections(with);
  leave_import(with);
  for (const std::string& decision : facts_.decisions) listener_.tell("import: " + decision);
}

void IncrementalBuild::import(const std::vector<fs::path>& sources) {
  study::Wanted with = wanted_of(Stage::Import, orders_);
  if (sources.empty()) {
    if (orders_.discard_edits && study_->find(Stage::Import)) {
      const std::vector<std::string> edited = study::edited_outputs(*study_, Stage::Import);
      if (!edited.empty()) {
        throw_invalid("in the study " + study_->folder().string() + " " + edited.front() +
                      " was edited by hand and can be made anew from the images only; name them: "
                      "beatlas build SOURCE... --study " +
                      shell_word(study_->folder().string()) + " --discard-edits");
      }
    }
    require(Stage::Import);
    return;
  }
  if (study_) with.source_files = source_sha256(sources);
  // Without it the source cannot be read, and the reader says why.
  if (with.source_files && keeps(Stage::Import, with)) return;
  run(Stage::Import, [&](StageContext& context) {
    exam_ = ingest::read_exam(sources, orders_.recipe.import, context);
    facts_.input_sha256 = stack_sha256(exam_->stack);
    refuse_unless_from(with);
    part_with_corrections(with);
    exam_ = motion::without_acquisition_faults(std::move(*exam_), orders_.recipe.align);
    refuse_unless_edits_fit();
    leave_import(with);
  });
  for (const std::string& decision : facts_.decisions) listener_.tell("import: " + decision);
}

void IncrementalBuild::registration() {
  if (!keeps(Stage::Register, wanted_of(Stage::Register, orders_))) {
    run(Stage::Register, [&](StageContext& context) {
      const Affine map = shape::workspace_from_lps(exam().stack.grid(), segmentation().coverage);
      const double interval_s = exam_->stack.frame_interval_s();
      StageContext part = context.part(0, study_ ? 0.3 : 1);
      // Nothing after it needs more of them than what was noted, and the images around the heart.
      shapes_ = shape::shapes_in_workspace(std::move(*segmentation_), map,
                                           orders_.recipe.registration, part);
      segmentation_.reset();
      facts_.workspace_from_lps = map;
      if (plan_.volume) keep_heart_images();
      leave(Stage::Register, new_record(Stage::Register), [&] {
        context.progress(0.3, "images for the eye");
        const ImageCycle<float> images = shape::cine_in_workspace(std::move(exam_->stack), map);
        exam_.reset();
        const LabelCycle labels = shape::labels_in_workspace(*shapes_);
        context.progress(0.6, "files of the study");
        return study::write_registration(study_->folder(), map, *shapes_, images, labels,
                                         interval_s);
      });
    });
  }
  exam_.reset();
  segmentation_.reset();
}

void IncrementalBuild::keep_heart_images() {
  const field::FieldOptions& options = orders_.recipe.field;
  for (const ShapeCycle& shape : *shapes_) {
    if (shape.structure != Structure::Heart) continue;
    // The field's lattice ends some samples beyond outer_mm.
    const double lattice_mm = shape.level.grid.spacing_mm().x();
    const double margin_mm =
        options.outer_mm + 8 * field::voxel_edge_mm(lattice_mm, options) + 2 * lattice_mm;
    heart_images_ = cut_images(
        exam_->stack.images, tissue::noise_level(exam_->stack.images),
        box_around(exam_->stack.grid(), *facts_.workspace_from_lps, shape.level.grid, margin_mm));
  }
}

void IncrementalBuild::fields() {
  if (!keeps(Stage::Field, wanted_of(Stage::Field, orders_))) {
    run(Stage::Field, [&](StageContext& context) {
      std::vector<FieldCycle> made;
      (void)shapes();
      // All of them were needed: they agree on where they meet.
      std::erase_if(*shapes_, [&](const ShapeCycle& shape) {
        return !is_among(shape.structure, plan_.fields);
      });
      field::FieldOptions options = orders_.recipe.field;
      const bool closes = options.handles == field::Handles::Close;
      options.handles = field::Handles::Keep;
      const StageContext distances = context.part(0, 0.8);
      for (ShapeCycle& shape : *shapes_) {
        context.check_cancelled();
        StageContext part = part_of(distances, shape.structure, made.size(), shapes_->size());
        made.push_back(field::build_field(shape, options, part));
        shape.level.phases = {};
      }
      if (closes) field::repair_topology(made, context.part(0.8, kMade));
      fields_ = std::move(made);
      context.progress(kMade, "files of the study");
      leave(Stage::Field, new_record(Stage::Field),
            [&] { return study::write_fields(study_->folder(), *fields_); });
    });
  }
  shapes_.reset();
}

}  // namespace beatlas::build
