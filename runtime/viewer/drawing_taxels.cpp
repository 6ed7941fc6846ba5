#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "runtime/viewer/drawing_parts.h"
#include "runtime/viewer/drawing_patches.h"

namespace beatlas::viewer {
namespace {

// Pixels of a picture of 800 x 600.
constexpr double kTaxelSidePx = 110;
constexpr double kTaxelMarginPx = 18;
constexpr double kTaxelWordsPx = 145;
constexpr double kLeftOfScaleBar = 0.68;  // of the picture's width
constexpr Rgb kUntouched{46, 48, 54};

}  // namespace

TaxelParts HeartDrawing::Parts::make_taxels() {
  TaxelParts made;
  made.patches = vtkSmartPointer<vtkPolyData>::New();
  made.actor = patches_actor(*renderer, *made.patches);
  made.text = text_actor(*renderer, 15);
  made.text->VisibilityOff();
  return made;
}

// From beside the marker of the body's axes on, as far as the picture is wide.
void HeartDrawing::Parts::update_taxels() {
  while (taxel_parts.size() < tools.size()) taxel_parts.push_back(make_taxels());
  double left_px = marker_px() + text_scale() * kTaxelMarginPx;
  for (std::size_t n = 0; n < taxel_parts.size(); ++n) {
    left_px = std::max(left_px, update_taxels(n, left_px));
  }
}

double HeartDrawing::Parts::update_taxels(std::size_t n, double left_px) {
  constexpr int kSide = haptics::TaxelMap::kSide;
  const TaxelParts& taxels = taxel_parts[n];
  const ToolPicture* const tool = n < tools.size() ? &tools[n] : nullptr;
  const double grown = text_scale();
  const double side = std::min(0.2 * std::min(width, height), kTaxelSidePx * grown);
  // What stands at the right is the scale bar.
  const double room_px = n == 0 ? width : kLeftOfScaleBar * width - kTaxelWordsPx * grown;
  const bool roomy = options.caption && width >= 320 && height >= 240 && left_px <= room_px;
  const bool shown = roomy && tool != nullptr && tool->touching && tool->taxels.area_mm2 > 0;
  taxels.actor->SetVisibility(shown ? 1 : 0);
  taxels.text->SetVisibility(shown ? 1 : 0);
  if (!shown) return 0;
  const haptics::TaxelMap& map = tool->taxels;
  const Vec2 low(left_px, grown * kTaxelMarginPx);
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
  const std::string which = tools.size() > 1 ? std::to_string(n + 1) + ": " : "";
  taxels.text->SetInput((which + words.data()).c_str());
  taxels.text->GetTextProperty()->SetFontSize(font_size(grown * 15));
  taxels.text->SetDisplayPosition(static_cast<int>(std::lround(low.x())),
                                  static_cast<int>(std::lround(low.y() + side + 5 * grown)));
  // The words are wider than the map.
  return left_px + std::max(side, kTaxelWordsPx * grown) + kTaxelMarginPx * grown;
}

}  // namespace beatlas::viewer
