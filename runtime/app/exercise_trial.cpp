#include "runtime/app/exercise_trial.h"

#include "runtime/device/csv_table.h"
#include "runtime/device/replay.h"

namespace beatlas::app {

std::vector<TraceRow> read_trace(std::istream& stream, const std::string& name) {
  const device::CsvTable table =
      device::read_csv(stream, name,
                       {"t_s", "x_mm", "y_mm", "z_mm", "depth_mm", "fx_n", "fy_n", "fz_n",
                        "buttons", "valid", "stalled"});
  std::vector<TraceRow> out;
  out.reserve(table.rows.size());
  for (const std::vector<double>& row : table.rows) {
    out.push_back({.time_s = row[0],
                   .position_mm = Vec3(row[1], row[2], row[3]),
                   .depth_mm = row[4],
                   .force_n = Vec3(row[5], row[6], row[7]),
                   .buttons = device::buttons_of(row[8], name, out.size() + 1),
                   .valid = row[9] != 0,
                   .stalled = row[10] != 0});
  }
  return out;
}

TrialReplay replay_trial(const ExerciseGround& atlas, const exercise::Exercise& asked,
                         const std::vector<exercise::Lesion>& lesions,
                         const std::vector<std::vector<TraceRow>>& parts,
                         double heart_rate_per_min) {
  const double harmful_n =
      asked.harmful_force_n > 0 ? asked.harmful_force_n : atlas.harmful_force_n();
  exercise::Examination examination(asked, atlas.ground(), harmful_n);
  TrialReplay out;
  for (const std::vector<TraceRow>& rows : parts) {
    haptics::Servo servo(atlas.scene(lesions), exercise_servo_options(heart_rate_per_min));
    for (const TraceRow& row : rows) {
      const haptics::Tick felt =
          servo.tick({.time_s = row.time_s, .position_mm = row.position_mm, .valid = row.valid});
      ++out.ticks;
      // A number that was no number was written as 0, and -0 as 0; neither is felt otherwise.
      out.different += felt.force_n == row.force_n ? 0 : 1;
      examination.add(
          {.time_s = row.time_s,
           .beats = servo.published().phase,
           .tool_mm = row.position_mm,
           .contact_mm = row.position_mm -
                         (felt.contact.distance_mm + asked.tool_radius_mm) * felt.contact.normal,
           .touching = felt.contact.touching,
           .force_n = felt.contact.force_n.norm(),
           .buttons = row.buttons});
      if (row.stalled) servo.restart();
    }
    examination.end_part();
  }
  out.findings = examination.findings();
  return out;
}

}  // namespace beatlas::app
