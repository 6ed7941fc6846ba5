#include "pipeline/assess/structural_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string_view>
#include <utility>

#include "pipeline/assess/field_checks.h"
#include "pipeline/assess/surface_checks.h"
#include "pipeline/core/parallel.h"
#include "pipeline/core/possible_heart.h"
#include "runtime/atlas/scene.h"

namespace beatlas::assess {
namespace {

constexpr std::string_view kCrosses = "crosses_";
constexpr std::string_view kLevel = "_level_";

/// What a check measures, for people.
std::string words_of(const std::string& name) {
  const std::size_t level = name.find(kLevel);
  if (level != std::string::npos) {
    return "level of detail " + name.substr(level + kLevel.size()) + ", " +
           words_of(name.substr(0, level));
  }
  if (name.starts_with(kCrosses)) {
    return "triangles of its surface that cut those of " + name.substr(kCrosses.size()) + " [%]";
  }
  static constexpr std::array<std::pair<const char*, const char*>, 15> kWords{
      {{"content", "payloads that its scene does not name, or that it lacks"},
       {"end_phases", "end-diastole or end-systole is no extreme of the LV's volume"},
       {"missing_phases", "its scene needs it, and it is missing in phases"},
       {"impossible_ef_points", "no living heart ejects like this, by points of the EF"},
       {"open_edges", "its surface is open at edges"},
       {"pinched_vertices", "its surface is pinched at vertices"},
       {"crossing_percent", "triangles of its surface that cut others [%]"},
       {"surface_volume_gap_percent",
        "its surface holds another volume than it should, of its largest [%]"},
       {"wrap_step_ratio", "its surface jumps from the last phase to the first, of other steps"},
       {"field_volume_gap_percent",
        "its distances hold another volume than they should, of its largest [%]"},
       {"stray_percent", "islands beside it and holes in it, of its volume [%]"},
       {"slope_error", "its distances rise by more or less than 1 mm a mm"},
       {"surface_error_mm", "its surface lies off its distances in the mean [mm]"},
       {"vertex_distance_mm", "its surface lies off its distances [mm]"},
       {"wrong_side_percent", "inside and outside are exchanged at vertices of its surface [%]"}}};
  for (const auto& [known, words] : kWords) {
    if (name == known) return words;
  }
  return "";
}

constexpr double kSameMl = 0.01;  // of volumes that count as equal

/// Largest difference over the largest expected value [%]; 100 if nothing is expected.
double gap_percent(const std::vector<double>& expected, const std::vector<double>& found) {
  if (expected.size() != found.size() || expected.empty()) return HUGE_VAL;
  double gap = 0;
  for (std::size_t p = 0; p < expected.size(); ++p) {
    gap = std::max(gap, std::abs(found[p] - expected[p]));
  }
  const double scale = *std::max_element(expected.begin(), expected.end());
  return scale > 0 ? 100 * gap / scale : 100;
}

std::vector<Check> check_surface(const atlas::StructureEntry& entry,
                                 const atlas::SurfacePayload& surface,
                                 const StructuralLimits& limits) {
  const std::size_t phases = surface.positions.size();
  std::vector<double> enclosed(phases);
  std::vector<double> crossing(phases);
  parallel_for(phases, [&](std::size_t p) {
    enclosed[p] = enclosed_volume_ml(surface.triangles, surface.positions[p]);
    crossing[p] = static_cast<double>(crossing_triangles(surface.triangles, surface.positions[p]));
  });
  const double most = crossing.empty() ? 0 : *std::max_element(crossing.begin(), crossing.end());
  const auto triangles = static_cast<double>(std::max<std::size_t>(1, surface.triangles.size()));
  return {
      {entry.name, "open_edges", static_cast<double>(open_edges(surface.triangles)), 0},
      {entry.name, "pinched_vertices", static_cast<double>(pinched_vertices(surface.triangles)), 0},
      {entry.name, "crossing_percent", 100 * most / triangles, limits.crossing_percent},
      {entry.name, "surface_volume_gap_percent", gap_percent(entry.volume_ml, enclosed),
       limits.volume_gap_percent},
      {entry.name, "wrap_step_ratio", wrap_step_ratio(surface.positions), limits.wrap_step_ratio}};
}

std::vector<Check> check_field(const atlas::StructureEntry& entry, const field::FieldQuery& query,
                               const StructuralLimits& limits) {
  std::vector<double> volumes;
  double stray = 0;
  double slope = 0;
  for (const PhaseOfField& phase : look_at_phases(query.payload())) {
    volumes.push_back(phase.volume_ml);
    stray = std::max(stray, phase.stray_percent);
    slope = std::max(slope, phase.slope_error);
  }
  return {{entry.name, "field_volume_gap_percent", gap_percent(entry.volume_ml, volumes),
           limits.volume_gap_percent},
          {entry.name, "stray_percent", stray, limits.stray_percent},
          {entry.name, "slope_error", slope, limits.slope_error}};
}

/// What two structures' surfaces cut each other, of the triangles of the first [%]; worst phase.
Check check_two(const atlas::SurfacePayload& one, const atlas::SurfacePayload& other,
                const StructuralLimits& limits) {
  const std::size_t phases = std::min(one.positions.size(), other.positions.size());
  std::vector<double> crossing(phases);
  parallel_for(phases, [&](std::size_t p) {
    crossing[p] = static_cast<double>(
        crossing_triangles(one.triangles, one.positions[p], other.triangles, other.positions[p]));
  });
  const double most = crossing.empty() ? 0 : *std::max_element(crossing.begin(), crossing.end());
  std::string name = std::string(kCrosses) + std::string(structure_name(other.structure));
  if (one.level > 0) name += std::string(kLevel) + std::to_string(one.level);
  return {std::string(structure_name(one.structure)), std::move(name),
          100 * most / static_cast<double>(std::max<std::size_t>(1, one.triangles.size())),
          limits.nested_crossing_percent};
}

/// Payloads on one side only of what the scene holds and what the package lists.
int content_differences(const atlas::Manifest& manifest) {
  int differences = 0;
  for (const atlas::StructureEntry& entry : manifest.structures) {
    const auto structure = structure_from_name(entry.name);
    if (!structure) continue;
    for (const std::string_view kind : atlas::kKinds) {
      // Both are optional: see atlas/scene.h.
      if (kind == atlas::kVolumeKind || kind == atlas::kMapKind) continue;
      const bool is_field_alone = manifest.format_version < 4 && manifest.scene == "palpation";
      const bool listed =
          std::any_of(manifest.items.begin(), manifest.items.end(), [&](const atlas::Item& item) {
            return item.kind == kind && item.structure == entry.name;
          });
      const bool held = atlas::scene_holds(manifest.scene, kind, *structure) &&
                        !(is_field_alone && kind != atlas::kFieldKind);
      if (listed != held) ++differences;
    }
  }
  return differences;
}

/// 0, 1 or 2 of the two moments are not where the LV (or the heart) is largest and smallest.
int wrong_end_phases(const atlas::Manifest& manifest) {
  const auto named = [&](std::string_view name) {
    return std::find_if(manifest.structures.begin(), manifest.structures.end(),
                        [&](const atlas::StructureEntry& entry) { return entry.name == name; });
  };
  auto entry = named(structure_name(Structure::LvBlood));
  if (entry == manifest.structures.end()) entry = named(structure_name(Structure::Heart));
  if (entry == manifest.structures.end()) return 0;
  const std::vector<double>& curve = entry->volume_ml;
  const auto [low, high] = std::minmax_element(curve.begin(), curve.end());
  const double tolerance = kSameMl + 0.02 * (*high - *low);
  const auto at = [&](int phase) -> std::optional<double> {
    if (phase < 0 || phase >= static_cast<int>(curve.size())) return std::nullopt;
    return curve[static_cast<std::size_t>(phase)];
  };
  const auto largest = at(manifest.end_diastole);
  const auto smallest = at(manifest.end_systole);
  return (largest && *largest >= *high - tolerance ? 0 : 1) +
         (smallest && *smallest <= *low + tolerance ? 0 : 1);
}

/// The structures without which the package is not what its scene is for, as its maker wrote down.
std::vector<std::string> needs_of(const atlas::Manifest& manifest) {
  std::vector<std::string> out;
  const auto needs = manifest.provenance.find("needs");
  if (needs == manifest.provenance.end() || !needs->is_array()) return out;
  for (const nlohmann::json& name : *needs) {
    if (name.is_string()) out.push_back(name.get<std::string>());
  }
  return out;
}

/// In how many phases it is not there.
std::size_t missing_phases(const atlas::Manifest& manifest, const std::string& name) {
  for (const atlas::StructureEntry& entry : manifest.structures) {
    if (entry.name != name) continue;
    return static_cast<std::size_t>(std::count_if(entry.volume_ml.begin(), entry.volume_ml.end(),
                                                  [](double ml) { return !(ml > 0); }));
  }
  return std::max<std::size_t>(1, manifest.frame_times_s.size());
}

/// By how much the LV's ejection fraction lies outside what is possible [points].
double impossible_ef_points(const std::vector<double>& volume_ml) {
  if (volume_ml.empty()) return 0;
  const auto [low, high] = std::minmax_element(volume_ml.begin(), volume_ml.end());
  const double ef = *high > 0 ? 100 * (*high - *low) / *high : 0;
  return std::max({0.0, kLeastEfPercent - ef, ef - kMostEfPercent});
}

/// What a structure's coarser surfaces are like, against its field where it has one.
void check_coarser(const atlas::Atlas& package, const atlas::StructureEntry& entry,
                   Structure structure, const field::FieldQuery* query,
                   const StructuralLimits& limits, std::vector<Check>& checks) {
  const std::vector<double>& edges_mm = package.manifest().surface_edges_mm;
  for (std::size_t level = 1; level < edges_mm.size(); ++level) {
    const auto coarser = package.surface(structure, static_cast<int>(level));
    if (!coarser) continue;
    for (Check& check : check_one(entry, coarser.get(), query, limits, edges_mm[level])) {
      // The field is the same at every level.
      if (check.name.starts_with("field_") || check.name == "stray_percent" ||
          check.name == "slope_error") {
        continue;
      }
      check.name += std::string(kLevel) + std::to_string(level);
      checks.push_back(std::move(check));
    }
  }
}

/// Of every two structures' surfaces at every level of detail.
void check_every_two(const atlas::Atlas& package, const StructuralLimits& limits,
                     std::vector<Check>& checks) {
  // Before version 5 nothing kept structures that share a wall apart; their surfaces lie in it.
  const atlas::Manifest& manifest = package.manifest();
  const int levels =
      manifest.format_version < 5 ? 0 : static_cast<int>(manifest.surface_edges_mm.size());
  for (int level = 0; level < levels; ++level) {
    for (std::size_t n = 0; n < kAllStructures.size(); ++n) {
      const auto one = package.surface(kAllStructures[n], level);
      if (!one) continue;
      for (std::size_t m = n + 1; m < kAllStructures.size(); ++m) {
        const auto other = package.surface(kAllStructures[m], level);
        if (other) checks.push_back(check_two(*one, *other, limits));
      }
    }
  }
}

}  // namespace

std::vector<Check> check_one(const atlas::StructureEntry& entry,
                             const atlas::SurfacePayload* surface, const field::FieldQuery* query,
                             const StructuralLimits& limits, double edge_mm) {
  constexpr double kLongEdgeMm = 4;
  std::vector<Check> checks;
  if (surface != nullptr) checks = check_surface(entry, *surface, limits);
  if (query != nullptr) {
    const std::vector<Check> of_field = check_field(entry, *query, limits);
    checks.insert(checks.end(), of_field.begin(), of_field.end());
  }
  if (surface != nullptr && query != nullptr) {
    checks.push_back({entry.name, "vertex_distance_mm", vertex_distance_mm(*query, *surface),
                      limits.vertex_distance_voxels * query->payload().voxel_mm});
    checks.push_back({entry.name, "surface_error_mm", surface_error_mm(*query, *surface),
                      limits.surface_error_mm * std::pow(std::max(1.0, edge_mm / kLongEdgeMm), 2)});
    checks.push_back({entry.name, "wrong_side_percent", wrong_side_percent(*query, *surface),
                      limits.wrong_side_percent});
  }
  return checks;
}

std::vector<Check> check_manifest(const atlas::Manifest& manifest) {
  std::vector<Check> checks{
      {"package", "content", static_cast<double>(content_differences(manifest)), 0},
      {"package", "end_phases", static_cast<double>(wrong_end_phases(manifest)), 0}};
  for (const std::string& name : needs_of(manifest)) {
    checks.push_back({name, "missing_phases", double(missing_phases(manifest, name)), 0});
  }
  for (const atlas::StructureEntry& entry : manifest.structures) {
    if (entry.name != structure_name(Structure::LvBlood)) continue;
    checks.push_back(
        {entry.name, "impossible_ef_points", impossible_ef_points(entry.volume_ml), 0});
  }
  return checks;
}

std::vector<Check> check_structure(const atlas::Atlas& package, const StructuralLimits& limits,
                                   StageContext& context) {
  const atlas::Manifest& manifest = package.manifest();
  std::vector<Check> checks = check_manifest(manifest);
  double done = 0;
  for (const atlas::StructureEntry& entry : manifest.structures) {
    context.check_cancelled();
    const auto structure = structure_from_name(entry.name);
    if (!structure) continue;
    const auto surface = package.surface(*structure);
    const auto payload = package.field(*structure);
    std::optional<field::FieldQuery> query;
    if (payload) query.emplace(payload, manifest.rr_interval_s);
    const field::FieldQuery* of_field = query ? &*query : nullptr;
    const std::vector<double>& edges_mm = manifest.surface_edges_mm;
    const std::vector<Check> own =
        check_one(entry, surface.get(), of_field, limits, edges_mm.empty() ? 0 : edges_mm.front());
    checks.insert(checks.end(), own.begin(), own.end());
    check_coarser(package, entry, *structure, of_field, limits, checks);
    done += 1;
    context.progress(done / static_cast<double>(manifest.structures.size()));
  }
  check_every_two(package, limits, checks);
  return checks;
}

std::vector<std::string> failures_of(const std::vector<Check>& checks) {
  std::vector<std::string> out;
  for (const Check& check : checks) {
    if (check.passed()) continue;
    char text[320];
    std::snprintf(text, sizeof text, "%s: %s: %.3g (%s), limit %g", check.structure.c_str(),
                  words_of(check.name).c_str(), check.worst, check.name.c_str(), check.limit);
    out.emplace_back(text);
  }
  return out;
}

bool all_passed(const std::vector<Check>& checks) {
  return std::all_of(checks.begin(), checks.end(),
                     [](const Check& check) { return check.passed(); });
}

nlohmann::json checks_to_json(const std::vector<Check>& checks) {
  nlohmann::json list = nlohmann::json::array();
  for (const Check& check : checks) {
    list.push_back({{"structure", check.structure},
                    {"name", check.name},
                    {"worst", check.worst},
                    {"limit", check.limit},
                    {"passed", check.passed()}});
  }
  return {{"checks", list}, {"failures", failures_of(checks)}, {"passed", all_passed(checks)}};
}

std::string checks_to_text(const std::vector<Check>& checks) {
  std::string text;
  for (const Check& check : checks) {
    char line[160];
    std::snprintf(line, sizeof line, "%-6s %-14s %-28s %10.3f  (limit %g)\n",
                  check.passed() ? "ok" : "FAILED", check.structure.c_str(), check.name.c_str(),
                  check.worst, check.limit);
    text += line;
  }
  for (const std::string& failure : failures_of(checks)) text += failure + "\n";
  return text + (all_passed(checks) ? "passed\n" : "not passed\n");
}

}  // namespace beatlas::assess
