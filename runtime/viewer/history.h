#pragma once
/// What the plots show and a CSV keeps: every fifth tick, the last minute.

#include <deque>
#include <filesystem>
#include <vector>

#include "runtime/viewer/plots.h"
#include "runtime/viewer/touch.h"

namespace beatlas::viewer {

class History {
 public:
  /// One as new as the last is left out; with an older one another session begins. Where the
  /// parameters have changed, loops begin anew with the next beat that is theirs alone.
  void add(const PressRow& row);
  void clear();
  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  /// The last one; zeros without any.
  [[nodiscard]] PressRow last() const { return rows_.empty() ? PressRow{} : rows_.back(); }

  /// Force and depth of the last ten seconds, the last beat's P-V loop beside the last one without
  /// a touch.
  [[nodiscard]] std::vector<Panel> panels() const;
  /// t_s,force_n,depth_mm,volume_ml,lv_mmhg. @throws Error{Machine} if it cannot be written whole.
  void write_csv(const std::filesystem::path& file) const;

 private:
  void end_beat();
  void forget_loops();

  std::deque<PressRow> rows_;
  std::vector<PressRow> beat_;  ///< that is going on
  bool beat_touched_ = false;
  std::vector<PressRow> loop_;
  std::vector<PressRow> natural_;
  bool loop_touched_ = false;
  double settled_s_ = 0;  ///< a beat that begins earlier is none of the parameters alone
};

}  // namespace beatlas::viewer
