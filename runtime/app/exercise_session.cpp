#include "runtime/app/exercise_session.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <random>
#include <vector>

#include "runtime/app/exercise_files.h"
#include "runtime/app/exercise_report.h"
#include "runtime/app/exercise_trial.h"
#include "runtime/app/headless.h"
#include "runtime/app/play_device.h"
#include "runtime/app/text.h"
#include "runtime/app/trainee.h"
#include "runtime/atlas/scene.h"
#include "runtime/base/error.h"
#include "runtime/base/interrupts.h"
#include "runtime/base/json_text.h"
#include "runtime/exercise/random.h"
#include "runtime/exercise/score.h"
#include "runtime/exercise/staircase.h"

namespace beatlas::app {
namespace {

namespace fs = std::filesystem;
using exercise::Exercise;
using exercise::Lesion;
using exercise::Task;

/// Of independent random streams, each from the session's seed.
constexpr std::uint64_t kTraineeStream = 0x7261696e;
constexpr std::uint64_t kTrialStream = 0x74726961;

std::string item_sha256(const atlas::Manifest& manifest, std::string_view kind,
                        Structure structure) {
  const std::string path = atlas::item_path(kind, structure);
  for (const atlas::Item& item : manifest.items) {
    if (item.path == path) return item.sha256;
  }
  return "";
}

/// What is asked in each trial of a session: of a staircase it hangs on the answers before.
class Asked {
 public:
  Asked(const KeptSession& session, const ExerciseGround& atlas)
      : session_(session), atlas_(atlas) {
    const Exercise& asked = session.exercise;
    if (asked.task == Task::Find) {
      lesions_ = exercise::draw_lesions(asked, atlas.ground(), session.seed);
      return;
    }
    places_ = exercise::threshold_places(asked, atlas.ground());
    staircase_.emplace(exercise::StaircaseOptions{.observer = {.guess = 1.0 / asked.places},
                                                  .first = asked.first_difference,
                                                  .trials = asked.trials});
    ask();
  }

  [[nodiscard]] const std::vector<Lesion>& lesions() const { return lesions_; }
  [[nodiscard]] const std::vector<std::uint32_t>& places() const { return places_; }
  [[nodiscard]] const ExerciseResult& result() const { return result_; }

  /// What was found in a trial that is done; the next one is asked.
  void take(const TrialReplay& trial) {
    result_.ticks += trial.ticks;
    result_.findings.push_back(trial.findings);
    if (!staircase_) {
      result_.lesions = lesions_;
      result_.score = exercise::score_of(lesions_, trial.findings, atlas_.wall());
      return;
    }
    const std::vector<exercise::Mark>& marks = trial.findings.marks;
    ThresholdTrial told{.difference = difference_, .place = lesions_.front().vertex};
    if (!marks.empty()) {
      told.marked = places_[exercise::place_of(marks.back(), places_, atlas_.wall())];
    }
    // Who marks nothing found nothing.
    told.right = told.marked == told.place;
    staircase_->answer(difference_, told.right);
    result_.trials.push_back(told);
    result_.threshold = staircase_->estimate();
    if (!staircase_->done()) ask();
  }

 private:
  void ask() {
    exercise::Random random(session_.seed + kTrialStream * (result_.trials.size() + 1));
    const std::uint32_t vertex = places_[random.below(places_.size())];
    const exercise::Range& radius = session_.exercise.radius_mm;
    const Lesion lesion = exercise::lesion_of_difference(
        staircase_->next(), random.within(radius.low, radius.high), vertex, atlas_.muscle());
    difference_ = exercise::difference_of_lesion(lesion, atlas_.muscle());
    lesions_ = {lesion};
  }

