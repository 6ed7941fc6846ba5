#include "pipeline/segment/followed_seeds.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "pipeline/core/words.h"
#include "pipeline/segment/drawn_seeds.h"

namespace beatlas::segment {
namespace {

constexpr std::size_t kMost = 5;
/// Steps to what lies beside a voxel in its slice.
constexpr std::array kBeside{std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}};

/// How often each label lies on a seed and right beside it.
struct Around {
  std::array<std::size_t, kLastLabel + 1> on{};
  std::array<std::size_t, kLastLabel + 1> beside{};
};

Around look(const Grid& grid, const std::vector<std::uint8_t>& labels,
            const std::vector<std::uint8_t>& marks, const std::vector<std::size_t>& voxels,
            std::uint8_t label) {
  Around out;
  for (const std::size_t v : voxels) {
    if (marks[v] != label) continue;
    ++out.on.at(labels[v]);
    const Index3 at = index_of(grid, v);
    for (const auto& [di, dj] : kBeside) {
      if (!grid.contains(at[0] + di, at[1] + dj, at[2])) continue;
      const std::size_t next = grid.offset(at[0] + di, at[1] + dj, at[2]);
      if (marks[next] != label) ++out.beside.at(labels[next]);
    }
  }
  return out;
}

/// How many voxels that a seed does not mark hang together with it in its slices, in its label;
/// more than `most` are not counted.
std::size_t grown_from(const Grid& grid, const std::vector<std::uint8_t>& labels,
                       const std::vector<std::size_t>& voxels, std::uint8_t label,
                       std::size_t most) {
  std::vector<std::size_t> reached = voxels;
  std::sort(reached.begin(), reached.end());
  std::vector<std::size_t> front = reached;
  const std::size_t marked = reached.size();
  while (!front.empty() && reached.size() - marked <= most) {
    const Index3 at = index_of(grid, front.back());
    front.pop_back();
    for (const auto& [di, dj] : kBeside) {
      if (!grid.contains(at[0] + di, at[1] + dj, at[2])) continue;
      const std::size_t next = grid.offset(at[0] + di, at[1] + dj, at[2]);
      const auto place = std::lower_bound(reached.begin(), reached.end(), next);
      if (labels[next] != label || (place != reached.end() && *place == next)) continue;
      reached.insert(place, next);
      front.push_back(next);
    }
  }
  return reached.size() - marked;
}

template <class Counts>
std::uint8_t most_of(const Counts& counts) {
  return static_cast<std::uint8_t>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

std::string why(std::uint8_t label, std::uint8_t there) {
  const bool ventricular =
      label == kLabelLvBlood || label == kLabelLvMyocardium || label == kLabelRvBlood;
  if (there == kLabelBackground) return "what is there does not hang together with the heart";
  if (there == kLabelRestOfHeart && ventricular) return "the ventricle was found to end before it";
  return "it was taken for " + std::string(kLabelWords.at(there));
}

}  // namespace

std::vector<std::string> seeds_not_followed(const ImageCycle<std::uint8_t>& grown,
                                            const ImageCycle<std::uint8_t>& labels,
                                            const std::vector<Seed>& seeds,
                                            const LabelImages& marks) {
  std::vector<std::string> out;
  std::size_t more = 0;
  for (std::size_t s = 0; s < seeds.size(); ++s) {
    const Seed& seed = seeds[s];
    if (seed.label == kLabelBackground) continue;
    const std::vector<std::size_t> voxels = voxels_of(labels.grid, seed);
    std::size_t lost = 0;
    std::size_t alone = 0;
    std::size_t first = 0;
    std::size_t against_given = 0;
    Around instead;
    for (std::size_t p = 0; p < labels.phases.size(); ++p) {
      if (seed.phase >= 0 && static_cast<std::size_t>(seed.phase) != p) continue;
      const Around found = look(labels.grid, labels.phases[p], marks[p], voxels, seed.label);
      std::size_t marked = 0;
      for (const std::size_t count : found.on) marked += count;
      if (marked == 0) continue;
      const bool is_lost = 2 * found.on.at(seed.label) <= marked;
      // A voxel or two of noise beside a mark are nothing that it belongs to.
      const bool is_alone = !is_lost && grown_from(labels.grid, labels.phases[p], voxels,
                                                   seed.label, marked) <= marked;
      if (!is_lost && !is_alone) continue;
      if (lost + alone == 0) first = p;
      lost += is_lost ? 1 : 0;
      alone += is_alone ? 1 : 0;
      if (is_lost) {
        const Around before = look(labels.grid, grown.phases[p], marks[p], voxels, seed.label);
        against_given += 2 * before.on.at(seed.label) > marked ? 1 : 0;
      }
      for (std::size_t label = 0; label < instead.on.size(); ++label) {
        if (label == seed.label) continue;
        (is_lost ? instead.on : instead.beside).at(label) +=
            (is_lost ? found.on : found.beside).at(label);
      }
    }
    if (lost + alone == 0) continue;
    if (out.size() == kMost) {
      ++more;
      continue;
    }
    std::string told = seed_told(seeds, s);
    const std::size_t phases = lost + alone;
    const std::string where = seed.phase >= 0 ? std::string()
                              : phases == 1   ? " in phase " + std::to_string(first)
                                              : " in " + std::to_string(phases) + " phases";
    if (against_given == phases) {
      out.push_back(told + " was not followed" + where +
                    ": the labels that were given there stay; give them anew with the seed's label "
                    "painted");
      continue;
    }
    if (lost >= alone) {
      told += " was not followed" + where + ": " + why(seed.label, most_of(instead.on));
    } else {
      told += " stays alone" + where + ": all about it is " +
              std::string(kLabelWords.at(most_of(instead.beside)));
    }
    out.push_back(told + "; mark more of the structure, or paint the labels");
  }
  if (more > 0) out.back() += "; the same of " + counted(more, "more seed");
  return out;
}

}  // namespace beatlas::segment
