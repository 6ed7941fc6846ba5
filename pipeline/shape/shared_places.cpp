#include "pipeline/shape/shared_places.h"

#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "runtime/atlas/structures.h"

namespace beatlas::shape {
namespace {

using Level = std::vector<float>;

/// Calls body(row_a, row_b, length) for every row of samples that two lattices have in common.
template <class Body>
void for_shared_rows(const Grid& a, const Grid& b, const Body& body) {
  const double step = a.spacing_mm().x();
  const Vec3 between = (a.mm_from_index.translation() - b.mm_from_index.translation()) / step;
  Index3 shift{};  // index in b of a's first sample
  Index3 first{};  // of the common samples, in a
  Index3 last{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    shift[axis] = static_cast<int>(std::lround(between[static_cast<Eigen::Index>(axis)]));
    first[axis] = std::max(0, -shift[axis]);
    last[axis] = std::min(a.size[axis], b.size[axis] - shift[axis]) - 1;
    if (last[axis] < first[axis]) return;
  }
  const int wide = last[0] - first[0] + 1;
  const auto length = static_cast<std::size_t>(wide);
  for (int k = first[2]; k <= last[2]; ++k) {
    for (int j = first[1]; j <= last[1]; ++j) {
      body(a.offset(first[0], j, k), b.offset(first[0] + shift[0], j + shift[1], k + shift[2]),
           length);
    }
  }
}

/// What two structures beside each other both claim is parted in its middle; an atrium or a vessel
/// gives way to a ventricle and its muscle.
/// @param mine, theirs levels of both as they were claimed
void give_way(ShapeCycle& one, const Level& mine, const ShapeCycle& other, const Level& theirs,
              std::size_t phase) {
  const bool beyond = is_beyond_base(one.structure);
  const bool alike = beyond == is_beyond_base(other.structure);
  if (!alike && !beyond) return;
  const float own = alike ? 0.5F : 0.0F;
  const float its = alike ? -0.5F : -1.0F;
  for_shared_rows(one.level.grid, other.level.grid,
                  [&](std::size_t a, std::size_t b, std::size_t length) {
                    float* level = one.level.phases[phase].data() + a;
                    const float* at_one = mine.data() + a;
                    const float* at_other = theirs.data() + b;
                    for (std::size_t i = 0; i < length; ++i) {
                      level[i] = std::max(level[i], own * at_one[i] + its * at_other[i]);
                    }
                  });
}

/// Nothing of a part lies outside of the heart: a ventricle or its muscle meets it half-way, an
/// atrium or a vessel ends with it.
void hold_within(ShapeCycle& heart, ShapeCycle& part, std::size_t phase) {
  const bool beyond = is_beyond_base(part.structure);
  for_shared_rows(heart.level.grid, part.level.grid,
                  [&](std::size_t a, std::size_t b, std::size_t length) {
                    float* whole = heart.level.phases[phase].data() + a;
                    float* held = part.level.phases[phase].data() + b;
                    for (std::size_t i = 0; i < length; ++i) {
                      if (!(held[i] < whole[i])) continue;
                      if (!beyond) whole[i] = 0.5F * (held[i] + whole[i]);
                      held[i] = whole[i];
                    }
                  });
}

void settle(std::vector<ShapeCycle>& shapes, std::size_t phase) {
  std::vector<Level> claimed;
  claimed.reserve(shapes.size());
  for (const ShapeCycle& shape : shapes) claimed.push_back(shape.level.phases[phase]);
  ShapeCycle* heart = nullptr;
  for (std::size_t n = 0; n < shapes.size(); ++n) {
    if (shapes[n].structure == Structure::Heart) {
      heart = &shapes[n];
      continue;
    }
    for (std::size_t m = 0; m < shapes.size(); ++m) {
      if (m == n || shapes[m].structure == Structure::Heart) continue;
      give_way(shapes[n], claimed[n], shapes[m], claimed[m], phase);
    }
  }
  if (heart == nullptr) return;
  for (ShapeCycle& part : shapes) {
    if (&part != heart) hold_within(*heart, part, phase);
  }
}

}  // namespace

void settle_shared_places(std::vector<ShapeCycle>& shapes) {
  if (shapes.empty()) return;
  parallel_for(shapes.front().level.phases.size(),
               [&](std::size_t phase) { settle(shapes, phase); });
}

}  // namespace beatlas::shape
