#include "pipeline/report/slice_sheets.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "pipeline/core/parallel.h"
#include "pipeline/report/base64.h"
#include "pipeline/report/encoded_picture.h"
#include "pipeline/report/slice_view.h"
#include "runtime/base/error.h"

namespace beatlas::report {
namespace {

constexpr int kBlock = 8;  ///< a JPEG block; tiles begin with one, so that none bleeds into another
constexpr int kParts = 32;  ///< of a voxel, in packed outlines

struct Trial {
  int quality;
  double scale;
};
/// From the best to the smallest.
constexpr std::array kTrials{Trial{88, 1.0}, Trial{75, 1.0}, Trial{60, 1.0}, Trial{60, 0.75},
                             Trial{50, 0.5}, Trial{35, 0.5}, Trial{35, 0.25}};

int whole_blocks(double pixels) {
  return std::max(1, static_cast<int>(std::ceil(pixels / kBlock - 1e-9))) * kBlock;
}

std::vector<std::uint8_t> sheet_of(const Cine& cine, int k, const cv::Rect& part,
                                   const SliceSheets& sheets, const std::array<double, 2>& window) {
  const int phases = cine.phase_count();
  const int rows = (phases + sheets.columns - 1) / sheets.columns;
  cv::Mat sheet(rows * sheets.tile_height, sheets.columns * sheets.tile_width, CV_8U,
                cv::Scalar(0));
  const double gain = 255.0 / (window[1] - window[0]);
  const cv::Size used(std::max(1, static_cast<int>(std::lround(part.width * sheets.scale))),
                      std::max(1, static_cast<int>(std::lround(part.height * sheets.scale))));
  for (int p = 0; p < phases; ++p) {
    cv::Mat grey;
    slice_view(cine.images.phases[static_cast<std::size_t>(p)], cine.grid(), k)(part).convertTo(
        grey, CV_8U, gain, -window[0] * gain);
    if (used != grey.size()) cv::resize(grey, grey, used, 0, 0, cv::INTER_AREA);
    cv::copyMakeBorder(grey, grey, 0, sheets.tile_height - used.height, 0,
                       sheets.tile_width - used.width, cv::BORDER_REPLICATE);
    grey.copyTo(
        sheet({(p % sheets.columns) * sheets.tile_width, (p / sheets.columns) * sheets.tile_height,
               sheets.tile_width, sheets.tile_height}));
  }
  return jpeg_of(sheet, sheets.quality);
}

/// The corners of a cell of four voxels are numbered 0 (i, j), 1 (i+1, j), 2 (i+1, j+1), 3 (i,
/// j+1), its edges 0 (0-1), 1 (1-2), 2 (3-2), 3 (0-3).
class Squares {
 public:
  explicit Squares(const cv::Mat& inside) : inside_(inside) {}

  std::vector<Outline> closed_lines() {
    for (int j = 0; j + 1 < inside_.rows; ++j) {
      for (int i = 0; i + 1 < inside_.cols; ++i) add_cell(i, j);
    }
    std::vector<Outline> lines;
    while (!next_.empty()) {
      Outline line;
      int edge = next_.begin()->first;
      while (true) {
        const auto found = next_.find(edge);
        if (found == next_.end()) break;
        line.push_back(point_on(edge));
        edge = found->second;
        next_.erase(found);
      }
      if (line.size() > 2) lines.push_back(std::move(line));
    }
    return lines;
  }

