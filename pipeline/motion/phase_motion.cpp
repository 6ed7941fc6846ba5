#include "pipeline/motion/phase_motion.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/video/tracking.hpp>

#include "pipeline/core/parallel.h"

namespace beatlas::motion {
namespace {

/// The search works on patches of 8 pixels over several scales.
constexpr int kLeastEdgePx = 32;
constexpr int kMostSteps = 127;
/// There and back again must end this near to where it began; else what is there came from
/// elsewhere, through the slice, or shows nothing, and no motion is told.
constexpr int kMostOffSteps = 1;

cv::Mat bytes_of(const ImageCycle<float>& images, std::size_t p, std::size_t k, double top) {
  const int nx = images.grid.size[0];
  const int ny = images.grid.size[1];
  const cv::Mat slice(ny, nx, CV_32F,
                      const_cast<float*>(images.phases[p].data() + k * images.grid.slice_count()));
  cv::Mat bytes;
  slice.convertTo(bytes, CV_8U, 255 / top);
  // A border of what the edge shows, where the image is too small for the search.
  const int right = std::max(0, kLeastEdgePx - nx);
  const int below = std::max(0, kLeastEdgePx - ny);
  if (right + below > 0) {
    cv::copyMakeBorder(bytes, bytes, 0, below, 0, right, cv::BORDER_REPLICATE);
  }
  return bytes;
}

std::int8_t step_of(float flow, int at, int size) {
  const int step = std::clamp(static_cast<int>(std::lround(flow)), -kMostSteps, kMostSteps);
  return static_cast<std::int8_t>(std::clamp(step, -at, size - 1 - at));
}

/// Forgets what the way back does not confirm.
void keep_confirmed(const Grid& grid, std::size_t k, std::vector<PlaneStep>& there,
                    std::vector<PlaneStep>& back) {
  const auto unconfirmed = [&](const std::vector<PlaneStep>& go,
                               const std::vector<PlaneStep>& come) {
    std::vector<std::size_t> out;
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const std::size_t v = grid.offset(i, j, static_cast<int>(k));
        const PlaneStep& step = go[v];
        const PlaneStep& home = come[grid.offset(i + step[0], j + step[1], static_cast<int>(k))];
        if (std::max(std::abs(step[0] + home[0]), std::abs(step[1] + home[1])) > kMostOffSteps) {
          out.push_back(v);
        }
      }
    }
    return out;
  };
  const std::vector<std::size_t> lost_there = unconfirmed(there, back);
  const std::vector<std::size_t> lost_back = unconfirmed(back, there);
  for (const std::size_t v : lost_there) there[v] = {0, 0};
  for (const std::size_t v : lost_back) back[v] = {0, 0};
}

}  // namespace

PhaseMotion phase_motion(const ImageCycle<float>& images, double top) {
  const std::size_t phases = images.phases.size();
  const auto slices = static_cast<std::size_t>(images.grid.size[2]);
  const int nx = images.grid.size[0];
  const int ny = images.grid.size[1];
  PhaseMotion out;
  out.to_next.assign(phases, std::vector<PlaneStep>(images.grid.count()));
  out.to_previous = out.to_next;
  parallel_for(slices, [&](std::size_t k) {
    const cv::Ptr<cv::DISOpticalFlow> search =
        cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_ULTRAFAST);
    std::vector<cv::Mat> bytes;
    for (std::size_t p = 0; p < phases; ++p) bytes.push_back(bytes_of(images, p, k, top));
    cv::Mat flow;
    const auto follow = [&](std::size_t from, std::size_t to, std::vector<PlaneStep>& steps) {
      flow.release();  // or the last one would be where the search begins
      search->calc(bytes[from], bytes[to], flow);
      PlaneStep* out_step = steps.data() + k * images.grid.slice_count();
      for (int j = 0; j < ny; ++j) {
        for (int i = 0; i < nx; ++i, ++out_step) {
          const auto& d = flow.at<cv::Vec2f>(j, i);
          *out_step = {step_of(d[0], i, nx), step_of(d[1], j, ny)};
        }
      }
    };
    for (std::size_t p = 0; p < phases; ++p) {
      const std::size_t next = (p + 1) % phases;
      follow(p, next, out.to_next[p]);
      follow(next, p, out.to_previous[next]);
      keep_confirmed(images.grid, k, out.to_next[p], out.to_previous[next]);
    }
  });
  return out;
}

}  // namespace beatlas::motion
