#include "runtime/viewer/history.h"

#include <algorithm>
#include <sstream>

#include "runtime/base/replace_file.h"

namespace beatlas::viewer {
namespace {

constexpr double kKeptS = 60;
constexpr double kShownS = 10;
constexpr double kSettlingS = 0.25;  // until the circulation is as it is wished

}  // namespace

void History::clear() { *this = History(); }

void History::forget_loops() {
  natural_.clear();
  loop_.clear();
  loop_touched_ = false;
}

void History::end_beat() {
  if (beat_.front().time_s >= settled_s_) {
    beat_.push_back(beat_.front());
    loop_ = beat_;
    loop_touched_ = beat_touched_;
    if (!beat_touched_) natural_ = loop_;
  }
  beat_.clear();
  beat_touched_ = false;
}

void History::add(const PressRow& row) {
  if (!rows_.empty() && row.time_s == rows_.back().time_s) return;
  if (!rows_.empty() && row.time_s < rows_.back().time_s) clear();
  if (!rows_.empty() && row.wishes != rows_.back().wishes) {
    forget_loops();
    settled_s_ = row.time_s + kSettlingS;
  }
  if (!beat_.empty() && beat_.back().beat != row.beat) end_beat();
  beat_.push_back(row);
  beat_touched_ = beat_touched_ || row.touching;
  rows_.push_back(row);
  while (rows_.front().time_s < row.time_s - kKeptS) rows_.pop_front();
}

std::vector<Panel> History::panels() const {
  std::vector<PressRow> recent;
  for (const PressRow& row : rows_) {
    if (row.time_s >= rows_.back().time_s - kShownS) recent.push_back(row);
  }
  Panel loops{.title = "LV pressure [mmHg]",
              .x_title = "LV volume [ml]",
              .curves = {curve(natural_, &PressRow::volume_ml, &PressRow::lv_mmhg, "natural",
                               QColor(120, 180, 255))},
              .from_zero = true};
  if (loop_touched_) {
    loops.curves.push_back(
        curve(loop_, &PressRow::volume_ml, &PressRow::lv_mmhg, "pressed", QColor(255, 120, 110)));
  }
  return {
      {.title = "Force [N]",
       .x_title = "Time [s]",
       .curves = {curve(recent, &PressRow::time_s, &PressRow::force_n, "", QColor(90, 220, 120))},
       .from_zero = true},
      {.title = "Depth [mm]",
       .x_title = "Time [s]",
       .curves = {curve(recent, &PressRow::time_s, &PressRow::depth_mm, "", QColor(250, 200, 80))},
       .from_zero = true},
      loops};
}

void History::write_csv(const std::filesystem::path& file) const {
  std::ostringstream stream;
  stream.precision(9);
  stream << "t_s,force_n,depth_mm,volume_ml,lv_mmhg\n";
  for (const PressRow& row : rows_) {
    stream << row.time_s << ',' << row.force_n << ',' << row.depth_mm << ',' << row.volume_ml << ','
           << row.lv_mmhg << '\n';
  }
  replace_file(file, stream.view());
}

}  // namespace beatlas::viewer