 private:
  [[nodiscard]] float at(int i, int j) const { return inside_.at<float>(j, i); }
  /// Of the edge that runs from (i, j) along i or along j.
  [[nodiscard]] int edge_of(int i, int j, bool along_j) const {
    return 2 * (j * inside_.cols + i) + (along_j ? 1 : 0);
  }
  [[nodiscard]] std::array<float, 2> point_on(int edge) const {
    const int i = edge / 2 % inside_.cols;
    const int j = edge / 2 / inside_.cols;
    const bool along_j = edge % 2 == 1;
    const float a = at(i, j);
    const float b = along_j ? at(i, j + 1) : at(i + 1, j);
    const float share = (0.5F - a) / (b - a);
    return along_j ? std::array{float(i), float(j) + share}
                   : std::array{float(i) + share, float(j)};
  }
  void join(int from, int to) { next_[from] = to; }
  void add_cell(int i, int j) {
    const std::array<float, 4> corner{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
    const std::array<int, 4> edge{edge_of(i, j, false), edge_of(i + 1, j, true),
                                  edge_of(i, j + 1, false), edge_of(i, j, true)};
    // The inside lies at the right hand of the line, so each edge is left once and reached once.
    int entered = -1;
    std::array<std::pair<int, int>, 2> pieces;
    std::size_t count = 0;
    std::array<int, 4> kind{};  // +1: from outside to inside along 0-1-2-3, -1: back
    for (std::size_t c = 0; c < 4; ++c) {
      const bool in = corner[c] >= 0.5F;
      const bool next_in = corner[(c + 1) % 4] >= 0.5F;
      kind[c] = in == next_in ? 0 : (next_in ? 1 : -1);
    }
    for (std::size_t c = 0; c < 8 && count < 2; ++c) {
      const std::size_t e = c % 4;
      if (kind[e] == 1) entered = static_cast<int>(e);
      if (kind[e] == -1 && entered >= 0) {
        pieces[count++] = {edge[static_cast<std::size_t>(entered)], edge[e]};
        kind[static_cast<std::size_t>(entered)] = kind[e] = 0;
        entered = -1;
      }
    }
    for (std::size_t c = 0; c < count; ++c) join(pieces[c].first, pieces[c].second);
  }

  cv::Mat inside_;
  std::map<int, int> next_;
};

}  // namespace

SliceSheets slice_sheets(const Cine& cine, const Segmentation* segmentation,
                         const std::vector<Vec3>& places, const SheetOptions& options) {
  const Grid& grid = cine.grid();
  std::vector<int> phases(static_cast<std::size_t>(cine.phase_count()));
  std::iota(phases.begin(), phases.end(), 0);
  cv::Rect part(0, 0, grid.size[0], grid.size[1]);
  std::vector<int> for_window{0};
  if (segmentation != nullptr) {
    check_fit(cine, *segmentation);
    part = heart_rectangle(grid, segmentation->coverage, phases, options.margin_mm);
    for_window = {segmentation->end_diastole, segmentation->end_systole};
  }
  const Vec3 spacing = grid.spacing_mm();
  for (const Vec3& place : places) {
    const Vec3 at = grid.mm_from_index.inverse() * place;
    const cv::Point room(static_cast<int>(std::ceil(options.margin_mm / spacing[0])),
                         static_cast<int>(std::ceil(options.margin_mm / spacing[1])));
    const cv::Point centre(static_cast<int>(std::lround(at[0])),
                           static_cast<int>(std::lround(at[1])));
    part = (part | cv::Rect(centre - room, centre + room + cv::Point(1, 1))) &
           cv::Rect(0, 0, grid.size[0], grid.size[1]);
  }
  const auto window = grey_window(cine, for_window, part);

  SliceSheets sheets;
  sheets.first_i = part.x;
  sheets.first_j = part.y;
  sheets.width = part.width;
  sheets.height = part.height;
  sheets.columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(double(phases.size())))));
  for (const Trial& trial : kTrials) {
    sheets.quality = trial.quality;
    sheets.scale = trial.scale;
    sheets.tile_width = whole_blocks(part.width * trial.scale);
    sheets.tile_height = whole_blocks(part.height * trial.scale);
    sheets.jpeg.assign(static_cast<std::size_t>(grid.size[2]), {});
    parallel_for(sheets.jpeg.size(), [&](std::size_t k) {
      sheets.jpeg[k] = sheet_of(cine, static_cast<int>(k), part, sheets, window);
    });
    std::size_t bytes = 0;
    for (const auto& jpeg : sheets.jpeg) bytes += jpeg.size();
    if (bytes <= options.max_bytes) break;
  }
  return sheets;
}

std::vector<Outline> outlines(const Segmentation& segmentation, Structure structure, int phase,
                              int k, double tolerance_mm) {
  const CoverageCycle& coverage = segmentation.coverage;
  const auto found = coverage.phases.find(structure);
  if (found == coverage.phases.end()) return {};
  const Grid& part = coverage.grid;
  const cv::Rect rectangle(coverage.first[0], coverage.first[1], part.size[0], part.size[1]);
  cv::Mat inside =
      coverage_slice(coverage, found->second[static_cast<std::size_t>(phase)], k, rectangle);
  // A rim of nothing, so that every line is closed.
  cv::copyMakeBorder(inside, inside, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  std::vector<Outline> lines = Squares(inside).closed_lines();
  const Vec3 spacing = part.spacing_mm();
  const double tolerance = tolerance_mm / std::max(spacing[0], spacing[1]);
  for (Outline& line : lines) {
    std::vector<cv::Point2f> whole;
    for (const auto& point : line) whole.emplace_back(point[0], point[1]);
    std::vector<cv::Point2f> thin;
    cv::approxPolyDP(whole, thin, tolerance, true);
    line.clear();
    for (const cv::Point2f& point : thin) {
      line.push_back(
          {point.x - 1 + float(coverage.first[0]), point.y - 1 + float(coverage.first[1])});
    }
  }
  std::erase_if(lines, [](const Outline& line) { return line.size() < 3; });
  return lines;
}

std::vector<std::uint8_t> packed_outlines(const Segmentation& segmentation,
                                          const std::vector<Structure>& structures, int k,
                                          const SliceSheets& sheets, double tolerance_mm) {
  std::vector<std::uint8_t> out;
  const auto packed = [](double voxels) {
    return static_cast<std::int32_t>(std::lround(std::clamp(voxels * kParts, -32768.0, 32767.0)));
  };
  for (int p = 0; p < segmentation.labels.phase_count(); ++p) {
    for (const Structure structure : structures) {
      const std::vector<Outline> lines = outlines(segmentation, structure, p, k, tolerance_mm);
      put16(out, static_cast<std::int32_t>(lines.size()));
      for (const Outline& line : lines) {
        put16(out, static_cast<std::int32_t>(line.size()));
        for (const auto& point : line) {
          put16(out, packed(point[0] - sheets.first_i));
          put16(out, packed(point[1] - sheets.first_j));
        }
      }
    }
  }
  return out;
}

}  // namespace beatlas::report
