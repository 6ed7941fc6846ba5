/// The table of fields of a cycle: ours, dense float volumes, NanoVDB grids.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

#include "pipeline/cli/bench_probe.h"
#include "pipeline/pack/pack.h"
#include "runtime/atlas/atlas.h"
#include "runtime/field/sampled_query.h"
#include "tests/bench/alternatives.h"
#include "tests/bench/alternatives_files.h"
#include "tests/bench/alternatives_samplers.h"

namespace beatlas::bench {
namespace {

using cli::Question;

constexpr const char* kFieldPackage = "field.beatlas";
constexpr double kAwayMm = 3;  // errors are asked within it of the true surface

/// A way to keep a field, for the table.
struct Candidate {
  std::string name;
  double memory_mb = 0;
  double disk_mb = 0;
  double disk_zstd_mb = 0;
  std::function<void()> load;
  std::function<void()> load_zstd;  ///< none: what is on disk is compressed already
  std::function<double(const std::vector<Question>&)> round;  ///< CPU seconds
  std::function<FieldSample(const Vec3&, double)> sample;
  std::function<FieldSample(const Vec3&, double)> exact_sample;  ///< of the exact shape's field
};

double mb(std::size_t bytes) { return 1e-6 * static_cast<double>(bytes); }

template <class Query>
void ask_of(Candidate& out, std::shared_ptr<const Query> query,
            std::shared_ptr<const Query> exact) {
  out.round = [query](const std::vector<Question>& questions) {
    double sum = 0;  // used below, so that no call is left out
    const double start = cli::thread_cpu_s();
    for (const Question& question : questions) {
      const FieldSample sample = query->sample(question.x, question.t_s);
      sum += sample.distance_mm + sample.gradient.sum();
    }
    const double seconds = cli::thread_cpu_s() - start;
    volatile double used = sum;
    (void)used;
    return seconds;
  };
  out.sample = [query](const Vec3& x, double t) { return query->sample(x, t); };
  out.exact_sample = [exact](const Vec3& x, double t) { return exact->sample(x, t); };
}

std::shared_ptr<const field::FieldQuery> opened(const std::filesystem::path& file) {
  const atlas::Atlas package =
      atlas::Atlas::open(file, {.fields = {Structure::Heart}, .surfaces = {}});
  return std::make_shared<const field::FieldQuery>(package.field(Structure::Heart),
                                                   package.manifest().rr_interval_s);
}

std::filesystem::path written_package(const Setting& setting, const FieldCycle& cycle,
                                      const std::string& name) {
  pack::PackageContent content;
  content.manifest = manifest_of(setting, "palpation");
  content.fields.push_back(pack::encode_field(cycle, {}));
  std::filesystem::path file = setting.work / name;
  pack::write_package(file, content);
  return file;
}

std::vector<Candidate> our_candidates(const Setting& setting) {
  const std::filesystem::path file = written_package(setting, setting.field, kFieldPackage);
  const auto spline = opened(file);
  const auto exact = opened(written_package(setting, setting.exact_field, "exact.beatlas"));
  const atlas::FieldPayload& payload = spline->payload();
  const std::size_t samples = sizeof(std::int16_t) * payload.coefficients.size();
  Candidate out;
  out.name = "beatlas, C2 spline in space and time";
  out.disk_mb = mb(std::filesystem::file_size(file));
  out.disk_zstd_mb = out.disk_mb;
  out.memory_mb = mb(samples + 2 * sizeof(std::int32_t) * payload.blocks.size());
  out.load = [file] { (void)opened(file); };
  ask_of(out, spline, exact);

  const auto cheaper = [](const std::shared_ptr<const field::FieldQuery>& query) {
    return std::make_shared<const field::SampledQuery>(query, field::SpatialMode::Trilinear,
                                                       field::TemporalMode::Linear);
  };
  Candidate linear = out;
  linear.name = "beatlas, trilinear, linear in time";
  linear.memory_mb += mb(samples);
  linear.load = [file, cheaper] { (void)cheaper(opened(file)); };
  ask_of(linear, cheaper(spline), cheaper(exact));
  return {out, linear};
}

Candidate dense_candidate(const Setting& setting) {
  const Lattice lattice = lattice_of(setting.field, setting.rr_interval_s());
  const std::vector<std::vector<float>>& phases = setting.field.distance_mm.phases;
  std::string bytes;
  for (const std::vector<float>& phase : phases) {
    bytes.append(reinterpret_cast<const char*>(phase.data()), sizeof(float) * phase.size());
  }
  const auto parsed = [lattice, count = phases.size(),
                       voxels = phases.front().size()](const std::string& from) {
    std::vector<std::vector<float>> out(count, std::vector<float>(voxels));
    for (std::size_t p = 0; p < count; ++p) {
      std::memcpy(out[p].data(), from.data() + p * voxels * sizeof(float), voxels * sizeof(float));
    }
    return std::make_shared<const DenseField>(lattice, std::move(out));
  };
  const std::filesystem::path raw = setting.work / "dense.raw";
  const std::filesystem::path packed = setting.work / "dense.raw.zst";
  write_file(raw, bytes);
  write_file(packed, zstd_packed(bytes));

  Candidate out;
  out.name = "dense float volumes";
  out.memory_mb = mb(bytes.size());
  out.disk_mb = mb(std::filesystem::file_size(raw));
  out.disk_zstd_mb = mb(std::filesystem::file_size(packed));
  out.load = [raw, parsed] { (void)parsed(read_file(raw)); };
  out.load_zstd = [packed, parsed] { (void)parsed(zstd_unpacked(read_file(packed))); };
  ask_of(
      out, parsed(bytes),
      std::make_shared<const DenseField>(lattice_of(setting.exact_field, setting.rr_interval_s()),
                                         setting.exact_field.distance_mm.phases));
  return out;
}

template <class Build>
Candidate nano_candidate(const Setting& setting, const std::string& name, const std::string& stem) {
  using Field = NanoField<Build>;
  const Lattice lattice = lattice_of(setting.field, setting.rr_interval_s());
  const std::filesystem::path raw = setting.work / (stem + ".nvdb");
  const std::filesystem::path packed = setting.work / (stem + ".nvdb.zst");
  Candidate out;
  out.name = name;
  {
    const typename Field::Handles handles = nano_grids<Build>(setting.field);
    std::size_t bytes = 0;
    for (const auto& handle : handles) bytes += handle.size();
    out.memory_mb = mb(bytes);
    nanovdb::io::writeGrids<nanovdb::HostBuffer, std::vector>(raw.string(), handles);
  }
  write_file(packed, zstd_packed(read_file(raw)));
  out.disk_mb = mb(std::filesystem::file_size(raw));
  out.disk_zstd_mb = mb(std::filesystem::file_size(packed));
  const auto loaded = [lattice, raw] {
    return std::make_shared<const Field>(
        lattice, nanovdb::io::readGrids<nanovdb::HostBuffer, std::vector>(raw.string()));
  };
  out.load = [loaded] { (void)loaded(); };
  out.load_zstd = [lattice, packed] {
    std::istringstream stream(zstd_unpacked(read_file(packed)));
    (void)std::make_shared<const Field>(
        lattice, nanovdb::io::readGrids<nanovdb::HostBuffer, std::vector>(stream));
  };
  ask_of(out, loaded(),
         std::make_shared<const Field>(lattice_of(setting.exact_field, setting.rr_interval_s()),
                                       nano_grids<Build>(setting.exact_field)));
  return out;
}

using Ask = std::function<FieldSample(const Vec3&, double)>;

/// Force as assess::touch_of's of a SampledQuery, the same law for all.
/// @param like whose rule for directions is used where a gradient is none
assess::MakeTouch touch_of(const Ask& ask, std::shared_ptr<const field::FieldQuery> like,
                           double stiffness_n_per_m) {
  return [ask, like, stiffness_n_per_m] {
    return
        [ask, like, stiffness_n_per_m, direction = Vec3(0, 0, 0)](const Vec3& x, double t) mutable {
          const FieldSample sample = ask(x, t);
          haptics::Contact out;
          out.distance_mm = sample.distance_mm;
          out.depth_mm = std::max(0.0, -sample.distance_mm);
          out.touching = out.depth_mm > 0;
          const bool too_deep = out.touching && !sample.in_band;
          out.normal = too_deep && !direction.isZero() ? direction : like->normal(sample, x);
          out.force_n = haptics::contact_force_n(stiffness_n_per_m, out.distance_mm, out.normal);
          direction = out.touching ? out.normal : Vec3(0, 0, 0);
          return out;
        };
  };
}

/// A place and a time with the exact distance there.
struct Known {
  Question question;
  double distance_mm = 0;
};

std::vector<Known> known_distances(const Setting& setting) {
  std::uint64_t state = 1;
  std::vector<Known> out;
  for (const assess::TruthPoint& point : setting.truth.surfaces.at(Structure::Heart)) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;  // Knuth's MMIX
    const double uniform = static_cast<double>(state >> 11U) * 0x1p-53;
    const Vec3 lps = point.lps + kAwayMm * (2 * uniform - 1) * point.normal;
    const double t_s = point.share * setting.rr_interval_s();
    out.push_back({{setting.workspace_from_lps * lps, t_s},
                   setting.phantom.distance_mm(Structure::Heart, lps, t_s)});
  }
  return out;
}

DistanceErrors errors_of(const Ask& ask, const std::vector<Known>& known) {
  std::vector<double> errors;
  for (const Known& each : known) {
    errors.push_back(ask(each.question.x, each.question.t_s).distance_mm - each.distance_mm);
  }
  return summed_errors(std::move(errors));
}

}  // namespace

