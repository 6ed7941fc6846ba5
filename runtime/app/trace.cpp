#include "runtime/app/trace.h"

#include "runtime/app/text.h"
#include "runtime/device/csv_table.h"
#include "runtime/device/replay.h"

namespace beatlas::app {

std::string trace_csv(const std::vector<TraceRow>& trace) {
  std::string text = "t_s,x_mm,y_mm,z_mm,depth_mm,fx_n,fy_n,fz_n,buttons,valid,stalled\n";
  for (const TraceRow& row : trace) {
    append_number(text, row.time_s);
    const bool is_place = row.position_mm.allFinite();
    const Vec3 place = is_place ? row.position_mm : Vec3(Vec3::Zero());
    for (double value : {place[0], place[1], place[2], row.depth_mm, row.force_n[0], row.force_n[1],
                         row.force_n[2]}) {
      text += ',';
      append_number(text, value);
    }
    text += ',' + std::to_string(row.buttons) + (row.valid && is_place ? ",1" : ",0") +
            (row.stalled ? ",1" : ",0");
    text += '\n';
  }
  return text;
}

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

}  // namespace beatlas::app
