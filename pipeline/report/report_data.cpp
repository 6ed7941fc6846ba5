#include "pipeline/report/report_data.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "pipeline/core/segmented_volume.h"
#include "pipeline/core/words.h"
#include "pipeline/report/base64.h"
#include "pipeline/report/coarse_surface.h"
#include "pipeline/report/normal_ranges.h"
#include "pipeline/report/prediction_intervals.h"
#include "runtime/atlas/structure_colours.h"

namespace beatlas::report {
using nlohmann::json;
namespace {

constexpr int kVersion = 1;
constexpr double kMostFileBytes = 14e6;    ///< of the page, so that it stays below 15 MB
constexpr double kProgramBytes = 1.05e6;   ///< of it are page and library
constexpr double kMostImageBytes = 5.4e6;  ///< before they are written as text
constexpr std::size_t kMostVertices = 12000;
constexpr double kMostVertexBytes = 1.8e6;

/// To `parts` of one: a tenth is 10.
double rounded(double value, double parts) { return std::round(value * parts) / parts; }

json vector_to_json(const Vec3& x) {
  return {rounded(x[0], 1e3), rounded(x[1], 1e3), rounded(x[2], 1e3)};
}

std::vector<VolumeCurve> segmented_volumes(const Segmentation& segmentation) {
  std::vector<VolumeCurve> out;
  for (const Structure structure : kAllStructures) {
    std::vector<double> volume_ml = segmented_volume_ml(segmentation, structure);
    if (!volume_ml.empty()) out.push_back({structure, std::move(volume_ml)});
  }
  return out;
}

std::vector<VolumeCurve> volumes_of(const ReportInput& input) {
  return input.is_study ? segmented_volumes(*input.segmentation) : input.volumes;
}

std::vector<Place> places_of(const ReportInput& input) {
  if (input.segmentation == nullptr || !input.is_study) return {};
  std::vector<Place> places = leak_places(*input.segmentation);
  const std::vector<Place> uncertain =
      uncertain_places(input.uncertainty, input.segmentation->coverage.grid, places);
  places.insert(places.end(), uncertain.begin(), uncertain.end());
  return places;
}

/// Whether the phase's labels stay as somebody drew them, whatever is seeded.
bool drawn(const ReportInput& input, int phase) {
  return input.given_phases.count(phase) != 0 ||
         std::any_of(input.stages.begin(), input.stages.end(), [](const ReportStage& stage) {
           return stage.name == "segment" && !stage.edited.empty();
         });
}

std::vector<int> drawn_phases(const ReportInput& input) {
  std::vector<int> out;
  for (int phase = 0; phase < input.exam->stack.phase_count(); ++phase) {
    if (drawn(input, phase)) out.push_back(phase);
  }
  return out;
}

/// Whether it is of a study whose labels grew as those did that intervals and bands were fitted to.
bool is_fitted(const ReportInput& input) {
  return input.is_study &&
         std::any_of(input.stages.begin(), input.stages.end(), [](const ReportStage& stage) {
           return stage.name == "segment" && is_fitted_to(stage.options);
         });
}

json known_to_json(const std::vector<KnownSurface>& known) {
  json out = json::object();
  for (const KnownSurface& surface : known) {
    out[std::string(structure_name(surface.structure))] = {
        {"in_slices_mm", rounded(surface.in_slices_mm, 10)},
        {"worst_slice", surface.worst_slice},
        {"worst_slice_mm", rounded(surface.worst_slice_mm, 10)},
        {"at_base_mm", rounded(surface.at_base_mm, 10)},
        {"at_apex_mm", rounded(surface.at_apex_mm, 10)}};
  }
  return out;
}

void ask_of_stages(const ReportInput& input, VerdictInput& asked) {
  for (const ReportStage& stage : input.stages) {
    const bool runs_again = stage.state == "stale" || stage.state == "waits";
    if (runs_again && input.refused.empty()) asked.stale.push_back(stage.name);
    if (stage.name == "import" || stage.name == "pack") continue;
    for (const std::string& warning : stage.warnings) {
      if (stage.name == "segment") {
        asked.warnings.push_back(warning);
      } else {
        asked.remarks.push_back(stage.name + ": " + warning);
      }
    }
  }
}

void ask_of_segmentation(const ReportInput& input, const std::vector<Place>& places,
                         const VerdictLimits& limits, VerdictInput& asked) {
  if (input.segmentation == nullptr) return;
  asked.segmented = true;
  const std::vector<VolumeCurve> volumes = volumes_of(input);
  asked.segmentation = heart_figures(volumes);
  asked.missing = missing_structures(volumes, input.needed);
  if (!asked.missing.empty() && input.is_study) {
    const int phase = input.segmentation->end_diastole;
    WaysToFind ways =
        ways_to_find(asked.missing, phase, drawn(input, phase), input.has_made_package);
    asked.how_to_find = std::move(ways.how);
    asked.finding_commands = std::move(ways.commands);
  }
  const std::vector<std::string>& own = input.segmentation->warnings;
  asked.warnings.insert(asked.warnings.begin(), own.begin(), own.end());
  const std::vector<LeakAlarm>& alarms = input.segmentation->alarms;
  for (std::size_t n = 0; n < alarms.size() && n < places.size(); ++n) {  // leaks come first
    if (is_borne_out(alarms[n], *input.segmentation, limits.expected)) {
      asked.leaks.push_back(places[n]);
    } else {
      ++asked.other_leaks;
    }
  }
  if (input.is_study) asked.doubts = doubts_of(*input.segmentation, asked.segmentation);
  for (const auto& [structure, phases] : input.uncertainty) {
    const double share = uncertain_percent(input.uncertainty, structure, limits.uncertain_mm);
    if (asked.uncertain_percent && share <= *asked.uncertain_percent) continue;
    asked.uncertain_percent = share;
    asked.uncertain_structure = structure_words(structure);
  }
}

std::vector<Finding> findings_of(const ReportInput& input, const std::vector<Place>& places) {
  VerdictInput asked;
  const VerdictLimits limits;
  asked.refused = input.refused;
  asked.of_study = input.is_study;
  ask_of_stages(input, asked);
  ask_of_segmentation(input, places, limits, asked);
  if (input.package) {
    if (input.is_study) {
      asked.package = ventricles_at(asked.segmentation, input.package->enclosed);
    }
    asked.worst_gap_percent = input.package->worst_gap_percent;
    asked.worst_gap_sign = input.package->worst_gap_sign;
    asked.worst_gap_of = input.package->worst_gap_of;
    asked.checks = input.package->checks;
    asked.failed_checks = input.package->failed_checks;
  }
  asked.surfaces = input.surface_figures;
  asked.slice_shifts_mm = input.exam->slice_shifts_mm;
  asked.slice_lags = input.exam->slice_lags;
  asked.phases = input.exam->stack.phase_count();
  asked.rr_interval_s = input.exam->stack.rr_interval_s;
  return findings(asked, limits);
}

json figures_to_json(const HeartFigures& figures, double rr_interval_s) {
  json out = json::object();
  const auto put = [&](const char* key, std::optional<double> value, double parts) {
    out[key] = value ? json(rounded(*value, parts)) : json();
  };
  for (const char* key : {"lv_ef_percent", "lv_edv_ml", "lv_esv_ml", "lv_sv_ml", "rv_ef_percent",
                          "rv_edv_ml", "rv_esv_ml", "rv_sv_ml", "lv_mass_g"}) {
    put(key, figure_of(figures, key), 1000);
  }
  put("heart_rate_per_min", rr_interval_s > 0 ? std::optional(60 / rr_interval_s) : std::nullopt,
      10);
  std::optional<double> output;
  if (figures.lv && rr_interval_s > 0) output = figures.lv->stroke_ml() * 0.06 / rr_interval_s;
  put("cardiac_output_l_per_min", output, 100);
  return out;
}

json curves_to_json(const std::vector<VolumeCurve>& curves) {
  json out = json::object();
  for (const VolumeCurve& curve : curves) {
    json& values = out[std::string(structure_name(curve.structure))] = json::array();
    for (const double value : curve.volume_ml) values.push_back(rounded(value, 100));
  }
  return out;
}

json findings_to_json(const std::vector<Finding>& findings) {
  json out = json::array();
  for (const Finding& finding : findings) {
    out.push_back({{"id", finding.id},
                   {"title", finding.title},
                   {"trouble", finding.trouble},
                   {"level", level_name(finding.level)},
                   {"said", finding.said},
                   {"limit", finding.limit},
                   {"why", finding.why},
                   {"how", finding.how},
                   {"commands", finding.commands}});
  }
  return out;
}

json places_to_json(const ReportInput& input, const std::vector<Place>& places) {
  json out = json::array();
  const Affine index_from_lps = input.exam->stack.grid().mm_from_index.inverse();
  for (const Place& place : places) {
    const Vec3 at = index_from_lps * place.lps_mm;
    json entry{{"kind", place.kind == Place::Kind::Leak ? "leak" : "uncertain"},
               {"structure", structure_name(place.structure)},
               {"phase", place.phase},
               {"slice", static_cast<int>(std::lround(at[2]))},
               {"index", {rounded(at[0], 100), rounded(at[1], 100)}},
               {"lps_mm", vector_to_json(place.lps_mm)},
               {"title", place.title},
               {"sentence", place.sentence},
               {"commands",
                correcting_commands(place, drawn(input, place.phase), input.has_made_package)}};
    if (input.workspace_from_lps) {
      entry["workspace_mm"] = vector_to_json(*input.workspace_from_lps * place.lps_mm);
    }
    out.push_back(std::move(entry));
  }
  return out;
}

/// All surfaces share the vertices that the budget allows, by their own numbers of them.
json surfaces_to_json(const ReportInput& input) {
  json out = json::array();
  if (input.surfaces.empty()) return out;
  std::size_t all = 0;
  for (const SurfaceCycle& surface : input.surfaces) all += surface.positions.front().size();
  const auto phases = static_cast<double>(input.surfaces.front().positions.size());
  const std::size_t budget =
      std::min(kMostVertices, static_cast<std::size_t>(kMostVertexBytes / (6 * phases)));
  const double share = std::min(1.0, double(budget) / double(all));
  const int phase = input.segmentation != nullptr ? input.segmentation->end_diastole : 0;
  for (const SurfaceCycle& surface : input.surfaces) {
    const auto wanted =
        static_cast<std::size_t>(std::floor(share * double(surface.positions.front().size())));
    const CoarseSurface coarse = coarse_surface(surface, std::max<std::size_t>(wanted, 50), phase);
    Vec3f low = coarse.positions.front().front();
    Vec3f high = low;
    for (const auto& positions : coarse.positions) {
      for (const Vec3f& x : positions) {
        low = low.cwiseMin(x);
        high = high.cwiseMax(x);
      }
    }
    const double step = std::max(1e-6, double((high - low).maxCoeff()) / 65535);
    std::vector<std::uint8_t> places;
    for (const auto& positions : coarse.positions) {
      for (const Vec3f& x : positions) {
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
          put16(places, static_cast<std::int32_t>(std::lround(double(x[axis] - low[axis]) / step)));
        }
      }
    }
    std::vector<std::uint8_t> corners;
    for (const auto& triangle : coarse.triangles) {
      for (const std::uint32_t corner : triangle) put16(corners, static_cast<std::int32_t>(corner));
    }
    out.push_back({{"structure", structure_name(surface.structure)},
                   {"vertices", coarse.positions.front().size()},
                   {"all_vertices", surface.positions.front().size()},
                   {"triangles", base64(corners)},
                   {"origin_mm", vector_to_json(low.cast<double>())},
                   {"step_mm", step},
                   {"positions", base64(places)}});
  }
  return out;
}

/// @param bytes that are left for images
json slices_to_json(const ReportInput& input, const std::vector<Place>& places, double bytes) {
  const Cine& cine = input.exam->stack;
  // A package may hold neither images nor distances to draw outlines of.
  if (cine.images.phases.front().empty()) {
    return {{"spacing_mm", vector_to_json(cine.grid().spacing_mm())},
            {"structures", json::array()},
            {"list", json::array()}};
  }
  std::vector<Vec3> lps;
  lps.reserve(places.size());
  for (const Place& place : places) lps.push_back(place.lps_mm);
  SheetOptions options;
  const SliceSheets rough = slice_sheets(cine, input.segmentation, lps, {options.margin_mm, 0, 0});
  std::vector<Structure> structures;
  std::vector<std::string> packed(static_cast<std::size_t>(cine.grid().size[2]));
  if (input.segmentation != nullptr) {
    for (const Structure structure : kAllStructures) {
      if (input.segmentation->coverage.phases.count(structure) != 0) {
        structures.push_back(structure);
      }
    }
    for (std::size_t k = 0; k < packed.size(); ++k) {
      packed[k] = base64(packed_outlines(*input.segmentation, structures, static_cast<int>(k),
                                         rough, options.outline_tolerance_mm));
      bytes -= static_cast<double>(packed[k].size());
    }
  }
  options.max_bytes = static_cast<std::size_t>(std::clamp(bytes * 0.75, 0.0, kMostImageBytes));
  const SliceSheets sheets = slice_sheets(cine, input.segmentation, lps, options);
  const Vec3 spacing = cine.grid().spacing_mm();
  json list = json::array();
  for (std::size_t k = 0; k < packed.size(); ++k) {
    json slice{{"image", "data:image/jpeg;base64," + base64(sheets.jpeg[k])},
               {"outlines", packed[k]}};
    if (!input.exam->slice_shifts_mm.empty()) {
      const Vec2& shift = input.exam->slice_shifts_mm[k];
      slice["shift_mm"] = {rounded(shift[0], 100), rounded(shift[1], 100)};
    }
    list.push_back(std::move(slice));
  }
  json names = json::array();
  for (const Structure structure : structures) names.push_back(structure_name(structure));
  return {{"first", {sheets.first_i, sheets.first_j}},
          {"size", {sheets.width, sheets.height}},
          {"spacing_mm", vector_to_json(spacing)},
          {"scale", sheets.scale},
          {"tile", {sheets.tile_width, sheets.tile_height}},
          {"columns", sheets.columns},
          {"jpeg_quality", sheets.quality},
          {"structures", names},
          {"list", list}};
}

json package_to_json(const ReportPackage& package) {
  json items = json::array();
  for (const ReportItem& item : package.items) {
    items.push_back({{"what", item.what},
                     {"bytes", item.bytes},
                     {"sha256", item.sha256},
                     {"error", item.error}});
  }
  return {{"scene", package.scene},
          {"sha256", package.sha256},
          {"bytes", package.bytes},
          {"items", items}};
}

json stages_to_json(const std::vector<ReportStage>& stages) {
  json out = json::array();
  for (const ReportStage& stage : stages) {
    json entry{{"name", stage.name},     {"version", stage.version},
               {"state", stage.state},   {"options", stage.options},
               {"edited", stage.edited}, {"warnings", stage.warnings}};
    if (stage.wall_s) entry["wall_s"] = rounded(*stage.wall_s, 10);
    out.push_back(std::move(entry));
  }
  return out;
}

/// As the segmentation was told; labels of elsewhere are taken to count them as blood, as most do.
Papillary papillary_of(const std::vector<ReportStage>& stages) {
  for (const ReportStage& stage : stages) {
    const auto told = stage.options.find("papillary");
    if (stage.name == "segment" && told != stage.options.end() && *told == "muscle") {
      return Papillary::Muscle;
    }
  }
  return Papillary::Blood;
}

}  // namespace

