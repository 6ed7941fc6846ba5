#include "pipeline/build/tried_seeds.h"

#include "pipeline/alarm/alarm.h"
#include "pipeline/build/seed_effect.h"
#include "runtime/base/error.h"

namespace beatlas::build {
namespace {

constexpr int kRounds = 3;  ///< of seeds against what is left of a leak
/// A round that leaves more of the alarm than this would not halve it in all of them: 0.5^(1/3).
constexpr double kLessened = 0.794;

/// The alarm that rings for the same as `asked`; null if none does.
const LeakAlarm* same_alarm(const std::vector<LeakAlarm>& alarms, const LeakAlarm& asked) {
  const LeakAlarm* out = nullptr;
  for (const LeakAlarm& alarm : alarms) {
    if (alarm.kind != asked.kind || alarm.structure != asked.structure) continue;
    if (asked.kind == LeakKind::VolumeJump && alarm.phase != asked.phase) continue;
    if (out == nullptr || alarm.figure > out->figure) out = &alarm;
  }
  return out;
}

/// Round by round, the seeds of the alarm and of what is left of it, until they do what is asked;
/// none if they do not.
std::vector<LeakSeed> seeds_that_help(const Exam& exam, Corrections corrections,
                                      const segment::SegmentOptions& options,
                                      const prior::PriorCycle* prior, const Segmentation& found,
                                      const LeakAlarm& alarm, const StageContext& context) {
  StageContext quiet;  // what it would warn of is of no segmentation that is kept
  quiet.cancel = context.cancel;
  std::vector<LeakSeed> seeds;
  LeakAlarm now = alarm;
  for (int round = 0; round < kRounds && !now.seeds.empty(); ++round) {
    for (const LeakSeed& seed : now.seeds) {
      seeds.push_back(seed);
      corrections.seeds.push_back({seed.label, seed.lps_mm, seed.radius_mm, seed.phase});
    }
    Segmentation tried;
    try {
      tried = segment_with(exam, corrections, options, quiet, prior);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::InvalidInput) throw;
      return {};
    }
    const std::vector<LeakAlarm> alarms =
        alarm::leak_alarms(exam.stack, tried, options.leak, quiet);
    const LeakAlarm* left = same_alarm(alarms, alarm);
    const double figure = left == nullptr ? 0 : left->figure;
    const double elsewhere_ml = changed_elsewhere_ml(found.labels, tried.labels, seeds);
    if (elsewhere_ml > kElsewhereMl) return {};
    if (figure <= kAlarmLeft * alarm.figure) return seeds;
    if (figure > kLessened * now.figure) return {};
    now = *left;
  }
  return {};
}

}  // namespace

void try_seeds(const Exam& exam, const Corrections& corrections,
               const segment::SegmentOptions& options, const prior::PriorCycle* prior,
               Segmentation& found, const StageContext& context) {
  for (LeakAlarm& alarm : found.alarms) {
    if (alarm.seeds.empty()) continue;
    alarm.seeds = seeds_that_help(exam, corrections, options, prior, found, alarm, context);
  }
}

}  // namespace beatlas::build
