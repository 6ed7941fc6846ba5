#include "runtime/app/exercise_trial.h"

namespace beatlas::app {

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
