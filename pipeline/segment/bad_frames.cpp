#include "pipeline/segment/bad_frames.h"

#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"

namespace beatlas::segment {
namespace {

constexpr int kFewestPhases = 4;
constexpr double kUnlike = 0.5;  ///< correlation with the slice's mean: less is another image
constexpr double kAlike = 0.8;   ///< that the slice's phases have in the middle, or none is judged
constexpr double kMostShare = 0.25;  ///< of the phases

double correlation(const float* a, const std::vector<double>& b, double mean_b, double square_b) {
  const std::size_t n = b.size();
  double sum = 0;
  for (std::size_t v = 0; v < n; ++v) sum += static_cast<double>(a[v]);
  const double mean = sum / static_cast<double>(n);
  double square = 0;
  double product = 0;
  for (std::size_t v = 0; v < n; ++v) {
    const double off = static_cast<double>(a[v]) - mean;
    square += off * off;
    product += off * (b[v] - mean_b);
  }
  return square > 0 && square_b > 0 ? product / std::sqrt(square * square_b) : 0;
}

/// Of each phase of slice k with the mean of all.
std::vector<double> likeness(const ImageCycle<float>& images, int k) {
  const std::size_t count = images.grid.slice_count();
  const std::size_t begin = images.grid.offset(0, 0, k);
  const std::size_t n = images.phases.size();
  std::vector<double> mean(count, 0);
  for (const std::vector<float>& phase : images.phases) {
    for (std::size_t v = 0; v < count; ++v) {
      mean[v] += static_cast<double>(phase[begin + v]) / static_cast<double>(n);
    }
  }
  double level = 0;
  for (const double value : mean) level += value / static_cast<double>(count);
  double square = 0;
  for (const double value : mean) square += (value - level) * (value - level);
  std::vector<double> out;
  for (const std::vector<float>& phase : images.phases) {
    out.push_back(correlation(phase.data() + begin, mean, level, square));
  }
  return out;
}

}  // namespace

std::vector<BadFrame> bad_frames(const ImageCycle<float>& images) {
  const int n = images.phase_count();
  std::vector<BadFrame> out;
  if (n < kFewestPhases) return out;
  std::vector<std::vector<double>> alike(static_cast<std::size_t>(images.grid.size[2]));
  parallel_for(alike.size(),
               [&](std::size_t k) { alike[k] = likeness(images, static_cast<int>(k)); });
  for (int k = 0; k < images.grid.size[2]; ++k) {
    const std::vector<double>& of = alike[static_cast<std::size_t>(k)];
    std::vector<double> sorted = of;
    std::sort(sorted.begin(), sorted.end());
    const auto unlike = std::count_if(of.begin(), of.end(), [](double c) { return c < kUnlike; });
    if (sorted[sorted.size() / 2] < kAlike || static_cast<double>(unlike) > kMostShare * n)
      continue;
    for (int p = 0; p < n; ++p) {
      if (of[static_cast<std::size_t>(p)] < kUnlike) out.push_back({p, k});
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const BadFrame& a, const BadFrame& b) { return a.phase < b.phase; });
  return out;
}

ImageCycle<float> without_bad_frames(const ImageCycle<float>& images,
                                     const std::vector<BadFrame>& bad) {
  ImageCycle<float> out{images.grid, images.phases};
  const int n = images.phase_count();
  const auto is_bad = [&](int p, int k) {
    return std::any_of(bad.begin(), bad.end(),
                       [&](const BadFrame& frame) { return frame.phase == p && frame.k == k; });
  };
  for (const BadFrame& frame : bad) {
    int before = 1;
    int after = 1;
    while (is_bad((frame.phase + n - before) % n, frame.k)) ++before;
    while (is_bad((frame.phase + after) % n, frame.k)) ++after;
    const auto phase = [&](int p) -> const std::vector<float>& {
      return images.phases[static_cast<std::size_t>((p + n) % n)];
    };
    const std::vector<float>& earlier = phase(frame.phase - before);
    const std::vector<float>& later = phase(frame.phase + after);
    const auto share = static_cast<float>(before) / static_cast<float>(before + after);
    const std::size_t begin = images.grid.offset(0, 0, frame.k);
    for (std::size_t v = begin; v < begin + images.grid.slice_count(); ++v) {
      out.phases[static_cast<std::size_t>(frame.phase)][v] =
          (1 - share) * earlier[v] + share * later[v];
    }
  }
  return out;
}

std::optional<Exam> without_bad_frames(const Exam& exam) {
  const std::vector<BadFrame> bad = bad_frames(exam.stack.images);
  if (bad.empty()) return {};
  Exam out = exam;
  out.stack.images = without_bad_frames(exam.stack.images, bad);
  return out;
}

std::vector<std::string> told(const std::vector<BadFrame>& bad, int slices) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at < bad.size();) {
    std::size_t end = at;
    std::string list;
    for (; end < bad.size() && bad[end].phase == bad[at].phase; ++end) {
      list += (list.empty() ? "" : ", ") + std::to_string(bad[end].k);
    }
    const bool all = end - at == static_cast<std::size_t>(slices);
    out.push_back(
        "phase " + std::to_string(bad[at].phase) +
        (all ? "" : (end - at == 1 ? " of slice " : " of slices ") + list) +
        " shows nothing of what the other phases show, as noise does; it was labelled from "
        "the phases beside it");
    at = end;
  }
  return out;
}

}  // namespace beatlas::segment