json report_summary(const ReportInput& input) {
  const std::vector<Place> places = places_of(input);
  const std::vector<Finding> found = findings_of(input, places);
  const Level level = verdict(found);
  json reasons = json::array();
  for (const Finding& finding : found) {
    if (finding.level == Level::Good) continue;
    reasons.push_back({{"id", finding.id},
                       {"level", level_name(finding.level)},
                       {"sentence", finding.trouble + ": " + finding.said}});
    if (!finding.how.empty()) reasons.back()["how"] = finding.how;
    if (!finding.commands.empty()) reasons.back()["commands"] = finding.commands;
  }
  json alarms = json::array();
  for (const Place& place : places) {
    alarms.push_back({{"kind", place.kind == Place::Kind::Leak ? "leak" : "uncertain"},
                      {"structure", structure_name(place.structure)},
                      {"phase", place.phase},
                      {"lps_mm", vector_to_json(place.lps_mm)},
                      {"sentence", place.sentence},
                      {"commands", correcting_commands(place, drawn(input, place.phase),
                                                       input.has_made_package)}});
    if (place.kind != Place::Kind::Leak) continue;
    alarms.back()["alarm"] = place.alarm;
    alarms.back()["figure"] = rounded(place.figure, 10);
    alarms.back()["limit"] = rounded(place.limit, 10);
  }
  json out{{"version", kVersion},
           {"program", input.program},
           {"verdict", level_name(level)},
           {"reasons", reasons},
           {"figures", figures_to_json({}, input.exam->stack.rr_interval_s)},
           {"intervals_90", json::object()},
           {"surfaces_90", json::object()},
           {"volumes_ml", json::object()},
           {"rr_interval_s", input.exam->stack.rr_interval_s},
           {"phases", input.exam->stack.phase_count()},
           {"end_diastole", nullptr},
           {"end_systole", nullptr},
           {"places", alarms},
           {"slice_shifts_mm", json::array()},
           {"package", nullptr},
           {"input_sha256", input.input_sha256},
           {"made_from", input.made_from},
           {"self_test", input.self_test},
           {"before", input.before}};
  if (input.segmentation != nullptr) {
    const std::vector<VolumeCurve> volumes = volumes_of(input);
    const HeartFigures figures = heart_figures(volumes);
    out["figures"] = figures_to_json(figures, input.exam->stack.rr_interval_s);
    if (is_fitted(input)) {
      for (const auto& [key, interval] : prediction_intervals(*input.segmentation, figures)) {
        out["intervals_90"][key] = {rounded(interval.low, 10), rounded(interval.high, 10)};
      }
      out["surfaces_90"] = known_to_json(input.known);
    }
    out["volumes_ml"] = curves_to_json(volumes);
    out["end_diastole"] = input.segmentation->end_diastole;
    out["end_systole"] = input.segmentation->end_systole;
  }
  for (const Vec2& shift : input.exam->slice_shifts_mm) {
    out["slice_shifts_mm"].push_back({rounded(shift[0], 100), rounded(shift[1], 100)});
  }
  if (input.package) {
    out["package"] = {{"scene", input.package->scene},
                      {"bytes", input.package->bytes},
                      {"sha256", input.package->sha256}};
  }
  return out;
}

