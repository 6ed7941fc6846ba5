#include "runtime/app/ticks.h"

#include <chrono>
#include <fstream>
#include <ostream>
#include <sstream>
#include <utility>

#include "runtime/app/text.h"
#include "runtime/app/touched_heart.h"
#include "runtime/app/ventricle.h"
#include "runtime/atlas/scene.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"
#include "runtime/base/json_text.h"

namespace beatlas::app {
namespace {

std::string field_sha256(const atlas::Manifest& manifest, const TouchOptions& options) {
  const std::string path = atlas::item_path(atlas::kFieldKind, touched_structure(options.inside));
  for (const atlas::Item& item : manifest.items) {
    if (item.path == path) return item.sha256;
  }
  return "";
}

}  // namespace

std::string ticks_about(const atlas::Manifest& manifest, const TouchOptions& options) {
  return json_text(
      {{"field_sha256", field_sha256(manifest, options)}, {"touch", touch_to_json(options)}});
}

TickKeeper::TickKeeper(haptics::Servo& servo, std::filesystem::path file, std::string about)
    : servo_(servo), file_(std::move(file)), about_(std::move(about)) {
  thread_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      if (servo_.recorder().frozen()) {
        of_fault_ = true;
        write();
        return;  // the first fault is the one to look at
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
}

void TickKeeper::write() {
  std::ostringstream text;
  haptics::write_ticks(text, about_, servo_.recorder().ticks());
  try {
    write_file(file_, text.str());
  } catch (const Error& error) {
    failure_ = error.what();
  }
}

void TickKeeper::finish() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  if (!of_fault_) {
    of_fault_ = servo_.recorder().frozen();
    write();
  }
  if (!failure_.empty()) throw Error(ErrorCode::Machine, failure_);
}

void replay_ticks_file(const std::string& package, const std::string& file, std::ostream& out) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw_invalid(file + " cannot be read; check its name and rights");
  const haptics::RecordedTicks recorded = haptics::read_ticks(stream, file);
  const nlohmann::json about = parse_json(recorded.about);
  JsonObject object(about, "");
  std::string sha256;
  object.read("field_sha256", sha256);
  const TouchOptions options = touch_from_json(object.at("touch"));
  object.finish();
  const Structure structure = touched_structure(options.inside);
  const bool has_tissue = !options.tissue.of_vertex.empty();
  const atlas::Needs needs = has_tissue ? needs_of_press(atlas::Atlas::open(package, {}).manifest())
                                        : needs_of_inside(options.inside, options.valve);
  const atlas::Atlas atlas = atlas::Atlas::open(package, needs);
  if (field_sha256(atlas.manifest(), options) != sha256) {
    throw_invalid(file + " was recorded on another package than " + package +
                  "; replay it on the one it was recorded on");
  }
  const auto field = std::make_shared<const field::FieldQuery>(atlas.field(structure),
                                                               atlas.manifest().rr_interval_s);
  haptics::Servo servo(
      make_scene(field, options, has_tissue ? palpation::lv_wall_of(atlas) : nullptr,
                 options.valve ? valve_of(atlas, package) : nullptr),
      {});
  const haptics::ReplayReport report = haptics::replay_ticks(servo, recorded.ticks);
  if (report.different > 0) {
    const haptics::TickRecord& tick = recorded.ticks[report.first_different];
    std::ostringstream text;
    text << file << ": " << report.different << " of " << report.ticks
         << " ticks come out otherwise, first line " << report.first_different + 4 << " (t "
         << tick.time_s << " s); replay with the build and on the kind of machine that recorded it";
    throw_invalid(text.str());
  }
  std::size_t faults = 0;
  for (const haptics::TickRecord& tick : recorded.ticks) {
    faults += tick.status == haptics::TickStatus::Fault ? 1 : 0;
  }
  out << report.ticks << " ticks replayed, all the same to the bit; " << faults << " faults\n";
}

}  // namespace beatlas::app
