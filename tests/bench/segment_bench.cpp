/// segment_bench [--preset NAME] [--whole] [--snr X] [--bias X]: time and memory of a segmentation,
/// of another one after a stroke, and the error of each option against the time it takes, on a
/// phantom. Markdown.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/imgproc.hpp>

#include "pipeline/cli/bench_probe.h"
#include "pipeline/core/segmented_volume.h"
#include "pipeline/motion/acquisition_faults.h"
#include "pipeline/phantom/acquisition.h"
#include "pipeline/phantom/render.h"
#include "pipeline/segment/segment.h"
#include "runtime/base/error.h"
#include "tests/learned.h"

namespace beatlas::bench {
namespace {

struct Scene {
  phantom::Phantom phantom;
  Exam exam;
  LabelCycle truth;
  prior::PriorCycle prior = {};
};

struct Words {
  std::string preset = "small";
  bool whole = false;
  bool solves_only = false;
  bool defaults_only = false;
  std::optional<double> snr;
  std::optional<double> bias;
};

Scene scene_of(const Words& words) {
  phantom::PhantomSpec spec = phantom::preset(words.preset);
  if (!words.whole) spec.anatomy = phantom::ventricles_alone(spec.anatomy);
  if (words.snr) {
    const bool none = *words.snr == 0;
    spec.scanner.snr_blood = none ? std::numeric_limits<double>::infinity() : *words.snr;
  }
  if (words.bias) spec.scanner.bias_share = *words.bias;
  phantom::check_spec(spec);
  Scene out{phantom::Phantom(spec), {}, {}};
  StageContext quiet;
  phantom::Rendering rendering = phantom::render(out.phantom, quiet);
  out.exam.stack = std::move(rendering.cine);
  out.exam = motion::without_acquisition_faults(std::move(out.exam), {});  // as import does
  out.truth = std::move(rendering.labels);
  out.prior = test::learned(out.exam);
  return out;
}

/// Of all threads [s].
double process_cpu_s() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct Run {
  Segmentation result;
  double wall_s = 0;
  double cpu_s = 0;
  double memory_mb = 0;
};

Run run_of(const Scene& scene, const std::vector<segment::Seed>& seeds,
           const segment::SegmentOptions& options) {
  StageContext quiet;
  Run out;
  const cli::MemoryMeter meter;
  const double wall_s = cli::wall_clock_s();
  const double cpu_s = process_cpu_s();
  out.result = segment::segment_exam(scene.exam, seeds, options, quiet, {}, &scene.prior);
  out.wall_s = cli::wall_clock_s() - wall_s;
  out.cpu_s = process_cpu_s() - cpu_s;
  out.memory_mb = meter.added_mb().value_or(0);
  return out;
}

double dice(const Scene& scene, const Segmentation& result, Structure structure, std::size_t p) {
  double both = 0;
  double sum = 0;
  for (std::size_t v = 0; v < scene.truth.phases[p].size(); ++v) {
    const bool a = label_in_structure(scene.truth.phases[p][v], structure);
    const bool b = label_in_structure(result.labels.phases[p][v], structure);
    both += a && b ? 1 : 0;
    sum += (a ? 1 : 0) + (b ? 1 : 0);
  }
  return sum > 0 ? 2 * both / sum : 1;
}

double least_dice(const Scene& scene, const Segmentation& result, Structure structure) {
  double least = 1;
  for (std::size_t p = 0; p < scene.truth.phases.size(); ++p) {
    least = std::min(least, dice(scene, result, structure, p));
  }
  return least;
}

/// About `count` points of a structure's outline in slices: coverage of a half, along rows.
std::vector<Vec3> outline(const CoverageCycle& coverage, Structure structure, std::size_t phase,
                          std::size_t count) {
  const Grid& grid = coverage.grid;
  const std::vector<float>& image = coverage.phases.at(structure)[phase];
  std::vector<Vec3> points;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i + 1 < grid.size[0]; ++i) {
        const double here = image[grid.offset(i, j, k)] - 0.5;
        const double next = image[grid.offset(i + 1, j, k)] - 0.5;
        if ((here < 0) != (next < 0)) points.push_back(grid.mm(i + here / (here - next), j, k));
      }
    }
  }
  const std::size_t step = std::max<std::size_t>(1, points.size() / count);
  std::vector<Vec3> some;
  for (std::size_t at = 0; at < points.size(); at += step) some.push_back(points[at]);
  return some;
}

