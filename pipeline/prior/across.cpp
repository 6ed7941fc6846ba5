#include "pipeline/prior/across.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/core/lv_direction.h"
#include "pipeline/core/parallel.h"
#include "pipeline/core/slices.h"
#include "pipeline/prior/stored.h"
#include "pipeline/prior/window.h"
#include "runtime/atlas/structures.h"

namespace beatlas::prior {
namespace {

/// Beside the heart, for what slices show tells how bright they are. Chosen; with slices as wide as
/// the stack's own Dice of phantoms differs by .01 either way.
constexpr double kFieldMm = 60;

/// Calls visit(place [mm], label) for what is likeliest to be heart in any phase.
template <class Visit>
void each_of_heart(const PriorCycle& looked, const Visit& visit) {
  const Grid& grid = looked.grid;
  for (std::size_t p = 0; p < looked.phases.size(); ++p) {
    if (looked.phases[p].empty()) continue;
    std::size_t v = 0;
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i, ++v) {
          const std::uint8_t label = looked.likeliest(p, v);
          if (label != kLabelBackground) visit(grid.mm(i, j, k), label);
        }
      }
    }
  }
}

/// [voxel] in how much of the phases that were looked at a label is likeliest.
std::vector<float> share_of_phases(const PriorCycle& looked, std::uint8_t label) {
  std::vector<float> out(looked.grid.count(), 0.0F);
  const auto seen = std::count_if(looked.phases.begin(), looked.phases.end(),
                                  [](const auto& phase) { return !phase.empty(); });
  for (std::size_t p = 0; p < looked.phases.size(); ++p) {
    if (looked.phases[p].empty()) continue;
    for (std::size_t v = 0; v < out.size(); ++v) {
      if (looked.likeliest(p, v) == label) out[v] += 1.0F / static_cast<float>(seen);
    }
  }
  return out;
}

/// Axes of slices across a direction, as near to those of the stack as they can be.
Eigen::Matrix3d axes_across(const Vec3& direction, const Grid& stack) {
  const Eigen::Matrix3d old = stack.mm_from_index.linear().colwise().normalized();
  const Vec3 normal = direction.dot(old.col(2)) < 0 ? -direction : direction;
  Vec3 rows = old.col(0) - normal * normal.dot(old.col(0));
  if (rows.norm() < 0.5) rows = old.col(1) - normal * normal.dot(old.col(1));
  rows.normalize();
  Eigen::Matrix3d out;
  out << rows, normal.cross(rows), normal;
  return out;
}

/// The eight points of a grid about a place, and their weights between which values are linear.
struct Corners {
  std::array<std::size_t, 8> at{};
  std::array<float, 8> weight{};
};

/// @param index of the place in the grid @param within the part of the grid that is asked
/// @return none beyond that part
std::optional<Corners> corners_about(const Grid& grid, const Vec3& index, const Window& within) {
  Index3 low{};
  Index3 high{};
  std::array<float, 3> share{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double x = index[static_cast<Eigen::Index>(a)];
    const int last = within.first[a] + within.size[a] - 1;
    if (!(x >= within.first[a] && x <= last)) return {};
    low[a] = static_cast<int>(x);
    high[a] = std::min(low[a] + 1, last);
    share[a] = static_cast<float>(x - low[a]);
  }
  Corners out;
  for (std::size_t c = 0; c < 8; ++c) {
    Index3 point = low;
    float weight = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      const bool up = (c >> a & 1) != 0;
      if (up) point[a] = high[a];
      weight *= up ? share[a] : 1 - share[a];
    }
    out.at[c] = grid.offset(point[0], point[1], point[2]);
    out.weight[c] = weight;
  }
  return out;
}

}  // namespace

