// The integrator of the muscle patch beside what a trainer might take instead, and the cost of a
// tick. `palpation_bench [FOLDER]` prints Markdown; with a folder it writes integrators.svg and
// integrators.csv there. Thread CPU time; read ratios within one run.
//
// The case: the middle of paper B's Table 1 with its mass of 1.14 g, pushed with a force that is
// straight between corners 50 ms apart. Error: the largest of the dent at the corners, over the
// largest dent, against the closed form in long double.

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "runtime/app/text.h"
#include "runtime/palpation/oscillator.h"
#include "runtime/palpation/trainer.h"
#include "runtime/plot/plot.h"

namespace beatlas::palpation {
namespace {

constexpr double kMass = 1.14e-3, kDamping = 60, kStiffness = 75;
constexpr double kCornerS = 0.05;

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::vector<double> corners() {
  std::vector<double> out{0};
  for (int n = 1; n <= 40; ++n) out.push_back(0.3 + 0.3 * std::sin(2.1 * n) * (n % 7 != 0));
  return out;
}

// One step of m y'' + c y' + k y = f; force at both ends.
using Method = std::function<Motion(const Motion&, double from_n, double to_n, double h)>;

Motion explicit_euler(const Motion& s, double from, double /*to*/, double h) {
  const double a = (from - kDamping * s.speed_m_s - kStiffness * s.place_m) / kMass;
  return {s.place_m + h * s.speed_m_s, s.speed_m_s + h * a};
}

// Speed first, then the place by the new speed: what games do.
Motion half_explicit_euler(const Motion& s, double from, double /*to*/, double h) {
  const double a = (from - kDamping * s.speed_m_s - kStiffness * s.place_m) / kMass;
  const double speed = s.speed_m_s + h * a;
  return {s.place_m + h * speed, speed};
}

Motion backward_euler(const Motion& s, double /*from*/, double to, double h) {
  const double speed = (kMass * s.speed_m_s + h * (to - kStiffness * s.place_m)) /
                       (kMass + h * kDamping + h * h * kStiffness);
  return {s.place_m + h * speed, speed};
}

Motion implicit_midpoint(const Motion& s, double from, double to, double h) {
  const double half = 0.5 * h;
  const double middle =
      (kMass * s.speed_m_s + half * (0.5 * (from + to) - kStiffness * s.place_m)) /
      (kMass + half * kDamping + half * half * kStiffness);
  return {s.place_m + h * middle, 2 * middle - s.speed_m_s};
}

struct Named {
  std::string name;
  Method method;
};

// Dents at the corners by the closed form, from corner to corner.
std::vector<double> exact(const std::vector<double>& force) {
  using Complex = std::complex<long double>;
  const long double m = kMass, c = kDamping, k = kStiffness, t = kCornerS;
  const Complex root = std::sqrt(Complex(c * c - 4 * k * m));
  const Complex s1 = -(c + root) / (2 * m);
  const Complex s2 = k / (m * s1);
  long double y = 0;
  long double v = 0;
  std::vector<double> out;
  for (std::size_t n = 1; n < force.size(); ++n) {
    const long double rate = (force[n] - force[n - 1]) / t;
    const long double p0 = (force[n - 1] - c * rate / k) / k;
    const long double p1 = rate / k;
    const Complex b = ((v - p1) - s1 * (y - p0)) / (s2 - s1);
    const Complex a = (y - p0) - b;
    y = p0 + p1 * t + (a * std::exp(s1 * t) + b * std::exp(s2 * t)).real();
    v = p1 + (s1 * a * std::exp(s1 * t) + s2 * b * std::exp(s2 * t)).real();
    out.push_back(static_cast<double>(y));
  }
  return out;
}

struct Outcome {
  double error = 0;    // INFINITY: it blew up
  double cost_us = 0;  // a simulated second
};

Outcome run(const Method& method, int parts) {
  const std::vector<double> force = corners();
  const std::vector<double> truth = exact(force);
  const double h = kCornerS / parts;
  Outcome out;
  double largest = 0;
  for (const double y : truth) largest = std::max(largest, std::abs(y));
  const int repeats = std::max(1, 20000 / parts / 40);
  const double begin = cpu_s();
  for (int repeat = 0; repeat < repeats; ++repeat) {
    Motion motion;
    for (std::size_t n = 1; n < force.size(); ++n) {
      const double rise = (force[n] - force[n - 1]) / parts;
      for (int part = 0; part < parts; ++part) {
        const double from = force[n - 1] + rise * part;
        motion = method(motion, from, from + rise, h);
      }
      if (repeat > 0) continue;
      const double error = std::abs(motion.place_m - truth[n - 1]) / largest;
      out.error = std::isfinite(error) ? std::max(out.error, error) : INFINITY;
    }
  }
  out.cost_us = 1e6 * (cpu_s() - begin) / repeats / (kCornerS * static_cast<double>(truth.size()));
  if (!(out.error < 1e3)) out.error = INFINITY;
  return out;
}

std::string shown(double error) {
  if (!std::isfinite(error)) return "blows up";
  char text[32];
  std::snprintf(text, sizeof text, "%.1e", error);
  return text;
}

void integrators(const std::string& folder) {
  double step_of_kept = -1;
  OscillatorStep kept;
  const std::vector<Named> methods{
      {"explicit Euler", explicit_euler},
      {"half-explicit Euler", half_explicit_euler},
      {"backward Euler", backward_euler},
      {"implicit midpoint", implicit_midpoint},
      {"exponential (ours)",
       [&](const Motion& s, double from, double to, double h) {
         if (h != step_of_kept) {
           kept = OscillatorStep({kMass, kDamping, kStiffness}, h);
           step_of_kept = h;
         }
         return kept.advance(s, from, (to - from) / h);
       }},
      {"exponential, every step anew", [](const Motion& s, double from, double to, double h) {
         return OscillatorStep({kMass, kDamping, kStiffness}, h).advance(s, from, (to - from) / h);
       }}};
  const std::vector<int> parts{10000, 5000, 2000, 1000, 500, 200, 100, 50, 20, 10, 5, 1};
  plot::Plot by_step{
      .title = "Muscle patch, Table 1 middle, 1.14 g: error against step (at the top: it blows up)",
      .x_title = "step [ms]",
      .y_title = "largest error of the dent / dent",
      .series = {},
      .log_x = true,
      .log_y = true};
  plot::Plot by_cost = by_step;
  by_cost.title = "Error against cost";
  by_cost.x_title = "CPU time a simulated second [us]";
  std::string csv = "method,step_ms,error,cost_us_per_s\n";
  std::printf("| step ms |");
  for (const Named& m : methods) std::printf(" %s |", m.name.c_str());
  std::printf("\n|---|");
  for (std::size_t n = 0; n < methods.size(); ++n) std::printf("---|");
  std::printf("\n");
  for (const Named& m : methods) {
    by_step.series.push_back({.name = m.name, .x = {}, .y = {}, .dots = true});
    by_cost.series.push_back({.name = m.name, .x = {}, .y = {}, .dots = true});
  }
  for (const int part : parts) {
    const double step_ms = 1e3 * kCornerS / part;
    std::printf("| %g |", step_ms);
    for (std::size_t n = 0; n < methods.size(); ++n) {
      const Outcome outcome = run(methods[n].method, part);
      std::printf(" %s, %.1f us |", shown(outcome.error).c_str(), outcome.cost_us);
      csv += methods[n].name + ",";
      app::append_number(csv, step_ms);
      csv += "," + (std::isfinite(outcome.error) ? shown(outcome.error) : std::string("inf")) + ",";
      app::append_number(csv, outcome.cost_us);
      csv += "\n";
      // What blew up is drawn at the top.
      const double drawn = std::isfinite(outcome.error) ? std::max(outcome.error, 1e-17) : 1e3;
      by_step.series[n].x.push_back(step_ms);
      by_step.series[n].y.push_back(drawn);
      by_cost.series[n].x.push_back(outcome.cost_us);
      by_cost.series[n].y.push_back(drawn);
    }
    std::printf("\n");
  }
  if (folder.empty()) return;
  std::filesystem::create_directories(folder);
  app::write_file(std::filesystem::path(folder) / "integrators.svg",
                  plot::plots_svg({by_step, by_cost}));
  app::write_file(std::filesystem::path(folder) / "integrators.csv", csv);
}

// What the patch feels like where its stiffness beats: made anew each step, against tiny steps.
void beating_stiffness() {
  const auto dents = [](int parts) {
    VerticalPatch patch({});
    const ElastanceCurve curve(60.0 / 110, 32.4);
    const Contractile contractile;
    std::vector<double> out;
    for (int n = 0; n < 1000; ++n) {
      for (int part = 1; part <= parts; ++part) {
        const double t = 1e-2 * (n + static_cast<double>(part) / parts);
        const double middle = t - 0.5e-2 / parts;
        const double e = curve.at(std::fmod(middle, 60.0 / 110)).value;
        patch.advance(0.004 - 0.004 * std::cos(2 * M_PI * t),
                      75 + contractile.stiffness_n_per_m(1, 7.3, 0.19 + 4.31 * e), 1e-2 / parts);
      }
      out.push_back(patch.dent_m());
    }
    return out;
  };
  const std::vector<double> truth = dents(1000);
  std::printf("\nK_v + K_e(t), re-exponentiated: largest error of the dent [um]\n");
  for (const int parts : {1, 2, 5, 10, 20, 100}) {
    double worst = 0;
    const std::vector<double> tried = dents(parts);
    for (std::size_t n = 0; n < truth.size(); ++n) {
      worst = std::max(worst, std::abs(tried[n] - truth[n]));
    }
    std::printf("- step %g ms: %.2e\n", 10.0 / parts, 1e6 * worst);
  }
}

void ticks(std::size_t fingers, const char* name) {
  PalpationParameters parameters;
  Trainer trainer(parameters, fingers);
  std::vector<Finger> hand(fingers);
  for (std::size_t n = 0; n < fingers; ++n) {
    hand[n] = {
        .place_mm = Vec3(18.0 * static_cast<double>(n), 0, 0), .long_axis = 0.5, .segment = 7};
  }
  constexpr int kTicks = 2000000;
  std::vector<float> times_us;
  times_us.reserve(kTicks / 4);
  double total_s = 0;
  for (int block = 0; block < 2; ++block) {  // as a whole, then tick by tick
    const double begin = cpu_s();
    for (int n = 0; n < kTicks / (block == 0 ? 1 : 4); ++n) {
      const double depth = 0.004 - 0.004 * std::cos(2 * M_PI * 1.5e-3 * n);
      for (Finger& finger : hand) finger.depth_m = depth;
      const double from = block == 1 ? cpu_s() : 0;
      trainer.tick(1e-3, hand);
      if (block == 1) times_us.push_back(static_cast<float>(1e6 * (cpu_s() - from)));
    }
    if (block == 0) total_s = cpu_s() - begin;
  }
  std::vector<float> clock_us;
  for (int n = 0; n < 100000; ++n) {
    const double from = cpu_s();
    clock_us.push_back(static_cast<float>(1e6 * (cpu_s() - from)));
  }
  std::sort(clock_us.begin(), clock_us.end());
  std::sort(times_us.begin(), times_us.end());
  const float clock = clock_us[clock_us.size() / 2];
  const auto at = [&](double share) {
    return static_cast<double>(
        times_us[static_cast<std::size_t>(share * static_cast<double>(times_us.size() - 1))] -
        clock);
  };
  std::printf("| %s | %.3f | %.3f | %.3f | %.3f | %.1f |\n", name, 1e6 * total_s / kTicks, at(0.5),
              at(0.99), at(0.999), at(1));
}

}  // namespace
}  // namespace beatlas::palpation

int main(int argc, char** argv) {
  using namespace beatlas::palpation;
  integrators(argc > 1 ? argv[1] : "");
  beating_stiffness();
  std::printf("\n| tick of patch and circulation | mean us | p50 | p99 | p99.9 | largest |\n");
  std::printf("|---|---|---|---|---|---|\n");
  ticks(1, "one finger");
  ticks(5, "five fingers");
  return 0;
}