struct Errors {
  double mean = 0;
  double p95 = 0;
  double worst_mean = 0;  ///< of the phases
  double worst_p95 = 0;
};

Errors summary(std::vector<double> errors) {
  if (errors.empty()) return {};
  std::sort(errors.begin(), errors.end());
  const double sum = std::accumulate(errors.begin(), errors.end(), 0.0);
  return {sum / static_cast<double>(errors.size()), errors[errors.size() * 95 / 100], 0, 0};
}

/// Where slices lie [mm] after their shifts were found and undone, as far as images cannot tell: a
/// shift common to all slices of the heart, and one that grows evenly from slice to slice.
class UnseenShift {
 public:
  UnseenShift(const Scene& scene, const CoverageCycle& coverage) {
    const auto slices = phantom::acquisition(scene.phantom.spec());
    const Grid& grid = coverage.grid;
    Eigen::MatrixXd left(grid.size[2], 3);
    Eigen::MatrixXd line(grid.size[2], 2);
    for (int n = 0; n < grid.size[2]; ++n) {
      const auto k = static_cast<std::size_t>(coverage.first[2]) + static_cast<std::size_t>(n);
      const auto& found = scene.exam.slice_shifts_mm;
      const Vec2 undone = found.empty() ? Vec2(0, 0) : found[k];
      const auto axis = [&](int a) { return grid.mm_from_index.linear().col(a).normalized(); };
      left.row(n) = (slices[k].shift_i_mm - undone[0]) * axis(0) +
                    (slices[k].shift_j_mm - undone[1]) * axis(1);
      line.row(n) << 1, n;
    }
    line_ = line.colPivHouseholderQr().solve(left);
  }
  /// @param k slice of the coverage's grid, fractional
  [[nodiscard]] Vec3 at(double k) const { return line_.row(0) + k * line_.row(1); }

 private:
  Eigen::MatrixXd line_;
};

/// [mm] Of the heart's outline to the closed form's surface, 2 mm and more from its creases, where
/// a distance has no meaning.
Errors outline_error(const Scene& scene, const Segmentation& result) {
  constexpr std::size_t kPointsAPhase = 6000;
  constexpr double kCreaseMm = 2;
  const UnseenShift unseen(scene, result.coverage);
  const Affine index_from_mm = result.coverage.grid.mm_from_index.inverse(Eigen::Affine);
  std::vector<double> errors;
  Errors worst;
  for (std::size_t p = 0; p < scene.truth.phases.size(); ++p) {
    const auto frame = scene.phantom.frame(scene.phantom.phase_time_s(static_cast<int>(p)));
    std::vector<double> of_phase;
    for (const Vec3& shown : outline(result.coverage, Structure::Heart, p, kPointsAPhase)) {
      const Vec3 point = shown - unseen.at((index_from_mm * shown)[2]);
      if (frame->crease_distance_mm(Structure::Heart, point) < kCreaseMm) continue;
      of_phase.push_back(std::abs(frame->nearest(Structure::Heart, point).distance_mm));
    }
    errors.insert(errors.end(), of_phase.begin(), of_phase.end());
    const Errors phase = summary(std::move(of_phase));
    worst.mean = std::max(worst.mean, phase.mean);
    worst.p95 = std::max(worst.p95, phase.p95);
  }
  Errors out = summary(std::move(errors));
  out.worst_mean = worst.mean;
  out.worst_p95 = worst.p95;
  return out;
}

