#include "pipeline/report/overlay.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "pipeline/report/encoded_picture.h"
#include "pipeline/report/slice_view.h"
#include "runtime/atlas/structure_colours.h"
#include "runtime/base/error.h"

namespace beatlas::report {
namespace {

constexpr int kCaptionPx = 18;
constexpr int kGapPx = 4;
constexpr double kRingMm = 10;  ///< around the place of an alarm
constexpr Colour kRingColour{255, 80, 255};

cv::Scalar bgr(const Colour& colour) {
  return {double(colour[2]), double(colour[1]), double(colour[0])};
}

struct Sheet {
  cv::Rect rectangle;
  cv::Size tile;
};

cv::Mat draw_tile(const Cine& cine, const Segmentation& segmentation, const Sheet& sheet, int k,
                  int phase, const std::array<double, 2>& window) {
  const auto p = static_cast<std::size_t>(phase);
  cv::Mat grey;
  const double scale = 255.0 / (window[1] - window[0]);
  slice_view(cine.images.phases[p], cine.grid(), k)(sheet.rectangle)
      .convertTo(grey, CV_8U, scale, -window[0] * scale);
  cv::Mat tile;
  cv::resize(grey, tile, sheet.tile, 0, 0, cv::INTER_LINEAR);
  cv::cvtColor(tile, tile, cv::COLOR_GRAY2BGR);
  for (Structure structure : kAllStructures) {
    const auto found = segmentation.coverage.phases.find(structure);
    if (found == segmentation.coverage.phases.end()) continue;
    cv::Mat inside;
    cv::resize(coverage_slice(segmentation.coverage, found->second[p], k, sheet.rectangle), inside,
               sheet.tile, 0, 0, cv::INTER_LINEAR);
    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(cv::Mat(inside >= 0.5), contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
    cv::drawContours(tile, contours, -1, bgr(structure_colour(structure)), 1);
  }
  return tile;
}

/// Square pixels, the longer edge of `longest_px`.
cv::Size tile_size(const cv::Rect& rectangle, const Vec3& spacing, int longest_px) {
  const double width_mm = rectangle.width * spacing[0];
  const double height_mm = rectangle.height * spacing[1];
  const double px_per_mm = longest_px / std::max(width_mm, height_mm);
  return {std::max(1, static_cast<int>(std::lround(width_mm * px_per_mm))),
          std::max(1, static_cast<int>(std::lround(height_mm * px_per_mm)))};
}

std::vector<std::byte> encoded(const cv::Mat& picture) {
  const std::vector<std::uint8_t> bytes = png_of(picture);
  const auto* first = reinterpret_cast<const std::byte*>(bytes.data());
  return {first, first + bytes.size()};
}

void put_words(cv::Mat& picture, const std::string& words, cv::Point at, const cv::Scalar& colour) {
  cv::putText(picture, words, at, cv::FONT_HERSHEY_SIMPLEX, 0.4, colour, 1, cv::LINE_AA);
}

}  // namespace

std::vector<std::byte> overlay_png(const Cine& cine, const Segmentation& segmentation,
                                   const OverlayOptions& options) {
  check_fit(cine, segmentation);
  const Grid& grid = cine.grid();
  const std::array<int, 2> phases{segmentation.end_diastole, segmentation.end_systole};
  const std::array<std::string, 2> names{"ED", "ES"};

  Sheet sheet;
  sheet.rectangle =
      heart_rectangle(grid, segmentation.coverage, {phases[0], phases[1]}, options.margin_mm);
  const Vec3 spacing = grid.spacing_mm();
  sheet.tile = tile_size(sheet.rectangle, spacing, options.tile_px);

  const int slices = grid.size[2];
  const int pairs = std::max(1, static_cast<int>(std::ceil(std::sqrt(slices / 2.0))));
  const int rows = (slices + pairs - 1) / pairs;
  const int step_x = sheet.tile.width + kGapPx;
  const int step_y = sheet.tile.height + kCaptionPx + kGapPx;
  cv::Mat picture(rows * step_y + kCaptionPx + kGapPx, std::max(2 * pairs * step_x, 420), CV_8UC3,
                  cv::Scalar(24, 24, 24));
  int legend_x = kGapPx;
  for (Structure structure : kAllStructures) {
    if (segmentation.coverage.phases.count(structure) == 0) continue;
    put_words(picture, std::string(structure_name(structure)), {legend_x, kCaptionPx - 4},
              bgr(structure_colour(structure)));
    legend_x += 100;
  }
  for (std::size_t side = 0; side < phases.size(); ++side) {
    const auto window = grey_window(cine, {phases[side]}, sheet.rectangle);
    for (int k = 0; k < slices; ++k) {
      const int x = (2 * (k % pairs) + static_cast<int>(side)) * step_x;
      const int y = kCaptionPx + kGapPx + (k / pairs) * step_y;
      put_words(picture,
                "slice " + std::to_string(k) + " " + names[side] + " (phase " +
                    std::to_string(phases[side]) + ")",
                {x + kGapPx, y + kCaptionPx - 5}, cv::Scalar(220, 220, 220));
      draw_tile(cine, segmentation, sheet, k, phases[side], window)
          .copyTo(picture(cv::Rect({x, y + kCaptionPx}, sheet.tile)));
    }
  }
  return encoded(picture);
}

std::vector<std::byte> leak_png(const Cine& cine, const Segmentation& segmentation,
                                const LeakAlarm& alarm, const OverlayOptions& options) {
  check_fit(cine, segmentation);
  const Grid& grid = cine.grid();
  const Vec3 at = grid.mm_from_index.inverse() * alarm.lps_mm;
  const int k = static_cast<int>(std::lround(at[2]));
  const cv::Point2d place(at[0], at[1]);
  if (alarm.phase < 0 || alarm.phase >= cine.phase_count() ||
      !grid.contains(static_cast<int>(std::lround(place.x)), static_cast<int>(std::lround(place.y)),
                     k)) {
    throw_invalid("the place or phase of a leak alarm lies outside the images");
  }
  // The heart, and room around the place, which may lie beyond it.
  const Vec3 spacing = grid.spacing_mm();
  const cv::Point room(static_cast<int>(std::ceil(options.margin_mm / spacing[0])),
                       static_cast<int>(std::ceil(options.margin_mm / spacing[1])));
  const cv::Rect around(cv::Point(place) - room, cv::Point(place) + room + cv::Point(1, 1));
  Sheet sheet;
  sheet.rectangle =
      (heart_rectangle(grid, segmentation.coverage, {alarm.phase}, options.margin_mm) | around) &
      cv::Rect(0, 0, grid.size[0], grid.size[1]);
  sheet.tile = tile_size(sheet.rectangle, spacing, options.tile_px);

  const auto window = grey_window(cine, {alarm.phase}, sheet.rectangle);
  cv::Mat picture(sheet.tile.height + kCaptionPx + kGapPx,
                  std::max(2 * sheet.tile.width + kGapPx, 560), CV_8UC3, cv::Scalar(24, 24, 24));
  char words[160];
  const bool of_volume = alarm.kind == LeakKind::VolumeJump || alarm.kind == LeakKind::OpenCycle;
  std::snprintf(words, sizeof words, "%s of %s, slice %d, phase %d: %.0f %s (limit %.0f)",
                std::string(leak_kind_name(alarm.kind)).c_str(),
                std::string(structure_name(alarm.structure)).c_str(), k, alarm.phase, alarm.figure,
                of_volume ? "%" : "mm2", alarm.limit);
  put_words(picture, words, {kGapPx, kCaptionPx - 5}, cv::Scalar(220, 220, 220));
  const double px_per_mm = sheet.tile.width / (sheet.rectangle.width * spacing[0]);
  const cv::Point2d in_crop = place - cv::Point2d(sheet.rectangle.tl()) + cv::Point2d(0.5, 0.5);
  const cv::Point marked(
      static_cast<int>(std::lround(in_crop.x * sheet.tile.width / sheet.rectangle.width)),
      static_cast<int>(std::lround(in_crop.y * sheet.tile.height / sheet.rectangle.height)));
  Segmentation without;
  for (int side = 0; side < 2; ++side) {
    cv::Mat tile =
        draw_tile(cine, side == 0 ? segmentation : without, sheet, k, alarm.phase, window);
    cv::circle(tile, marked, std::max(6, static_cast<int>(std::lround(kRingMm * px_per_mm))),
               bgr(kRingColour), 1, cv::LINE_AA);
    tile.copyTo(picture(cv::Rect({side * (sheet.tile.width + kGapPx), kCaptionPx}, sheet.tile)));
  }
  return encoded(picture);
}

}  // namespace beatlas::report
