#include "pipeline/assess/validate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <set>

#include "pipeline/assess/drawn_errors.h"
#include "pipeline/assess/force_error.h"
#include "pipeline/assess/same_phantom.h"
#include "runtime/atlas/surface_band.h"
#include "runtime/base/error.h"
#include "runtime/field/field_query.h"

namespace beatlas::assess {
namespace {

using Queries = std::vector<std::shared_ptr<const field::FieldQuery>>;

std::shared_ptr<const field::FieldQuery> query_of(const Queries& queries, Structure structure) {
  const auto found = std::find_if(queries.begin(), queries.end(), [&](const auto& query) {
    return query->payload().structure == structure;
  });
  return found == queries.end() ? nullptr : *found;
}

const std::vector<double>& volume_curve(const atlas::Manifest& manifest, Structure structure,
                                        int phases) {
  const std::string name(structure_name(structure));
  for (const atlas::StructureEntry& entry : manifest.structures) {
    if (entry.name != name) continue;
    if (entry.volume_ml.size() != static_cast<std::size_t>(phases)) {
      throw_invalid("the package's volume curve of " + name +
                    " has another number of phases than its field; build the package again");
    }
    return entry.volume_ml;
  }
  throw_invalid("the package has a field of " + name + " but no volume curve; build it again");
}

double ejection_fraction(const std::vector<double>& curve) {
  const auto [low, high] = std::minmax_element(curve.begin(), curve.end());
  return *high > 0.0 ? 1.0 - *low / *high : 0.0;
}

void check(const ValidateOptions& options) {
  const auto spacing = [](double mm) { return mm >= 0.3 && mm <= 20.0; };
  if (!(options.motion.on_wall_mm > 0.0) || options.motion.parts < 1 || options.motion.parts > 64) {
    throw_invalid("motion needs a wall of more than 0 mm and 1 to 64 parts a phase");
  }
  if (!(options.map.rim_mm >= 0.0) || !(options.map.off_wall_mm > 0.0) ||
      options.map.most_vertices < 1 || options.map.most_vertices > 1000000) {
    throw_invalid("maps need a rim of 0 mm or more, a wall of more and 1 to 1000000 vertices");
  }
  if (!spacing(options.compare.sample_spacing_mm) || !spacing(options.thickness.spacing_mm)) {
    throw_invalid("the spacing of sampled points must be from 0.3 to 20 mm");
  }
  if (!(options.compare.crease_band_mm >= 0.0) || !(options.thickness.rim_mm >= 0.0)) {
    throw_invalid("the bands around creases and rim must not be negative");
  }
}

StructureErrors structure_errors(const Candidate& candidate, const Queries& queries,
                                 const field::FieldQuery& query, const phantom::Phantom& truth,
                                 const ValidateOptions& options,
                                 const std::function<void()>& after_phase) {
  const int phases = query.phases();
  StructureErrors out;
  out.structure = query.payload().structure;
  const std::vector<double>& curve = volume_curve(candidate.manifest, out.structure, phases);
  const auto blood =
      out.structure == Structure::LvMyocardium ? query_of(queries, Structure::LvBlood) : nullptr;
  std::vector<double> true_curve;
  for (int p = 0; p < phases; ++p) {
    PhaseErrors phase = compare_phase(candidate.manifest, query, truth, p, phases, options.compare);
    const double share = static_cast<double>(p) / phases;
    const double true_ml = truth.volume_ml(out.structure, truth.spec().rr_interval_s * share);
    phase.volume_error_ml = curve[static_cast<std::size_t>(p)] - true_ml;
    phase.volume_error_percent = 100.0 * phase.volume_error_ml / true_ml;
    true_curve.push_back(true_ml);
    out.phases.push_back(phase);
    if (blood) {
      out.wall_thickness.push_back(wall_thickness_errors(
          *blood, query, candidate.manifest.workspace_from_lps, truth, share, options.thickness));
    }
    after_phase();
  }
  for (const auto& surface : candidate.surfaces) {
    if (surface->structure != out.structure) continue;
    const MotionErrors motion =
        motion_errors(*surface, candidate.manifest.workspace_from_lps, truth, options.motion);
    if (motion.points > 0) out.motion = motion;
    for (const auto& map : candidate.maps) {
      if (map->structure != out.structure) continue;
      out.map =
          map_errors(*map, *surface, candidate.manifest.workspace_from_lps, truth, options.map);
    }
  }
  if (out.structure == Structure::LvBlood || out.structure == Structure::RvBlood) {
    out.ejection_fraction_error = ejection_fraction(curve) - ejection_fraction(true_curve);
  }
  return out;
}

DrawnStructure drawn_structure(const Candidate& candidate, const atlas::SurfacePayload& surface,
                               const phantom::Phantom& truth, const ValidateOptions& options) {
  DrawnStructure out{surface.structure, {}, {}, {}};
  if (!truth.frame(0)->has(surface.structure)) return out;
  for (int p = 0; p < static_cast<int>(surface.positions.size()); ++p) {
    const auto phases = static_cast<int>(surface.positions.size());
    const double true_ml =
        truth.volume_ml(surface.structure, truth.spec().rr_interval_s * p / phases);
    const TrueSurface there = true_surface(truth, surface.structure, p, phases, options.compare);
    const Affine& workspace_from_lps = candidate.manifest.workspace_from_lps;
    out.phases.push_back(drawn_errors(surface, workspace_from_lps, p, there,
                                      vertex_errors(surface, workspace_from_lps, p, there),
                                      true_ml));
  }
  return out;
}

/// [%] See DrawnStructure.
std::optional<double> band_percent(const atlas::BandQuery& band,
                                   const std::map<int, std::vector<VertexError>>& vertices,
                                   int phases) {
  double within = 0;
  double all = 0;
  for (const auto& [phase, of_phase] : vertices) {
    for (const VertexError& vertex : of_phase) {
      all += vertex.area_mm2;
      const double most_mm =
          band.half_width_mm(vertex.place, vertex.normal, static_cast<double>(phase) / phases);
      if (std::abs(vertex.off_mm) <= most_mm) within += vertex.area_mm2;
    }
  }
  if (all <= 0) return std::nullopt;
  return 100 * within / all;
}

FeltErrors felt_errors(const std::shared_ptr<const field::FieldQuery>& query,
                       const Affine& workspace_from_lps, const phantom::Phantom& truth,
                       const ValidateOptions& options, StageContext& context) {
  haptics::TwoStepOptions model;
  model.stiffness_n_per_m = options.stiffness_n_per_m;
  const ForceCandidate candidate = two_step_candidate(query, model, workspace_from_lps);
  const TrueForces forces = true_forces(truth, palpation_set(truth, options.palpations),
                                        options.stiffness_n_per_m, context);
  return {options.palpations.structure, options.stiffness_n_per_m, force_errors(candidate, forces)};
}

/// What broke a limit, and which limits met a figure at all.
struct Verdict {
  std::vector<std::string> failures;
  std::set<std::string_view> met;  // names of limits
};

/// Says which figures break their limits.
class Judge {
 public:
  Judge(const Limits& limits, std::string where, Verdict& verdict)
      : limits_(limits), where_(std::move(where)), verdict_(verdict) {}