/// Linear between voxels; 0 outside.
double covered(const CoverageCycle& coverage, const std::vector<float>& image, const Vec3& lps) {
  const Grid& grid = coverage.grid;
  const Vec3 at = grid.mm_from_index.inverse(Eigen::Affine) * lps;
  const std::array<int, 3> low{static_cast<int>(std::floor(at[0])),
                               static_cast<int>(std::floor(at[1])),
                               static_cast<int>(std::floor(at[2]))};
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::array<int, 3> voxel{};
    for (std::size_t a = 0; a < 3; ++a) {
      const int up = (corner >> a) & 1;
      const double part = at[static_cast<Eigen::Index>(a)] - low[a];
      voxel[a] = low[a] + up;
      weight *= up == 1 ? part : 1 - part;
    }
    if (weight == 0 || !grid.contains(voxel[0], voxel[1], voxel[2])) continue;
    sum += weight * static_cast<double>(image[grid.offset(voxel[0], voxel[1], voxel[2])]);
  }
  return sum;
}

/// [mm] Of the LV wall's thickness along the closed form's normal, from points of the cavity's
/// outline on, a wall's thickness and more below the base.
Errors wall_error(const Scene& scene, const Segmentation& result) {
  constexpr std::size_t kPointsAPhase = 200;
  constexpr double kBelowBaseMm = 10;
  constexpr double kStepMm = 0.05;
  constexpr double kMostMm = 30;
  std::vector<double> errors;
  for (std::size_t p = 0; p < scene.truth.phases.size(); ++p) {
    const auto frame = scene.phantom.frame(scene.phantom.phase_time_s(static_cast<int>(p)));
    const std::vector<float>& blood = result.coverage.phases.at(Structure::LvBlood)[p];
    const std::vector<float>& wall = result.coverage.phases.at(Structure::LvMyocardium)[p];
    for (const Vec3& point : outline(result.coverage, Structure::LvBlood, p, kPointsAPhase)) {
      if (frame->crease_distance_mm(Structure::LvBlood, point) < kBelowBaseMm) continue;
      const auto nearest = frame->nearest(Structure::LvBlood, point);
      double found = 0;
      while (found < kMostMm &&
             covered(result.coverage, blood, point + found * nearest.outward) +
                     covered(result.coverage, wall, point + found * nearest.outward) >=
                 0.5) {
        found += kStepMm;
      }
      double truth = kStepMm;
      while (truth < kMostMm &&
             frame->contains(Structure::LvMyocardium, nearest.point + truth * nearest.outward)) {
        truth += kStepMm;
      }
      errors.push_back(std::abs(found - truth));
    }
  }
  return summary(std::move(errors));
}

struct PumpError {
  double end_diastolic_percent = 0;
  double ejection_points = 0;
};

/// Of the LV: the largest volume, and the share of it that leaves.
PumpError pump_error(const Scene& scene, const Segmentation& result) {
  std::vector<double> truth;
  truth.reserve(scene.exam.stack.images.phases.size());
  for (int p = 0; p < scene.exam.stack.phase_count(); ++p) {
    truth.push_back(scene.phantom.volume_ml(Structure::LvBlood, scene.phantom.phase_time_s(p)));
  }
  const std::vector<double> found = segmented_volume_ml(result, Structure::LvBlood);
  const auto most = [](const std::vector<double>& v) {
    return *std::max_element(v.begin(), v.end());
  };
  const auto ejected = [&](const std::vector<double>& v) {
    return 100 * (1 - *std::min_element(v.begin(), v.end()) / most(v));
  };
  return {100 * (most(found) / most(truth) - 1), ejected(found) - ejected(truth)};
}

