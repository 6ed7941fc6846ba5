#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/prior/prior.h"
#include "pipeline/prior/stored.h"
#include "runtime/base/error.h"

namespace beatlas::prior {
namespace {

constexpr double kRoundOff = 1e-6;  // [voxels] of a grid's map

/// Where the voxels of one axis lie between pixels of the prior.
struct Places {
  std::vector<int> below;
  std::vector<int> above;
  std::vector<float> share;  ///< of the one above
};

Places places_of(int count, double first, double step, int pixels) {
  Places out;
  for (int n = 0; n < count; ++n) {
    const double place = std::clamp(first + n * step, 0.0, pixels - 1.0);
    const int below = static_cast<int>(place);
    out.below.push_back(below);
    out.above.push_back(std::min(below + 1, pixels - 1));
    out.share.push_back(static_cast<float>(place - below));
  }
  return out;
}

}  // namespace

std::vector<std::vector<float>> probabilities_on(const PriorCycle& prior, int phase,
                                                 const Grid& part) {
  const Grid& grid = prior.grid;
  if (phase < 0 || phase >= prior.phase_count()) {
    throw_invalid("the prior has no phase " + std::to_string(phase));
  }
  const Affine map = grid.mm_from_index.inverse() * part.mm_from_index;
  Affine axes = Affine::Identity();  // the same without what would turn or shear
  axes.linear().diagonal() = map.linear().diagonal();
  axes.translation() = map.translation();
  const double first_k = std::round(map.translation()[2]);
  const bool fits = (map.matrix() - axes.matrix()).cwiseAbs().maxCoeff() < kRoundOff &&
                    std::abs(map.translation()[2] - first_k) < kRoundOff &&
                    std::abs(map.linear()(2, 2) - 1) < kRoundOff && first_k >= 0 &&
                    first_k + part.size[2] <= grid.size[2];
  if (!fits) throw_invalid("the prior was made of another stack than the voxels it is asked for");
  const Places along =
      places_of(part.size[0], map.translation()[0], map.linear()(0, 0), grid.size[0]);
  const Places across =
      places_of(part.size[1], map.translation()[1], map.linear()(1, 1), grid.size[1]);

  const std::size_t outputs = prior.labels.size();
  const std::vector<std::int8_t>& stored = prior.phases[static_cast<std::size_t>(phase)];
  const std::array<float, 129>& table = stored_probabilities();
  std::vector<std::vector<float>> out(outputs, std::vector<float>(part.count()));
  parallel_for(static_cast<std::size_t>(part.size[2]), [&](std::size_t slice) {
    const int k = static_cast<int>(slice);
    const int from_k = static_cast<int>(first_k) + k;
    std::vector<float> sums(static_cast<std::size_t>(part.size[0]));
    for (int j = 0; j < part.size[1]; ++j) {
      const auto b = static_cast<std::size_t>(j);
      const std::size_t to = part.offset(0, j, k);
      std::fill(sums.begin(), sums.end(), 0.0F);
      for (std::size_t o = 0; o < outputs; ++o) {
        const std::int8_t* image = stored.data() + o * grid.count();
        const std::int8_t* low = image + grid.offset(0, across.below[b], from_k);
        const std::int8_t* high = image + grid.offset(0, across.above[b], from_k);
        const auto at = [&](int i) {
          const float here = table[static_cast<std::size_t>(-low[i])];
          return here + across.share[b] * (table[static_cast<std::size_t>(-high[i])] - here);
        };
        for (std::size_t a = 0; a < sums.size(); ++a) {
          const float here = at(along.below[a]);
          const float value = here + along.share[a] * (at(along.above[a]) - here);
          out[o][to + a] = value;
          sums[a] += value;
        }
      }
      for (std::size_t o = 0; o < outputs; ++o) {
        for (std::size_t a = 0; a < sums.size(); ++a) out[o][to + a] /= sums[a];
      }
    }
  });
  return out;
}

}  // namespace beatlas::prior
