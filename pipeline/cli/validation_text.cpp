#include "pipeline/cli/validation_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace beatlas::cli {
namespace {

template <class Errors>
double mean(const std::vector<Errors>& phases, double Errors::*member) {
  double sum = 0;
  for (const Errors& phase : phases) sum += phase.*member;
  return phases.empty() ? 0 : sum / static_cast<double>(phases.size());
}

/// Of the largest magnitude, with its sign.
template <class Errors>
double worst(const std::vector<Errors>& phases, double Errors::*member) {
  double out = 0;
  for (const Errors& phase : phases) {
    if (std::abs(phase.*member) > std::abs(out)) out = phase.*member;
  }
  return out;
}

template <class... Values>
std::string line(const char* format, Values... values) {
  char text[200];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string shapes(const assess::ValidationReport& report) {
  using assess::PhaseErrors;
  std::string text =
      "structure       Dice, least  mean mm   RMS mm   p95 mm  Hausdorff mm  bias mm  volume "
      "error\n";
  for (const assess::StructureErrors& entry : report.structures) {
    double dice = 1;
    for (const PhaseErrors& phase : entry.phases) dice = std::min(dice, phase.dice);
    text += line(
        "%-15s %11.4f %8.3f %8.3f %8.3f %13.3f %+8.3f %+6.2f ml %+5.1f %%\n",
        structure_name(entry.structure).data(), dice, mean(entry.phases, &PhaseErrors::mean_mm),
        worst(entry.phases, &PhaseErrors::rms_mm), worst(entry.phases, &PhaseErrors::p95_mm),
        worst(entry.phases, &PhaseErrors::hausdorff_mm), mean(entry.phases, &PhaseErrors::bias_mm),
        worst(entry.phases, &PhaseErrors::volume_error_ml),
        worst(entry.phases, &PhaseErrors::volume_error_percent));
  }
  return text;
}

/// What has a surface alone, in the columns of `shapes`.
std::string drawn_alone(const assess::ValidationReport& report) {
  using assess::DrawnErrors;
  std::string text;
  for (const assess::DrawnStructure& entry : report.drawn) {
    const std::string name(structure_name(entry.structure));
    if (entry.phases.empty()) {
      text += name + ": the truth has none\n";
      continue;
    }
    text += line(
        "%-15s %11s %8.3f %8.3f %8.3f %13.3f %+8.3f %+6.2f ml %+5.1f %%\n", name.c_str(), "surface",
        mean(entry.phases, &DrawnErrors::mean_mm), worst(entry.phases, &DrawnErrors::rms_mm),
        worst(entry.phases, &DrawnErrors::p95_mm), worst(entry.phases, &DrawnErrors::hausdorff_mm),
        mean(entry.phases, &DrawnErrors::bias_mm),
        worst(entry.phases, &DrawnErrors::volume_error_ml),
        worst(entry.phases, &DrawnErrors::volume_error_percent));
  }
  for (const assess::DrawnStructure& entry : report.drawn) {
    if (!entry.band_percent) continue;
    text += line(
        "%s: %.0f %% of the surface lies as near the true one as its band tells (90 %% are "
        "meant)\n",
        structure_name(entry.structure).data(), *entry.band_percent);
  }
  return text;
}

std::string motions(const assess::ValidationReport& report) {
  using assess::PhaseErrors;
  std::string text = "structure       normal, mean deg  p95 deg   velocity, mean mm/s  p95 mm/s\n";
  for (const assess::StructureErrors& entry : report.structures) {
    text += line("%-15s %16.2f %8.2f %21.2f %9.2f\n", structure_name(entry.structure).data(),
                 mean(entry.phases, &PhaseErrors::normal_mean_deg),
                 worst(entry.phases, &PhaseErrors::normal_p95_deg),
                 mean(entry.phases, &PhaseErrors::velocity_mean_mm_s),
                 worst(entry.phases, &PhaseErrors::velocity_p95_mm_s));
  }
  return text;
}

std::string walls(const assess::ValidationReport& report) {
  using assess::ThicknessErrors;
  std::string text;
  for (const assess::StructureErrors& entry : report.structures) {
    if (entry.wall_thickness.empty()) continue;
    int missing = 0;
    for (const ThicknessErrors& wall : entry.wall_thickness) missing += wall.missing;
    text += line("wall of the LV: thickness error mean %.3f, p95 %.3f, bias %+.3f mm",
                 mean(entry.wall_thickness, &ThicknessErrors::mean_mm),
                 worst(entry.wall_thickness, &ThicknessErrors::p95_mm),
                 mean(entry.wall_thickness, &ThicknessErrors::bias_mm));
    text += missing > 0 ? line("; %d rays found no wall\n", missing) : "\n";
  }
  return text;
}

std::string maps(const assess::ValidationReport& report) {
  std::string text;
  for (const assess::StructureErrors& entry : report.structures) {
    if (!entry.map) continue;
    if (text.empty()) {
      text =
          "map             thickness error, mean mm  p95 mm  bias mm  none where a wall is  right "
          "segment\n";
    }
    const assess::MapErrors& map = *entry.map;
    text += line("%-15s %24.3f %7.3f %+8.3f %15d / %-4d", structure_name(entry.structure).data(),
                 map.thickness_mean_mm, map.thickness_p95_mm, map.thickness_bias_mm, map.missing,
                 map.points + map.missing);
    text += map.named > 0 ? line(" %11.1f %%\n", map.segments_percent) : "\n";
  }
  return text;
}

std::string muscle(const assess::ValidationReport& report) {
  std::string text;
  for (const assess::StructureErrors& entry : report.structures) {
    if (!entry.motion) continue;
    if (text.empty()) {
      text =
          "structure       off its muscle, mean mm  p95 mm   along it, mean mm  of normal-only\n";
    }
    const assess::MotionErrors& motion = *entry.motion;
    text += line("%-15s %23.2f %7.2f %19.2f %13.0f %%\n", structure_name(entry.structure).data(),
                 motion.mean_mm, motion.p95_mm, motion.tangential_mean_mm,
                 100 * motion.tangential_share);
  }
  return text;
}

std::string force(const assess::FeltErrors& felt) {
  const assess::ForceErrors& errors = felt.errors;
  return line("force of %s, K %g N/m, %d palpations, %d of %d ticks in contact:\n",
              structure_name(felt.structure).data(), felt.stiffness_n_per_m, errors.trajectories,
              errors.contact_ticks, errors.ticks) +
         line("  error mean %.4f, RMS %.4f, p95 %.4f, largest %.4f N\n", errors.mean_n,
              errors.rms_n, errors.p95_n, errors.max_n) +
         line("  over the just noticeable difference: mean %.2f, p95 %.2f, largest %.1f\n",
              errors.mean_jnd, errors.p95_jnd, errors.max_jnd) +
         line(
             "  contact differs in %d ticks (%.2f %%); largest jump in a tick %.4f N, true %.4f "
             "N\n",
             errors.contact_differs_ticks, errors.contact_differs_percent, errors.max_jump_n,
             errors.true_max_jump_n);
}

}  // namespace

std::string validation_to_text(const assess::ValidationReport& report) {
  std::string text = shapes(report) + drawn_alone(report);
  if (!report.structures.empty()) {
    text += '\n';
    text += motions(report) + walls(report) + maps(report) + muscle(report);
  }
  text += "means and biases are means over the phases, the others the worst phase\n";
  if (report.force) {
    text += '\n';
    text += force(*report.force);
  }
  for (const std::string& failure : report.failures) text += "FAILED " + failure + "\n";
  if (const assess::PromiseSet* promises = assess::promise_set(report.held_to)) {
    text += line("held to %g times what is promised of what is made from %s (--limits %s)\n",
                 assess::kPromiseMargin, promises->made_from.data(), promises->name.data());
  }
  return text + (report.passed ? "passed\n" : "not passed\n");
}

std::string vertices_to_csv(const assess::ValidationReport& report) {
  std::string text = "structure,phase,x_mm,y_mm,z_mm,nx,ny,nz,area_mm2,off_mm\n";
  for (const assess::DrawnStructure& drawn : report.drawn) {
    const std::string name(structure_name(drawn.structure));
    for (const auto& [phase, vertices] : drawn.vertices) {
      for (const assess::VertexError& vertex : vertices) {
        const auto& [place, normal, area_mm2, off_mm] = vertex;
        text +=
            line("%s,%d,%.3f,%.3f,%.3f,%.4f,%.4f,%.4f,%.3f,%.4f\n", name.c_str(), phase, place.x(),
                 place.y(), place.z(), normal.x(), normal.y(), normal.z(), area_mm2, off_mm);
      }
    }
  }
  return text;
}

}  // namespace beatlas::cli
