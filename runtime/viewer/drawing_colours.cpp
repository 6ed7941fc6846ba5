#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkPointData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty.h>
#include <vtkProperty2D.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

#include "runtime/atlas/surface_band.h"
#include "runtime/base/error.h"
#include "runtime/viewer/band_colours.h"
#include "runtime/viewer/drawing_parts.h"
#include "runtime/viewer/drawing_patches.h"
#include "runtime/viewer/wall_colours.h"

namespace beatlas::viewer {
namespace {

constexpr int kBarSteps = 128;
constexpr int kMostMarks = 6;
constexpr double kMargin = 18;  // pixels, as all here, of a picture whose words are not enlarged

Vec2 on_circle(const Vec2& centre, double radius, double angle) {
  return centre + radius * Vec2(std::cos(angle), std::sin(angle));
}

/// Black or white, whichever is read the better on it.
double ink_on(const Rgb& colour) {
  return 0.299 * colour[0] + 0.587 * colour[1] + 0.114 * colour[2] > 140 ? 0.05 : 1;
}

}  // namespace

void HeartDrawing::Parts::make_legend() {
  legend.patches = vtkSmartPointer<vtkPolyData>::New();
  legend.actor = patches_actor(*renderer, *legend.patches);
}

void HeartDrawing::Parts::set_legend_texts(std::size_t count) {
  while (legend.texts.size() < count) {
    auto text = vtkSmartPointer<vtkTextActor>::New();
    text->GetTextProperty()->SetFontFamilyToArial();
    renderer->AddViewProp(text);
    legend.texts.push_back(text);
  }
  for (std::size_t n = 0; n < legend.texts.size(); ++n) {
    legend.texts[n]->SetVisibility(n < count ? 1 : 0);
  }
}

void HeartDrawing::Parts::put_legend_text(std::size_t n, const std::string& words, const Vec2& at,
                                          int size, double grey) {
  vtkTextActor& text = *legend.texts[n];
  text.SetInput(words.c_str());
  vtkTextProperty& property = *text.GetTextProperty();
  property.SetFontSize(font_size(size));
  property.SetColor(grey, grey, grey);
  property.SetVerticalJustificationToCentered();
  text.SetDisplayPosition(static_cast<int>(std::lround(at.x())),
                          static_cast<int>(std::lround(at.y())));
}

void HeartDrawing::Parts::update_bar() {
  const ColourScale& scale = colours->scale();
  const double grown = text_scale();
  const double right = width - grown * kMargin;
  const double left = right - grown * 20;
  const double low = 0.30 * height;
  const double high = 0.86 * height;
  const auto at = [&](double share) { return low + share * (high - low); };
  Patches patches;
  for (int n = 0; n < kBarSteps; ++n) {
    const double begin = static_cast<double>(n) / kBarSteps;
    const double end = static_cast<double>(n + 1) / kBarSteps;
    patches.add_box({left, at(begin)}, {right, at(end)}, colour_of_share(0.5 * (begin + end)));
  }
  const std::vector<double> marks = scale_marks(scale, kMostMarks);
  for (const double mark : marks) {
    const double y = at((mark - scale.low) / (scale.high - scale.low));
    patches.add_box({left - 6 * grown, y - 0.7 * grown}, {left, y + 0.7 * grown}, {237, 237, 237});
  }
  patches.give_to(*legend.patches);
  set_legend_texts(marks.size() + 1);
  for (std::size_t n = 0; n < marks.size(); ++n) {
    std::array<char, 32> number{};
    std::snprintf(number.data(), number.size(), "%g", marks[n]);
    const double y = at((marks[n] - scale.low) / (scale.high - scale.low));
    legend.texts[n]->GetTextProperty()->SetJustificationToRight();
    put_legend_text(n, number.data(), {left - 10 * grown, y},
                    static_cast<int>(std::lround(15 * grown)), 0.93);
  }
  legend.texts[marks.size()]->GetTextProperty()->SetJustificationToRight();
  put_legend_text(marks.size(), scale.title, {right, high + 16 * grown},
                  static_cast<int>(std::lround(16 * grown)), 0.93);
  legend.centre = {0.5 * (left + right), 0.5 * (low + high)};
  legend.half_px = 0.5 * (high - low);
}

void HeartDrawing::Parts::update_bulls_eye() {
  const double grown = text_scale();
  const double radius = std::min(0.17 * std::min(width, height), 120.0 * grown);
  const Vec2 centre(width - grown * kMargin - radius, height - grown * kMargin - radius);
  Patches patches;
  set_legend_texts(17);
  for (int segment = 1; segment <= 17; ++segment) {
    const palpation::BullsEyeSector sector = palpation::bulls_eye_sector(segment);
    const Rgb colour = colour_of_segment(segment);
    const int pieces = std::max(4, static_cast<int>((sector.end_rad - sector.begin_rad) / 0.08));
    const double gap = segment == 17 ? 0 : 0.7;  // pixels between neighbours
    for (int n = 0; n < pieces; ++n) {
      const auto angle = [&](int piece, double r) {
        const double share = static_cast<double>(piece) / pieces;
        const double off = r > 0 ? gap / r : 0;
        return sector.begin_rad + off + share * (sector.end_rad - sector.begin_rad - 2 * off);
      };
      const double inner = radius * sector.inner + (segment == 17 ? 0 : 0.7);
      const double outer = radius * sector.outer - 0.7;
      patches.add(
          {on_circle(centre, inner, angle(n, inner)), on_circle(centre, outer, angle(n, outer)),
           on_circle(centre, outer, angle(n + 1, outer)),
           on_circle(centre, inner, angle(n + 1, inner))},
          colour);
    }
    const double middle = segment == 17 ? 0 : 0.5 * (sector.inner + sector.outer);
    const Vec2 at = on_circle(centre, radius * middle, 0.5 * (sector.begin_rad + sector.end_rad));
    const auto n = static_cast<std::size_t>(segment - 1);
    legend.texts[n]->GetTextProperty()->SetJustificationToCentered();
    put_legend_text(n, std::to_string(segment), at, std::max(9, static_cast<int>(0.115 * radius)),
                    ink_on(colour));
  }
  patches.give_to(*legend.patches);
  legend.centre = centre;
  legend.half_px = radius;
}

void HeartDrawing::Parts::update_legend() {
  const bool roomy = options.caption && width >= 320 && height >= 240;
  const bool shown = roomy && colours && colours->by() != ColourBy::Structure;
  legend.actor->SetVisibility(shown ? 1 : 0);
  if (!shown) {
    set_legend_texts(0);
  } else if (colours->by() == ColourBy::Segments) {
    update_bulls_eye();
  } else {
    update_bar();
  }
}

void HeartDrawing::Parts::colour_surface(SurfaceParts& part) const {
  const bool coloured = colours && colours->has(part.structure);
  part.mapper->SetScalarVisibility(coloured ? 1 : 0);
  // Gloss and too much light would make other colours of them than the legend's.
  vtkProperty& property = *part.actor->GetProperty();
  property.SetSpecular(coloured ? 0.0 : 0.25);
  property.SetAmbient(coloured ? 0.25 : 0.12);
  property.SetDiffuse(coloured ? 0.62 : 0.85);
  if (!coloured) return;
  colours->colours_of({.structure = part.structure,
                       .beats = beats,
                       .positions = part.positions,
                       .normals = part.normals},
                      part.colours);
  if (!part.point_colours) {
    part.point_colours = vtkSmartPointer<vtkUnsignedCharArray>::New();
    part.point_colours->SetNumberOfComponents(3);
    part.point_colours->SetName("colours");
  }
  part.point_colours->SetArray(part.colours.front().data(),
                               3 * static_cast<vtkIdType>(part.colours.size()), 1);
  part.mesh->GetPointData()->SetScalars(part.point_colours);
  part.point_colours->Modified();
}

void HeartDrawing::set_colouring(ColourBy by, const palpation::PalpationParameters& parameters) {
  parts_->stale = true;
  parts_->colours.reset();
  if (by == ColourBy::Structure) return;
  if (!can_colour_by(by)) {
    throw_invalid(
        by == ColourBy::Uncertainty
            ? "the package does not tell how well its surfaces are known; build it again, "
              "from images"
            : "the package has no map of the LV's wall to colour by; build it again");
  }
  if (by == ColourBy::Uncertainty) {
    parts_->colours = parts_->band_colours();
    return;
  }
  std::vector<std::shared_ptr<const atlas::SurfaceMapPayload>> maps;
  for (const SurfaceParts& part : parts_->surfaces) {
    if (auto map = parts_->atlas->surface_map(part.structure)) maps.push_back(std::move(map));
  }
  parts_->colours = std::make_unique<const WallColours>(std::move(maps), by, parameters);
}

std::unique_ptr<const SurfaceColours> HeartDrawing::Parts::band_colours() const {
  std::vector<BandColours::Banded> banded;
  for (const SurfaceParts& part : surfaces) {
    const auto band = atlas::band_query(atlas->manifest(), part.structure);
    if (band) banded.push_back({part.structure, *band, part.motion.get()});
  }
  return std::make_unique<const BandColours>(banded);
}

bool HeartDrawing::can_colour_by(ColourBy by) const {
  const atlas::Atlas& package = *parts_->atlas;
  return by == ColourBy::Structure ||
         std::any_of(parts_->surfaces.begin(), parts_->surfaces.end(), [&](const auto& part) {
           return by == ColourBy::Uncertainty
                      ? atlas::band_query(package.manifest(), part.structure).has_value()
                      : package.surface_map(part.structure) != nullptr;
         });
}

const SurfaceColours* HeartDrawing::colouring() const { return parts_->colours.get(); }

LegendPlace HeartDrawing::legend_place() const {
  return {.x = parts_->legend.centre.x(),
          .y = parts_->height - 1 - parts_->legend.centre.y(),
          .half_height = parts_->legend.half_px};
}

}  // namespace beatlas::viewer
