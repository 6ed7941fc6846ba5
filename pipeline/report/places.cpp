#include "pipeline/report/places.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace beatlas::report {
namespace {

struct Uncertain {
  Vec3 lps_mm;
  float sigma_mm;
};

std::vector<Uncertain> worse_than(const std::vector<BoundaryPoint>& points, const Grid& grid,
                                  double sigma_mm) {
  std::vector<Uncertain> out;
  for (const BoundaryPoint& point : points) {
    if (point.sigma_mm <= sigma_mm) continue;
    const auto v = static_cast<int>(point.voxel);
    const int i = v % grid.size[0];
    const int j = v / grid.size[0] % grid.size[1];
    const int k = v / (grid.size[0] * grid.size[1]);
    out.push_back({grid.mm(i, j, k), point.sigma_mm});
  }
  return out;
}

std::string title_of(const LeakAlarm& alarm) {
  switch (alarm.kind) {
    case LeakKind::VolumeJump:
      return (alarm.sign > 0 ? "Too much volume in phase " : "Volume missing in phase ") +
             std::to_string(alarm.phase);
    case LeakKind::OpenCycle:
      return "Beat does not close";
    case LeakKind::ImageBorder:
      return "Runs along the image's border";
    case LeakKind::Air:
      return "Holds lung or air";
    case LeakKind::StillTissue:
      return "Follows what does not beat";
    case LeakKind::NoEdge:
      return "No edge in the image";
  }
  return "";
}

}  // namespace

std::string structure_words(Structure structure) {
  switch (structure) {
    case Structure::Heart:
      return "the heart's outside";
    case Structure::LvBlood:
      return "the left ventricle's blood";
    case Structure::RvBlood:
      return "the right ventricle's blood";
    case Structure::LvMyocardium:
      return "the left ventricle's muscle";
    case Structure::LaBlood:
      return "the left atrium's blood";
    case Structure::RaBlood:
      return "the right atrium's blood";
    case Structure::Aorta:
      return "the aorta's lumen";
  }
  return "";
}

std::vector<Place> leak_places(const Segmentation& segmentation) {
  std::vector<Place> out;
  for (const LeakAlarm& alarm : segmentation.alarms) {
    out.push_back({Place::Kind::Leak, alarm.structure, alarm.phase, alarm.lps_mm,
                   title_of(alarm) + ": " + structure_words(alarm.structure), alarm.sentence,
                   std::string(leak_kind_name(alarm.kind)), alarm.figure, alarm.limit,
                   alarm.seeds});
  }
  return out;
}

std::vector<Place> uncertain_places(const BoundaryUncertainty& uncertainty, const Grid& grid,
                                    const std::vector<Place>& leaks,
                                    const UncertainOptions& options) {
  std::vector<Place> out;
  const Vec3 spacing = grid.spacing_mm();
  // A voxel that the boundary crosses stands for about this much of it.
  const double point_mm2 = spacing[2] * std::sqrt(spacing[0] * spacing[1]);
  for (const auto& [structure, phases] : uncertainty) {
    std::size_t worst = 0;
    std::vector<Uncertain> points;
    for (std::size_t p = 0; p < phases.size(); ++p) {
      std::vector<Uncertain> here = worse_than(phases[p], grid, options.sigma_mm);
      if (here.size() <= points.size()) continue;
      worst = p;
      points = std::move(here);
    }
    for (int found = 0; found < options.most; ++found) {
      // The place with the most uncertain boundary around it.
      std::size_t best = 0;
      std::size_t most = 0;
      const auto around = [&](std::size_t at) {
        return static_cast<std::size_t>(
            std::count_if(points.begin(), points.end(), [&](const Uncertain& other) {
              return (other.lps_mm - points[at].lps_mm).norm() < options.apart_mm / 2;
            }));
      };
      const std::size_t step = 1 + points.size() / 1000;
      for (std::size_t at = 0; at < points.size(); at += step) {
        const std::size_t count = around(at);
        if (count > most) {
          most = count;
          best = at;
        }
      }
      const double area_mm2 = static_cast<double>(most) * point_mm2;
      if (most == 0 || area_mm2 < options.smallest_mm2) break;
      const Vec3 centre = points[best].lps_mm;
      const auto is_near = [&](const Vec3& x) { return (x - centre).norm() < options.apart_mm; };
      const bool told = std::any_of(leaks.begin(), leaks.end(),
                                    [&](const Place& leak) { return is_near(leak.lps_mm); });
      if (!told) {
        char text[256];
        std::snprintf(text, sizeof text,
                      "within %.0f mm, %.0f mm2 of %s are known no better than %.1f mm (standard "
                      "deviation); compare outline and image, and correct it if it is wrong",
                      options.apart_mm / 2, area_mm2, structure_words(structure).c_str(),
                      options.sigma_mm);
        std::string title("Uncertain: ");
        title += structure_words(structure);
        out.push_back({Place::Kind::Uncertain, structure, static_cast<int>(worst), centre,
                       std::move(title), text});
      }
      std::erase_if(points, [&](const Uncertain& point) { return is_near(point.lps_mm); });
    }
  }
  return out;
}

double uncertain_percent(const BoundaryUncertainty& uncertainty, Structure structure,
                         double sigma_mm) {
  const auto found = uncertainty.find(structure);
  if (found == uncertainty.end()) return 0;
  std::size_t all = 0;
  std::size_t worse = 0;
  for (const std::vector<BoundaryPoint>& phase : found->second) {
    all += phase.size();
    worse += static_cast<std::size_t>(
        std::count_if(phase.begin(), phase.end(),
                      [&](const BoundaryPoint& point) { return point.sigma_mm > sigma_mm; }));
  }
  return all == 0 ? 0 : 100 * static_cast<double>(worse) / static_cast<double>(all);
}

}  // namespace beatlas::report