  void figure(const std::string& name, double value, LimitMember member) {
    if (member == nullptr || !(limits_.*member)) return;
    verdict_.met.insert(name_of(member).name);
    const double limit = *(limits_.*member);
    const LimitName& known = name_of(member);
    if (known.is_least() ? value >= limit : std::abs(value) <= limit) return;
    char text[200];
    std::snprintf(text, sizeof text, ": %s is %.4g, %s the limit of %.4g (%s)", name.c_str(), value,
                  known.is_least() ? "below" : "beyond", limit, known.name);
    verdict_.failures.push_back(where_ + text);
  }

  template <class Errors, std::size_t N>
  void figures(const std::array<Figure<Errors>, N>& table, const Errors& errors,
               const std::string& prefix = "") {
    for (const Figure<Errors>& each : table) {
      figure(prefix + each.name, errors.*each.value, each.limit);
    }
  }

 private:
  const Limits& limits_;
  std::string where_;
  Verdict& verdict_;
};

void judge_structure(const Limits& limits, const StructureErrors& structure, Verdict& verdict) {
  const std::string name(structure_name(structure.structure));
  for (std::size_t p = 0; p < structure.phases.size(); ++p) {
    const PhaseErrors& errors = structure.phases[p];
    const std::string where = name + " in phase " + std::to_string(p);
    Judge judge_phase(limits, where, verdict);
    if (p < structure.wall_thickness.size() && structure.wall_thickness[p].points > 0) {
      judge_phase.figures(kThicknessFigures, structure.wall_thickness[p], "wall_thickness ");
    }
    if (errors.points == 0) {
      verdict.failures.push_back(where + ": the package has no surface");
      continue;
    }
    if (!(errors.dice > 0.0)) {
      verdict.failures.push_back(where + ": the package and the truth do not overlap");
    }
    judge_phase.figures(kPhaseFigures, errors);
  }
  if (structure.motion) {
    Judge(limits, name, verdict).figures(kMotionFigures, *structure.motion, "motion ");
  }
  if (structure.map && structure.map->points > 0) {
    Judge judge_map(limits, name, verdict);
    judge_map.figures(kMapFigures, *structure.map, "map ");
    if (structure.map->named > 0) judge_map.figures(kSegmentFigures, *structure.map, "map ");
  }
  if (structure.ejection_fraction_error) {
    Judge(limits, name, verdict)
        .figure("ejection_fraction_error", *structure.ejection_fraction_error,
                &Limits::max_ejection_fraction_error);
  }
}

/// Nothing is promised of what is beyond the base, and no limit bounds it: it is drawn, not felt.
void judge_drawn(const Limits& limits, const DrawnStructure& structure, Verdict& verdict) {
  if (is_beyond_base(structure.structure)) return;
  for (std::size_t p = 0; p < structure.phases.size(); ++p) {
    const std::string where =
        std::string(structure_name(structure.structure)) + " in phase " + std::to_string(p);
    if (structure.phases[p].points == 0) {
      verdict.failures.push_back(where + ": nothing of it could be compared");
      continue;
    }
    Judge(limits, where, verdict).figures(kDrawnFigures, structure.phases[p]);
  }
}

/// A limit that met no figure is not kept: what it bounds could not be measured.
void judge_unmet(const Limits& limits, const std::string& of, Verdict& verdict) {
  for (const LimitName& limit : kLimitNames) {
    if (!(limits.*limit.member) || verdict.met.contains(limit.name)) continue;
    verdict.failures.push_back(std::string(limit.name) + of +
                               " bounds what could not be measured: the package lacks the field or "
                               "the surface for it");
  }
}

}  // namespace

void judge(const LimitSet& limits, ValidationReport& report) {
  Verdict all;
  std::map<Structure, Verdict> each;
  for (const StructureErrors& structure : report.structures) {
    judge_structure(limits.of(structure.structure), structure, each[structure.structure]);
  }
  for (const DrawnStructure& structure : report.drawn) {
    judge_drawn(limits.of(structure.structure), structure, each[structure.structure]);
  }
  if (report.force) {
    const Limits bounds = limits.of(report.force->structure);
    Judge(bounds, "force of " + std::string(structure_name(report.force->structure)),
          each[report.force->structure])
        .figures(kForceFigures, report.force->errors);
  }
  for (const auto& [structure, bounds] : limits.structures) {
    judge_unmet(bounds, " of " + std::string(structure_name(structure)), each[structure]);
  }
  for (const auto& [structure, verdict] : each) {
    report.failures.insert(report.failures.end(), verdict.failures.begin(), verdict.failures.end());
    all.met.insert(verdict.met.begin(), verdict.met.end());
  }
  judge_unmet(limits.all, "", all);
  report.failures.insert(report.failures.end(), all.failures.begin(), all.failures.end());
  report.passed = report.failures.empty();
}

ValidationReport validate(const Candidate& candidate, const phantom::Phantom& truth,
                          const ValidateOptions& options, StageContext& context) {
  check(options);
  demand_same_phantom(candidate.manifest, candidate.fields, truth);
  if (candidate.fields.empty()) {
    throw_invalid("no field to validate was opened; the scenes palpation and full hold fields");
  }
  Queries queries;
  for (const auto& field : candidate.fields) {
    queries.push_back(
        std::make_shared<const field::FieldQuery>(field, candidate.manifest.rr_interval_s));
  }
  const auto felt = query_of(queries, options.palpations.structure);
  if (!felt && options.demand_force) {
    throw_invalid("the package has no field of " +
                  std::string(structure_name(options.palpations.structure)) +
                  " whose force could be compared; its scene leaves it out");
  }
  ValidationReport report;
  double done = 0;
  const double all = static_cast<double>(queries.size()) + (felt ? 1.0 : 0.0);
  for (const auto& query : queries) {
    report.structures.push_back(structure_errors(candidate, queries, *query, truth, options, [&] {
      context.check_cancelled();
      done += 1.0 / query->phases();
      context.progress(done / all);
    }));
  }
  for (const auto& surface : candidate.surfaces) {
    if (query_of(queries, surface->structure) || surface->level != 0) continue;
    context.check_cancelled();
    report.drawn.push_back(drawn_structure(candidate, *surface, truth, options));
  }
  if (felt) {
    report.force =
        felt_errors(felt, candidate.manifest.workspace_from_lps, truth, options, context);
    context.progress(1.0);
  }
  judge(options.limits, report);
  if (options.promises != nullptr) hold_to(*options.promises, report);
  return report;
}

ValidationReport validate(const Candidate& candidate, const phantom::DrawnTruth& truth,
                          const ValidateOptions& options, StageContext& context) {
  check(options);
  const atlas::Manifest& manifest = candidate.manifest;
  demand_same_draw(manifest, truth);
  const Grid seen = source_grid(manifest);
  const double spacing_mm = options.compare.sample_spacing_mm;
  ValidationReport report;
  std::vector<const atlas::SurfacePayload*> surfaces;
  for (const auto& surface : candidate.surfaces) {
    if (surface->level != 0) continue;
    if (surface->positions.size() != static_cast<std::size_t>(truth.phases())) {
      throw_invalid("the package's surface of " + std::string(structure_name(surface->structure)) +
                    " has another number of phases than its images; build the package again");
    }
    surfaces.push_back(surface.get());
    report.drawn.push_back({surface->structure, {}, {}, {}});
  }
  if (surfaces.empty()) throw_invalid("the package holds no surface that could be compared");
  for (int p = 0; p < truth.phases(); ++p) {
    context.check_cancelled();
    context.progress(static_cast<double>(p) / truth.phases());
    const phantom::DrawnTruth::Frame frame = truth.frame(p, spacing_mm);
    for (std::size_t n = 0; n < surfaces.size(); ++n) {
      const Structure structure = surfaces[n]->structure;
      const double true_ml = truth.volume_ml(structure, p);
      if (!(true_ml > 0)) continue;
      const TrueSurface there = true_surface(frame, structure, spacing_mm, seen);
      std::vector<VertexError> vertices =
          vertex_errors(*surfaces[n], manifest.workspace_from_lps, p, there);
      report.drawn[n].phases.push_back(
          drawn_errors(*surfaces[n], manifest.workspace_from_lps, p, there, vertices, true_ml));
      if (p == manifest.end_diastole || p == manifest.end_systole) {
        report.drawn[n].vertices.emplace(p, std::move(vertices));
      }
    }
  }
  for (DrawnStructure& drawn : report.drawn) {
    if (const auto band = atlas::band_query(manifest, drawn.structure)) {
      drawn.band_percent = band_percent(*band, drawn.vertices, truth.phases());
    }
  }
  judge(options.limits, report);
  return report;
}

Candidate candidate_of(const atlas::Atlas& atlas) {
  Candidate out{atlas.manifest(), {}};
  for (Structure structure : kAllStructures) {
    if (auto field = atlas.field(structure)) out.fields.push_back(std::move(field));
    if (auto surface = atlas.surface(structure)) out.surfaces.push_back(std::move(surface));
    if (auto map = atlas.surface_map(structure)) out.maps.push_back(std::move(map));
  }
  return out;
}

}  // namespace beatlas::assess