/// What a technician would mark in three slices of end-diastole: each label where it is widest, and
/// background on both sides of the heart.
std::vector<segment::Seed> seeds_in_three_slices(const Scene& scene) {
  constexpr double kBesideMm = 8;
  const Grid& grid = scene.truth.grid;
  const std::vector<std::uint8_t>& truth = scene.truth.phases[0];
  const Vec3 spacing = grid.spacing_mm();
  const double pixel_mm = std::sqrt(spacing[0] * spacing[1]);
  std::vector<int> slices;
  for (int k = 0; k < grid.size[2]; ++k) {
    const auto begin = truth.begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, k));
    const auto end = begin + static_cast<std::ptrdiff_t>(grid.slice_count());
    if (std::find(begin, end, kLabelLvBlood) != end) slices.push_back(k);
  }
  std::vector<segment::Seed> seeds;
  for (const std::size_t quarter : {1U, 2U, 3U}) {
    const int k = slices.at(slices.size() * quarter / 4);
    const cv::Mat labels(grid.size[1], grid.size[0], CV_8U,
                         const_cast<std::uint8_t*>(truth.data() + grid.offset(0, 0, k)));
    for (const std::uint8_t label : {kLabelLvBlood, kLabelRvBlood, kLabelLvMyocardium}) {
      cv::Mat within;
      cv::distanceTransform(labels == label, within, cv::DIST_L2, cv::DIST_MASK_PRECISE);
      double most_px = 0;
      cv::Point at;
      cv::minMaxLoc(within, nullptr, &most_px, nullptr, &at);
      if (most_px < 1) continue;
      seeds.push_back({label, grid.mm(at.x, at.y, k), std::min(3.0, 0.7 * most_px * pixel_mm), 0});
    }
    const cv::Rect heart = cv::boundingRect(labels != kLabelBackground);
    const double away = kBesideMm / spacing[0];
    for (const double i : {heart.x - away, heart.x + heart.width + away}) {
      seeds.push_back({kLabelBackground, grid.mm(i, heart.y + 0.5 * heart.height, k), 2, 0});
    }
  }
  return seeds;
}

/// Background across the outer wall of the middle slice, in phase 1.
segment::Seed stroke_on(const Segmentation& found) {
  const Grid& grid = found.labels.grid;
  const int k = grid.size[2] / 2;
  segment::Seed stroke;
  stroke.label = kLabelBackground;
  stroke.phase = 1;
  for (int i = grid.size[0] - 1; i >= 0; --i) {
    for (int j = 4; j + 4 < grid.size[1]; ++j) {
      if (found.labels.phases[1][grid.offset(i, j, k)] == kLabelBackground) continue;
      stroke.lps_mm = grid.mm(i - 1, j - 4, k);
      stroke.stroke_lps_mm = {grid.mm(i - 1, j + 4, k)};
      return stroke;
    }
  }
  throw_invalid("no heart was found in the middle slice");
}

void write_solves(const Scene& scene) {
  const int phases = scene.exam.stack.phase_count();
  std::cout << "## Solving, the prior apart\n\n"
               "| | wall s | CPU s | wall s a phase | memory MB |\n|---|---|---|---|---|\n";
  const auto write = [&](const char* name, const Run& run) {
    std::printf("| %s | %.2f | %.2f | %.3f | %.0f |\n", name, run.wall_s, run.cpu_s,
                run.wall_s / phases, run.memory_mb);
    std::fflush(stdout);
  };
  (void)run_of(scene, {}, {});  // warms up, not counted
  const Run first = run_of(scene, {}, {});
  write("without seeds", first);
  write("with a stroke", run_of(scene, {stroke_on(first.result)}, {}));
  std::cout << "\n";
}

