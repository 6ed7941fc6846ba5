#include "pipeline/prior/window.h"

#include <algorithm>
#include <cmath>

#include "runtime/atlas/structures.h"

namespace beatlas::prior {
namespace {

struct Body {
  std::size_t lv_blood = 0;  ///< voxels, all phases together
  Index3 low{0, 0, 0};
  Index3 high{0, 0, 0};  ///< included
};

/// What hangs together by faces, in any of the phases.
std::vector<Body> bodies_of(const PriorCycle& looked) {
  const Grid& grid = looked.grid;
  std::vector<std::uint8_t> heart(grid.count(), 0);
  std::vector<std::uint8_t> blood(grid.count(), 0);  // in how many phases
  for (std::size_t p = 0; p < looked.phases.size(); ++p) {
    if (looked.phases[p].empty()) continue;
    for (std::size_t v = 0; v < heart.size(); ++v) {
      const std::uint8_t label = looked.likeliest(p, v);
      if (label != kLabelBackground) heart[v] = 1;
      if (label == kLabelLvBlood) ++blood[v];
    }
  }
  const auto row = static_cast<std::size_t>(grid.size[0]);
  const std::size_t slice = grid.slice_count();
  std::vector<Body> out;
  std::vector<std::size_t> reached;
  for (std::size_t start = 0; start < heart.size(); ++start) {
    if (heart[start] == 0) continue;
    Body body{0, grid.size, {0, 0, 0}};
    heart[start] = 0;
    reached.assign(1, start);
    while (!reached.empty()) {
      const std::size_t v = reached.back();
      reached.pop_back();
      body.lv_blood += blood[v];
      const Index3 at{static_cast<int>(v % row), static_cast<int>(v % slice / row),
                      static_cast<int>(v / slice)};
      for (std::size_t a = 0; a < 3; ++a) {
        body.low[a] = std::min(body.low[a], at[a]);
        body.high[a] = std::max(body.high[a], at[a]);
        const std::size_t step = a == 0 ? 1 : a == 1 ? row : slice;
        if (at[a] > 0 && heart[v - step] != 0) {
          heart[v - step] = 0;
          reached.push_back(v - step);
        }
        if (at[a] + 1 < grid.size[a] && heart[v + step] != 0) {
          heart[v + step] = 0;
          reached.push_back(v + step);
        }
      }
    }
    out.push_back(body);
  }
  return out;
}

}  // namespace

std::vector<int> looked_at(int phases) {
  const int count = std::min(phases, 3);
  std::vector<int> out(static_cast<std::size_t>(count));
  for (int n = 0; n < count; ++n) out[static_cast<std::size_t>(n)] = n * phases / count;
  return out;
}

Window window_of_heart(const PriorCycle& looked, int multiple) {
  const Grid& grid = looked.grid;
  const std::vector<Body> bodies = bodies_of(looked);
  std::size_t most = 0;
  for (const Body& body : bodies) most = std::max(most, body.lv_blood);
  Window out{{0, 0, 0}, grid.size};
  if (most == 0) return out;
  Index3 low = grid.size;
  Index3 high{0, 0, 0};
  for (const Body& body : bodies) {
    if (2 * body.lv_blood < most) continue;
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], body.low[a]);
      high[a] = std::max(high[a], body.high[a]);
    }
  }
  const Vec3 mm = grid.spacing_mm();
  for (std::size_t a = 0; a < 3; ++a) {
    // What would be filled up with zeros is better seen.
    const int of = a < 2 ? multiple : 1;
    const int room = static_cast<int>(std::ceil(kRoomMm / mm[static_cast<Eigen::Index>(a)]));
    int first = std::max(0, low[a] - room);
    int end = std::min(grid.size[a], high[a] + 1 + room);
    end = std::min(grid.size[a], end + (of - (end - first) % of) % of);
    first = std::max(0, first - (of - (end - first) % of) % of);
    out.first[a] = first;
    out.size[a] = end - first;
  }
  return out;
}

}  // namespace beatlas::prior