std::optional<AcrossLv> across_lv(const PriorCycle& looked, const Grid& stack,
                                  const ModelCard& card) {
  const Vec3 spacing = stack.spacing_mm();
  if (are_thick_slices(spacing[2])) return {};
  const std::optional<Vec3> direction =
      lv_direction(looked.grid, share_of_phases(looked, kLabelLvBlood),
                   share_of_phases(looked, kLabelLvMyocardium));
  if (!direction || cuts_across(stack, *direction)) return {};
  const Eigen::Matrix3d axes = axes_across(*direction, stack);
  Vec3 low = Vec3::Constant(1e9);
  Vec3 high = Vec3::Constant(-1e9);
  each_of_heart(looked, [&](const Vec3& place, std::uint8_t) {
    const Vec3 along = axes.transpose() * place;
    low = low.cwiseMin(along);
    high = high.cwiseMax(along);
  });
  const double pixel = std::min(spacing[0], spacing[1]);
  const Vec3 step(pixel, pixel, 0.5 * card.neighbour_mm);
  const Vec3 extent = high - low;
  const Vec3 room(kFieldMm, kFieldMm, kRoomMm);
  AcrossLv out;
  for (Eigen::Index a = 0; a < 3; ++a) {
    out.grid.size[static_cast<std::size_t>(a)] =
        static_cast<int>(std::ceil((extent[a] + 2 * room[a]) / step[a])) + 1;
  }
  out.grid.mm_from_index = Affine::Identity();
  out.grid.mm_from_index.linear() = axes * step.asDiagonal();
  out.grid.mm_from_index.translation() = axes * (low - room);
  const Grid seen = network_grid(out.grid, card.pixel_mm, card.multiple);
  out.window = {{0, 0, 0}, seen.size};
  for (std::size_t a = 0; a < 2; ++a) {
    const double unseen_mm = room[static_cast<Eigen::Index>(a)] - kRoomMm;
    const int first = std::min(static_cast<int>(unseen_mm / card.pixel_mm), seen.size[a] / 2);
    const int size = seen.size[a] - 2 * first;
    const int padded = (size + card.multiple - 1) / card.multiple * card.multiple;
    out.window.first[a] = first;
    out.window.size[a] = std::min(seen.size[a] - first, padded);
  }
  return out;
}

Cine cut_anew(const Cine& stack, const Grid& grid) {
  Cine out;
  out.rr_interval_s = stack.rr_interval_s;
  out.frame_times_s = stack.frame_times_s;
  out.images.grid = grid;
  out.images.phases.assign(stack.images.phases.size(), std::vector<float>(grid.count(), 0.0F));
  const Grid& source = stack.grid();
  const Affine source_from_new = source.mm_from_index.inverse() * grid.mm_from_index;
  parallel_for(static_cast<std::size_t>(grid.size[2]), [&](std::size_t slice) {
    const int k = static_cast<int>(slice);
    std::size_t to = grid.offset(0, 0, k);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++to) {
        const auto corners =
            corners_about(source, source_from_new * Vec3(i, j, k), {{0, 0, 0}, source.size});
        if (!corners) continue;
        for (std::size_t p = 0; p < out.images.phases.size(); ++p) {
          float sum = 0;
          for (std::size_t c = 0; c < 8; ++c) {
            sum += corners->weight[c] * stack.images.phases[p][corners->at[c]];
          }
          out.images.phases[p][to] = sum;
        }
      }
    }
  });
  return out;
}

void mix_in(const PriorCycle& across, const Window& window, PriorCycle& prior) {
  const Grid& grid = prior.grid;
  const Affine across_from_prior = across.grid.mm_from_index.inverse() * grid.mm_from_index;
  const std::size_t count = grid.count();
  const std::size_t other = across.grid.count();
  const std::array<float, 129>& table = stored_probabilities();
  const auto of = [&](std::int8_t log) { return table[static_cast<std::size_t>(-log)]; };
  parallel_for(static_cast<std::size_t>(grid.size[2]), [&](std::size_t slice) {
    const int k = static_cast<int>(slice);
    std::size_t v = grid.offset(0, 0, k);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++v) {
        const auto corners = corners_about(across.grid, across_from_prior * Vec3(i, j, k), window);
        if (!corners) continue;
        for (std::size_t p = 0; p < prior.phases.size(); ++p) {
          const std::vector<std::int8_t>& logs = across.phases[p];
          for (std::size_t o = 0; o < prior.labels.size(); ++o) {
            float sum = 0;
            for (std::size_t c = 0; c < 8; ++c) {
              sum += corners->weight[c] * of(logs[o * other + corners->at[c]]);
            }
            std::int8_t& here = prior.phases[p][o * count + v];
            here = stored_log(0.5F * (sum + of(here)));
          }
        }
      }
    }
  });
}

}  // namespace beatlas::prior
