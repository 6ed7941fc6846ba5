#include "pipeline/cli/structural_checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "pipeline/cli/quality.h"
#include "pipeline/core/parallel.h"
#include "runtime/field/field_query.h"

namespace beatlas::cli {
namespace {

double largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

double gap_percent(const std::vector<double>& expected, const std::vector<double>& found) {
  double gap = 0;
  for (std::size_t p = 0; p < expected.size(); ++p) {
    gap = std::max(gap, std::abs(found[p] - expected[p]));
  }
  const double scale = largest(expected);
  return scale > 0 ? 100 * gap / scale : 100;
}

/// Directed edges that do not meet exactly one opposite.
std::size_t open_edges(const atlas::SurfacePayload& surface) {
  using Edge = std::pair<std::uint32_t, std::uint32_t>;
  std::vector<Edge> edges;
  for (const auto& [a, b, c] : surface.triangles) {
    edges.insert(edges.end(), {Edge{a, b}, Edge{b, c}, Edge{c, a}});
  }
  std::sort(edges.begin(), edges.end());
  std::size_t open = 0;
  for (const Edge& edge : edges) {
    const auto [first, last] =
        std::equal_range(edges.begin(), edges.end(), Edge{edge.second, edge.first});
    const auto [same, end] = std::equal_range(edges.begin(), edges.end(), edge);
    if (last - first != 1 || end - same != 1) ++open;
  }
  return open;
}

/// Volume of each phase: every sample of the lattice counts by how much of it lies inside, for a
/// surface that crosses its voxel straight.
std::vector<double> field_volumes_ml(const field::FieldQuery& query) {
  const atlas::FieldPayload& payload = query.payload();
  const auto phases = static_cast<std::size_t>(payload.phases);
  Index3 size{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    size[axis] = payload.block_count[axis] * atlas::FieldPayload::kBlockEdge;
  }
  const auto layers = static_cast<std::size_t>(size[2]);
  std::vector<double> layer_sums(layers * phases, 0.0);
  parallel_for(layer_sums.size(), [&](std::size_t task) {
    const std::size_t phase = task / layers;
    const double t_s = query.rr_interval_s() * static_cast<double>(phase) / payload.phases;
    double sum = 0;
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const Vec3 at =
            payload.origin_mm + payload.voxel_mm * Vec3(i, j, static_cast<double>(task % layers));
        const double voxels = query.sample(at, t_s).distance_mm / payload.voxel_mm;
        sum += std::clamp(0.5 - voxels, 0.0, 1.0);
      }
    }
    layer_sums[task] = sum;
  });
  std::vector<double> volumes(phases, 0.0);
  for (std::size_t task = 0; task < layer_sums.size(); ++task) {
    volumes[task / layers] += layer_sums[task] * std::pow(payload.voxel_mm, 3) * 1e-3;
  }
  return volumes;
}

double vertex_distance_mm(const field::FieldQuery& query, const atlas::SurfacePayload& surface) {
  double worst = 0;
  const std::size_t phases = surface.positions.size();
  for (std::size_t phase = 0; phase < phases; ++phase) {
    const double t_s =
        query.rr_interval_s() * static_cast<double>(phase) / static_cast<double>(phases);
    double squares = 0;
    for (const Vec3f& vertex : surface.positions[phase]) {
      squares += std::pow(query.sample(vertex.cast<double>(), t_s).distance_mm, 2);
    }
    worst = std::max(worst, std::sqrt(squares / static_cast<double>(std::max<std::size_t>(
                                                    1, surface.positions[phase].size()))));
  }
  return worst;
}

}  // namespace

std::vector<Check> check_structure(const atlas::Atlas& package, const StructuralLimits& limits,
                                   StageContext& context) {
  std::vector<Check> checks;
  const atlas::Manifest& manifest = package.manifest();
  for (const atlas::StructureEntry& entry : manifest.structures) {
    context.check_cancelled();
    const auto structure = structure_from_name(entry.name);
    if (!structure) continue;
    const auto surface = package.surface(*structure);
    const auto payload = package.field(*structure);
    if (surface) {
      checks.push_back({entry.name, "open_edges", static_cast<double>(open_edges(*surface)), 0});
      std::vector<double> enclosed;
      for (const std::vector<Vec3f>& phase : surface->positions) {
        enclosed.push_back(enclosed_volume_ml(surface->triangles, phase));
      }
      checks.push_back({entry.name, "surface_volume_gap_percent",
                        gap_percent(entry.volume_ml, enclosed), limits.volume_gap_percent});
    }
    if (!payload) continue;
    const field::FieldQuery query(payload, manifest.rr_interval_s);
    checks.push_back({entry.name, "field_volume_gap_percent",
                      gap_percent(entry.volume_ml, field_volumes_ml(query)),
                      limits.volume_gap_percent});
    if (surface) {
      checks.push_back({entry.name, "vertex_distance_mm", vertex_distance_mm(query, *surface),
                        limits.vertex_distance_voxels * payload->voxel_mm});
    }
  }
  return checks;
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
  return {{"checks", list}, {"passed", all_passed(checks)}};
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
  return text + (all_passed(checks) ? "passed\n" : "not passed\n");
}

}  // namespace beatlas::cli
