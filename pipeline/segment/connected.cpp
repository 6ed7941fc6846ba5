#include "pipeline/segment/connected.h"

#include <algorithm>
#include <array>
#include <vector>

#include "pipeline/core/parallel.h"
#include "runtime/atlas/structures.h"

namespace beatlas::segment {
namespace {

/// Neighbours in a row of voxels, all of them held.
struct Run {
  std::uint32_t phase = 0;
  std::uint32_t row = 0;  ///< of the phase
  int begin = 0;          ///< index along the row
  int end = 0;
  std::uint32_t parent = 0;  ///< a run of the same part, itself or one before it

  /// Calls act(voxel).
  template <class Act>
  void each(int width, const Act& act) const {
    const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
    for (int i = begin; i < end; ++i) act(first + static_cast<std::size_t>(i));
  }
};

std::size_t length_of(const Run& run) { return static_cast<std::size_t>(run.end - run.begin); }

/// Parts of what `holds` over some phases that share faces of voxels or, with more than one phase,
/// places in phases that follow each other round the cycle.
class Parts {
 public:
  template <class Holds>
  Parts(const Grid& grid, std::size_t phases, const Holds& holds)
      : rows_(static_cast<std::size_t>(grid.size[1]) * static_cast<std::size_t>(grid.size[2])) {
    for (std::uint32_t p = 0; p < phases; ++p) {
      for (std::uint32_t row = 0; row < rows_; ++row) {
        first_.push_back(runs_.size());
        add_runs(p, row, grid.size[0], holds);
      }
    }
    first_.push_back(runs_.size());
    const auto height = static_cast<std::size_t>(grid.size[1]);
    for (std::size_t p = 0; p < phases; ++p) {
      const std::size_t here = p * rows_;
      const std::size_t next = (p + 1) % phases * rows_;
      for (std::size_t row = 0; row < rows_; ++row) {
        if (row % height > 0) join(here + row, here + row - 1);
        if (row >= height) join(here + row, here + row - height);
        if (phases > 1) join(here + row, next + row);
      }
    }
  }

  /// Those of all parts but the largest.
  [[nodiscard]] std::vector<Run> others() {
    const std::vector<std::size_t> voxels = sums(length_of);
    const std::size_t largest = most(voxels);
    return runs_of([&](std::size_t part) { return part != largest; });
  }

  /// What the runs of each part measure together; by the part's first run, 0 elsewhere.
  template <class Measure>
  [[nodiscard]] std::vector<std::size_t> sums(const Measure& measure) {
    std::vector<std::size_t> out(runs_.size(), 0);
    for (std::uint32_t at = 0; at < runs_.size(); ++at) out[root(at)] += measure(runs_[at]);
    return out;
  }

  /// The part that measures most.
  static std::size_t most(const std::vector<std::size_t>& sums) {
    return static_cast<std::size_t>(std::max_element(sums.begin(), sums.end()) - sums.begin());
  }

  /// Runs of the parts that pass a test.
  template <class Test>
  [[nodiscard]] std::vector<Run> runs_of(const Test& test) {
    std::vector<Run> out;
    for (std::uint32_t at = 0; at < runs_.size(); ++at) {
      if (test(root(at))) out.push_back(runs_[at]);
    }
    return out;
  }

 private:
  template <class Holds>
  void add_runs(std::uint32_t phase, std::uint32_t row, int width, const Holds& holds) {
    const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
    const auto held = [&](int i) { return holds(phase, first + static_cast<std::size_t>(i)); };
    for (int i = 0; i < width; ++i) {
      if (!held(i)) continue;
      const int begin = i;
      while (i < width && held(i)) ++i;
      runs_.push_back({phase, row, begin, i, static_cast<std::uint32_t>(runs_.size())});
    }
  }

  /// The part's first run.
  std::uint32_t root(std::uint32_t at) {
    while (runs_[at].parent != at) at = runs_[at].parent = runs_[runs_[at].parent].parent;
    return at;
  }

  /// Joins the runs of two rows of all phases that lie beside each other.
  void join(std::size_t row, std::size_t other) {
    std::size_t a = first_[row];
    std::size_t b = first_[other];
    while (a < first_[row + 1] && b < first_[other + 1]) {
      if (runs_[a].begin < runs_[b].end && runs_[b].begin < runs_[a].end) {
        const std::uint32_t root_a = root(static_cast<std::uint32_t>(a));
        const std::uint32_t root_b = root(static_cast<std::uint32_t>(b));
        runs_[std::max(root_a, root_b)].parent = std::min(root_a, root_b);
      }
      ++(runs_[a].end < runs_[b].end ? a : b);
    }
  }

