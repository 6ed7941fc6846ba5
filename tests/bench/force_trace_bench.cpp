// The force that a finger on the LV feels, tick by tick, beside that of the closed form.
//   force_trace_bench FOLDER CLEAN.beatlas CLEAN_PHANTOM NOISY.beatlas NOISY_PHANTOM
// prints Markdown and writes force_traces.svg to FOLDER. Before the safety stage, K 150 N/m, a
// point, no friction, all over the LV: a still finger through ten beats, and ten beats of a 2 Hz
// palpation of 8 mm. Cost: thread CPU time of a model's evaluation along these paths; read ratios.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/assess/force_error.h"
#include "pipeline/assess/touch.h"
#include "pipeline/phantom/truth.h"
#include "runtime/app/text.h"
#include "runtime/atlas/atlas.h"
#include "runtime/haptics/proxy.h"
#include "runtime/plot/plot.h"

namespace beatlas {
namespace {

namespace fs = std::filesystem;

constexpr double kStiffness = 150;
constexpr double kFiveGramForceN = 0.049;
constexpr int kBeats = 10;
constexpr int kPlaces = 96;
constexpr double kCreaseBandMm = 6;  // as palpation_set at end-diastole
constexpr double kStillMm = 4;
constexpr double kPressMm = 8;
constexpr double kPressHz = 2;

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

phantom::Phantom read_phantom(const fs::path& folder) {
  std::ifstream in(folder / "truth.json");
  return phantom::phantom_from_truth(nlohmann::json::parse(in));
}

struct Place {
  Vec3 at_lps;
  Vec3 outward;
};

// Whether a finger there comes near a crease at any time of the beat. The base comes down by 14 mm
// and the RV beats beside the LV, so such places are not those of end-diastole alone.
bool meets_crease(const phantom::Phantom& phantom, const Place& place) {
  constexpr int kMoments = 30;
  for (int moment = 0; moment < kMoments; ++moment) {
    const auto frame = phantom.frame(phantom.spec().rr_interval_s * moment / kMoments);
    for (const double depth_mm : {0.0, kStillMm, kPressMm}) {
      const Vec3 finger = place.at_lps - depth_mm * place.outward;
      const Vec3 foot = frame->nearest(Structure::Heart, finger).point;
      if (frame->crease_distance_mm(Structure::Heart, foot) < kCreaseBandMm) return true;
    }
  }
  return false;
}

// Spread over what of the heart's surface has the LV's muscle 3 mm under it.
std::vector<Place> places_on_lv(const phantom::Phantom& phantom) {
  const assess::PalpationSet all =
      assess::palpation_set(phantom, {.places = kPlaces, .depth_mm = kPressMm, .cycles = 1});
  const auto frame = phantom.frame(0);
  std::vector<Place> out;
  for (const assess::Trajectory& path : all.trajectories) {
    if (path.touch != assess::Touch::Press) continue;
    const Vec3& at = path.at_lps.front();
    const Vec3 outward = frame->nearest(Structure::Heart, at).outward;
    if (frame->contains(Structure::LvMyocardium, at - 3 * outward) &&
        !meets_crease(phantom, {at, outward})) {
      out.push_back({at, outward});
    }
  }
  return out;
}

struct Paths {
  std::string name;
  assess::TrueForces truth;
};

Paths make_paths(const phantom::Phantom& phantom, const std::vector<Place>& places, bool press,
                 StageContext& context) {
  assess::PalpationSet set;
  set.structure = Structure::Heart;
  const double rr_s = phantom.spec().rr_interval_s;
  set.ticks_per_beat = static_cast<int>(std::lround(1000 * rr_s));
  set.tick_s = rr_s / set.ticks_per_beat;
  for (const Place& place : places) {
    assess::Trajectory path{press ? assess::Touch::Press : assess::Touch::Hold, {}};
    for (int tick = 0; tick < kBeats * set.ticks_per_beat; ++tick) {
      const double turn = 2 * std::numbers::pi * kPressHz * tick * set.tick_s;
      const double depth_mm = press ? 0.5 * kPressMm * (1 - std::cos(turn)) : kStillMm;
      path.at_lps.push_back(place.at_lps - depth_mm * place.outward);
    }
    set.trajectories.push_back(std::move(path));
  }
  return {press ? "2 Hz palpation of 8 mm" : "still finger, 4 mm deep",
          assess::true_forces(phantom, std::move(set), kStiffness, context)};
}

struct Model {
  std::string name;
  assess::ForceCandidate candidate;
};

std::vector<Model> models(const atlas::Atlas& package) {
  const Affine& place = package.manifest().workspace_from_lps;
  const double rr_s = package.manifest().rr_interval_s;
  const auto field =
      std::make_shared<const field::FieldQuery>(package.field(Structure::Heart), rr_s);
  const auto sampled = [&](field::SpatialMode space, field::TemporalMode time) {
    return assess::ForceCandidate{
        assess::touch_of(std::make_shared<const field::SampledQuery>(field, space, time),
                         kStiffness),
        place, rr_s};
  };
  const auto proxy = [field]() -> assess::ForceAt {
    const auto model = std::make_shared<haptics::ProxyModel>(
        std::make_shared<const haptics::AtlasField>(field),
        haptics::ProxyOptions{.stiffness_n_per_m = kStiffness});
    return [model](const Vec3& x, double t_s) { return model->evaluate(x, t_s); };
  };
  return {{"proxy on the spline (ours)", {proxy, place, rr_s}},
          {"two-step on the spline",
           assess::two_step_candidate(field, {.stiffness_n_per_m = kStiffness}, place)},
          {"trilinear, linear in time",
           sampled(field::SpatialMode::Trilinear, field::TemporalMode::Linear)},
          {"force linear between frames",
           assess::two_step_candidate(
               field, {.stiffness_n_per_m = kStiffness, .time_mode = haptics::TimeMode::Published},
               place)},
          {"nearest voxel, linear in time",
           sampled(field::SpatialMode::NearestVoxel, field::TemporalMode::Linear)}};
}

std::vector<Vec3> felt(const assess::ForceCandidate& candidate, const assess::TrueForces& truth,
                       std::size_t path, double& cost_s) {
  const std::vector<Vec3>& at = truth.set.trajectories[path].at_lps;
  const double tick_s = candidate.rr_interval_s / truth.set.ticks_per_beat;
  const Eigen::Matrix3d turn = candidate.workspace_from_lps.linear().transpose();
  std::vector<Vec3> workspace;
  for (const Vec3& x : at) workspace.push_back(candidate.workspace_from_lps * x);
  const assess::ForceAt force_at = candidate.start();
  std::vector<Vec3> out(at.size());
  const double begin = cpu_s();
  for (std::size_t tick = 0; tick < at.size(); ++tick) {
    out[tick] = force_at(workspace[tick], tick_s * static_cast<double>(tick)).force_n;
  }
  cost_s += cpu_s() - begin;
  for (Vec3& force : out) force = turn * force;
  return out;
}

struct Figures {
  double rms_n = 0;  // over ticks in contact of either
  double p95_n = 0;
  double max_n = 0;
  double tick_ns = 0;
  double median_n = 0;  // of the places: the RMS error of each, over all its ticks
  int within = 0;       // places whose error never exceeds 5 gf
};

Figures measure(const assess::ForceCandidate& candidate, const assess::TrueForces& truth) {
  const assess::ForceErrors errors = assess::force_errors(candidate, truth);
  double cost_s = 0;
  std::size_t ticks = 0;
  int within = 0;
  std::vector<double> of_places_n;
  for (std::size_t n = 0; n < truth.force_n.size(); ++n) {
    const std::vector<Vec3> found = felt(candidate, truth, n, cost_s);
    double largest_n = 0;
    double sum_n2 = 0;
    for (std::size_t tick = 0; tick < found.size(); ++tick) {
      const double error_n = (found[tick] - truth.force_n[n][tick]).norm();
      largest_n = std::max(largest_n, error_n);
      sum_n2 += error_n * error_n;
    }
    of_places_n.push_back(std::sqrt(sum_n2 / static_cast<double>(found.size())));
    within += largest_n <= kFiveGramForceN ? 1 : 0;
    ticks += found.size();
  }
  std::sort(of_places_n.begin(), of_places_n.end());
  return {errors.rms_n,
          errors.p95_n,
          errors.max_n,
          1e9 * cost_s / static_cast<double>(ticks),
          of_places_n[of_places_n.size() / 2],
          within};
}

// The path whose true force changes most.
std::size_t liveliest(const assess::TrueForces& truth) {
  std::size_t best = 0;
  double widest = -1;
  for (std::size_t n = 0; n < truth.force_n.size(); ++n) {
    double low = INFINITY;
    double high = 0;
    for (const Vec3& force : truth.force_n[n]) {
      low = std::min(low, force.norm());
      high = std::max(high, force.norm());
    }
    if (high - low > widest) {
      widest = high - low;
      best = n;
    }
  }
  return best;
}

struct Images {
  std::string name;  // "no noise", "SNR 20"
  std::vector<Model> models;
};

plot::PlotSeries sizes(const std::string& name, const std::vector<Vec3>& force, double tick_s,
                       std::size_t first, bool dashed = false) {
  plot::PlotSeries out{.name = name, .x = {}, .y = {}, .dashed = dashed};
  for (std::size_t n = first; n < force.size(); ++n) {
    out.x.push_back(static_cast<double>(n) * tick_s);
    out.y.push_back(force[n].norm());
  }
  return out;
}

void draw(const Paths& paths, const std::vector<Images>& images, std::vector<plot::Plot>& panels) {
  const assess::TrueForces& truth = paths.truth;
  const std::size_t path = liveliest(truth);
  const std::vector<Vec3>& exact = truth.force_n[path];
  const double tick_s = truth.set.tick_s;
  const std::size_t last_beats =
      exact.size() - 2 * static_cast<std::size_t>(truth.set.ticks_per_beat);
  plot::Plot force{
      .title = "LV, " + paths.name + ": the last two of ten beats, where the force changes most",
      .x_title = "time [s]",
      .y_title = "force [N]",
      .series = {}};
  plot::Plot error{.title = "Its error through all ten beats",
                   .x_title = "time [s]",
                   .y_title = "|error| [N]",
                   .series = {}};
  double cost_s = 0;
  for (const Images& image : images) {
    for (const Model* model : {&image.models.front(), &image.models.back()}) {
      const std::vector<Vec3> found = felt(model->candidate, truth, path, cost_s);
      const bool ours = model == &image.models.front();
      const std::string name = std::string(ours ? "ours" : "as published") + ", " + image.name;
      force.series.push_back(sizes(name, found, tick_s, last_beats));
      std::vector<Vec3> off(found);
      for (std::size_t n = 0; n < off.size(); ++n) off[n] -= exact[n];
      error.series.push_back(sizes(name, off, tick_s, 0));
    }
  }
  force.series.push_back(sizes("closed form", exact, tick_s, last_beats, true));
  const double end_s = static_cast<double>(exact.size()) * tick_s;
  error.series.push_back({.name = "5 gf, the least that is felt",
                          .x = {0, end_s},
                          .y = {kFiveGramForceN, kFiveGramForceN},
                          .dashed = true});
  panels.push_back(std::move(force));
  panels.push_back(std::move(error));
}

int run(const std::vector<fs::path>& words) {
  StageContext context;
  std::vector<Images> images;
  const phantom::Phantom clean = read_phantom(words[2]);
  for (std::size_t n = 1; n < words.size(); n += 2) {
    if (n > 1 && read_phantom(words[n + 1]).spec().rr_interval_s != clean.spec().rr_interval_s) {
      std::fprintf(stderr, "both phantoms must have one R-R interval\n");
      return 2;
    }
    const auto package =
        atlas::Atlas::open(words[n], {.fields = {Structure::Heart}, .surfaces = {}});
    images.push_back({n == 1 ? "no noise" : "SNR 20", models(package)});
  }
  const std::vector<Place> places = places_on_lv(clean);
  std::printf("%zu places on the LV\n\n", places.size());
  std::vector<plot::Plot> panels;
  plot::Plot front{
      .title = "Both, at the median of the places: error against cost (left and low is good)",
      .x_title = "CPU time of a tick's model [ns]",
      .y_title = "RMS error of the force [N]",
      .series = {},
      .log_x = true,
      .log_y = true};
  std::printf(
      "| path | images | model | RMS N | p95 N | largest N | median place, RMS N | places within "
      "5 gf | ns a tick |\n|---|---|---|---|---|---|---|---|---|\n");
  std::vector<std::vector<Figures>> sums(images.size());
  for (const bool press : {false, true}) {
    const Paths paths = make_paths(clean, places, press, context);
    for (std::size_t i = 0; i < images.size(); ++i) {
      sums[i].resize(images[i].models.size());
      for (std::size_t m = 0; m < images[i].models.size(); ++m) {
        const Figures figures = measure(images[i].models[m].candidate, paths.truth);
        std::printf("| %s | %s | %s | %.4f | %.4f | %.4f | %.4f | %d | %.0f |\n",
                    paths.name.c_str(), images[i].name.c_str(), images[i].models[m].name.c_str(),
                    figures.rms_n, figures.p95_n, figures.max_n, figures.median_n, figures.within,
                    figures.tick_ns);
        sums[i][m].median_n += 0.5 * figures.median_n * figures.median_n;
        sums[i][m].tick_ns += 0.5 * figures.tick_ns;
      }
    }
    draw(paths, images, panels);
  }
  for (std::size_t m = 0; m < images.front().models.size(); ++m) {
    plot::PlotSeries series{
        .name = images.front().models[m].name, .x = {}, .y = {}, .dots = true, .dashed = true};
    for (const std::vector<Figures>& of_images : sums) {
      series.x.push_back(of_images[m].tick_ns);
      series.y.push_back(std::sqrt(of_images[m].median_n));
    }
    front.series.push_back(std::move(series));
  }
  panels.push_back(std::move(front));
  fs::create_directories(words[0]);
  app::write_file(words[0] / "force_traces.svg", plot::plots_svg(panels));
  return 0;
}

}  // namespace
}  // namespace beatlas

int main(int argc, char** argv) try {
  if (argc != 6) {
    std::fprintf(
        stderr,
        "force_trace_bench FOLDER CLEAN.beatlas CLEAN_PHANTOM NOISY.beatlas NOISY_PHANTOM\n");
    return 2;
  }
  return beatlas::run({argv + 1, argv + argc});
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
