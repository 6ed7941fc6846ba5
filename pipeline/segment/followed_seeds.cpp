#include "pipeline/segment/followed_seeds.h"

#include <algorithm>
#include <array>
#include <numeric>
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

/// In which phases labels do not follow a seed, and what they hold instead.
struct NotFollowed {
  std::size_t lost = 0;           ///< phases in which other labels lie on it
  std::size_t alone = 0;          ///< phases in which it does not go on beside it
  std::size_t first = 0;          ///< of all these phases
  std::size_t against_given = 0;  ///< lost ones in which it grew, until given labels were put back
  Around instead;                 ///< labels on it where it is lost, beside it where it is alone

  [[nodiscard]] std::size_t phases() const { return lost + alone; }
};

/// Adds counts of all labels but one.
template <class Counts>
void add_others(const Counts& counts, std::uint8_t label, Counts& sums) {
  for (std::size_t other = 0; other < counts.size(); ++other) {
    if (other != label) sums[other] += counts[other];
  }
}

NotFollowed not_followed(const ImageCycle<std::uint8_t>& grown,
                         const ImageCycle<std::uint8_t>& labels, const Seed& seed,
                         const LabelImages& marks) {
  const std::vector<std::size_t> voxels = voxels_of(labels.grid, seed);
  NotFollowed out;
  for (std::size_t p = 0; p < labels.phases.size(); ++p) {
    if (seed.phase >= 0 && static_cast<std::size_t>(seed.phase) != p) continue;
    const Around found = look(labels.grid, labels.phases[p], marks[p], voxels, seed.label);
    const std::size_t marked = std::accumulate(found.on.begin(), found.on.end(), std::size_t{0});
    if (marked == 0) continue;
    const bool is_lost = 2 * found.on.at(seed.label) <= marked;
    // A voxel or two of noise beside a mark are nothing that it belongs to.
    const bool is_alone =
        !is_lost && grown_from(labels.grid, labels.phases[p], voxels, seed.label, marked) <= marked;
    if (!is_lost && !is_alone) continue;
    if (out.phases() == 0) out.first = p;
    if (is_alone) {
      ++out.alone;
      add_others(found.beside, seed.label, out.instead.beside);
      continue;
    }
    ++out.lost;
    add_others(found.on, seed.label, out.instead.on);
    const Around before = look(labels.grid, grown.phases[p], marks[p], voxels, seed.label);
    if (2 * before.on.at(seed.label) > marked) ++out.against_given;
  }
  return out;
}

/// A sentence about a seed that some phases do not follow.
std::string not_followed_told(const std::vector<Seed>& seeds, std::size_t at,
                              const NotFollowed& found) {
  const Seed& seed = seeds[at];
  const std::string told = seed_told(seeds, at);
  const std::size_t phases = found.phases();
  const std::string where = seed.phase >= 0 ? std::string()
                            : phases == 1   ? " in phase " + std::to_string(found.first)
                                            : " in " + std::to_string(phases) + " phases";
  if (found.against_given == phases) {
    return told + " was not followed" + where +
           ": the labels that were given there stay; give them anew with the seed's label painted";
  }
  const std::string trouble = found.lost >= found.alone
                                  ? " was not followed" + where + ": it was taken for " +
                                        std::string(kLabelWords.at(most_of(found.instead.on)))
                                  : " stays alone" + where + ": all about it is " +
                                        std::string(kLabelWords.at(most_of(found.instead.beside)));
  return told + trouble + "; mark more of the structure, or paint the labels";
}

}  // namespace

std::vector<std::string> seeds_not_followed(const ImageCycle<std::uint8_t>& grown,
                                            const ImageCycle<std::uint8_t>& labels,
                                            const std::vector<Seed>& seeds,
                                            const LabelImages& marks) {
  std::vector<std::string> out;
  std::size_t more = 0;
  for (std::size_t s = 0; s < seeds.size(); ++s) {
    if (seeds[s].label == kLabelBackground) continue;
    const NotFollowed found = not_followed(grown, labels, seeds[s], marks);
    if (found.phases() == 0) continue;
    if (out.size() < kMost) {
      out.push_back(not_followed_told(seeds, s, found));
    } else {
      ++more;
    }
  }
  if (more > 0) out.back() += "; the same of " + counted(more, "more seed");
  return out;
}

}  // namespace beatlas::segment
