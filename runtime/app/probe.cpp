#include "runtime/app/probe.h"

#include <algorithm>
#include <array>
#include <istream>
#include <ostream>
#include <string_view>

#include "runtime/app/text.h"
#include "runtime/base/error.h"
#include "runtime/device/csv_table.h"
#include "runtime/haptics/two_step.h"

namespace beatlas::app {
namespace {

constexpr std::array<std::string_view, 8> kColumns{"distance_mm",   "nx",   "ny",   "nz",
                                                   "velocity_mm_s", "fx_n", "fy_n", "fz_n"};
constexpr std::array<std::string_view, 2> kBandColumns{"band_mm", "band_n"};

void check_header(const device::CsvTable& table, const std::string& name) {
  for (const std::string& column : table.columns) {
    const auto is_added = [&](std::string_view added) { return column == added; };
    if (std::any_of(kColumns.begin(), kColumns.end(), is_added) ||
        std::any_of(kBandColumns.begin(), kBandColumns.end(), is_added)) {
      throw_invalid(name + ", line 1: column " + column +
                    " is one that probe adds; rename or remove it");
    }
  }
}

}  // namespace

void probe(const field::FieldQuery& field, const ProbeOptions& options, std::istream& points,
           const std::string& name, std::ostream& out) {
  const device::CsvTable table = device::read_csv(points, name, {"x_mm", "y_mm", "z_mm", "t_s"});
  check_header(table, name);
  const Affine lps_from_workspace = options.workspace_from_lps.inverse(Eigen::Isometry);
  std::string text = table.header;
  for (std::string_view column : kColumns) text.append(",").append(column);
  if (options.band) {
    for (std::string_view column : kBandColumns) text.append(",").append(column);
  }
  text += '\n';
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    const std::vector<double>& row = table.rows[r];
    Vec3 x(row[0], row[1], row[2]);
    if (options.lps) x = options.workspace_from_lps * x;
    const field::FieldSample sample = field.sample(x, row[3]);
    Vec3 n = field.normal(sample, x);
    const double share_of_cycle = row[3] / field.rr_interval_s();
    const double band_mm = options.band ? options.band->half_width_mm(x, n, share_of_cycle) : 0;
    if (options.lps) n = lps_from_workspace.linear() * n;
    const Vec3 force = haptics::contact_force_n(options.stiffness_n_per_m, sample.distance_mm, n);
    text += table.lines[r];
    for (double value :
         {sample.distance_mm, n[0], n[1], n[2], field::FieldQuery::normal_velocity_mm_s(sample),
          force[0], force[1], force[2]}) {
      text += ',';
      append_number(text, value);
    }
    if (options.band) {
      for (double value : {band_mm, options.stiffness_n_per_m * 1e-3 * band_mm}) {
        text += ',';
        append_number(text, value);
      }
    }
    text += '\n';
  }
  out << text;
}

}  // namespace beatlas::app