Table field_table(const Setting& setting) {
  std::vector<Candidate> candidates = our_candidates(setting);
  candidates.push_back(dense_candidate(setting));
  candidates.push_back(nano_candidate<float>(setting, "NanoVDB float, a grid a phase", "float"));
  candidates.push_back(nano_candidate<nanovdb::Fp8>(setting, "NanoVDB Fp8, a grid a phase", "fp8"));

  const double rr_s = setting.rr_interval_s();
  const auto path = cli::path_questions(setting.truth, setting.workspace_from_lps, rr_s);
  const auto anywhere = cli::random_questions(setting.truth, setting.workspace_from_lps, rr_s);
  std::vector<std::function<std::vector<double>()>> turns;
  for (const Candidate& each : candidates) {
    turns.emplace_back([&]() -> std::vector<double> {
      const auto ns = [&](const std::vector<Question>& questions) {
        (void)each.round(questions);  // the others' turns emptied the caches
        return 1e9 * each.round(questions) / static_cast<double>(questions.size());
      };
      return {clocked_ms(each.load), each.load_zstd ? clocked_ms(each.load_zstd) : 0, ns(path),
              ns(anywhere)};
    });
  }
  const auto medians = interleaved(3 * setting.repeats, turns);

  Table out;
  out.key = "field";
  out.title = "The heart's field through the cycle";
  out.note =
      "Value and gradient at (x, t); all but the first trilinear and linear in time. The same "
      "samples at 1.5 mm in each. Distance error within 3 mm of the surface at 3 moments a frame, "
      "force error over palpations at 150 N/m; exact: of a field of the exact shape, what storing "
      "and interpolating cost; images: of the field that beatlas made from the images. Loaded from "
      "the page cache; ours checks hashes and every index.";
  out.columns = {{"memory_mb", "memory MB", 2},
                 {"disk_mb", "disk MB", 2},
                 {"disk_zstd_mb", "with zstd-3, MB", 2},
                 {"load_ms", "load ms", 1},
                 {"load_zstd_ms", "with zstd-3, ms", 1},
                 {"path_ns", "1 kHz path, ns", 0},
                 {"random_ns", "random, ns", 0},
                 {"exact_mean_mm", "exact, mean mm", 4},
                 {"exact_p95_mm", "p95 mm", 4},
                 {"exact_force_mean_n", "force mean N", 4},
                 {"images_mean_mm", "images, mean mm", 3},
                 {"images_p95_mm", "p95 mm", 3},
                 {"images_force_mean_n", "force mean N", 4}};
  const std::vector<Known> known = known_distances(setting);
  const auto like = opened(setting.work / kFieldPackage);
  const auto force = [&](const Ask& ask) {
    const assess::TrueForces& truth = setting.truth.forces;
    return assess::force_errors(
               {touch_of(ask, like, truth.stiffness_n_per_m), setting.workspace_from_lps, rr_s},
               truth)
        .mean_n;
  };
  for (std::size_t n = 0; n < candidates.size(); ++n) {
    const Candidate& each = candidates[n];
    const std::vector<double>& clock = medians[n];
    const DistanceErrors exact = errors_of(each.exact_sample, known);
    const DistanceErrors images = errors_of(each.sample, known);
    out.rows.push_back(
        {each.name,
         {each.memory_mb, each.disk_mb, each.disk_zstd_mb, clock[0],
          each.load_zstd ? clock[1] : clock[0], clock[2], clock[3], exact.mean_mm, exact.p95_mm,
          force(each.exact_sample), images.mean_mm, images.p95_mm, force(each.sample)}});
  }
  return out;
}

}  // namespace beatlas::bench
