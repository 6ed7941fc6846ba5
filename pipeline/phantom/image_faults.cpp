#include "pipeline/phantom/image_faults.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace beatlas::phantom {

void blur(std::vector<float>& image, int columns, float sigma) {
  if (sigma < 0.2F) return;
  const int reach = std::max(1, static_cast<int>(std::ceil(3 * sigma)));
  std::vector<float> weights(static_cast<std::size_t>(reach) + 1);
  float sum = 0;
  for (int d = 0; d <= reach; ++d) {
    const auto x = static_cast<float>(d);
    weights[static_cast<std::size_t>(d)] = std::exp(-0.5F * x * x / (sigma * sigma));
    sum += (d == 0 ? 1.0F : 2.0F) * weights[static_cast<std::size_t>(d)];
  }
  std::vector<float> other(image.size());
  for (int pass = 0; pass < 2; ++pass) {
    const int step = pass == 0 ? 1 : columns;
    const int line = pass == 0 ? columns : 1;
    for (int l = 0; l < columns; ++l) {
      const float* from = image.data() + l * line;
      float* to = other.data() + l * line;
      for (int x = 0; x < columns; ++x) {
        float value = weights[0] * from[x * step];
        for (int d = 1; d <= reach; ++d) {
          value += weights[static_cast<std::size_t>(d)] *
                   (from[std::max(x - d, 0) * step] + from[std::min(x + d, columns - 1) * step]);
        }
        to[x * step] = value / sum;
      }
    }
    image.swap(other);
  }
}

Ghost::Ghost(const Family& family)
    : strength_(family.happens("ghosts") ? family.number("ghost_strength") : 0),
      shift_(family.number("ghost_shift")),
      along_rows_(family.uniform("ghost_rows") < 0.5F) {}

void Ghost::add(std::vector<float>& image, int columns) const {
  if (strength_ <= 0) return;
  const std::vector<float> before = image;
  const int shift = static_cast<int>(shift_ * static_cast<float>(columns));
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int from_i = along_rows_ ? i : (i + shift) % columns;
      const int from_j = along_rows_ ? (j + shift) % columns : j;
      image[static_cast<std::size_t>(j * columns + i)] +=
          strength_ * before[static_cast<std::size_t>(from_j * columns + from_i)];
    }
  }
}

BlankedEdge::BlankedEdge(const Family& family) : there_(family.happens("masked")) {
  if (!there_) return;
  round_ = family.uniform("mask_round") < 0.4F;
  edge_ = family.number("mask_edge");
  bend_ = family.number("mask_bend");
  const float way = family.between(0, 2 * std::numbers::pi_v<float>, "mask_way");
  cosine_ = std::cos(way);
  sine_ = std::sin(way);
}

bool BlankedEdge::blanks(float x, float y) const {
  if (!there_) return false;
  const float s = x * cosine_ + y * sine_;
  const float t = -x * sine_ + y * cosine_;
  return (round_ ? std::hypot(x, y) : std::abs(s) + bend_ * t * t) > edge_;
}

}  // namespace beatlas::phantom
