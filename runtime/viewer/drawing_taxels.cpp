#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "runtime/viewer/drawing_parts.h"
#include "runtime/viewer/drawing_patches.h"

namespace beatlas::viewer {
namespace {

// Pixels of a picture of 800 x 600.
constexpr double kTaxelSidePx = 110;
constexpr double kTaxelMarginPx = 18;
constexpr Rgb kUntouched{46, 48, 54};

}  // namespace

void HeartDrawing::Parts::make_taxels() {
  taxels.patches = vtkSmartPointer<vtkPolyData>::New();
  taxels.actor = patches_actor(*renderer, *taxels.patches);
  taxels.text = text_actor(*renderer, 15);
  taxels.text->VisibilityOff();
}

void HeartDrawing::Parts::update_taxels() {
  constexpr int kSide = haptics::TaxelMap::kSide;
  const bool roomy = options.caption && width >= 320 && height >= 240;
  const bool shown = roomy && tool && tool->touching && tool->taxels.area_mm2 > 0;
  taxels.actor->SetVisibility(shown ? 1 : 0);
  taxels.text->SetVisibility(shown ? 1 : 0);
  if (!shown) return;
  const haptics::TaxelMap& map = tool->taxels;
  const double grown = text_scale();
  const double side = std::min(0.2 * std::min(width, height), kTaxelSidePx * grown);
  // Beside the marker of the body's axes.
  const Vec2 low(marker_px() + grown * kTaxelMarginPx, grown * kTaxelMarginPx);
  const double pitch = side / kSide;
  const float most = *std::max_element(map.pressure_kpa.begin(), map.pressure_kpa.end());
  Patches patches;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const float kpa = map.pressure_kpa[static_cast<std::size_t>(row * kSide + column)];
      const Vec2 corner = low + pitch * Vec2(column, row);
      patches.add_box(corner, corner + Vec2::Constant(pitch - grown),
                      kpa > 0 ? colour_of_share(static_cast<double>(kpa / most)) : kUntouched);
    }
  }
  patches.give_to(*taxels.patches);
  std::array<char, 64> words{};
  std::snprintf(words.data(), words.size(), "%.1f kPa  %.0f mm\u00b2", map.peak_kpa, map.area_mm2);
  taxels.text->SetInput(words.data());
  taxels.text->GetTextProperty()->SetFontSize(font_size(grown * 15));
  taxels.text->SetDisplayPosition(static_cast<int>(std::lround(low.x())),
                                  static_cast<int>(std::lround(low.y() + side + 5 * grown)));
}

}  // namespace beatlas::viewer