  const KeptSession& session_;
  const ExerciseGround& atlas_;
  std::vector<Lesion> lesions_;
  std::vector<std::uint32_t> places_;
  std::optional<exercise::Staircase> staircase_;
  double difference_ = 0;
  ExerciseResult result_;
};

TrialReplay replay_kept(const ExerciseGround& atlas, const KeptSession& session, const Asked& asked,
                        const fs::path& folder, const KeptTrial& trial) {
  TrialReplay replay = replay_trial(atlas, session.exercise, asked.lesions(),
                                    read_parts(folder, trial), session.heart_rate_per_min);
  if (replay.different > 0) {
    throw_invalid((folder / trial.parts.front()).string() + ": " +
                  std::to_string(replay.different) + " of " + std::to_string(replay.ticks) +
                  " ticks came out otherwise than they were felt; was a file changed, or is this "
                  "another kind of machine?");
  }
  return replay;
}

void write_result(const KeptSession& session, const ExerciseGround& atlas, const Asked& asked,
                  const fs::path& folder) {
  const ExerciseResult& result = asked.result();
  write_file(folder / "score.json", json_text(result_json(session, atlas, result), 2) + "\n");
  write_file(folder / "report.html", report_html(session, atlas, result));
}

KeptSession new_session(const PlayArguments& arguments, const ExerciseGround& atlas,
                        const Exercise& asked) {
  KeptSession out;
  out.exercise = asked;
  out.package = fs::path(arguments.package).filename().string();
  out.field_sha256 = item_sha256(atlas.manifest(), atlas::kFieldKind, Structure::Heart);
  out.map_sha256 = item_sha256(atlas.manifest(), atlas::kMapKind, Structure::LvBlood);
  if (arguments.seed >= 0) {
    out.seed = static_cast<std::uint64_t>(arguments.seed);
  } else {
    std::random_device chance;
    out.seed = chance();
  }
  out.heart_rate_per_min = arguments.heart_rate_per_min;
  return out;
}

void check_package(const KeptSession& session, const ExerciseGround& atlas,
                   const std::string& package, const fs::path& folder) {
  if (session.field_sha256 == item_sha256(atlas.manifest(), atlas::kFieldKind, Structure::Heart) &&
      session.map_sha256 == item_sha256(atlas.manifest(), atlas::kMapKind, Structure::LvBlood)) {
    return;
  }
  throw_invalid(folder.string() + " is a session on " + session.package + ", which " + package +
                " is not");
}

KeptSession session_to_play(const PlayArguments& arguments, const ExerciseGround& atlas,
                            const Exercise& asked, const fs::path& folder) {
  if (!holds_session(folder)) return new_session(arguments, atlas, asked);
  KeptSession out = read_session(folder);
  check_package(out, atlas, arguments.package, folder);
  if (out.finished()) {
    throw_invalid(folder.string() + " holds a session that is finished; name another --session");
  }
  if (exercise::exercise_to_json(out.exercise) != exercise::exercise_to_json(asked) ||
      (arguments.seed >= 0 && out.seed != static_cast<std::uint64_t>(arguments.seed)) ||
      out.heart_rate_per_min != arguments.heart_rate_per_min) {
    throw_invalid(folder.string() +
                  " holds another session that was broken off; name another --session, or the "
                  "exercise, seed and heart rate that it was begun with");
  }
  return out;
}

std::unique_ptr<device::Device> device_of_trial(const PlayArguments& arguments,
                                                const ExerciseGround& atlas,
                                                const KeptSession& session, const Asked& asked,
                                                const ExerciseStage* stage,
                                                SessionOptions& options) {
  if (arguments.device == "mouse" && stage != nullptr) {
    constexpr double kTicksPerS = 1000;
    constexpr std::size_t kBeyond = 1000;
    options.expected_ticks = static_cast<std::size_t>(kTicksPerS * arguments.seconds) + kBeyond;
    return stage->mouse();
  }
  if (arguments.device != "trainee") {
    std::unique_ptr<device::Device> device =
        open_device(arguments, *atlas.field(), atlas.manifest(), options);
    const int wanted = static_cast<int>(session.exercise.kinds.size());
    if (stage == nullptr && is_hardware(arguments.device) && device->buttons() < wanted) {
      throw Error(ErrorCode::Usage, "this exercise is marked by " + std::to_string(wanted) +
                                        " buttons, and " + device->name() + " has " +
                                        std::to_string(device->buttons()) +
                                        "; play it with --window, which has its own");
    }
    return device;
  }
  options.expected_ticks = static_cast<std::size_t>(1000 * session.exercise.seconds) + 2;
  return std::make_unique<Trainee>(
      atlas, session.exercise,
      Trainee::Options{.skill = skill_from_name(arguments.trainee),
                       .places = asked.places(),
                       .heart_rate_per_min = session.heart_rate_per_min,
                       .seed = session.seed + kTraineeStream * (session.trials.size() + 1),
                       .pace = arguments.fast ? device::Pace::Fast : device::Pace::RealTime});
}

/// Where a finger finds them on the heart's surface.
std::vector<Vec3> places_over(const ExerciseGround& atlas,
                              const std::vector<std::uint32_t>& places) {
  std::vector<Vec3> out;
  for (const std::uint32_t vertex : places) {
    if (atlas.over()[vertex]) out.push_back(*atlas.over()[vertex]);
  }
  return out;
}

/// One part of the trial that is next; returns when that trial is done.
void play_part(const PlayArguments& arguments, const ExerciseGround& atlas, const Asked& asked,
               const fs::path& folder, KeptSession& session, const ExerciseStage* stage,
               const std::stop_token& stop) {
  const bool goes_on = !session.trials.empty() && !session.trials.back().done;
  const std::size_t trial = session.trials.size() - (goes_on ? 1 : 0);
  const double played_s = goes_on ? session.trials.back().played_s : 0;
  // What was marked before the device was lost is marked.
  const std::size_t marked =
      goes_on
          ? replay_kept(atlas, session, asked, folder, session.trials.back()).findings.marks.size()
          : 0;
  PlayArguments told = arguments;
  told.seconds = std::max(0.001, session.exercise.seconds - played_s);
  SessionOptions options;
  options.stop = stop;
  options.keep_trace = true;
  options.watchdog = !arguments.fast;
  const int marks = session.exercise.task == Task::Find ? session.exercise.lesions : 1;
  options.marks = std::max(1, marks - static_cast<int>(marked));
  options.mark_buttons = (1U << session.exercise.kinds.size()) - 1;
  std::unique_ptr<device::Device> device =
      device_of_trial(told, atlas, session, asked, stage, options);
  options.seconds = told.seconds;
  haptics::Servo servo(atlas.scene(asked.lesions()),
                       exercise_servo_options(session.heart_rate_per_min));
  std::atomic<int> made = 0;
  options.marks_made = &made;
  if (stage != nullptr) {
    options.more_buttons = stage->marks;
    stage->begins({.exercise = session.exercise,
                   .trial = trial,
                   .marks = options.marks,
                   .seconds = told.seconds,
                   .places_mm = places_over(atlas, asked.places()),
                   .servo = servo,
                   .made = made});
  }
  // Whatever ends it: nobody looks at the servo any more when it is gone.
  const std::shared_ptr<void> ends(nullptr, [stage](void*) {
    if (stage != nullptr) stage->ends();
  });
  const Session played = run_session(*device, servo, options);
  device.reset();
  const bool broken_off = played.lost || stop.stop_requested();
  keep_part(played.trace, !broken_off, folder, trial, session);
  if (played.lost) {
    throw Error(played.lost->code(), std::string(played.lost->what()) + "; trial " +
                                         std::to_string(trial + 1) +
                                         " is kept and goes on with the same command");
  }
}

}  // namespace

Exercise read_exercise(const std::string& file) {
  const nlohmann::json document = read_json_file(file);
  try {
    return exercise::exercise_from_json(document);
  } catch (const Error& error) {
    throw error.with_context(file);
  }
}

void run_exercise(const PlayArguments& arguments, std::ostream& out, const ExerciseStage* stage) {
  if (arguments.session.empty()) {
    throw Error(ErrorCode::Usage, "--exercise is kept in a folder; name one with --session");
  }
  const Exercise asked_exercise = read_exercise(arguments.exercise);
  ToldMuscle told;
  told.parameters = palpation::palpation_preset(asked_exercise.preset);
  const ExerciseGround atlas(arguments.package, told, asked_exercise.tool_radius_mm);
  const fs::path folder = arguments.session;
  KeptSession session = session_to_play(arguments, atlas, asked_exercise, folder);
  Asked asked(session, atlas);
  for (const KeptTrial& trial : session.trials) {
    if (trial.done) asked.take(replay_kept(atlas, session, asked, folder, trial));
  }
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Error(ErrorCode::Machine, folder.string() + " cannot be made");
  write_session(session, folder);

  std::stop_source interrupted;
  std::optional<Interrupts> interrupts;
  if (stage == nullptr) interrupts.emplace([&interrupted] { interrupted.request_stop(); });
  const std::stop_token stop = stage != nullptr ? stage->stop : interrupted.get_token();
  const auto check_stop = [&] {
    if (interrupts) interrupts->check();
    if (stop.stop_requested()) {
      throw Error(ErrorCode::Machine,
                  "the exercise was broken off; it is kept and goes on with the same command");
    }
  };
  while (!session.finished()) {
    check_stop();  // Replaying what a trial kept takes a while, too.
    play_part(arguments, atlas, asked, folder, session, stage, stop);
    check_stop();
    asked.take(replay_kept(atlas, session, asked, folder, session.trials.back()));
    if (session.exercise.task == Task::Threshold && !arguments.json && stage == nullptr) {
      const ThresholdTrial& last = asked.result().trials.back();
      out << "trial " << session.trials.size() << " of " << session.exercise.trials << ": "
          << (last.right ? "right" : "wrong") << "\n"
          << std::flush;
    }
  }
  write_result(session, atlas, asked, folder);
  if (arguments.json) {
    out << json_text(result_json(session, atlas, asked.result()), 2) << '\n';
    return;
  }
  out << result_text(session, atlas, asked.result())
      << "report: " << (folder / "report.html").string() << "\n";
}

void replay_exercise(const std::string& package, const std::string& file, std::ostream& out) {
  const fs::path folder = file;
  const KeptSession session = read_session(folder);
  if (!session.finished()) {
    throw_invalid(folder.string() +
                  " holds a session that was broken off; finish it with beatlas-play --exercise");
  }
  ToldMuscle told;
  told.parameters = palpation::palpation_preset(session.exercise.preset);
  const ExerciseGround atlas(package, told, session.exercise.tool_radius_mm);
  check_package(session, atlas, package, folder);
  Asked asked(session, atlas);
  for (const KeptTrial& trial : session.trials) {
    asked.take(replay_kept(atlas, session, asked, folder, trial));
  }
  write_result(session, atlas, asked, folder);
  out << result_text(session, atlas, asked.result()) << asked.result().ticks
      << " ticks came out the same to the bit\n";
}

}  // namespace beatlas::app
