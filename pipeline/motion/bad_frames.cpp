#include "pipeline/motion/bad_frames.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "pipeline/core/parallel.h"
#include "pipeline/core/statistics.h"

namespace beatlas::motion {
namespace {

constexpr std::size_t kFewestPhases = 4;
constexpr double kUnlike = 0.5;  ///< correlation with the slice's mean: less is another image
constexpr double kAlike = 0.8;   ///< that the slice's phases have in the middle, or none is judged
constexpr double kMostShare = 0.25;  ///< of the phases that show something

/// One value alone, as where a slice of fewer frames than the others was filled up.
bool is_blank(const float* slice, std::size_t count) {
  return std::all_of(slice, slice + count, [&](float value) { return value == slice[0]; });
}

/// Of each of the phases of slice k with the mean of all.
std::vector<double> likeness(const ImageCycle<float>& images, const std::vector<int>& phases,
                             int k) {
  const std::size_t count = images.grid.slice_count();
  const std::size_t begin = images.grid.offset(0, 0, k);
  const auto slice = [&](int p) {
    return images.phases[static_cast<std::size_t>(p)].data() + begin;
  };
  std::vector<double> mean(count, 0);
  for (const int p : phases) {
    for (std::size_t v = 0; v < count; ++v) {
      mean[v] += static_cast<double>(slice(p)[v]) / static_cast<double>(phases.size());
    }
  }
  std::vector<double> out;
  out.reserve(phases.size());
  for (const int p : phases) {
    out.push_back(correlation({slice(p), slice(p) + count}, mean));
  }
  return out;
}

/// Of the phases of slice k that show something, those that show another thing than most.
std::vector<int> unlike_phases(const ImageCycle<float>& images, const std::vector<int>& phases,
                               int k) {
  if (phases.size() < kFewestPhases) return {};
  const std::vector<double> alike = likeness(images, phases, k);
  std::vector<double> sorted = alike;
  std::sort(sorted.begin(), sorted.end());
  if (sorted[sorted.size() / 2] < kAlike) return {};
  std::vector<int> out;
  for (std::size_t n = 0; n < phases.size(); ++n) {
    if (alike[n] < kUnlike) out.push_back(phases[n]);
  }
  const double share = static_cast<double>(out.size()) / static_cast<double>(phases.size());
  return share > kMostShare ? std::vector<int>() : out;
}

/// Phases of slice k that are not to be believed.
std::vector<int> bad_phases(const ImageCycle<float>& images, int k) {
  const std::size_t count = images.grid.slice_count();
  const std::size_t begin = images.grid.offset(0, 0, k);
  std::vector<int> shown;
  std::vector<int> out;
  for (int p = 0; p < images.phase_count(); ++p) {
    const float* slice = images.phases[static_cast<std::size_t>(p)].data() + begin;
    (is_blank(slice, count) ? out : shown).push_back(p);
  }
  if (shown.empty()) return out;
  const std::vector<int> unlike = unlike_phases(images, shown, k);
  out.insert(out.end(), unlike.begin(), unlike.end());
  return out;
}

/// [slice] phases that are bad, of which nothing is left where no phase is good.
std::vector<int> slices_without_any(const std::vector<BadFrame>& bad, int slices, int phases) {
  std::vector<int> count(static_cast<std::size_t>(slices), 0);
  for (const BadFrame& frame : bad) ++count[static_cast<std::size_t>(frame.k)];
  std::vector<int> out;
  for (int k = 0; k < slices; ++k) {
    if (count[static_cast<std::size_t>(k)] == phases) out.push_back(k);
  }
  return out;
}

/// Draws slices of which no phase is good straight between the nearest ones beside them.
/// @pre there is one on either side
void draw_slices(const std::vector<int>& lost, ImageCycle<float>& images) {
  const Grid& grid = images.grid;
  for (const int k : lost) {
    const auto is_lost = [&](int at) { return std::binary_search(lost.begin(), lost.end(), at); };
    int below = k - 1;
    int above = k + 1;
    while (is_lost(below)) --below;
    while (is_lost(above)) ++above;
    const float share = static_cast<float>(k - below) / static_cast<float>(above - below);
    for (std::vector<float>& phase : images.phases) {
      const std::size_t to = grid.offset(0, 0, k);
      const std::size_t low = grid.offset(0, 0, below);
      const std::size_t high = grid.offset(0, 0, above);
      for (std::size_t v = 0; v < grid.slice_count(); ++v) {
        phase[to + v] = (1 - share) * phase[low + v] + share * phase[high + v];
      }
    }
  }
}

std::string listed(const std::vector<int>& slices) {
  std::string out = slices.size() == 1 ? "slice " : "slices ";
  for (std::size_t n = 0; n < slices.size(); ++n) {
    out += (n == 0 ? "" : ", ") + std::to_string(slices[n]);
  }
  return out;
}

}  // namespace

std::vector<BadFrame> bad_frames(const ImageCycle<float>& images) {
  std::vector<std::vector<int>> bad(static_cast<std::size_t>(images.grid.size[2]));
  parallel_for(bad.size(),
               [&](std::size_t k) { bad[k] = bad_phases(images, static_cast<int>(k)); });
  // Beyond the outermost slices that show something nothing is missed.
  const auto whole = static_cast<std::size_t>(images.phase_count());
  for (auto k = bad.begin(); k != bad.end() && k->size() == whole; ++k) k->clear();
  for (auto k = bad.rbegin(); k != bad.rend() && k->size() == whole; ++k) k->clear();
  std::vector<BadFrame> out;
  for (int k = 0; k < images.grid.size[2]; ++k) {
    for (const int p : bad[static_cast<std::size_t>(k)]) out.push_back({p, k});
  }
  std::sort(out.begin(), out.end(), [](const BadFrame& a, const BadFrame& b) {
    return std::pair(a.phase, a.k) < std::pair(b.phase, b.k);
  });
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
  const std::vector<int> lost = slices_without_any(bad, images.grid.size[2], n);
  for (const BadFrame& frame : bad) {
    if (std::binary_search(lost.begin(), lost.end(), frame.k)) continue;
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
  draw_slices(lost, out);
  return out;
}

std::optional<Exam> without_bad_frames(const Exam& exam) {
  const std::vector<BadFrame> bad = bad_frames(exam.stack.images);
  if (bad.empty()) return {};
  Exam out = exam;
  out.stack.images = without_bad_frames(exam.stack.images, bad);
  return out;
}

std::vector<std::string> told(const std::vector<BadFrame>& bad, int slices, int phases) {
  const std::vector<int> lost = slices_without_any(bad, slices, phases);
  std::vector<std::string> out;
  if (!lost.empty()) {
    out.push_back(listed(lost) + (lost.size() == 1 ? " shows" : " show") +
                  " nothing in any phase, between slices that do; what is labelled there is drawn "
                  "between the slices beside, not seen");
  }
  std::map<int, std::vector<int>> of_phase;
  for (const BadFrame& frame : bad) {
    if (!std::binary_search(lost.begin(), lost.end(), frame.k)) {
      of_phase[frame.phase].push_back(frame.k);
    }
  }
  for (const auto& [phase, frames] : of_phase) {
    const bool all = frames.size() + lost.size() == static_cast<std::size_t>(slices);
    out.push_back(
        "phase " + std::to_string(phase) + (all ? "" : " of " + listed(frames)) +
        " shows nothing of what the other phases show, as noise does; it was labelled from "
        "the phases beside it");
  }
  return out;
}

}  // namespace beatlas::motion
