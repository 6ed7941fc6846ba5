#include "runtime/app/atlas_press.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "runtime/app/headless.h"
#include "runtime/app/text.h"
#include "runtime/base/error.h"
#include "runtime/field/surface_point.h"
#include "runtime/palpation/over_wall.h"
#include "runtime/palpation/patch_model.h"
#include "runtime/plot/plot.h"

namespace beatlas::app {
namespace {

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

/// Over the middle of a segment's wall.
std::optional<Vec3> over_segment(const palpation::LvWall& wall, int segment,
                                 const field::FieldQuery& heart, double end_diastole_s) {
  return palpation::over_wall(wall, wall.middle_of(segment), heart, end_diastole_s);
}

/// One finger on one muscle of an atlas.
struct Feeler {
  std::shared_ptr<const field::FieldQuery> heart;
  double end_diastole_s;
  double end_systole_s;
  double speed;
  Vec3 place_mm;
  Vec3 outward;

  /// @param depth_mm [moment] of the finger along `outward`, below the place
  template <class Depth>
  [[nodiscard]] FeltBeat feel(const palpation::PatchModelOptions& muscle, Depth depth_mm) const {
    constexpr int kBeats = 8;  // the patch forgets the first touch
    palpation::PatchModel patch(std::make_shared<const haptics::AtlasField>(heart), muscle);
    const auto ticks = static_cast<std::size_t>(heart->rr_interval_s() / speed / kTickS);
    const double systole_s =
        (end_systole_s - end_diastole_s) / speed +
        (end_systole_s < end_diastole_s ? heart->rr_interval_s() / speed : 0.0);
    FeltBeat out;
    for (std::size_t n = 0; n < kBeats * ticks; ++n) {
      const double t = kTickS * static_cast<double>(n % ticks);
      const haptics::Moment moment{.elapsed_s = n == 0 ? 0 : kTickS,
                                   .field_time_s = end_diastole_s + speed * t,
                                   .speed = speed};
      const Vec3 at = place_mm - depth_mm(moment.field_time_s) * outward;
      const double force_n =
          patch.evaluate({.time_s = kTickS * static_cast<double>(n), .position_mm = at}, moment)
              .force_n.norm();
      if (n < (kBeats - 1) * ticks) continue;
      out.time_s.push_back(t);
      out.force_n.push_back(force_n);
    }
    out.diastole_n = out.force_n.back();
    out.systole_n = out.force_n[std::min(ticks - 1, static_cast<std::size_t>(systole_s / kTickS))];
    return out;
  }

  /// Where the surface lies along `outward`, above the place.
  [[nodiscard]] double surface_above_mm(double t) const {
    double above = 0;  // the distance is the way to go where the line stands upright on the surface
    for (int n = 0; n < 20; ++n) {
      const double distance = heart->sample(place_mm + above * outward, t).distance_mm;
      above -= distance;
      if (std::abs(distance) < 1e-4) break;
    }
    return above;
  }