json report_json(const ReportInput& input) {
  const std::vector<Place> places = places_of(input);
  json out{{"summary", report_summary(input)},
           {"findings", findings_to_json(findings_of(input, places))},
           {"places", places_to_json(input, places)},
           {"normal", normal_to_json(papillary_of(input.stages))},
           {"decisions", input.exam->decisions},
           {"source_format", input.exam->source_format},
           {"source_size", input.exam->stack.grid().size},
           {"frame_times_s", input.exam->stack.frame_times_s},
           {"views", input.exam->views.size()},
           {"stages", stages_to_json(input.stages)},
           {"drawn_seeds", input.drawn_seeds},
           {"is_study", input.is_study},
           {"has_images", input.has_images},
           {"drawn_phases", drawn_phases(input)},
           {"surfaces", surfaces_to_json(input)}};
  for (const Structure structure : kAllStructures) {
    const std::string name(structure_name(structure));
    out["colours"][name] = colour_code(structure_colour(structure));
    out["inks"][name] = colour_code(structure_ink(structure));
  }
  if (input.package) {
    out["package"] = package_to_json(*input.package);
  }
  if (input.workspace_from_lps) {
    const auto direction = [&](const Vec3& lps) {
      return vector_to_json(input.workspace_from_lps->linear() * lps);
    };
    json axes{{"left", direction(Vec3::UnitX())},
              {"posterior", direction(Vec3::UnitY())},
              {"superior", direction(Vec3::UnitZ())},
              {"slice_normal",
               direction(input.exam->stack.grid().mm_from_index.linear().col(2).normalized())}};
    if (input.segmentation != nullptr && input.segmentation->axis) {
      axes["towards_base"] = direction(input.segmentation->axis->towards_base);
    }
    out["axes"] = axes;
  }
  double used = kProgramBytes;
  for (const json& surface : out["surfaces"]) {
    used += static_cast<double>(surface["positions"].get_ref<const std::string&>().size() +
                                surface["triangles"].get_ref<const std::string&>().size());
  }
  out["slices"] = slices_to_json(input, places, kMostFileBytes - used);
  return out;
}

}  // namespace beatlas::report
