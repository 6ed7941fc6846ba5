#include "runtime/app/atlas_press.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "runtime/app/headless.h"
#include "runtime/app/text.h"
#include "runtime/field/surface_point.h"
#include "runtime/palpation/patch_model.h"
#include "runtime/plot/plot.h"

namespace beatlas::app {
namespace {

constexpr double kTickS = 1e-3;
constexpr double kApartMm = 3;  // centres nearer to each other tell no direction

std::shared_ptr<const field::FieldQuery> query_of(const atlas::Atlas& package,
                                                  Structure structure) {
  return std::make_shared<const field::FieldQuery>(package.field(structure),
                                                   package.manifest().rr_interval_s);
}

// From the heart's middle through that of the LV's blood: the wall that faces away from the septum.
Vec3 towards_free_wall(const atlas::Atlas& package, const field::FieldQuery& heart) {
  Vec3 left = package.manifest().workspace_from_lps.linear() * Vec3::UnitX();
  if (!package.field(Structure::LvBlood)) return left;
  const Vec3 across = query_of(package, Structure::LvBlood)->centre_mm() - heart.centre_mm();
  return across.norm() < kApartMm ? left : Vec3(across.normalized());
}

}  // namespace

atlas::Needs needs_of_press(const atlas::Manifest& manifest) {
  atlas::Needs needs{.fields = {Structure::Heart}, .surfaces = {}};
  if (atlas::everything_in(manifest).fields.count(Structure::LvBlood) > 0) {
    needs.fields.insert(Structure::LvBlood);
  }
  return needs;
}

AtlasPress press_on_atlas(const atlas::Atlas& package,
                          const palpation::PalpationParameters& parameters,
                          const PressScript& script) {
  const atlas::Manifest& manifest = package.manifest();
  const auto heart = query_of(package, Structure::Heart);
  const double end_diastole_s = manifest.rr_interval_s * manifest.end_diastole / heart->phases();
  AtlasPress out;
  out.place_mm =
      field::surface_point_mm(*heart, towards_free_wall(package, *heart), end_diastole_s);
  out.outward = heart->normal(heart->sample(out.place_mm, end_diastole_s), out.place_mm);
  palpation::PatchModel patch(std::make_shared<const haptics::AtlasField>(heart),
                              {.parameters = parameters,
                               .long_axis = script.long_axis,
                               .segment = script.segment,
                               .end_diastole_s = end_diastole_s});
  // The heart begins at end-diastole and beats as often as the circulation does.
  const double speed = parameters.circulation.heart_rate_per_min / 60 * manifest.rr_interval_s;
  const double end_s = script.natural_s + 2 * script.moving_s + script.held_s + script.after_s;
  const auto ticks = static_cast<std::size_t>(std::lround(end_s / kTickS));
  out.rows.reserve(ticks);
  for (std::size_t n = 0; n < ticks; ++n) {
    const double t = kTickS * static_cast<double>(n);
    const double displacement_mm = finger_displacement_mm(script, t);
    const haptics::Contact contact =
        patch.evaluate({.time_s = t, .position_mm = out.place_mm - displacement_mm * out.outward},
                       {.elapsed_s = n == 0 ? 0 : kTickS,
                        .field_time_s = end_diastole_s + speed * t,
                        .speed = speed});
    const double force_n = contact.force_n.norm();
    out.rows.push_back({t, displacement_mm, -contact.distance_mm, force_n});
    out.deepest_mm = std::max(out.deepest_mm, contact.depth_mm);
    out.largest_force_n = std::max(out.largest_force_n, force_n);
  }
  return out;
}

void write_atlas_press(const AtlasPress& press, const std::filesystem::path& folder) {
  std::string csv = "t_s,displacement_mm,depth_mm,force_n\n";
  plot::PlotSeries finger{.name = "finger", .x = {}, .y = {}};
  plot::PlotSeries depth{.name = "below moving surface", .x = {}, .y = {}};
  plot::PlotSeries force{.name = "", .x = {}, .y = {}};
  for (const AtlasPressRow& row : press.rows) {
    bool first = true;
    for (const double number : {row.time_s, row.displacement_mm, row.depth_mm, row.force_n}) {
      if (!first) csv += ',';
      append_number(csv, number);
      first = false;
    }
    csv += '\n';
    for (plot::PlotSeries* series : {&finger, &depth, &force}) series->x.push_back(row.time_s);
    finger.y.push_back(row.displacement_mm);
    depth.y.push_back(row.depth_mm);
    force.y.push_back(row.force_n);
  }
  write_file(folder / "atlas_press.csv", csv);
  write_file(folder / "atlas_press.svg",
             plot::plots_svg({{.title = "A finger on the atlas's own left ventricle",
                               .x_title = "time [s]",
                               .y_title = "displacement [mm]",
                               .series = {finger, depth}},
                              {.title = "Force on the finger",
                               .x_title = "time [s]",
                               .y_title = "force [N]",
                               .series = {force},
                               .from_zero = true}}));
}

nlohmann::json atlas_press_json(const AtlasPress& press) {
  const auto numbers = [](const Vec3& v) { return nlohmann::json{v.x(), v.y(), v.z()}; };
  return {{"place_mm", numbers(press.place_mm)},
          {"outward", numbers(press.outward)},
          {"deepest_mm", press.deepest_mm},
          {"largest_force_n", press.largest_force_n}};
}

std::string atlas_press_text(const AtlasPress& press) {
  std::ostringstream text;
  text.precision(3);
  text << "on the atlas's own left ventricle: at most " << press.deepest_mm
       << " mm below its moving surface, largest force " << press.largest_force_n << " N\n";
  return text.str();
}

}  // namespace beatlas::app
