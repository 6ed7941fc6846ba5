#include "pipeline/segment/beyond_base.h"

#include <algorithm>
#include <array>
#include <optional>

#include "runtime/atlas/structures.h"

namespace beatlas::segment {
namespace {

constexpr double kLeastOfMost = 0.25;  ///< of a structure's largest volume
/// Dice with itself one phase on, of steps of an eighth of the beat and shorter. Over a longer one
/// an atrium empties by up to 70 % and moves with the base, so that little of it is shared.
constexpr double kLeastShared = 0.5;
constexpr std::size_t kShortStep = 8;  ///< phases in the beat
constexpr double kLeastSharedOfLong = 0.1;
/// Dice. As for a right ventricle, whose limits were set on drawn hearts (.63 and .78,
/// report/verdict.h).
constexpr double kLeastExpected = 2.0 / 3;

using Mask = std::vector<std::uint8_t>;

bool comes_and_goes(const ImageCycle<std::uint8_t>& labels, std::uint8_t label) {
  const std::size_t n = labels.phases.size();
  std::vector<double> volume;
  for (const Mask& phase : labels.phases) {
    volume.push_back(static_cast<double>(std::count(phase.begin(), phase.end(), label)));
  }
  const auto [least, most] = std::minmax_element(volume.begin(), volume.end());
  if (*least <= kLeastOfMost * *most) return true;
  const double least_shared = n < kShortStep ? kLeastSharedOfLong : kLeastShared;
  for (std::size_t p = 0; p < n; ++p) {
    const std::size_t next = (p + 1) % n;
    double both = 0;
    for (std::size_t v = 0; v < labels.phases[p].size(); ++v) {
      both += labels.phases[p][v] == label && labels.phases[next][v] == label ? 1 : 0;
    }
    if (2 * both < least_shared * (volume[p] + volume[next])) return true;
  }
  return false;
}

bool is_doubted(const Belief& belief, Structure structure) {
  const auto found = belief.find(structure);
  if (found == belief.end()) return false;
  return std::any_of(found->second.begin(), found->second.end(), [](const auto& slices) {
    return about_labels(slices).expected_dice() < kLeastExpected;
  });
}

/// The label that lies beyond a face from `label`; none if both sides of it are of that or neither.
std::optional<std::uint8_t> met_by(std::uint8_t label, std::uint8_t one, std::uint8_t other) {
  if ((one == label) == (other == label)) return {};
  return one == label ? other : one;
}

/// Faces between voxels of a label and of two others, all phases together.
std::array<double, 2> meets(const ImageCycle<std::uint8_t>& labels, std::uint8_t label,
                            const std::array<std::uint8_t, 2>& others) {
  const Grid& grid = labels.grid;
  const std::array<std::size_t, 3> step{1, static_cast<std::size_t>(grid.size[0]),
                                        grid.slice_count()};
  const Vec3 mm = grid.spacing_mm();
  std::array<double, 2> area{};
  for (const Mask& phase : labels.phases) {
    for_each_voxel(grid, [&](int i, int j, int k, std::size_t v) {
      const Index3 at{i, j, k};
      for (std::size_t a = 0; a < 3; ++a) {
        if (at[a] + 1 >= grid.size[a]) continue;
        const std::optional<std::uint8_t> met = met_by(label, phase[v], phase[v + step[a]]);
        if (!met) continue;
        const double face = mm.prod() / mm[static_cast<Eigen::Index>(a)];
        for (std::size_t n = 0; n < 2; ++n) area[n] += *met == others[n] ? face : 0;
      }
    });
  }
  return area;
}

}  // namespace

std::vector<std::string> drop_doubtful_beyond_base(const Belief& belief,
                                                   ImageCycle<std::uint8_t>& labels) {
  std::vector<std::string> told;
  for (const Structure structure : kBeyondBase) {
    const std::uint8_t label = label_of(structure);
    if (std::none_of(labels.phases.begin(), labels.phases.end(), [&](const Mask& phase) {
          return std::find(phase.begin(), phase.end(), label) != phase.end();
        })) {
      continue;
    }
    const bool right = structure == Structure::RaBlood;
    const auto [own, other] = right ? meets(labels, label, {kLabelRvBlood, kLabelLvBlood})
                                    : meets(labels, label, {kLabelLvBlood, kLabelRvBlood});
    std::string why;
    if (is_doubted(belief, structure)) {
      why = " is hard to tell from what lies beside it";
    } else if (comes_and_goes(labels, label)) {
      why = " is in view in a part of the beat alone";
    } else if (other > own) {
      why = std::string(" opens into the ") + (right ? "left" : "right") + " ventricle";
    } else {
      continue;
    }
    for (Mask& phase : labels.phases) {
      std::replace(phase.begin(), phase.end(), label, std::uint8_t{kLabelRestOfHeart});
    }
    told.push_back(std::string(structure_name(structure)) + why +
                   "; it counts as rest of the heart");
  }
  return told;
}

}  // namespace beatlas::segment
