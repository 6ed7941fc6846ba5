#include "pipeline/prior/window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

#include "runtime/atlas/structures.h"

namespace beatlas::prior {
namespace {

struct Body {
  std::vector<std::vector<std::size_t>> lv_blood;  ///< [phase][slice] voxels
  Index3 low{0, 0, 0};
  Index3 high{0, 0, 0};  ///< included

  [[nodiscard]] std::size_t lv_blood_of_all() const {
    std::size_t out = 0;
    for (const auto& phase : lv_blood) {
      out = std::accumulate(phase.begin(), phase.end(), out);
    }
    return out;
  }
};

/// What the phases that were looked at hold.
struct SeenHeart {
  std::vector<std::uint8_t> heart;       ///< [voxel] 1 where any of them has a label
  std::vector<std::vector<bool>> blood;  ///< [phase of them][voxel] of the LV
};

SeenHeart seen_heart(const PriorCycle& looked) {
  SeenHeart out;
  out.heart.assign(looked.grid.count(), 0);
  for (std::size_t p = 0; p < looked.phases.size(); ++p) {
    if (looked.phases[p].empty()) continue;
    out.blood.emplace_back(out.heart.size(), false);
    for (std::size_t v = 0; v < out.heart.size(); ++v) {
      const std::uint8_t label = looked.likeliest(p, v);
      if (label != kLabelBackground) out.heart[v] = 1;
      if (label == kLabelLvBlood) out.blood.back()[v] = true;
    }
  }
  return out;
}

/// What hangs together with a voxel by faces; taken out of what is seen.
Body take_body(const Grid& grid, std::size_t start, SeenHeart& seen) {
  const auto row = static_cast<std::size_t>(grid.size[0]);
  const std::size_t slice = grid.slice_count();
  const std::array<std::size_t, 3> step{1, row, slice};
  Body body;
  body.lv_blood.assign(seen.blood.size(),
                       std::vector<std::size_t>(static_cast<std::size_t>(grid.size[2]), 0));
  body.low = grid.size;
  std::vector<std::size_t> reached;
  const auto reach = [&](std::size_t v) {
    if (seen.heart[v] == 0) return;
    seen.heart[v] = 0;
    reached.push_back(v);
  };
  reach(start);
  while (!reached.empty()) {
    const std::size_t v = reached.back();
    reached.pop_back();
    for (std::size_t p = 0; p < seen.blood.size(); ++p) {
      body.lv_blood[p][v / slice] += seen.blood[p][v] ? 1 : 0;
    }
    const Index3 at{static_cast<int>(v % row), static_cast<int>(v % slice / row),
                    static_cast<int>(v / slice)};
    for (std::size_t a = 0; a < 3; ++a) {
      body.low[a] = std::min(body.low[a], at[a]);
      body.high[a] = std::max(body.high[a], at[a]);
      if (at[a] > 0) reach(v - step[a]);
      if (at[a] + 1 < grid.size[a]) reach(v + step[a]);
    }
  }
  return body;
}

/// What hangs together by faces, in any of the phases.
std::vector<Body> bodies_of(const PriorCycle& looked) {
  SeenHeart seen = seen_heart(looked);
  std::vector<Body> out;
  for (std::size_t v = 0; v < seen.heart.size(); ++v) {
    if (seen.heart[v] != 0) out.push_back(take_body(looked.grid, v, seen));
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

double least_lv_ml(const PriorCycle& looked) {
  const std::vector<Body> bodies = bodies_of(looked);
  const auto heart = std::max_element(bodies.begin(), bodies.end(), [](auto& a, auto& b) {
    return a.lv_blood_of_all() < b.lv_blood_of_all();
  });
  if (heart == bodies.end()) return 0;
  const Vec3 mm = looked.grid.spacing_mm();
  double least = 0;
  for (const std::vector<std::size_t>& phase : heart->lv_blood) {
    const std::size_t voxels = std::accumulate(phase.begin(), phase.end(), std::size_t{0});
    const double seen = looked.grid.voxel_ml() * static_cast<double>(voxels);
    const double section_mm2 =
        mm[0] * mm[1] * static_cast<double>(*std::max_element(phase.begin(), phase.end()));
    // A ball's volume from its largest section.
    const double ball = 4 / (3 * std::sqrt(EIGEN_PI)) * std::pow(section_mm2, 1.5) * 1e-3;
    least = std::max({least, seen, ball});
  }
  return least;
}

Window window_of_heart(const PriorCycle& looked, int multiple) {
  const Grid& grid = looked.grid;
  const std::vector<Body> bodies = bodies_of(looked);
  std::size_t most = 0;
  for (const Body& body : bodies) most = std::max(most, body.lv_blood_of_all());
  Window out{{0, 0, 0}, grid.size};
  if (most == 0) return out;
  Index3 low = grid.size;
  Index3 high{0, 0, 0};
  for (const Body& body : bodies) {
    if (2 * body.lv_blood_of_all() < most) continue;
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