void write_options(const Scene& scene, bool defaults_only) {
  std::cout
      << "## Options: error against time\n\n"
         "Least Dice of the phases; heart's outline in slices (of all phases and of the worst "
         "one,\n"
         "beside what no image tells: a shift common to the slices or growing evenly) and the LV\n"
         "wall's thickness against closed form; the LV's end-diastolic volume and ejection "
         "fraction\n"
         "against theirs.\n\n"
         "| option | CPU s | Dice heart | LV | RV | muscle | mean mm | p95 mm | worst mean mm "
         "| worst p95 mm | wall mm | EDV % | EF points |\n"
         "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  const auto write = [&](const std::string& name, const segment::SegmentOptions& options,
                         const std::vector<segment::Seed>& seeds = {}) {
    const Run run = run_of(scene, seeds, options);
    const Errors surface = outline_error(scene, run.result);
    const Errors wall = wall_error(scene, run.result);
    const PumpError pump = pump_error(scene, run.result);
    std::printf(
        "| %s | %.2f | %.3f | %.3f | %.3f | %.3f | %.2f | %.2f | %.2f | %.2f | %.2f | %+.1f | "
        "%+.1f "
        "|\n",
        name.c_str(), run.cpu_s, least_dice(scene, run.result, Structure::Heart),
        least_dice(scene, run.result, Structure::LvBlood),
        least_dice(scene, run.result, Structure::RvBlood),
        least_dice(scene, run.result, Structure::LvMyocardium), surface.mean, surface.p95,
        surface.worst_mean, surface.worst_p95, wall.mean, pump.end_diastolic_percent,
        pump.ejection_points);
    std::fflush(stdout);
  };
  write("defaults", {});
  write("seeds on three slices of one phase", {}, seeds_in_three_slices(scene));
  if (defaults_only) return;
  segment::SegmentOptions plain;
  plain.denoise = false;
  write("denoise off", plain);
  plain = {};
  plain.even_shading = false;
  write("even_shading off", plain);
  plain = {};
  plain.follow_motion = false;
  write("follow_motion off", plain);
  for (const double value : {0.0, 5.0, 10.0, 40.0}) {
    segment::SegmentOptions options;
    options.edge_cost_mm = value;
    write("edge_cost_mm " + std::to_string(static_cast<int>(value)), options);
  }
  for (const double value : {0.5, 1.0, 3.0, 5.0}) {
    segment::SegmentOptions options;
    options.outline_sigma_mm = value;
    char text[40];
    std::snprintf(text, sizeof text, "outline_sigma_mm %g", value);
    write(text, options);
  }
  std::cout << "\n";
}

int run(int argc, char** argv) {
  CLI::App app{"Time, memory and error of the segmentation of a phantom"};
  Words words;
  app.add_option("--preset", words.preset, "phantom: " + CLI::detail::join(phantom::preset_names()))
      ->capture_default_str();
  app.add_flag("--whole", words.whole, "with atria, vessels, papillary muscles and fat");
  app.add_flag("--solves-only", words.solves_only, "without the table of options");
  app.add_flag("--defaults-only", words.defaults_only, "the first two rows of that table alone");
  app.add_option("--snr", words.snr, "blood over noise, 0 = no noise; else the preset's");
  app.add_option("--bias", words.bias, "of the coil, 0.3 = 1 +- 0.3; else the preset's");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const Scene scene = scene_of(words);
  const Index3& size = scene.exam.stack.grid().size;
  std::cout << "# Segmentation, phantom " << words.preset
            << (words.whole ? "" : ", ventricles alone") << ", SNR "
            << scene.phantom.spec().scanner.snr_blood << ", bias "
            << scene.phantom.spec().scanner.bias_share << "\n"
            << scene.exam.stack.phase_count() << " phases of " << size[0] << " x " << size[1]
            << " x " << size[2] << " voxels.\n\n";
  if (!words.defaults_only) write_solves(scene);
  if (!words.solves_only) write_options(scene, words.defaults_only);
  return 0;
}

}  // namespace
}  // namespace beatlas::bench

int main(int argc, char** argv) {
  try {
    return beatlas::bench::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "segment_bench: " << error.what() << "\n";
    return 1;
  }
}