  std::size_t rows_;                ///< of a phase
  std::vector<Run> runs_;           ///< in the order of phases, rows and voxels
  std::vector<std::size_t> first_;  ///< [row of all phases], and their number
};

std::array<bool, 256> those(const std::vector<std::uint8_t>& labels) {
  std::array<bool, 256> out{};
  for (const std::uint8_t label : labels) out[label] = true;
  return out;
}

/// Of a section, over the cavity in the slice before. Of the drawn hearts to tune with (9000 to
/// 9054), as they grow, every piece of 100 voxels and more that is LV has .54 and more, and those
/// that are none and do not simply lie over the LV have .05 to .21.
constexpr double kLeastOver = 0.25;

/// Faces in the plane of a slice between voxels of two labels.
std::size_t faces_between(const Grid& grid, const std::vector<std::uint8_t>& phase, int k,
                          std::uint8_t one, std::uint8_t other) {
  const auto row = static_cast<std::size_t>(grid.size[0]);
  const auto meet = [&](std::size_t a, std::size_t b) {
    return (phase[a] == one && phase[b] == other) || (phase[a] == other && phase[b] == one);
  };
  std::size_t count = 0;
  std::size_t v = grid.offset(0, 0, k);
  for (int j = 0; j < grid.size[1]; ++j) {
    for (int i = 0; i < grid.size[0]; ++i, ++v) {
      count += i + 1 < grid.size[0] && meet(v, v + 1) ? 1 : 0;
      count += j + 1 < grid.size[1] && meet(v, v + row) ? 1 : 0;
    }
  }
  return count;
}

/// Whether the slices between two sections of a cavity, if there are any, show wall where the
/// larger of both lies, over half of it and more, and either section has no more cavity than wall:
/// there the wall closed upon the cavity, which goes on beyond. What leaked through a pole has
/// hardly a wall.
bool closed_by_wall(const Grid& grid, const std::vector<std::uint8_t>& phase, int first, int second,
                    std::uint8_t cavity, std::uint8_t wall) {
  if (second == first + 1) return true;
  const auto voxels = [&](int k, std::uint8_t label) {
    const auto begin = phase.begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, k));
    return std::count(begin, begin + static_cast<std::ptrdiff_t>(grid.slice_count()), label);
  };
  for (const int k : {first, second}) {
    if (voxels(k, wall) < voxels(k, cavity)) return false;
  }
  const auto held = std::max(voxels(first, cavity), voxels(second, cavity));
  const std::size_t from = grid.offset(0, 0, voxels(first, cavity) == held ? first : second);
  for (int k = first + 1; k < second; ++k) {
    const std::size_t to = grid.offset(0, 0, k);
    std::ptrdiff_t closed = 0;
    for (std::size_t v = 0; v < grid.slice_count(); ++v) {
      closed += phase[from + v] == cavity && phase[to + v] == wall ? 1 : 0;
    }
    if (2 * closed < held) return false;
  }
  return true;
}

/// Of the slices that follow each other with the cavity, or the wall that closed upon it, in each,
/// those stay that have most wall about it together.
void keep_walled_run(const Grid& grid, std::uint8_t cavity, std::uint8_t wall, std::uint8_t instead,
                     std::vector<std::uint8_t>& phase) {
  struct Slices {
    int begin = 0;
    int end = 0;  ///< behind the last; 0: none
    std::size_t walled = 0;
  };
  const auto slice = [&](int k) {
    return phase.begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, k));
  };
  Slices best;
  Slices now;
  for (int k = 0; k < grid.size[2]; ++k) {
    if (std::find(slice(k), slice(k + 1), cavity) == slice(k + 1)) continue;
    if (now.end == 0 || !closed_by_wall(grid, phase, now.end - 1, k, cavity, wall)) now = {k, 0, 0};
    now.walled += faces_between(grid, phase, k, cavity, wall);
    now.end = k + 1;
    if (best.end == 0 || now.walled > best.walled || now.begin == best.begin) best = now;
  }
  std::replace(slice(0), slice(best.begin), cavity, instead);
  std::replace(slice(best.end), phase.end(), cavity, instead);
}

Grid one_slice(Grid grid) {
  grid.size[2] = 1;
  return grid;
}

/// Some phases of the whole grid, or of a slice of it.
struct Piece {
  Grid grid;
  std::size_t first_voxel = 0;
  std::size_t first_phase = 0;
  std::size_t phases = 1;
};

/// Of the labels that are held, what does not hang together with their largest part in the piece
/// gets `instead`.
template <class Holds>
void keep_largest_in(const Piece& piece, const Holds& holds, std::uint8_t instead,
                     ImageCycle<std::uint8_t>& labels) {
  const auto at = [&](std::size_t phase, std::size_t voxel) -> std::uint8_t& {
    return labels.phases[piece.first_phase + phase][piece.first_voxel + voxel];
  };
  Parts parts(piece.grid, piece.phases,
              [&](std::size_t p, std::size_t v) { return holds(at(p, v)); });
  for (const Run& run : parts.others()) {
    run.each(piece.grid.size[0], [&](std::size_t v) { at(run.phase, v) = instead; });
  }
}

