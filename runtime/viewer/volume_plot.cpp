#include "runtime/viewer/volume_plot.h"

#include <string>
#include <utility>

#include "runtime/atlas/structure_colours.h"

namespace beatlas::viewer {
namespace {

/// As the legend names a curve; empty: it does not.
const char* name_of_curve(Structure structure) {
  switch (structure) {
    case Structure::LvBlood:
      return "LV";
    case Structure::RvBlood:
      return "RV";
    case Structure::LaBlood:
      return "LA";
    case Structure::RaBlood:
      return "RA";
    case Structure::LvMyocardium:
      return "LV muscle";
    default:
      return "";
  }
}

}  // namespace

Panel volume_panel(const atlas::Manifest& manifest) {
  Panel panel{.title = "Volume [ml]", .x_title = "Time [s]", .curves = {}, .from_zero = true};
  for (const atlas::StructureEntry& entry : manifest.structures) {
    const auto structure = structure_from_name(entry.name);
    if (!structure || entry.volume_ml.empty() || *structure == Structure::Heart) continue;
    const Colour colour = structure_colour(*structure);
    // A vessel is cut somewhere by what is in view: its volume says nothing.
    if (*structure == Structure::Aorta) continue;
    Curve line{.name = name_of_curve(*structure),
               .colour = QColor(colour[0], colour[1], colour[2]),
               .x = {},
               .y = {}};
    const std::size_t phases = entry.volume_ml.size();
    for (std::size_t n = 0; n <= phases; ++n) {
      line.x.push_back(manifest.rr_interval_s * static_cast<double>(n) /
                       static_cast<double>(phases));
      line.y.push_back(entry.volume_ml[n % phases]);
    }
    panel.curves.push_back(std::move(line));
  }
  return panel;
}

}  // namespace beatlas::viewer