  [[nodiscard]] TissueForce feel_both(const std::string& name,
                                      const palpation::PatchModelOptions& muscle,
                                      double depth_mm) const {
    return {name, feel(muscle, [&](double) { return depth_mm; }),
            feel(muscle, [&](double t) { return 0.5 * depth_mm - surface_above_mm(t); })};
  }
};

}  // namespace

int reachable_segment(const atlas::Atlas& package, const palpation::LvWall& wall) {
  // The free wall from its anterior end, each level of the ventricle in turn; the septum last.
  constexpr std::array kOrder{7, 12, 11, 10, 1, 6, 5, 4, 13, 16, 15, 8, 9, 2, 3, 14, 17};
  const atlas::Manifest& manifest = package.manifest();
  const auto heart = query_of(package, Structure::Heart);
  const double end_diastole_s = manifest.rr_interval_s * manifest.end_diastole / heart->phases();
  for (const int segment : kOrder) {
    if (over_segment(wall, segment, *heart, end_diastole_s)) return segment;
  }
  throw_invalid(
      "a finger can reach no segment of the left ventricle from outside: other heart lies over "
      "all");
}

AtlasPress press_on_atlas(const atlas::Atlas& package,
                          const palpation::PalpationParameters& parameters,
                          const PressScript& script,
                          const std::optional<AtlasVentricle>& ventricle) {
  const atlas::Manifest& manifest = package.manifest();
  const auto heart = query_of(package, Structure::Heart);
  const double end_diastole_s = manifest.rr_interval_s * manifest.end_diastole / heart->phases();
  AtlasPress out;
  palpation::PatchModelOptions muscle{.parameters = parameters,
                                      .long_axis = script.long_axis,
                                      .segment = script.segment,
                                      .end_diastole_s = end_diastole_s};
  if (ventricle) {
    const palpation::LvWall& wall = *ventricle->wall;
    const std::optional<Vec3> over = over_segment(wall, script.segment, *heart, end_diastole_s);
    if (!over) {
      throw_invalid("a finger cannot reach the segment " +
                    std::string(palpation::segment_name(script.segment)) +
                    " from outside: other heart lies over its wall; press another segment");
    }
    out.place_mm = *over;
    const palpation::WallPlace place =
        wall.nearest(out.place_mm, end_diastole_s / manifest.rr_interval_s);
    out.wall = PressedWall{place, ventricle->tissue.at(place)};
    muscle.long_axis = place.long_axis;
    muscle.segment = place.segment;
    muscle.tissue = out.wall->tissue;
  } else {
    out.place_mm =
        field::surface_point_mm(*heart, towards_free_wall(package, *heart), end_diastole_s);
  }
  out.outward = heart->normal(heart->sample(out.place_mm, end_diastole_s), out.place_mm);
  palpation::PatchModel patch(std::make_shared<const haptics::AtlasField>(heart), muscle);
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
  if (!out.wall) return out;
  const Feeler feeler{
      .heart = heart,
      .end_diastole_s = end_diastole_s,
      .end_systole_s = manifest.rr_interval_s * manifest.end_systole / heart->phases(),
      .speed = speed,
      .place_mm = out.place_mm,
      .outward = out.outward};
  const auto add = [&](const char* name, const palpation::Tissue& tissue) {
    muscle.tissue = tissue;
    out.tissues.push_back(feeler.feel_both(name, muscle, script.depth_mm));
  };
  add("healthy", {});
  add("infarct", palpation::infarct_tissue());
  add("as it is", out.wall->tissue);
  compare_with_first(out.tissues);
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
  nlohmann::json out = {{"place_mm", numbers(press.place_mm)},
                        {"outward", numbers(press.outward)},
                        {"deepest_mm", press.deepest_mm},
                        {"largest_force_n", press.largest_force_n}};
  if (press.wall) {
    const palpation::WallPlace& place = press.wall->place;
    const palpation::Tissue& tissue = press.wall->tissue;
    out["wall"] = {{"segment", palpation::segment_name(place.segment)},
                   {"long_axis", place.long_axis},
                   {"thickness_mm", place.wall_mm},
                   {"scar", tissue.scar},
                   {"thickness_ratio", tissue.thickness_ratio},
                   {"alpha", tissue.alpha},
                   {"stiffness_ratio", tissue.stiffness_ratio}};
    out["tissues"] = tissues_json(press.tissues);
  }
  return out;
}

std::string atlas_press_text(const AtlasPress& press) {
  std::ostringstream text;
  text.precision(3);
  text << "on the atlas's own left ventricle: at most " << press.deepest_mm
       << " mm below its moving surface, largest force " << press.largest_force_n << " N\n";
  if (!press.wall) return text.str();
  const palpation::WallPlace& place = press.wall->place;
  text << "it presses " << palpation::segment_name(place.segment) << ", a wall of " << place.wall_mm
       << " mm, scar " << press.wall->tissue.scar << ", thickness "
       << press.wall->tissue.thickness_ratio << " of healthy, contraction "
       << press.wall->tissue.alpha << "\n";
  for (const TissueForce& tissue : press.tissues) {
    text << "there " << tissue.name << ": " << tissue.in_space.diastole_n << " N at end-diastole ("
         << tissue.in_space.diastole_jnd << " JND from healthy); with the wall "
         << tissue.with_wall.diastole_n << " to " << tissue.with_wall.systole_n << " N ("
         << tissue.with_wall.diastole_jnd << ", " << tissue.with_wall.systole_jnd << " JND)\n";
  }
  return text.str();
}

}  // namespace beatlas::app