/// The same through space and time, and of what is left in each phase.
template <class Holds>
void keep_body_of(const Holds& holds, std::uint8_t instead, ImageCycle<std::uint8_t>& labels) {
  keep_largest_in({labels.grid, 0, 0, labels.phases.size()}, holds, instead, labels);
  parallel_for(labels.phases.size(), [&](std::size_t p) {
    keep_largest_in({labels.grid, 0, p}, holds, instead, labels);
  });
}

}  // namespace

void keep_largest(const std::vector<std::uint8_t>& of_labels, std::uint8_t instead,
                  ImageCycle<std::uint8_t>& labels) {
  const std::array<bool, 256> wanted = those(of_labels);
  keep_largest_in(
      {labels.grid, 0, 0, labels.phases.size()}, [&](std::uint8_t label) { return wanted[label]; },
      instead, labels);
}

void keep_largest_of_each_slice(const std::vector<std::uint8_t>& of_labels, std::uint8_t instead,
                                ImageCycle<std::uint8_t>& labels) {
  const std::array<bool, 256> wanted = those(of_labels);
  const auto holds = [&](std::uint8_t label) { return wanted[label]; };
  const Grid one = one_slice(labels.grid);
  parallel_for(static_cast<std::size_t>(labels.grid.size[2]), [&](std::size_t k) {
    const std::size_t first = k * one.count();
    keep_largest_in({one, first, 0, labels.phases.size()}, holds, instead, labels);
    for (std::size_t p = 0; p < labels.phases.size(); ++p) {
      keep_largest_in({one, first, p}, holds, instead, labels);
    }
  });
}

void clear_marked_parts(std::uint8_t marked, ImageCycle<std::uint8_t>& image) {
  Parts parts(image.grid, image.phases.size(),
              [&](std::size_t p, std::size_t v) { return image.phases[p][v] != 0; });
  const int width = image.grid.size[0];
  const std::vector<std::size_t> marks = parts.sums([&](const Run& run) {
    std::size_t count = 0;
    run.each(width, [&](std::size_t v) { count += image.phases[run.phase][v] == marked ? 1 : 0; });
    return count;
  });
  for (const Run& run : parts.runs_of([&](std::size_t part) { return marks[part] > 0; })) {
    run.each(width, [&](std::size_t v) { image.phases[run.phase][v] = 0; });
  }
}

void keep_stacked(std::uint8_t cavity, std::uint8_t wall, std::uint8_t instead,
                  ImageCycle<std::uint8_t>& labels) {
  const Grid one = one_slice(labels.grid);
  const int slices = labels.grid.size[2];
  int first = -1;
  std::size_t most = 0;
  for (int k = 0; k < slices; ++k) {
    std::size_t walled = 0;
    for (const std::vector<std::uint8_t>& phase : labels.phases) {
      walled += faces_between(labels.grid, phase, k, cavity, wall);
    }
    if (walled > most) {
      most = walled;
      first = k;
    }
  }
  if (first < 0) return;
  for (const int way : {-1, 1}) {
    for (int k = first + way; k >= 0 && k < slices; k += way) {
      const std::size_t here = labels.grid.offset(0, 0, k);
      const std::size_t before = labels.grid.offset(0, 0, k - way);
      Parts parts(one, labels.phases.size(), [&](std::size_t p, std::size_t v) {
        return labels.phases[p][here + v] == cavity;
      });
      const std::vector<std::size_t> voxels = parts.sums(length_of);
      const std::vector<std::size_t> shared = parts.sums([&](const Run& run) {
        std::size_t count = 0;
        run.each(one.size[0], [&](std::size_t v) {
          count += labels.phases[run.phase][before + v] == cavity ? 1 : 0;
        });
        return count;
      });
      const auto goes = [&](std::size_t part) {
        return static_cast<double>(shared[part]) < kLeastOver * static_cast<double>(voxels[part]);
      };
      for (const Run& run : parts.runs_of(goes)) {
        run.each(one.size[0], [&](std::size_t v) { labels.phases[run.phase][here + v] = instead; });
      }
    }
  }
  for (std::vector<std::uint8_t>& phase : labels.phases) {
    keep_walled_run(labels.grid, cavity, wall, instead, phase);
  }
}

void keep_connected_heart(ImageCycle<std::uint8_t>& labels) {
  keep_body_of([](std::uint8_t label) { return label != kLabelBackground; }, kLabelBackground,
               labels);
}

void keep_one_body(const std::vector<std::uint8_t>& of_labels, std::uint8_t instead,
                   ImageCycle<std::uint8_t>& labels) {
  const std::array<bool, 256> wanted = those(of_labels);
  keep_body_of([&](std::uint8_t label) { return wanted[label]; }, instead, labels);
}

}  // namespace beatlas::segment
